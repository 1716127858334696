//! Levers, second moments and area shares of the skin of each joint.
//!
//! Source: `docs/methods/motion-lod.md` 4.1. Besides the lever at rest there is a reach that bounds
//! every pose: the lever at rest is too small for a chain that is bent at rest.

use super::hull::JointHull;
use super::joint_lever::JointLever;
use articula_core::{Mesh, PosedMesh, Rig, SecondMoment};
use glam::{Quat, Vec3};

/// Minimum summed weight with which a vertex belongs to a joint's skin.
const MIN_WEIGHT: f32 = 0.3;

/// Computes the levers of all joints, in the rig's order. Without a mesh they follow from the
/// bones.
pub fn levers(rig: &Rig, mesh: &Mesh) -> Vec<JointLever> {
    let rest = Rest::of(rig, mesh);
    let gathered = gathered(rig, mesh, &rest);
    let area: f32 = rest.areas.iter().sum::<f32>().max(1e-12);
    let bones = if mesh.is_empty() {
        bone_levers(rig, &rest)
    } else {
        vec![BoneLever::default(); rig.len()]
    };
    gathered
        .iter()
        .enumerate()
        .map(|(j, g)| JointLever {
            rest_metres: g.rest.max(bones[j].rest).max(JointLever::FLOOR_METRES),
            reach_metres: g.reach.max(bones[j].reach).max(JointLever::FLOOR_METRES),
            second_moment: SecondMoment::of(rest.offsets(j, g).map(|x| (x, 1.0))),
            skin_share: (g.area / area).min(1.0),
        })
        .collect()
}

/// Computes the hulls of the skin of all joints, the same skin whose farthest vertex is the lever.
/// Without a mesh they are those of the joints below.
pub(crate) fn hulls(rig: &Rig, mesh: &Mesh) -> Vec<JointHull> {
    let rest = Rest::of(rig, mesh);
    let gathered = gathered(rig, mesh, &rest);
    let hull = |j: usize| {
        if mesh.is_empty() {
            let below = (j + 1..rig.len()).filter(|c| rig.is_at_or_below(*c, j));
            let bones = below.map(|c| rest.joints[c] - rest.joints[j]);
            return JointHull::of(bones.map(|x| rest.rotations[j].conjugate() * x));
        }
        JointHull::of(rest.offsets(j, &gathered[j]))
    };
    (0..rig.len()).map(hull).collect()
}

/// What belongs to each joint, of every vertex.
fn gathered(rig: &Rig, mesh: &Mesh, rest: &Rest) -> Vec<Gathered> {
    let mut gathered = vec![Gathered::default(); rig.len()];
    let mut below = Below::new(rig.len());
    for v in 0..mesh.len() {
        below.gather(rig, mesh, rest, v);
        for &j in &below.joints {
            let g = &mut gathered[j];
            g.reach = g.reach.max(below.reach[j]);
            if below.weight[j] >= MIN_WEIGHT {
                g.rest = g.rest.max(rest.skin[v].distance(rest.joints[j]));
                g.area += rest.areas[v];
                g.vertices.push(v as u32);
            }
        }
    }
    gathered
}

/// For each joint, the maximum number of moving joints on the paths from the root to any vertex
/// below it: the divisor of a tolerance with which errors along a chain stay within it. Without a
/// mesh, the paths to the joints themselves.
pub(crate) fn chain_counts(rig: &Rig, mesh: &Mesh, moving: &articula_core::JointSet) -> Vec<usize> {
    let mut counts = vec![1; rig.len()];
    let mut count = |ends: &mut dyn Iterator<Item = usize>| {
        let mut chain = articula_core::JointSet::EMPTY;
        for joint in ends {
            let mut at = Some(joint);
            while let Some(j) = at {
                chain.insert(j);
                at = rig.parent(j);
            }
        }
        let links = chain.intersection(moving);
        for j in links.iter() {
            counts[j] = counts[j].max(links.len());
        }
    };
    if mesh.is_empty() {
        (0..rig.len()).for_each(|joint| count(&mut std::iter::once(joint)));
    }
    for v in 0..mesh.len() {
        count(&mut mesh.influences_of(v).map(|(joint, _)| joint));
    }
    counts
}

