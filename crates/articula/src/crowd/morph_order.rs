//! The order in which morph targets are left out of a crowd's faces: each time the one whose absence,
//! together with those left out so far, costs least.
//!
//! Source: `docs/methods/runtime.md` 4.2. The cost is the error of a crowd's levels, the larger of the
//! 95th percentile over vertices and half of their maximum, as the maximum over sampled frames. Most
//! of the others can only cost more than when they were last looked at, so few are looked at again.

use articula_core::{lod_error_metres, percentile};
use glam::Vec3A;

/// Maximum number of frames and of vertices on which targets are ordered.
pub(super) const FRAMES: usize = 96;
pub(super) const VERTICES: usize = 4000;

/// Maximum number of targets that are looked at again to find the next one.
const LOOKS: usize = 16;

/// What the morph targets of a character do in its clips.
#[derive(Debug)]
pub(super) struct MovedFaces {
    /// For each target the vertices that it moves, with the displacement per unit of its weight,
    /// metres.
    pub(super) fields: Vec<Vec<(u32, Vec3A)>>,
    /// For each frame the difference of each target's weight to its default.
    pub(super) frames: Vec<Vec<f32>>,
    /// Number of vertices that are moved; where they are a sample, of the sample.
    pub(super) moved: usize,
    /// Number of all vertices, by the same sample.
    pub(super) vertices: f32,
}

/// A target that is left out, with the error in metres of all that are left out by then.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dropped {
    pub(super) target: usize,
    pub(super) error_metres: f32,
}

/// Displacement of each vertex in one frame by the targets that are left out, with its error.
struct Missing {
    field: Vec<Vec3A>,
    lengths: Vec<f32>,
    error: f32,
}

