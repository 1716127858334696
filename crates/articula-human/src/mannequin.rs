//! The mannequin as a character: skin in two tones, lips, brows and eyes.

use crate::body::Body;
use crate::pieces::Pieces;
use crate::primitive::{materials, mesh, part, rigid, skin};
use crate::{gait, gestures, head, skeleton};
use articula_core::source::{Character, Primitive, RawMesh};
use glam::Vec3;

/// Creates the mannequin with about this number of triangles.
pub(crate) fn character(triangles: usize) -> Character {
    let body = Body::new();
    let pieces = Pieces::new(&body, triangles);
    Character {
        name: "Reference human".to_owned(),
        skeleton: skeleton::skeleton(),
        articulation: Some(skeleton::articulation()),
        meshes: meshes(&body, &pieces),
        clips: vec![gestures::idle(), gait::walk(), gestures::wave()],
        materials: materials(&MATERIALS),
        ..Character::default()
    }
}

/// Names and linear colours of the materials; primitives refer to them by index.
const MATERIALS: [(&str, [f32; 3]); 7] = [
    ("skin", [0.74, 0.62, 0.47]),
    ("lips", [0.6, 0.43, 0.32]),
    ("brows", [0.3, 0.2, 0.12]),
    ("sclera", [0.82, 0.79, 0.74]),
    ("iris", [0.13, 0.1, 0.07]),
    ("pupil", [0.01, 0.01, 0.01]),
    ("suit", [0.4, 0.34, 0.29]),
];

fn meshes(body: &Body, pieces: &Pieces) -> Vec<RawMesh> {
    let skull = skeleton::joint("skullbase") as u16;
    let eyes = [
        skeleton::joint("l_eyeball_joint"),
        skeleton::joint("r_eyeball_joint"),
    ];
    let eye = |p: Vec3| eyes[usize::from(p.x < 0.0)] as u16;
    let eye_normal = |p: Vec3| {
        let center = Vec3::new(
            skeleton::EYE.x.copysign(p.x),
            skeleton::EYE.y,
            skeleton::EYE.z,
        );
        (p - center).normalize()
    };
    let iris = |i: usize| rigid(&pieces.eyes[i], 3 + i, eye_normal, eye);
    let brow = head::brow(&body.head);
    let lips = head::lips(&body.head);
    vec![
        mesh(
            "skin",
            two_tones(&skin(body, &pieces.skin), &pieces.skin.tones),
        ),
        mesh(
            "lips",
            vec![rigid(&pieces.lips, 1, |p| lips.normal(p), |_| skull)],
        ),
        mesh(
            "brows",
            vec![rigid(&pieces.brows, 2, |p| brow.normal(p), |_| skull)],
        ),
        mesh("eyes", (0..3).map(iris).collect()),
    ]
}

/// The skin in two primitives with the same vertices along their border: bare, then suit.
fn two_tones(skin: &Primitive, tones: &[u8]) -> Vec<Primitive> {
    let of = |tone: u8| -> Vec<[u32; 3]> {
        let pairs = skin.triangles.iter().zip(tones);
        pairs
            .filter(|(_, t)| **t == tone)
            .map(|(t, _)| *t)
            .collect()
    };
    vec![part(skin, &of(0), 0), part(skin, &of(1), 6)]
}
