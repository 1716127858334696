//! Real characters: bounds of their clips contain every vertex, also between frames, and are tight.

use crate::real::bytes;
use articula::build::ClipOptions;
use articula::build::motion_bounds;
use articula::build::{Asset, character};
use articula::core::{
    Articulation, Clip, JointArticulation, PosedMesh, Region, Wrap, sample, sample_morphs,
};
use articula::formats::{Limits, gltf};
use glam::Vec3;

/// The character of a file with its first clips.
fn asset(name: &str, clips: usize) -> Option<Asset> {
    let bytes = bytes(&format!("glb/{name}"))?;
    let mut beside = |uri: &str| Err(format!("{uri} lies beside"));
    let file = gltf::read(&bytes, &Limits::default(), &mut beside).unwrap();
    let mut source = file.value.character;
    source.clips.truncate(clips);
    let joint = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![joint; source.skeleton.joints.len()],
    };
    Some(character(&source, Some(articulation), &ClipOptions::default()).unwrap())
}

fn points(asset: &Asset, clip: &Clip, secs: f64) -> Vec<Vec3> {
    let (rig, mesh) = (&asset.rig, &asset.mesh);
    let mut pose = rig.rest_pose().clone();
    let mut weights = mesh.morph_weights.clone();
    sample(clip, secs, Wrap::Loop, &rig.all(), &mut pose);
    sample_morphs(clip, secs, Wrap::Loop, &mut weights);
    PosedMesh::new(rig, mesh)
        .pose(&pose)
        .skinned(&weights)
        .positions
}

#[test]
fn no_vertex_of_a_real_character_leaves_its_bound() {
    for name in [
        "pab_arnaud.glb",
        "KayKit_Knight.glb",
        "RobotExpressive.glb",
        "AnimatedMorphCube.glb",
        "CesiumMan.glb",
        "Fox.glb",
    ] {
        let Some(asset) = asset(name, 3) else {
            continue;
        };
        let bounds = motion_bounds(&asset, 0.0).unwrap();
        for (clip, bounds) in asset.clips.iter().zip(&bounds.clips) {
            let (mut least, mut greatest) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for i in 0..50 {
                // Times that are not on the frames of any rate, over two loops.
                let secs = f64::from(i) * 0.041_421 * f64::from(clip.duration_secs());
                let bound = bounds.over(secs, 0.0, 1.0, Wrap::Loop);
                for p in points(&asset, clip, secs) {
                    assert!(bound.contains(p), "{name} {}: {p} {bound:?}", clip.name);
                    least = least.min(p);
                    greatest = greatest.max(p);
                }
            }
            let whole = bounds.whole();
            let spare = (least - whole.least)
                .max(whole.greatest - greatest)
                .max_element();
            let (box_ball, ball) = (0.5 * (greatest - least).length(), whole.sphere.radius);
            println!(
                "{name} {}: {ball:.3} m, box {box_ball:.3}, spare {spare:.3}",
                clip.name
            );
            // A bound much larger than its content is useless.
            assert!(
                ball < 1.25 * box_ball,
                "{name} {}: {ball} {box_ball}",
                clip.name
            );
        }
        println!("{name}: reach {:.3} m", bounds.reach_metres);
    }
}
