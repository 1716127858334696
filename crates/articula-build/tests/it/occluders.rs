//! Occluder capsules are inside the body: every line of sight to a capsule meets the skin first.

use crate::random_figure::{RATE, character_of, flat, rows};
use crate::reference_human::asset_of_2000;
use articula_build::ClipOptions;
use articula_build::occluders;
use articula_build::{Asset, character};
use articula_core::{Clip, Mesh, PosedMesh, Track, Tracks, Wrap};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

fn skin(asset: &Asset, clip: &Clip, secs: f64) -> Vec<DVec3> {
    let (rig, mesh) = (&asset.rig, &asset.mesh);
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let mut points = vec![Vec3::ZERO; all.len()];
    let mut posed = PosedMesh::new(rig, mesh);
    posed
        .pose_at(clip, secs, Wrap::Loop)
        .points(&all, &mut points);
    points.iter().map(|p| p.as_dvec3()).collect()
}

/// Whether a triangle lies between two points, by the signs of the volumes they make.
fn is_between(from: DVec3, to: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).dot((r - p).cross(s - p));
    let sides = volume(from, a, b, c) * volume(to, a, b, c) < 0.0;
    let (u, v, w) = (
        volume(from, to, a, b),
        volume(from, to, b, c),
        volume(from, to, c, a),
    );
    sides && ((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0))
}

#[test]
fn every_line_of_sight_to_a_capsule_meets_the_skin() {
    let asset = asset_of_2000();
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let unit = prop::array::uniform4(-1.0f64..1.0);
    let mut draw = || unit.new_tree(&mut runner).unwrap().current();
    for clip in asset.clips.iter().filter(|c| c.name == "walk") {
        let capsules = occluders(asset, clip, 3);
        // At least a trunk; hands swing.
        let trunk = capsules.first().unwrap();
        let tall = trunk.ends[0].distance(trunk.ends[1]);
        assert!(
            trunk.radius > 0.04 && tall > 0.3,
            "{}: {trunk:?}",
            clip.name
        );
        for _ in 0..12 {
            let [when, ..] = draw();
            let points = skin(asset, clip, 10.0 * when);
            for capsule in &capsules {
                let [x, y, z, along] = draw();
                let out = DVec3::new(x, y, z).normalize() * f64::from(capsule.radius);
                let [a, b] = capsule.ends.map(|end| end.as_dvec3());
                let inside = a.lerp(b, 0.5 + 0.5 * along) + out * 0.999;
                let [x, y, z, _] = draw();
                let eye = inside + DVec3::new(x, y, z).normalize() * 4.0;
                let meets = asset
                    .mesh
                    .triangles
                    .iter()
                    .any(|t| is_between(eye, inside, t.map(|v| points[v as usize])));
                assert!(meets, "{}: {inside} shows from {eye}", clip.name);
            }
        }
    }
}

#[test]
fn a_figure_without_an_inside_hides_nothing() {
    proptest!(ProptestConfig::with_cases(16), |(rows in rows())| {
        let opts = ClipOptions { rate_hz: Some(RATE) };
        let asset = character(&character_of(&rows), Some(flat(rows.len())), &opts).unwrap();
        // Ten unconnected triangles are no body.
        prop_assert_eq!(occluders(&asset, &asset.clips[0], 3), vec![]);
        let bare = Asset { mesh: Mesh::default().into(), ..asset };
        prop_assert_eq!(occluders(&bare, &bare.clips[0], 3), vec![]);
    });
}

#[test]
fn what_jumps_or_is_nowhere_hides_nothing() {
    let asset = asset_of_2000();
    let clip = |step, x: f32| {
        let tracks = Tracks {
            translations: vec![Track {
                target: 0,
                step,
                values: vec![Vec3::Y, Vec3::Y + Vec3::X * x],
            }],
            ..Tracks::default()
        };
        Clip::new("c", 30.0, 2, asset.rig.len(), tracks).unwrap()
    };
    assert!(!occluders(asset, &clip(false, 1e-3), 1).is_empty());
    assert_eq!(occluders(asset, &clip(true, 1e-3), 1), vec![]);
    assert_eq!(occluders(asset, &clip(false, 5.0), 1), vec![]);
    assert_eq!(occluders(asset, &clip(false, f32::NAN), 1), vec![]);
    assert_eq!(occluders(asset, &clip(false, 1e-3), 0), vec![]);
}
