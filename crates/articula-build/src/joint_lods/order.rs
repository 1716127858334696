//! The order in which joints are merged: greedily, the joint whose fold adds the least error.
//!
//! Source: `docs/methods/motion-lod.md` part 8, `docs/methods/runtime.md` 4.1. A fold moves the
//! skin of a joint to its parent, relative to which the joint then stays in the mean pose; kept
//! joints keep their true transforms. For near levels only leaves among the kept joints are folded,
//! so that a level contains the ancestors of its joints. To bound the work, the cost of a candidate
//! is evaluated on the watched vertices that it moves, and again only after a fold that touched one
//! of them.

use super::JointLodOptions;
use super::moments::{model_of, pose_of, share_frames, spread_frames};
use super::watch::{Watched, skin_of};
use crate::character::Asset;
use articula_core::percentile;
use articula_core::{JointSet, LocalPose, Mesh, ModelPose, Transform};
use glam::{Affine3A, Vec3A};

/// Maximum product of frames and joints.
const MAX_MATRICES: usize = 40_000;

/// Order of a rig's joints, with the error of each prefix.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Order {
    /// Joints in the reverse order of merging: the last to be merged comes first.
    pub(super) joints: Vec<u16>,
    /// `errors_metres[n]` is the error with the first `n` joints kept, for `n` of at least 1: 95th
    /// percentile over the sampled vertices, maximum over frames. Never rises with `n`.
    pub(super) errors_metres: Vec<f32>,
}

/// Selects which joints may be folded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Folds {
    /// Leaves among the kept joints, so that a level contains the ancestors of its joints.
    Leaves,
    /// Any joint: its children keep their true transforms and attach to the next ancestor.
    Any,
}

/// Merges one joint after another; protected joints go last.
pub(super) fn order(
    asset: &Asset,
    mean: &LocalPose,
    folds: Folds,
    opts: &JointLodOptions,
) -> Order {
    let mut fold = Fold::new(asset, mean, folds, opts);
    let count = asset.rig.len();
    let mut errors_metres = vec![0.0; count + 1];
    let mut joints = vec![0; count];
    for kept in (0..count).rev() {
        let joint = fold.cheapest(&opts.protected);
        joints[kept] = joint as u16;
        fold.merge(joint);
        errors_metres[kept] = if kept == 0 {
            f32::INFINITY
        } else {
            fold.error_metres()
        };
    }
    // Errors of different joints may cancel out; a longer prefix never has a larger error.
    for n in 1..=count {
        errors_metres[n] = errors_metres[n].min(errors_metres[n - 1]);
    }
    errors_metres[0] = errors_metres[1];
    Order {
        joints,
        errors_metres,
    }
}

/// Joints that no level may merge: the protected ones, the roots that carry skin, and their
/// ancestors.
pub(super) fn never_merged(asset: &Asset, mesh: &Mesh, protected: &JointSet) -> JointSet {
    let asked = protected.intersection(&asset.rig.all());
    let all = asked.union(&skinned_roots(asset, mesh));
    articula_core::loa::with_ancestors(&asset.rig, &all)
}

/// Roots with skin on themselves or a descendant.
pub(super) fn skinned_roots(asset: &Asset, mesh: &Mesh) -> JointSet {
    let used = (0..mesh.len()).flat_map(|v| mesh.influences_of(v));
    let mut carriers = JointSet::EMPTY;
    used.for_each(|(joint, _)| carriers.insert(joint));
    let root_of = |mut joint: usize| {
        while let Some(parent) = asset.rig.parent(joint) {
            joint = parent;
        }
        joint
    };
    carriers.iter().map(root_of).collect()
}

/// Skin of one watched vertex on one joint: the summed weight, and the weighted position in the
/// space of the joint.
#[derive(Debug, Clone, Copy)]
struct Hang {
    vertex: u32,
    weight: f32,
    point: Vec3A,
}

