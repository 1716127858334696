//! Error of shown palettes at one level: the maximum over every vertex and the percentile over a sample, of
//! which few have to be skinned.
//!
//! Skinning is linear, so a vertex moves by the sum of what its bindings alone would move it by,
//! times their weights. For each binding that is at most what it does to a corner of the box around
//! its vertices, since the length of an affine function of the position is convex. Bounds are enlarged by
//! the greatest sum of weights, so that no vertex is off by more than the greatest one of its bindings. Ticks are looked at in
//! the order of these bounds, so that the first ones have nearly the greatest errors; of the others only
//! vertices are skinned whose sum exceeds the greatest error so far, in patches of which the same holds.

use super::looks::{Change, Images, Looks, ShownError, influences, squared_lengths};
use crate::beyond::points_beyond;
use crate::skin_patches::{GreatestWeights, Patch, split};
use articula_core::{Mesh, percentile};
use glam::{Vec3, Vec4};

/// Covers f32 rounding in a bound and in what is bounded, relative to the bound and to the greatest number that is
/// added on the way.
const ROUNDING: f32 = 1e-5;

/// Most vertices of a patch.
const PATCH: usize = 16;

/// The greatest error of one clip at one level so far.
#[derive(Debug, Clone)]
pub(super) struct LevelError<'a> {
    skin: &'a BoundedSkin,
    mesh: &'a Mesh,
    /// Bound for the skin of each binding in each tick of a block, metres.
    bounds: Vec<f32>,
    lengths: Vec<f32>,
    error: ShownError,
}

/// A skin in patches, all of it and the sample over which percentiles are computed.
#[derive(Debug, Clone)]
pub(super) struct BoundedSkin {
    groups: Vec<Group>,
    all: Vec<PatchGroup>,
    sample: Vec<PatchGroup>,
    /// Number of vertices of the sample, with those that have no place.
    sample_len: usize,
    /// Greatest coordinate.
    reach: f32,
}

/// The patches on one binding.
#[derive(Debug, Clone)]
struct PatchGroup {
    weights: GreatestWeights,
    patches: Vec<Patch>,
}

/// The box around the vertices of one binding in mesh space.
#[derive(Debug, Clone)]
struct Group {
    least: Vec3,
    greatest: Vec3,
    /// Greatest sum of the magnitudes of the weights of a vertex, at least 1.
    sum: f32,
}

impl<'a> LevelError<'a> {
    pub(super) fn new(mesh: &'a Mesh, skin: &'a BoundedSkin) -> Self {
        Self {
            skin,
            mesh,
            bounds: Vec::new(),
            lengths: Vec::with_capacity(skin.sample_len),
            error: ShownError::default(),
        }
    }

    /// The greatest error so far.
    pub(super) fn error(&self) -> ShownError {
        self.error
    }

    /// Adds ticks, whose changes may be those of more bindings than the level has.
    pub(super) fn take(&mut self, looks: &Looks) {
        let groups = &self.skin.groups;
        let mut bounds = std::mem::take(&mut self.bounds);
        bounds.clear();
        for changes in looks.ticks() {
            let each = groups.iter().zip(changes);
            bounds.extend(each.map(|(group, change)| group.bound(change, self.skin.reach)));
        }
        let count = groups.len().max(1);
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
            if most > self.error.worst_metres {
                self.add_all(changes, bounds);
            }
            self.add_sample(changes, bounds);
        }
        self.bounds = bounds;
    }

    /// Adds the errors of all vertices in one tick.
    fn add_all(&mut self, changes: &[Change], bounds: &[f32]) {
        let worst = &mut self.error.worst_metres;
        for group in &self.skin.all {
            if coarse_bound(&group.weights, bounds) <= *worst {
                continue;
            }
            for patch in &group.patches {
                if !self.skin.may_exceed(patch, (changes, bounds), *worst) {
                    continue;
                }
                for vertex in &patch.vertices {
                    if bound(self.mesh, *vertex, bounds) > *worst {
                        *worst = worst.max(Change::of_vertex(changes, self.mesh, *vertex));
                    }
                }
            }
        }
    }

    /// Adds the percentile over the sample in one tick.
    fn add_sample(&mut self, changes: &[Change], bounds: &[f32]) {
        let (mesh, known) = (self.mesh, self.error.percentile_metres);
        let beyond = points_beyond(self.skin.sample_len);
        let sample = &self.skin.sample;
        let groups = sample.iter();
        let groups = groups.filter(|g| coarse_bound(&g.weights, bounds) > known);
        let patches = groups.flat_map(|g| &g.patches);
        let moved = patches.filter(|p| coarse_bound(&p.weights, bounds) > known);
        // So few may be beyond the percentile without raising it.
        if moved.clone().map(|p| p.vertices.len()).sum::<usize>() <= beyond {
            return;
        }
        let may = moved.filter(|p| self.skin.may_exceed(p, (changes, bounds), known));
        let may = may.flat_map(|p| &p.vertices);
        let does = may.filter(|v| {
            bound(mesh, **v, bounds) > known && Change::of_vertex(changes, mesh, **v) > known
        });
        if does.take(beyond + 1).count() <= beyond {
            return;
        }
        let lengths = &mut self.lengths;
        lengths.clear();
        let patches = sample.iter().flat_map(|g| &g.patches);
        let each = patches.flat_map(|p| &p.vertices);
        lengths.extend(each.map(|v| Change::of_vertex(changes, mesh, *v)));
        lengths.resize(self.skin.sample_len, 0.0);
        self.error.percentile_metres = known.max(percentile(lengths, 0.95));
    }
}

