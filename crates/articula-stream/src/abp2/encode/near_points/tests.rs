//! Bounds against the distances of all points.

use super::*;
use crate::abp2::encode::skin_points::offsets_by_vertex;
use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, Binding, JointArticulation, Mesh, Morph, Region, Rig, Transform,
};
use articula_mutate::Dice;
use glam::Quat;

/// Joints of a chain along an arm of one metre, which ends at `x = 1`.
const JOINTS: usize = 5;
const RINGS: usize = 60;
const AROUND: usize = 8;

pub(in crate::abp2::encode) fn rig() -> Rig {
    let joint = |j: usize| Joint {
        name: format!("joint {j}"),
        parent: j.checked_sub(1),
        rest: Transform {
            translation: Vec3::X * if j == 0 { 0.0 } else { 1.0 / JOINTS as f32 },
            ..Transform::default()
        },
        in_skin: true,
    };
    let known = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::ALL[0],
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![known; JOINTS],
    };
    let joints = (0..JOINTS).map(joint).collect();
    Rig::new(&Skeleton { joints }, articulation).unwrap()
}

/// A tube around the chain that follows two joints everywhere; a morph target moves part of it.
pub(in crate::abp2::encode) fn tube() -> Mesh {
    let mut mesh = Mesh {
        influences: 2,
        morph_weights: vec![0.5],
        ..Mesh::default()
    };
    for ring in 0..RINGS {
        let along = ring as f32 / RINGS as f32 * JOINTS as f32;
        let joint = along.floor();
        for side in 0..AROUND {
            let angle = std::f32::consts::TAU * side as f32 / AROUND as f32;
            let around = 0.04 * Vec3::new(0.0, angle.cos(), angle.sin());
            mesh.positions
                .push(Vec3::X * along / JOINTS as f32 + around);
            let next = (joint as u16 + 1).min(JOINTS as u16 - 1);
            mesh.binding_indices.extend([joint as u16, next]);
            mesh.weights.extend([1.0 - (along - joint), along - joint]);
        }
    }
    let binding = |joint: usize| Binding {
        joint: joint as u16,
        inverse_bind: Affine3A::from_translation(Vec3::NEG_X * joint as f32 / JOINTS as f32),
    };
    mesh.bindings = (0..JOINTS).map(binding).collect();
    mesh.morphs.push(Morph {
        slot: 0,
        vertices: (100..180).collect(),
        positions: (0..80).map(|v| Vec3::Y * v as f32 / 800.0).collect(),
        normals: vec![Vec3::ZERO; 80],
    });
    mesh
}

#[test]
fn bounds_miss_no_point() {
    for weights in [
        (0.0, 0.0),
        (0.5, 0.5),
        (0.5, 0.4999),
        (0.2, 0.3),
        (-0.1, 0.0),
    ] {
        check(weights);
    }
}

/// Weights of the morph target in the true and the coded pose.
fn check((right_weight, found_weight): (f32, f32)) {
    let (rig, mesh) = (rig(), tube());
    let points = SkinPoints::of_vertices(&mesh, &offsets_by_vertex(&mesh), 0..mesh.positions.len());
    let near = NearPoints::of(&points);
    let (right_weights, found_weights) = (&[right_weight][..], &[found_weight][..]);
    let weights = (right_weights, found_weights);
    let mut dice = Dice::new(7);
    let mut turned = |most: f32, weights: &[f32]| {
        let mut posed = points.posed(&rig);
        for rotation in &mut posed.local.rotations {
            let axis = Vec3::from([(); 3].map(|()| dice.roll(2001) as f32 / 1000.0 - 1.0));
            *rotation *= Quat::from_scaled_axis(most * axis);
        }
        points.skin(&rig, weights, &mut posed);
        posed
    };
    let right = turned(0.0, right_weights);
    let mut left_out = 0;
    for most in [1e-5, 1e-4, 1e-3, 1e-2] {
        let found = turned(most, found_weights);
        let pairs = right.points.iter().zip(&found.points);
        let distances: Vec<f64> = pairs.map(|(a, b)| f64::from(a.distance(*b))).collect();
        let greatest = distances.iter().copied().fold(0.0, f64::max);
        assert!(greatest > 0.0);
        for part in [0.0, 0.5, 0.9, 0.999, 1.0, 1.1] {
            let limit = part * greatest;
            let mut expected = (None, limit);
            for (point, distance) in distances.iter().enumerate() {
                if *distance > expected.1 {
                    expected = (Some(point), *distance);
                }
            }
            let right = (&right.palette[..], right_weights);
            let found = (&found.palette[..], found_weights);
            assert_eq!(near.farthest(&points, right, found, limit), expected.0);
        }
        let pairs = right.palette.iter().zip(&found.palette);
        let apart: Vec<Apart> = pairs.map(|(a, b)| Apart::of(a, b)).collect();
        let blocks = near.groups.iter().flat_map(|group| &group.blocks);
        let bounds = blocks.map(|(block, _)| f64::from(block.bound(&apart, block.moved(weights))));
        left_out += bounds.filter(|bound| *bound <= greatest).count();
    }
    // Bounds are of use: the blocks of the upper arm move less than the hand.
    let blocks: usize = near.groups.iter().map(|group| group.blocks.len()).sum();
    assert!(left_out > 2 * blocks, "{left_out}");
}
