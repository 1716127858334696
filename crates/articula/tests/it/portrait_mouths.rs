//! Heads without teeth and tongue get default ones in portraits.

use articula::core::{Mesh, Viewport};
use articula::face::{HeadSurface, face_layout};
use articula::flat::portrait::PortraitOptions;
use articula::flatten::{FramedHead, PortraitReport, PortraitShot, TeethAndTongue, portrait};
use articula::glam::Vec3;
use articula::{CharacterFile, Executor, Figure};
use articula_human::HumanOptions;
use std::ops::Range;

/// The human with a face, without its pieces of some materials.
fn human(without: &[&str]) -> Figure {
    let options = HumanOptions {
        triangles: 6_000,
        face: true,
    };
    let mut human = articula_human::human(&options).unwrap();
    let materials = &human.materials;
    let is_out = |m: Option<usize>| m.is_some_and(|m| without.contains(&&*materials[m].name));
    for mesh in &mut human.meshes {
        mesh.primitives.retain(|p| !is_out(p.material));
    }
    human.clips.clear();
    Figure::new(CharacterFile::from_character("human", human)).unwrap()
}

fn shot(default_mouth: bool) -> PortraitShot {
    PortraitShot {
        clip: None,
        triangles: Some(200),
        viewport: Viewport {
            width_px: 64.0,
            height_px: 64.0,
            fov_y_radians: 0.4,
        },
        default_mouth,
        options: PortraitOptions {
            views: 1,
            yaw_limit_degrees: 10.0,
            pitch_limit_degrees: 5.0,
            ..PortraitOptions::default()
        },
    }
}

/// Where the teeth of a head are from, its triangles in 2D, and the head.
fn made<'a>(figure: &'a Figure, shot: &PortraitShot) -> (TeethAndTongue, usize, FramedHead<'a>) {
    let (head, portrait) = portrait(figure, shot, &Executor::default()).unwrap();
    let report = PortraitReport::new(
        "p.html".to_owned(),
        &portrait,
        &head,
        &[],
        Vec::new(),
        &shot.options,
    );
    let told = report.unwrap().teeth_and_tongue;
    (told, portrait.counts().triangles, head)
}

/// Offsets of vertices by the morph targets of an expression.
fn offsets(head: &FramedHead<'_>, name: &str, of: &Range<usize>) -> Vec<Vec3> {
    let source = head.source();
    let expression = source.expressions.iter().find(|e| e.name == name).unwrap();
    let mut moved = vec![Vec3::ZERO; of.len()];
    for (slot, weight) in &expression.morphs {
        for morph in source.mesh.morphs.iter().filter(|m| m.slot == *slot) {
            for (vertex, offset) in morph.vertices.iter().zip(&morph.positions) {
                if of.contains(&(*vertex as usize)) {
                    moved[*vertex as usize - of.start] += *weight * *offset;
                }
            }
        }
    }
    moved
}

fn mouth(mesh: &Mesh) -> Range<usize> {
    let part = mesh.parts.iter().find(|p| p.name == "default mouth");
    part.unwrap().vertices.clone()
}

#[test]
fn heads_without_teeth_and_tongue_get_default_ones() {
    let figure = human(&["teeth", "tongue"]);
    let (told, triangles, head) = made(&figure, &shot(true));
    assert_eq!(told, TeethAndTongue::Default);
    assert!(told.line().is_some());
    let (left_out, fewer, plain) = made(&figure, &shot(false));
    assert_eq!(left_out, TeethAndTongue::LeftOut);
    assert!(triangles > fewer + 20, "{triangles} and {fewer}");
    assert_eq!(plain.source().mesh, &*figure.asset.mesh);

    let layout = face_layout(&figure, &[]).unwrap();
    let point = |name: &str| {
        let found = layout.points.iter().find(|p| p.name == name).unwrap();
        Vec3::from(found.place_m)
    };
    let (lips, height) = (point("2.2").midpoint(point("2.3")), layout.height_m);
    let mesh = head.source().mesh;
    let all = mouth(mesh);
    let places = &mesh.positions[all.clone()];
    // Behind the lips, and in the head.
    let skin = HeadSurface::of(&figure).surface.positions;
    let back = skin.iter().map(|p| p.z).fold(f32::MAX, f32::min);
    for p in places {
        assert!(p.z < lips.z - 0.01 * height && p.z > back, "{p}");
        assert!((p.y - lips.y).abs() < 0.3 * height, "{p}");
    }
    // What is above the lips rests, teeth below and the tongue go down with the jaw.
    let open = offsets(&head, "jawOpen", &all);
    let near = |low: f32, high: f32| {
        let of = places.iter().zip(&open).filter(move |(p, _)| {
            let from = (**p - lips) / height;
            from.x.abs() < 0.1 && from.z > -0.2 && (low..high).contains(&from.y)
        });
        of.map(|(_, moved)| moved.y / height).collect::<Vec<f32>>()
    };
    let (upper, lower) = (near(0.05, 0.17), near(-0.19, -0.08));
    assert!(
        upper.len() > 5 && upper.iter().all(|y| *y == 0.0),
        "{upper:?}"
    );
    assert!(
        lower.len() > 5 && lower.iter().all(|y| *y < -0.05),
        "{lower:?}"
    );
    // The tongue comes to the front, in an open mouth.
    let out = offsets(&head, "tongueOut", &all);
    let tip = out.iter().map(|m| m.z / height).fold(0.0, f32::max);
    assert!(tip > 0.08, "{tip}");
    let still = offsets(&head, "browInnerUp", &all);
    assert!(still.iter().all(|m| *m == Vec3::ZERO));
}

#[test]
fn heads_with_their_own_stay_as_they_are() {
    for without in [&[][..], &["tongue"]] {
        let figure = human(without);
        let (told, _, head) = made(&figure, &shot(true));
        assert_eq!((told, told.line()), (TeethAndTongue::Own, None));
        assert_eq!(head.source().mesh, &*figure.asset.mesh);
    }
}