#[derive(Clone, Default)]
struct Gathered {
    rest: f32,
    reach: f32,
    area: f32,
    vertices: Vec<u32>,
}

/// The figure at rest.
struct Rest {
    joints: Vec<Vec3>,
    rotations: Vec<Quat>,
    skin: Vec<Vec3>,
    areas: Vec<f32>,
}

impl Rest {
    fn of(rig: &Rig, mesh: &Mesh) -> Self {
        let mut posed = PosedMesh::new(rig, mesh);
        let skinned = posed.pose(rig.rest_pose()).skinned(&mesh.morph_weights);
        let model = &posed.model;
        let mut areas = vec![0.0; mesh.len()];
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| skinned.positions[v as usize]);
            let third = (b - a).cross(c - a).length() / 6.0;
            for v in t {
                areas[*v as usize] += third;
            }
        }
        Self {
            joints: (0..rig.len()).map(|j| model.position(j)).collect(),
            rotations: model
                .matrices
                .iter()
                .map(|m| m.to_scale_rotation_translation().1.normalize())
                .collect(),
            skin: skinned.positions,
            areas,
        }
    }

    /// Offsets of the skin of a joint from the joint, in the joint's own frame.
    fn offsets(&self, joint: usize, of: &Gathered) -> impl Iterator<Item = Vec3> {
        let skin = of.vertices.iter().map(|v| self.skin[*v as usize]);
        let (origin, to_joint) = (self.joints[joint], self.rotations[joint].conjugate());
        skin.map(move |v| to_joint * (v - origin))
    }
}

/// Summed weight and weighted reach of one vertex for every joint above it.
struct Below {
    joints: Vec<usize>,
    weight: Vec<f32>,
    reach: Vec<f32>,
}

impl Below {
    fn new(joints: usize) -> Self {
        Self {
            joints: Vec::new(),
            weight: vec![0.0; joints],
            reach: vec![0.0; joints],
        }
    }

    fn gather(&mut self, rig: &Rig, mesh: &Mesh, rest: &Rest, vertex: usize) {
        for j in self.joints.drain(..) {
            self.weight[j] = 0.0;
            self.reach[j] = 0.0;
        }
        for (joint, weight) in mesh.influences_of(vertex) {
            let mut way = rest.skin[vertex].distance(rest.joints[joint]);
            let mut at = Some(joint);
            while let Some(j) = at {
                if self.weight[j] == 0.0 {
                    self.joints.push(j);
                }
                self.weight[j] += weight;
                self.reach[j] += weight * way;
                at = rig.parent(j);
                way += at.map_or(0.0, |p| rest.joints[j].distance(rest.joints[p]));
            }
        }
    }
}

#[derive(Clone, Copy, Default)]
struct BoneLever {
    rest: f32,
    reach: f32,
}

