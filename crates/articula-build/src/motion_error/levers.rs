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
