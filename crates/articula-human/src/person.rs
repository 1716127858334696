//! The human with a face as a character: meshes, materials and clips.

use crate::body::Body;
use crate::expression::{self, Expressions};
use crate::eyes::EYE;
use crate::person_pieces::{Piece, Sheet, pieces};
use crate::polygonise::Surface;
use crate::primitive::{materials, mesh, part, rigid, skin};
use crate::{gait, gestures, morphs, performance, person_head, skeleton};
use articula_core::source::{Character, Primitive, RawMesh, Skeleton};
use glam::{Affine3A, Vec3};

/// Names and linear colours of the materials of the human with a face.
const MATERIALS: [(&str, [f32; 3]); 14] = [
    ("skin", [0.71, 0.42, 0.29]),
    ("mouth", [0.22, 0.05, 0.045]),
    ("shirt", [0.16, 0.36, 0.43]),
    ("trousers", [0.055, 0.065, 0.11]),
    ("shoes", [0.30, 0.19, 0.12]),
    ("lips", [0.56, 0.24, 0.19]),
    ("lids", [0.66, 0.37, 0.26]),
    ("brows", [0.075, 0.042, 0.026]),
    ("hair", [0.085, 0.048, 0.03]),
    ("teeth", [0.82, 0.79, 0.72]),
    ("tongue", [0.5, 0.17, 0.15]),
    ("sclera", [0.84, 0.82, 0.78]),
    ("iris", [0.12, 0.17, 0.12]),
    ("pupil", [0.01, 0.01, 0.01]),
];

/// Joints of the eyes, each with the sign of its side.
const EYEBALLS: [(&str, f32); 2] = [("l_eyeball_joint", 1.0), ("r_eyeball_joint", -1.0)];

/// Creates the human with about this number of triangles.
pub(crate) fn character(triangles: usize) -> Character {
    let body = person_head::body();
    let pieces = pieces(&body, triangles);
    Character {
        name: "Reference human".to_owned(),
        skeleton: skeleton(),
        articulation: Some(skeleton::articulation()),
        meshes: meshes(&body, &pieces),
        clips: vec![
            performance::idle(),
            gait::walk(),
            gestures::wave(),
            performance::talk(),
        ],
        materials: materials(&MATERIALS),
        ..Character::default()
    }
}

/// The skeleton of the mannequin with the centres of these larger eyes.
fn skeleton() -> Skeleton {
    let mut skeleton = skeleton::skeleton();
    for (name, sign) in EYEBALLS {
        let shift = (EYE - skeleton::EYE) * Vec3::new(sign, 1.0, 1.0);
        skeleton.joints[skeleton::joint(name)].rest.translation += shift;
    }
    skeleton
}

/// Face, body and hair; the bare skin of the head belongs to the face, that of the arms to the body.
fn meshes(body: &Body, pieces: &[Piece]) -> Vec<RawMesh> {
    let expressions = Expressions::new(&person_head::closed_head());
    let [mut face, mut clothes, mut hair] = [const { Vec::new() }; 3];
    for piece in pieces {
        match piece.sheet {
            Sheet::Skin => {
                let (mut head, rest) = skin_parts(body, &piece.surface);
                for part in &mut head {
                    morphs::add(part, Sheet::Skin, &expressions);
                }
                face.extend(head);
                clothes.extend(rest);
            }
            Sheet::Hair => hair.push(small_piece(piece)),
            sheet => {
                let mut part = small_piece(piece);
                morphs::add(&mut part, sheet, &expressions);
                face.push(part);
            }
        }
    }
    let mut meshes = vec![
        mesh("face", face),
        mesh("body", clothes),
        mesh("hair", hair),
    ];
    meshes[0].morph_names = expression::names();
    meshes[0].morph_weights = vec![0.0; meshes[0].morph_names.len()];
    // The mesh binds to the centres of the mannequin.
    for mesh in &mut meshes {
        for (name, sign) in EYEBALLS {
            let center = EYE * Vec3::new(sign, 1.0, 1.0);
            mesh.skin.inverse_bind[skeleton::joint(name)] = Affine3A::from_translation(-center);
        }
    }
    meshes
}

/// The skin by its tones: the bare parts of the head, and all others.
fn skin_parts(body: &Body, surface: &Surface) -> (Vec<Primitive>, Vec<Primitive>) {
    let whole = skin(body, surface);
    let (mut face, mut rest) = (Vec::new(), Vec::new());
    for tone in person_head::BARE..=person_head::SHOES {
        let of_tone = surface.tones.iter().zip(&whole.triangles);
        let triangles = of_tone.filter(|(t, _)| **t == tone).map(|(_, t)| *t);
        let of_face = |t: &[u32; 3]| {
            tone <= person_head::INSIDE && whole.positions[t[0] as usize].y > person_head::ARMS
        };
        let (head, others): (Vec<_>, Vec<_>) = triangles.partition(of_face);
        for (triangles, parts) in [(head, &mut face), (others, &mut rest)] {
            if !triangles.is_empty() {
                parts.push(part(&whole, &triangles, usize::from(tone)));
            }
        }
    }
    (face, rest)
}

/// A piece on one joint: an eyeball on its own, all others on the skull.
fn small_piece(piece: &Piece) -> Primitive {
    let skull = skeleton::joint("skullbase") as u16;
    let balls = EYEBALLS.map(|(name, _)| skeleton::joint(name) as u16);
    let side = |p: Vec3| Vec3::new(if p.x < 0.0 { -1.0 } else { 1.0 }, 1.0, 1.0);
    let hair = person_head::hair();
    let normal = |p: Vec3| match piece.sheet {
        Sheet::Eyeball => (p - EYE * side(p)).normalize(),
        Sheet::Hair => hair.normal(p),
        // The triangles' own.
        _ => Vec3::ZERO,
    };
    let joint = |p: Vec3| match piece.sheet {
        Sheet::Eyeball => balls[usize::from(p.x < 0.0)],
        _ => skull,
    };
    rigid(&piece.surface, piece.material, normal, joint)
}
