//! The channels of a face as morph targets of points, one for each channel, on a rig of one joint.
//!
//! Form: `docs/formats/afp2.md`, part 2.

use crate::abp2::face_channels::{COUNT, field_of, is_exact, metres_per_weight};
use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, Binding, JointArticulation, Mesh, Mismatch, Morph, Region, Rig, Transform,
};
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// What a field that is exact may be off by at the tolerance: less than what rounding takes away.
const EXACT: f64 = 0.45;

/// The rig: a head, which does not move.
///
/// # Errors
/// As [`Rig::new`]; none is known.
pub(super) fn rig() -> Result<Rig, Mismatch> {
    let head = Joint {
        name: "head".into(),
        parent: None,
        rest: Transform::default(),
        in_skin: true,
    };
    let known = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Face,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![known],
    };
    Rig::new(&Skeleton { joints: vec![head] }, articulation)
}

/// The points: each is moved by one channel, by as much as the parameter moves its feature point on
/// an average face.
pub(super) fn mesh(tolerance_metres: f64) -> Mesh {
    let metres = |channel: usize| match is_exact(channel) {
        true => (tolerance_metres / EXACT) as f32,
        false => metres_per_weight(field_of(channel).0),
    };
    let morph = |channel: usize| Morph {
        slot: channel as u16,
        vertices: vec![channel as u32],
        positions: vec![metres(channel) * Vec3::X],
        normals: vec![Vec3::ZERO],
    };
    Mesh {
        positions: vec![Vec3::ZERO; COUNT],
        normals: vec![Vec3::Y; COUNT],
        texcoords: vec![Vec2::ZERO; COUNT],
        colors: vec![Vec4::ONE; COUNT],
        influences: 1,
        binding_indices: vec![0; COUNT],
        weights: vec![1.0; COUNT],
        bindings: vec![Binding {
            joint: 0,
            inverse_bind: Affine3A::IDENTITY,
        }],
        morphs: (0..COUNT).map(morph).collect(),
        morph_weights: vec![0.0; COUNT],
        morph_slots: vec![0],
        ..Mesh::default()
    }
}
