//! Error of shown palettes at one level: the maximum over every vertex and the percentile over a sample, of
//! which few have to be skinned.
//!
//! Skinning is linear, so a vertex moves by the sum of what its bindings alone would move it by,
//! times their weights. For each binding that is at most what it does to a corner of the box around
//! its vertices, since the length of an affine function of the position is convex. Bounds are enlarged by
//! the greatest sum of weights, so that no vertex is off by more than the greatest one of its bindings. Ticks are looked at in
//! the order of these bounds, so that the first ones have nearly the greatest errors; of the others only
//! vertices are skinned whose sum exceeds the greatest error so far.

use super::beyond::points_beyond;
use super::looks::{Change, Looks, ShownError, influences};
use articula_core::{Mesh, percentile};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Covers f32 rounding in the bound of a vertex, relative to it and in metres.
const ROUNDING: f32 = 1e-3;
const ROUNDING_METRES: f32 = 1e-6;

/// The greatest error of one clip at one level so far.
#[derive(Debug, Clone)]
pub(super) struct LevelError<'a> {
    mesh: &'a Mesh,
    groups: &'a [Group],
    /// Vertices over which the percentile is computed.
    sample: &'a [u32],
    /// How many of these each binding moves.
    of_sample: Vec<usize>,
    /// Bound for the skin of each binding in each tick of a block, metres.
    bounds: Vec<f32>,
    lengths: Vec<f32>,
    error: ShownError,
}

/// The vertices of one binding, and the box around them in mesh space.
#[derive(Debug, Clone)]
pub(super) struct Group {
    vertices: Vec<u32>,
    least: Vec3,
    greatest: Vec3,
    /// Greatest sum of the magnitudes of the weights of a vertex, at least 1.
    sum: f32,
}

impl<'a> LevelError<'a> {
    pub(super) fn new(mesh: &'a Mesh, groups: &'a [Group], sample: &'a [u32]) -> Self {
        let mut of_sample = vec![0; groups.len()];
        for vertex in sample {
            influences(mesh, *vertex as usize).for_each(|(b, _)| of_sample[b] += 1);
        }
        Self {
            mesh,
            groups,
            sample,
            of_sample,
            bounds: Vec::new(),
            lengths: Vec::with_capacity(sample.len()),
            error: ShownError::default(),
        }
    }

    /// The greatest error so far.
    pub(super) fn error(&self) -> ShownError {
        self.error
    }

    /// Adds ticks, whose changes may be those of more bindings than the level has.
    pub(super) fn take(&mut self, looks: &Looks) {
        let mut bounds = std::mem::take(&mut self.bounds);
        bounds.clear();
        for changes in looks.ticks() {
            let each = self.groups.iter().zip(changes);
            bounds.extend(each.map(|(group, change)| group.bound(change)));
        }
        let count = self.groups.len().max(1);
        let greatest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
        let most = bounds.chunks_exact(count).map(greatest);
        let mut order: Vec<(f32, usize)> = most.zip(0..).collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (most, tick) in order {
            // None of the vertices of this tick and of those after it exceeds any error so far.
            if most <= self.error.percentile_metres.min(self.error.worst_metres) {
                break;
            }
            let (changes, bounds) = (looks.tick(tick), &bounds[tick * count..][..count]);
            self.add_all(changes, bounds);
            self.add_sample(changes, bounds);
        }
        self.bounds = bounds;
    }

    /// Adds the errors of all vertices in one tick.
    fn add_all(&mut self, changes: &[Change], bounds: &[f32]) {
        for (binding, group) in self.groups.iter().enumerate() {
            // What is not a number exceeds nothing.
            if bounds[binding] <= self.error.worst_metres {
                continue;
            }
            for vertex in &group.vertices {
                let known = self.error.worst_metres;
                // A vertex of several bindings is looked at with the first one that exceeds what is known.
                let is_first = |b: usize| b >= binding || bounds[b] <= known;
                let mut of = influences(self.mesh, *vertex as usize);
                if of.all(|(b, _)| is_first(b)) && bound(self.mesh, *vertex, bounds) > known {
                    let metres = Change::of_vertex(changes, self.mesh, *vertex);
                    self.error.worst_metres = self.error.worst_metres.max(metres);
                }
            }
        }
    }

    /// Adds the percentile over the sample in one tick.
    fn add_sample(&mut self, changes: &[Change], bounds: &[f32]) {
        let (mesh, known) = (self.mesh, self.error.percentile_metres);
        let beyond = points_beyond(self.sample.len());
        let of_groups = self.of_sample.iter().zip(bounds);
        let moved = of_groups.filter(|(_, bound)| **bound > known);
        if moved.map(|(count, _)| count).sum::<usize>() <= beyond {
            return;
        }
        let may = |v: &&u32| bound(mesh, **v, bounds) > known;
        let does = |v: &&u32| Change::of_vertex(changes, mesh, **v) > known;
        // So few may be beyond the percentile without raising it.
        if self.sample.iter().filter(may).nth(beyond).is_none()
            || self
                .sample
                .iter()
                .filter(may)
                .filter(does)
                .nth(beyond)
                .is_none()
        {
            return;
        }
        let lengths = &mut self.lengths;
        lengths.clear();
        let each = self.sample.iter();
        lengths.extend(each.map(|v| Change::of_vertex(changes, mesh, *v)));
        self.error.percentile_metres = known.max(percentile(lengths, 0.95));
    }
}

/// Upper bound on how far a vertex is off, given those of all bindings.
fn bound(mesh: &Mesh, vertex: u32, bounds: &[f32]) -> f32 {
    let of = influences(mesh, vertex as usize);
    of.map(|(b, weight)| weight.abs() * bounds[b]).sum()
}