/// State of the greedy search.
struct Fold {
    folds: Folds,
    /// Nearest kept ancestor of each joint, and the mean transform of the joint relative to it.
    above: Vec<Option<usize>>,
    mean: Vec<Affine3A>,
    models: Vec<ModelPose>,
    watched: Watched,
    /// Skin attached to each joint, in ascending order of vertices.
    hangs: Vec<Vec<Hang>>,
    /// `errors[frame][watched vertex]`: displacement so far, in metres.
    errors: Vec<Vec<Vec3A>>,
    children: Vec<u16>,
    depths: Vec<u16>,
    kept: JointSet,
    /// Error that folding each joint would add; `None` where it must be computed again.
    costs: Vec<Option<f64>>,
}

impl Fold {
    fn new(asset: &Asset, mean: &LocalPose, folds: Folds, opts: &JointLodOptions) -> Self {
        let rig = &asset.rig;
        let mesh = skin_of(asset);
        let watched = Watched::draw(&mesh, rig.len(), opts.vertices, opts.seed);
        let frames = opts.frames.min(MAX_MATRICES / rig.len()).max(1);
        let counts = share_frames(&asset.clips, frames);
        let mut models = Vec::new();
        for (clip, count) in asset.clips.iter().zip(counts) {
            let at = spread_frames(clip.frames(), count).into_iter();
            models.extend(at.map(|f| model_of(asset, &pose_of(asset, clip, f))));
        }
        let mut children = vec![0; rig.len()];
        let mut depths = vec![0; rig.len()];
        for joint in 0..rig.len() {
            if let Some(parent) = rig.parent(joint) {
                children[parent] += 1;
                depths[joint] = depths[parent] + 1;
            }
        }
        Self {
            folds,
            above: (0..rig.len()).map(|j| rig.parent(j)).collect(),
            mean: (0..rig.len())
                .map(|j| mean.get(j))
                .map(Transform::to_affine)
                .collect(),
            errors: vec![vec![Vec3A::ZERO; watched.vertices.len()]; models.len()],
            models,
            hangs: hangs(&mesh, &watched, rig.len()),
            watched,
            children,
            depths,
            kept: rig.all(),
            costs: vec![None; rig.len()],
        }
    }

    /// The kept joint with the smallest cost; protected joints and roots with skin come last.
    fn cheapest(&mut self, protected: &JointSet) -> usize {
        let may = |j: &usize| self.folds == Folds::Any || self.children[*j] == 0;
        let candidates: Vec<usize> = self.kept.iter().filter(may).collect();
        for &joint in &candidates {
            if self.costs[joint].is_none() {
                self.costs[joint] = Some(self.cost(joint));
            }
        }
        let rank = |joint: usize| {
            let is_tree = !self.hangs[joint].is_empty() || self.children[joint] > 1;
            let is_anchor = self.above[joint].is_none() && is_tree;
            let cost = self.costs[joint].unwrap_or(0.0);
            (is_anchor, protected.contains(joint), cost)
        };
        let better = |a: usize, b: usize| {
            let (ra, rb) = (rank(a), rank(b));
            let order = (ra.0, ra.1).cmp(&(rb.0, rb.1));
            let order = order.then(ra.2.total_cmp(&rb.2));
            // Ties: the deeper joint first, then the one with the larger index.
            order.then((self.depths[b], b).cmp(&(self.depths[a], a)))
        };
        let first = candidates.into_iter().min_by(|a, b| better(*a, *b));
        // A non-empty set has a leaf.
        first.unwrap_or(0)
    }

    /// Error that folding a joint would add over all frames and watched vertices.
    fn cost(&self, joint: usize) -> f64 {
        let mut added = 0.0;
        for (model, errors) in self.models.iter().zip(&self.errors) {
            let change = self.change(joint, model);
            for hang in &self.hangs[joint] {
                let before = errors[hang.vertex as usize];
                let after = before + change.moved(hang);
                added += harm(after) - harm(before);
            }
        }
        if added.is_nan() { f64::INFINITY } else { added }
    }

    fn change(&self, joint: usize, model: &ModelPose) -> Change {
        let folded = match self.above[joint] {
            Some(parent) => model.matrices[parent] * self.mean[joint],
            None => self.mean[joint],
        };
        Change::between(&model.matrices[joint], &folded)
    }