/// Upper bound on how far a vertex is off, given those of all bindings.
fn bound(mesh: &Mesh, vertex: u32, bounds: &[f32]) -> f32 {
    let of = influences(mesh, vertex as usize);
    of.map(|(b, weight)| weight.abs() * bounds[b]).sum()
}

/// Upper bound on how far vertices are off, given their greatest weights and those of all bindings.
fn coarse_bound(weights: &GreatestWeights, bounds: &[f32]) -> f32 {
    let all = weights.others.iter().chain([&weights.own]);
    all.map(|(b, weight)| weight * bounds[*b]).sum()
}

impl BoundedSkin {
    /// Divides a mesh and a sample of its vertices into patches.
    pub(super) fn new(mesh: &Mesh, sample: &[u32]) -> Self {
        let all: Vec<u32> = (0..mesh.len() as u32).collect();
        let reach = mesh.positions.iter().map(|p| p.abs().max_element());
        Self {
            groups: Group::of(mesh),
            all: patches(mesh, &all),
            sample: patches(mesh, sample),
            sample_len: sample.len(),
            reach: reach.filter(|c| c.is_finite()).fold(0.0, f32::max),
        }
    }

    /// Whether a vertex of a patch may be off by more than is known, by the bounds of all bindings and by the box
    /// around the patch: with weights that sum to 1 it moves as its own binding does, and by its other weights
    /// times what these bindings do otherwise.
    fn may_exceed(
        &self,
        patch: &Patch,
        (changes, bounds): (&[Change], &[f32]),
        known: f32,
    ) -> bool {
        let weights = &patch.weights;
        if coarse_bound(weights, bounds) <= known {
            return false;
        }
        let far = |change: &Change| {
            let middle = change.at(patch.middle);
            Change::over(farthest(&middle, &change.along(patch.half)))
        };
        let own = &changes[weights.own.0];
        let mut metres = far(own) * (1.0 + patch.unbalanced);
        let mut magnitude = own.magnitude(self.reach);
        for (binding, weight) in &weights.others {
            let other = &changes[*binding];
            metres += weight * far(&other.less(own));
            magnitude = magnitude.max(other.magnitude(self.reach));
        }
        metres * (1.0 + ROUNDING) + ROUNDING * magnitude > known
    }
}

/// Patches of those vertices that have a place, by the heaviest binding.
fn patches(mesh: &Mesh, vertices: &[u32]) -> Vec<PatchGroup> {
    let mut of_binding = vec![Vec::new(); mesh.bindings.len()];
    let finite = |v: &&u32| mesh.positions[**v as usize].is_finite();
    for v in vertices.iter().filter(finite) {
        let of = influences(mesh, *v as usize);
        let heaviest = of.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        if let Some((binding, _)) = heaviest {
            of_binding[binding].push(*v);
        }
    }
    let groups = of_binding.into_iter().enumerate();
    let groups = groups.map(|(binding, vertices)| {
        let mut patches = Vec::new();
        split(mesh, binding, vertices, PATCH, &mut patches);
        let mut weights = GreatestWeights::on(binding);
        patches.iter().for_each(|p| weights.join(&p.weights));
        PatchGroup { weights, patches }
    });
    groups.filter(|g| !g.patches.is_empty()).collect()
}