impl Group {
    /// The vertices of each binding of a mesh.
    pub(super) fn of(mesh: &Mesh) -> Vec<Self> {
        let nothing = Self {
            vertices: Vec::new(),
            least: Vec3::INFINITY,
            greatest: Vec3::NEG_INFINITY,
            sum: 1.0,
        };
        let mut groups = vec![nothing; mesh.bindings.len()];
        for (v, position) in mesh.positions.iter().enumerate() {
            if !position.is_finite() {
                continue;
            }
            let sum = influences(mesh, v).map(|(_, weight)| weight.abs()).sum();
            for (binding, _) in influences(mesh, v) {
                let group = &mut groups[binding];
                group.sum = group.sum.max(sum);
                if group.vertices.last() != Some(&(v as u32)) {
                    group.vertices.push(v as u32);
                }
                group.least = group.least.min(*position);
                group.greatest = group.greatest.max(*position);
            }
        }
        groups
    }

    /// Upper bound on the error of the skin of the binding.
    fn bound(&self, change: &Change) -> f32 {
        if self.vertices.is_empty() {
            return 0.0;
        }
        change.over(|map| self.farthest(map)) * self.sum * (1.0 + ROUNDING) + ROUNDING_METRES
    }

    /// Length of the longest image of a corner of the box.
    fn farthest(&self, map: &Affine3A) -> f32 {
        let half = 0.5 * (self.greatest - self.least);
        let middle = map.transform_point3a((0.5 * (self.least + self.greatest)).into());
        let Mat3A {
            x_axis,
            y_axis,
            z_axis,
        } = map.matrix3;
        let (x, y, z) = (x_axis * half.x, y_axis * half.y, z_axis * half.z);
        let corners = [x + y + z, x + y - z, x - y + z, x - y - z];
        let squared = |at: Vec3A| {
            (middle + at)
                .length_squared()
                .max((middle - at).length_squared())
        };
        corners.map(squared).into_iter().fold(0.0, f32::max).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::joint_lods::test_figures::arm;
    use super::*;
    use crate::split_mix::SplitMix;
    use glam::Quat;

    /// Weights of the mesh times a factor for each vertex.
    fn unequal(mesh: &mut Mesh) {
        let influences = mesh.influences;
        for (i, weight) in mesh.weights.iter_mut().enumerate() {
            *weight *= 0.5 + (i / influences % 7) as f32 / 3.0;
        }
    }

    #[test]
    fn maximum_and_percentile_are_those_of_every_vertex_and_of_every_tick() {
        let mut random = SplitMix(1);
        let mut number = |size: f32| size * (random.below(2001) as f32 / 1000.0 - 1.0);
        let mut mesh = Mesh::clone(&arm(5).mesh);
        for position in &mut mesh.positions {
            *position += Vec3::new(number(0.3), number(0.3), number(0.3));
        }
        unequal(&mut mesh);
        let (groups, sample) = (Group::of(&mesh), (0..mesh.len() as u32).step_by(2));
        let sample: Vec<u32> = sample.collect();
        let mut found = LevelError::new(&mesh, &groups, &sample);
        let mut expected = ShownError::default();
        let mut looks = Looks::new(mesh.bindings.len());
        for tick in 0..300 {
            // Most ticks are calmer than some before, and only bounds are needed.
            let size = if tick % 50 == 20 { 0.02 } else { 0.01 };
            let mut palette = || -> Vec<Affine3A> {
                let mut matrix = || {
                    let axis = Vec3::new(number(size), number(size), number(size));
                    let offset = Vec3::new(number(size), number(size), number(size));
                    Affine3A::from_rotation_translation(Quat::from_scaled_axis(axis), offset)
                };
                mesh.bindings.iter().map(|_| matrix()).collect()
            };
            let [truth, shown] = [0, 1].map(|_| [palette(), palette(), palette()]);
            looks.add(
                truth.each_ref().map(Vec::as_slice),
                shown.each_ref().map(Vec::as_slice),
            );
            let changes = looks.ticks().last().unwrap();
            let length = |v: &u32| Change::of_vertex(changes, &mesh, *v);
            let all: Vec<u32> = (0..mesh.len() as u32).collect();
            let worst = all.iter().map(length).fold(0.0, f32::max);
            let mut lengths: Vec<f32> = sample.iter().map(length).collect();
            let percentile = percentile(&mut lengths, 0.95);
            expected.worst_metres = expected.worst_metres.max(worst);
            expected.percentile_metres = expected.percentile_metres.max(percentile);
            if tick % 70 == 69 || tick == 299 {
                found.take(&looks);
                looks.clear();
                assert_eq!(found.error(), expected, "tick {tick}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_counts_as_nothing() {
        let mut mesh = Mesh::clone(&arm(2).mesh);
        mesh.positions[3] = Vec3::NAN;
        let groups = Group::of(&mesh);
        let mut looks = Looks::new(2);
        let same = [Affine3A::IDENTITY; 2];
        let lost = [Affine3A::from_translation(Vec3::NAN); 2];
        let off = [Affine3A::from_translation(Vec3::X * 0.25); 2];
        looks.add([&same; 3], [&lost; 3]);
        looks.add([&same; 3], [&off; 3]);
        let all: Vec<u32> = (0..mesh.len() as u32).collect();
        let mut found = LevelError::new(&mesh, &groups, &all);
        found.take(&looks);
        assert_eq!(found.error().worst_metres, 0.25);
        assert_eq!(found.error().percentile_metres, 0.25);
    }
}