    fn merge(&mut self, joint: usize) {
        self.kept.remove(joint);
        let moved = std::mem::take(&mut self.hangs[joint]);
        let mut touched = vec![false; self.watched.vertices.len()];
        for hang in &moved {
            touched[hang.vertex as usize] = true;
        }
        for f in 0..self.models.len() {
            let change = self.change(joint, &self.models[f]);
            for hang in &moved {
                self.errors[f][hang.vertex as usize] += change.moved(hang);
            }
        }
        if let Some(parent) = self.above[joint] {
            self.children[parent] -= 1;
            let local = self.mean[joint];
            let folded = moved.iter().map(|h| Hang {
                point: local.matrix3 * h.point + local.translation * h.weight,
                ..*h
            });
            self.hangs[parent] = joined(&self.hangs[parent], folded.collect());
            self.costs[parent] = None;
        }
        let hung = |j: &usize| self.above[*j] == Some(joint);
        let below: Vec<usize> = self.kept.iter().filter(hung).collect();
        for j in below {
            self.above[j] = self.above[joint];
            self.mean[j] = self.mean[joint] * self.mean[j];
            self.costs[j] = None;
            if let Some(parent) = self.above[joint] {
                self.children[parent] += 1;
            }
        }
        for (cost, hangs) in self.costs.iter_mut().zip(&self.hangs) {
            if cost.is_some() && hangs.iter().any(|h| touched[h.vertex as usize]) {
                *cost = None;
            }
        }
    }

    /// 95th percentile over the uniform random sample of vertices, maximum over frames.
    fn error_metres(&self) -> f32 {
        let mut lengths = Vec::with_capacity(self.watched.vertices.len());
        let mut worst = 0.0f32;
        for errors in &self.errors {
            let drawn = errors.iter().zip(&self.watched.drawn).filter(|(_, d)| **d);
            lengths.clear();
            lengths.extend(drawn.map(|(e, _)| e.length()));
            worst = worst.max(percentile(&mut lengths, 0.95));
        }
        worst
    }
}

/// Cost of a displacement. The fourth power lies between the mean, which lets a hand fly off for
/// the sake of a still chest, and the maximum, which depends on a single vertex.
fn harm(displacement: Vec3A) -> f64 {
    let squared = f64::from(displacement.length_squared());
    squared * squared
}

/// Difference of two matrices.
struct Change {
    linear: glam::Mat3A,
    offset: Vec3A,
}

impl Change {
    fn between(from: &Affine3A, to: &Affine3A) -> Self {
        Self {
            linear: to.matrix3 - from.matrix3,
            offset: to.translation - from.translation,
        }
    }

    fn moved(&self, hang: &Hang) -> Vec3A {
        self.linear * hang.point + self.offset * hang.weight
    }
}

fn hangs(mesh: &Mesh, watched: &Watched, joints: usize) -> Vec<Vec<Hang>> {
    let mut hangs = vec![Vec::<Hang>::new(); joints];
    for (at, &vertex) in watched.vertices.iter().enumerate() {
        let position = Vec3A::from(mesh.positions[vertex as usize]);
        let first = vertex as usize * mesh.influences;
        for i in first..first + mesh.influences {
            let weight = mesh.weights[i];
            if weight.is_nan() || weight <= 0.0 {
                continue;
            }
            let binding = &mesh.bindings[usize::from(mesh.binding_indices[i])];
            let point = binding.inverse_bind.transform_point3a(position) * weight;
            let list = &mut hangs[usize::from(binding.joint)];
            match list.last_mut().filter(|h| h.vertex == at as u32) {
                Some(hang) => {
                    hang.weight += weight;
                    hang.point += point;
                }
                None => list.push(Hang {
                    vertex: at as u32,
                    weight,
                    point,
                }),
            }
        }
    }
    hangs
}