impl Group {
    /// The boxes of the bindings of a mesh.
    fn of(mesh: &Mesh) -> Vec<Self> {
        let nothing = Self {
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
                group.least = group.least.min(*position);
                group.greatest = group.greatest.max(*position);
            }
        }
        groups
    }

    /// Upper bound on the error of the skin of the binding.
    fn bound(&self, change: &Change, reach: f32) -> f32 {
        // Of no vertices.
        if self.least.x > self.greatest.x {
            return 0.0;
        }
        let half = 0.5 * (self.greatest - self.least);
        let middle = change.at(0.5 * (self.least + self.greatest));
        let metres = Change::over(farthest(&middle, &change.along(half)));
        (metres * (1.0 + ROUNDING) + ROUNDING * change.magnitude(reach)) * self.sum
    }
}

/// Lengths of the longest images of a corner of a box, given those of its middle and of half its sides; infinite
/// where that is not a number.
fn farthest(middle: &Images, [x, y, z]: &[Images; 3]) -> Vec4 {
    let mut squared = Vec4::ZERO;
    for (y_sign, z_sign) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let corner = |row: usize| x[row] + y[row] * y_sign + z[row] * z_sign;
        let corner = [corner(0), corner(1), corner(2)];
        let one = [0, 1, 2].map(|row| middle[row] + corner[row]);
        let other = [0, 1, 2].map(|row| middle[row] - corner[row]);
        squared = squared.max(squared_lengths(&one).max(squared_lengths(&other)));
    }
    let lengths = squared.to_array().map(f32::sqrt);
    let number = |length: f32| {
        if length.is_nan() {
            f32::INFINITY
        } else {
            length
        }
    };
    Vec4::from_array(lengths.map(number))
}

#[cfg(test)]
mod tests {
    use super::super::super::joint_lods::test_figures::arm;
    use super::*;
    use crate::split_mix::SplitMix;
    use glam::{Affine3A, Quat};

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
        let sample: Vec<u32> = (0..mesh.len() as u32).step_by(2).collect();
        let skin = BoundedSkin::new(&mesh, &sample);
        let mut found = LevelError::new(&mesh, &skin);
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
        // Beside each other, vertices on one binding and on both.
        mesh.influences = 2;
        let of = |v: usize| [(v % 2) as u16, 1 - (v % 2) as u16];
        mesh.binding_indices = (0..mesh.len()).flat_map(of).collect();
        let shares = |v: usize| [[1.0, 0.0], [0.75, 0.25]][v / 2 % 2];
        mesh.weights = (0..mesh.len()).flat_map(shares).collect();
        let mut looks = Looks::new(2);
        let same = [Affine3A::IDENTITY; 2];
        let lost = [Affine3A::from_translation(Vec3::NAN); 2];
        let off = [Affine3A::from_translation(Vec3::X * 0.25); 2];
        looks.add([&same; 3], [&lost; 3]);
        looks.add([&same; 3], [&off; 3]);
        let all: Vec<u32> = (0..mesh.len() as u32).collect();
        let skin = BoundedSkin::new(&mesh, &all);
        let mut found = LevelError::new(&mesh, &skin);
        found.take(&looks);
        assert_eq!(found.error().worst_metres, 0.25);
        assert_eq!(found.error().percentile_metres, 0.25);
        // Where one binding is lost, the vertices on others alone count.
        let further = Affine3A::from_translation(Vec3::X * 0.5);
        for shown in [[lost[0], further], [further, lost[0]]] {
            looks.clear();
            looks.add([&same; 3], [&shown; 3]);
            let mut found = LevelError::new(&mesh, &skin);
            found.take(&looks);
            let length = |v: &u32| Change::of_vertex(looks.tick(0), &mesh, *v);
            let worst = all.iter().map(length).fold(0.0, f32::max);
            assert_eq!((worst, found.error().worst_metres), (0.5, 0.5));
            let mut lengths: Vec<f32> = all.iter().map(length).collect();
            let percentile = percentile(&mut lengths, 0.95);
            assert_eq!((percentile, found.error().percentile_metres), (0.5, 0.5));
        }
    }
}