impl MovedFaces {
    /// Orders the targets, those first whose absence costs least.
    pub(super) fn order(&self) -> Vec<Dropped> {
        let still = || Missing {
            field: vec![Vec3A::ZERO; self.moved],
            lengths: vec![0.0; self.moved],
            error: 0.0,
        };
        let mut missing: Vec<Missing> = self.frames.iter().map(|_| still()).collect();
        let mut room = Vec::with_capacity(self.moved);
        let targets = self.fields.len();
        let alone: Vec<f32> = (0..targets)
            .map(|t| self.with(&missing, t, &mut room))
            .collect();
        let mut costs = alone.clone();
        let mut left: Vec<usize> = (0..targets).collect();
        let mut dropped = Vec::with_capacity(targets);
        while !left.is_empty() {
            // Equal where another one costs more in the same frame; then by what each does alone.
            let rank = |costs: &[f32], t: usize| (costs[t], alone[t], t);
            let least = |costs: &[f32], among: &[usize]| {
                let ranks = among.iter().map(|t| rank(costs, *t));
                ranks.min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal))
            };
            let mut looked: Vec<usize> = Vec::with_capacity(LOOKS);
            let next = loop {
                let Some((_, _, next)) = least(&costs, &left) else {
                    break left[0];
                };
                if looked.contains(&next) {
                    break next;
                }
                if looked.len() == LOOKS {
                    break least(&costs, &looked).map_or(next, |(_, _, t)| t);
                }
                costs[next] = self.with(&missing, next, &mut room);
                looked.push(next);
            };
            self.leave_out(&mut missing, next, &mut room);
            left.retain(|t| *t != next);
            let errors = missing.iter().map(|m| m.error);
            dropped.push(Dropped {
                target: next,
                error_metres: errors.fold(0.0, f32::max),
            });
        }
        dropped
    }

    /// Error with one more target left out.
    fn with(&self, missing: &[Missing], target: usize, room: &mut Vec<f32>) -> f32 {
        let each = self.frames.iter().zip(missing).map(|(weights, missing)| {
            let weight = weights[target];
            if weight == 0.0 {
                return missing.error;
            }
            room.clone_from(&missing.lengths);
            for (v, offset) in &self.fields[target] {
                let v = *v as usize;
                room[v] = (missing.field[v] + *offset * weight).length();
            }
            self.error(room)
        });
        each.fold(0.0, f32::max)
    }

    fn leave_out(&self, missing: &mut [Missing], target: usize, room: &mut Vec<f32>) {
        for (weights, missing) in self.frames.iter().zip(missing) {
            let weight = weights[target];
            if weight == 0.0 {
                continue;
            }
            for (v, offset) in &self.fields[target] {
                let v = *v as usize;
                missing.field[v] += *offset * weight;
                missing.lengths[v] = missing.field[v].length();
            }
            room.clone_from(&missing.lengths);
            missing.error = self.error(room);
        }
    }

    /// The error by which levels are chosen, over all vertices.
    fn error(&self, lengths: &mut [f32]) -> f32 {
        let worst = lengths.iter().copied().fold(0.0, f32::max);
        // Vertices that no target moves are at the lower end.
        let share = 1.0 - 0.05 * self.vertices / lengths.len().max(1) as f32;
        let p95 = match share > 0.0 {
            true => percentile(lengths, share),
            false => 0.0,
        };
        lod_error_metres(p95, worst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Targets that each move vertices of their own by a length along X, of 1000 vertices.
    fn faces(lengths: &[f32], frames: &[&[f32]]) -> MovedFaces {
        let fields = lengths.iter().enumerate();
        MovedFaces {
            fields: fields
                .map(|(t, length)| vec![(t as u32, Vec3A::X * *length)])
                .collect(),
            frames: frames.iter().map(|f| f.to_vec()).collect(),
            moved: lengths.len(),
            vertices: 1000.0,
        }
    }

    #[test]
    fn the_smallest_falls_out_first_and_the_largest_last() {
        // The third is large and hardly used, the last never.
        let faces = faces(
            &[0.02, 0.01, 0.5, 9.0],
            &[&[1.0, 0.5, 0.0, 0.0], &[0.0, -1.0, 0.01, 0.0]],
        );
        let order: Vec<(usize, f32)> = faces
            .order()
            .iter()
            .map(|d| (d.target, d.error_metres))
            .collect();
        assert_eq!(order, [(3, 0.0), (2, 0.0025), (1, 0.005), (0, 0.01)]);
    }

    #[test]
    fn targets_that_cancel_each_other_fall_out_together() {
        // The first two move the same vertex to either side, the third another one.
        let mut faces = faces(&[0.02, 0.02, 0.012], &[&[1.0, 1.0, 1.0]]);
        faces.fields[1] = vec![(0, Vec3A::NEG_X * 0.02)];
        let order: Vec<usize> = faces.order().iter().map(|d| d.target).collect();
        assert_eq!(order[0], 2);
        assert!(faces.order()[2].error_metres <= 0.006 + 1e-9);
    }

    #[test]
    fn the_percentile_counts_where_many_vertices_move() {
        // 100 of 1000 vertices by 1 cm, against one by 1.5 cm.
        let mut faces = faces(&[0.0, 0.015], &[&[1.0, 1.0]]);
        faces.fields[0] = (2..102).map(|v| (v, Vec3A::X * 0.01)).collect();
        faces.moved = 102;
        let order = faces.order();
        assert_eq!(order[0].target, 1);
        assert!((order[0].error_metres - 0.0075).abs() < 1e-6);
        assert!((order[1].error_metres - 0.01).abs() < 1e-6);
    }

    proptest! {
        /// Every target falls out once, and the last error is that of a face at rest.
        #[test]
        fn all_fall_out_and_the_rest_error_remains(
            lengths in prop::collection::vec(0.001f32..0.1, 1..30),
            weights in prop::collection::vec(prop::collection::vec(-1.0f32..1.0, 30), 1..5),
        ) {
            let frames: Vec<&[f32]> = weights.iter().map(|w| &w[..lengths.len()]).collect();
            let order = faces(&lengths, &frames).order();
            let mut targets: Vec<usize> = order.iter().map(|d| d.target).collect();
            targets.sort_unstable();
            prop_assert_eq!(targets, (0..lengths.len()).collect::<Vec<_>>());
            let moved = frames.iter().flat_map(|f| f.iter().zip(&lengths).map(|(w, l)| (w * l).abs()));
            let rest = 0.5 * moved.fold(0.0, f32::max);
            prop_assert!((order[order.len() - 1].error_metres - rest).abs() < 1e-6);
            // Nothing cancels here, so errors rise.
            prop_assert!(order.windows(2).all(|p| p[0].error_metres <= p[1].error_metres));
        }
    }
}