/// Merges two lists that are sorted by vertex.
fn joined(a: &[Hang], mut b: Vec<Hang>) -> Vec<Hang> {
    let mut all = a.to_vec();
    all.append(&mut b);
    all.sort_by_key(|h| h.vertex);
    let mut out: Vec<Hang> = Vec::with_capacity(all.len());
    for hang in all {
        match out.last_mut().filter(|h| h.vertex == hang.vertex) {
            Some(last) => {
                last.weight += hang.weight;
                last.point += hang.point;
            }
            None => out.push(hang),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::mean_pose::mean_pose;
    use super::super::test_figures::{arm, figure, moving};
    use super::*;
    use glam::Quat;
    use std::sync::Arc;

    fn order_of(asset: &Asset, protected: JointSet) -> Order {
        folded(asset, protected, Folds::Leaves)
    }

    fn folded(asset: &Asset, protected: JointSet, folds: Folds) -> Order {
        let opts = JointLodOptions {
            protected,
            ..JointLodOptions::default()
        };
        order(asset, &mean_pose(asset), folds, &opts)
    }

    fn swing(joints: usize, joint: usize, radians: f32) -> articula_core::Clip {
        let turn = |i: i32| Quat::from_rotation_z(radians * (i as f32 / 5.0 - 1.0));
        let frames: Vec<Quat> = (0..=10).map(turn).collect();
        moving(joints, joint, &frames)
    }

    #[test]
    fn what_moves_least_goes_first_and_ancestors_stay() {
        // A star: four arms on one joint that swing by different angles.
        let mut asset = figure(&[None, Some(0), Some(0), Some(0), Some(0)]);
        for (joint, angle) in [(1, 0.2), (2, 0.6), (3, 0.1), (4, 0.4)] {
            asset.clips.push(swing(5, joint, angle));
        }
        let order = order_of(&asset, JointSet::EMPTY);
        assert_eq!(order.joints, [0, 2, 4, 1, 3]);
        assert!(order.errors_metres.windows(2).all(|w| w[0] >= w[1]));
        assert_eq!(order.errors_metres[5], 0.0);
        let kept = order_of(&asset, JointSet::from_iter([3]));
        assert_eq!(kept.joints, [0, 3, 2, 4, 1], "protected outlasts the rest");
    }

    #[test]
    fn the_error_of_a_fold_by_hand() {
        // Two joints; the upper swings by 0.2 about its mean. Its own skin lies half a metre above
        // and 0.1 from the axis in x: the chord of the farther corner.
        let mut asset = arm(2);
        asset.clips = vec![swing(2, 1, 0.2)];
        let order = order_of(&asset, JointSet::EMPTY);
        let chord = 2.0 * (0.1f32).sin() * (0.5f32.powi(2) + 0.1f32.powi(2)).sqrt();
        assert!((order.errors_metres[1] - chord).abs() < 1e-5);
    }

    #[test]
    fn skin_of_a_folded_joint_moves_with_the_joint_that_took_it() {
        // The last joint never turns, so it folds for nothing; its skin then is that of the middle
        // one, which swings by 0.2 about its mean. The farthest corner is 1.5 m above the middle
        // joint.
        let mut asset = arm(3);
        asset.clips = vec![swing(3, 1, 0.2)];
        let order = order_of(&asset, JointSet::EMPTY);
        assert_eq!(order.joints, [0, 1, 2]);
        assert!(order.errors_metres[2] < 1e-6);
        let chord = 2.0 * (0.1f32).sin() * (1.5f32.powi(2) + 0.1f32.powi(2)).sqrt();
        assert!(
            (order.errors_metres[1] - chord).abs() < 1e-5,
            "{:?}",
            order.errors_metres
        );
    }

    #[test]
    fn joints_without_skin_cost_nothing_and_go_first() {
        let mut asset = arm(4);
        // The end of the arm moves most but has no skin.
        asset.clips = vec![swing(4, 3, 1.0), swing(4, 1, 0.1)];
        let mesh = Arc::make_mut(&mut asset.mesh);
        let bare = mesh.positions.len() - 8;
        mesh.positions.truncate(bare);
        mesh.weights.truncate(bare * 2);
        mesh.binding_indices.truncate(bare * 2);
        let order = order_of(&asset, JointSet::EMPTY);
        assert_eq!(order.joints[3], 3);
        assert_eq!(order.errors_metres[3], 0.0);
    }

    #[test]
    fn a_second_root_with_skin_outlasts_all_others() {
        let mut asset = figure(&[None, Some(0), None, Some(2)]);
        asset.clips = vec![swing(4, 1, 1.0), swing(4, 3, 0.5)];
        let order = order_of(&asset, JointSet::EMPTY);
        assert_eq!(order.joints[2..], [1, 3]);
        let never = never_merged(&asset, &asset.mesh, &JointSet::from_iter([3, 900]));
        assert_eq!(never, JointSet::from_iter([0, 2, 3]));
    }

    #[test]
    fn skin_hangs_on_each_joint_by_its_weight_in_the_space_of_the_joint() {
        let mut mesh = Mesh::clone(&arm(2).mesh);
        mesh.weights[2..4].copy_from_slice(&[f32::NAN, 1.0]);
        let watched = Watched {
            vertices: vec![0, 1, 5, 9],
            drawn: vec![true; 4],
        };
        let hangs = hangs(&mesh, &watched, 2);
        let corner = |x: f32, y: f32, z: f32| Vec3A::new(x, y, z);
        // Vertices by their place among the watched ones, with weight and weighted point: both
        // halves of vertex 0 are on the root, one of vertex 1 is not a number, and vertex 9 is
        // shared by both joints, at the second of which it lies.
        let expected = [
            vec![
                (0, 1.0, corner(0.1, 0.0, 0.1)),
                (1, 1.0, corner(-0.1, 0.0, 0.1)),
                (2, 1.0, corner(-0.1, 0.5, 0.1)),
                (3, 0.5, corner(-0.05, 0.5, 0.05)),
            ],
            vec![(3, 0.5, corner(-0.05, 0.0, 0.05))],
        ];
        for (found, expected) in hangs.iter().zip(&expected) {
            assert_eq!(found.len(), expected.len());
            for (hang, (vertex, weight, point)) in found.iter().zip(expected) {
                assert_eq!((hang.vertex, hang.weight), (*vertex, *weight));
                assert!(hang.point.distance(*point) < 1e-6);
            }
        }
        // Two lists of which vertex 3 is in both.
        let both = joined(&hangs[1], hangs[0].clone());
        let vertices: Vec<(u32, f32)> = both.iter().map(|h| (h.vertex, h.weight)).collect();
        assert_eq!(vertices, [(0, 1.0), (1, 1.0), (2, 1.0), (3, 1.0)]);
        assert!(both[3].point.distance(corner(-0.1, 0.5, 0.1)) < 1e-6);
    }

    #[test]
    fn harm_is_the_fourth_power_of_the_length() {
        assert_eq!(harm(Vec3A::new(1.0, 2.0, 2.0)), 81.0);
        assert_eq!(harm(Vec3A::ZERO), 0.0);
    }

    #[test]
    fn a_change_moves_the_skin_from_where_it_is_to_where_it_folds() {
        let from = Affine3A::from_translation(glam::Vec3::new(1.0, 2.0, 3.0));
        let to = Affine3A::from_scale_rotation_translation(
            glam::Vec3::ONE,
            Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
            glam::Vec3::new(4.0, 6.0, 8.0),
        );
        let hang = Hang {
            vertex: 0,
            weight: 0.5,
            point: Vec3A::new(1.0, 0.0, 2.0) * 0.5,
        };
        // (1, 0, 2) from (2, 2, 5) to (4, 7, 10), half of it.
        let moved = Change::between(&from, &to).moved(&hang);
        assert!(moved.distance(Vec3A::new(1.0, 2.5, 2.5)) < 1e-6);
    }

    #[test]
    fn a_joint_above_others_is_folded_where_any_may_go() {
        // Three joints; the middle one stays still, so that its fold costs nothing. Only where any
        // joint may be folded does it go first.
        let mut asset = arm(3);
        asset.clips = vec![swing(3, 2, 0.5)];
        let any = folded(&asset, JointSet::EMPTY, Folds::Any);
        assert_eq!(any.joints, [0, 2, 1]);
        assert!(any.errors_metres[2] < 1e-6 && any.errors_metres[1] > 0.1);
        assert_eq!(order_of(&asset, JointSet::EMPTY).joints, [0, 1, 2]);
    }
}