/// Distance of the farthest descendant plus half of the last bone on the path to it: straight at
/// rest, and along the bones.
fn bone_levers(rig: &Rig, rest: &Rest) -> Vec<BoneLever> {
    let mut levers = vec![BoneLever::default(); rig.len()];
    for joint in 0..rig.len() {
        let Some(parent) = rig.parent(joint) else {
            continue;
        };
        let last = rest.joints[joint].distance(rest.joints[parent]);
        let mut way = 1.5 * last;
        let mut at = Some(parent);
        while let Some(j) = at {
            let straight = rest.joints[joint].distance(rest.joints[j]) + 0.5 * last;
            levers[j].rest = levers[j].rest.max(straight);
            levers[j].reach = levers[j].reach.max(way);
            at = rig.parent(j);
            way += at.map_or(0.0, |p| rest.joints[j].distance(rest.joints[p]));
        }
    }
    levers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{arm, figure};
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{Articulation, JointArticulation, JointSet, Region, Transform};
    use std::sync::Arc;

    fn near(found: f32, expected: f32) {
        assert!(
            (found - expected).abs() < 1e-5,
            "{found}, expected {expected}"
        );
    }

    #[test]
    fn levers_of_an_arm_by_hand() {
        // Rings of four vertices at 0.1414 m from the axis: at each joint, shared with its parent,
        // and half a metre above it.
        let mut asset = arm(3);
        // 0.02 m² on the top joint, 0.05 m² on the lowest.
        Arc::make_mut(&mut asset.mesh).triangles = vec![[20, 21, 22], [0, 4, 5]];
        let found = levers(&asset.rig, &asset.mesh);
        let aside = 0.02_f32;
        let last = (0.25 + aside).sqrt();
        for (lever, (up, bones)) in found.iter().zip([(2.5, 2.0), (1.5, 1.0), (0.5, 0.0)]) {
            near(lever.rest_metres, (up * up + aside).sqrt());
            near(lever.reach_metres, last + bones);
        }
        for (lever, share) in found.iter().zip([1.0, 2.0 / 7.0, 2.0 / 7.0]) {
            near(lever.skin_share, share);
        }
        // The skin of the top joint: both of its rings.
        let offsets = [0.0, 0.5].into_iter().flat_map(|up| {
            let sides = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
            sides.map(|(x, z)| (Vec3::new(0.1 * x, up, 0.1 * z), 1.0))
        });
        let expected = SecondMoment::of(offsets);
        for (a, b, view) in [
            (Quat::from_rotation_x(0.1), Quat::IDENTITY, Vec3::X),
            (Quat::from_rotation_y(0.1), Quat::IDENTITY, Vec3::X),
            (Quat::from_rotation_z(0.1), Quat::IDENTITY, Vec3::Y),
        ] {
            let part = found[2].second_moment.seen_fraction(a, b, view);
            near(part, expected.seen_fraction(a, b, view));
        }
    }

    #[test]
    fn skin_of_little_weight_counts_for_the_reach_only() {
        let mut asset = arm(2);
        // The upper ring of the upper joint moves by a quarter with it, the rest with the root.
        let mesh = Arc::make_mut(&mut asset.mesh);
        for v in 12..16 {
            mesh.binding_indices[2 * v + 1] = 0;
            mesh.weights[2 * v..2 * v + 2].copy_from_slice(&[0.25, 0.75]);
        }
        let found = levers(&asset.rig, &asset.mesh);
        near(found[1].rest_metres, 0.02_f32.sqrt());
        near(found[1].reach_metres, 0.25 * 0.27_f32.sqrt());
        near(found[0].rest_metres, 2.27_f32.sqrt());
        // 0.75 of the way straight from the root, 0.25 by the joint.
        let straight = 2.27_f32.sqrt();
        near(
            found[0].reach_metres,
            0.75 * straight + 0.25 * (1.0 + 0.27_f32.sqrt()),
        );
    }

    #[test]
    fn bones_stand_in_for_skin() {
        // Up, then to the side.
        let joint = |(j, offset): (usize, Vec3)| Joint {
            name: format!("j{j}"),
            parent: j.checked_sub(1),
            rest: Transform::from_translation(offset),
            in_skin: true,
        };
        let offsets = [Vec3::ZERO, Vec3::Y, Vec3::X * 2.0];
        let joints = offsets.into_iter().enumerate().map(joint).collect();
        let entry = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Torso,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![entry; 3],
        };
        let rig = Rig::new(&Skeleton { joints }, articulation).unwrap();
        let found = levers(&rig, &Mesh::default());
        // Half of the last bone, of 2 m, is beyond its joint.
        near(found[0].rest_metres, 5.0_f32.sqrt() + 1.0);
        near(found[0].reach_metres, 1.0 + 2.0 + 1.0);
        near(found[1].rest_metres, 3.0);
        near(found[1].reach_metres, 3.0);
        near(found[2].rest_metres, JointLever::FLOOR_METRES);
        near(found[2].reach_metres, JointLever::FLOOR_METRES);
    }

    #[test]
    fn chains_count_what_moves_on_them() {
        // 0 ─ 1 ─ 3 and 0 ─ 2.
        let asset = figure(&[None, Some(0), Some(0), Some(1)]);
        for mesh in [&asset.mesh, &Mesh::default()] {
            let count = |joints: &[usize]| {
                let moving: JointSet = joints.iter().copied().collect();
                chain_counts(&asset.rig, mesh, &moving)
            };
            assert_eq!(count(&[0, 1, 2, 3]), [3, 3, 2, 3]);
            assert_eq!(count(&[1, 2, 3]), [1, 2, 1, 2]);
            assert_eq!(count(&[]), [1; 4]);
        }
    }
}
