//! What a palette that is shown changes, binding by binding, against the true one.

use articula_core::{Mesh, lod_error_metres};
use glam::{Affine3A, Vec3, Vec4};

/// Share of the bend over one tick that is added between its half ticks: a constant curvature would
/// need a quarter.
const BEND_SHARE: f32 = 0.5;

/// Difference of the shown and the true matrix of one binding in one tick: at its begin, in its middle and at
/// its end, and the bend of the true one in the middle, against the mean of both ends.
///
/// The components of the four matrices, column by column, so that all four are applied at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change([Vec4; 12]);

/// What the four matrices of a change make of a point: its x, y and z.
pub(super) type Images = [Vec4; 3];

/// Changes of ticks, one after the other, each of so many bindings.
#[derive(Debug, Default)]
pub(super) struct Looks {
    changes: Vec<Change>,
    bindings: usize,
}

impl Change {
    pub(super) fn new(truth: [&Affine3A; 3], shown: [&Affine3A; 3]) -> Self {
        let [before, middle, after] = truth;
        let mut line = Affine3A::ZERO;
        for end in [before, after] {
            line.matrix3 += end.matrix3 * 0.5;
            line.translation += end.translation * 0.5;
        }
        let [a, b, c] = [0, 1, 2].map(|at| difference(truth[at], shown[at]).to_cols_array());
        let bend = difference(middle, &line).to_cols_array();
        Self(std::array::from_fn(|i| {
            Vec4::new(a[i], b[i], c[i], bend[i])
        }))
    }

    /// Greatest number that is added where the images of a point are computed, given its greatest coordinate;
    /// infinite where that is not a number.
    #[inline]
    pub(super) fn magnitude(&self, coordinate: f32) -> f32 {
        let greatest = |of: &[Vec4]| of.iter().fold(Vec4::ZERO, |most, c| most.max(c.abs()));
        let (linear, moved) = self.0.split_at(9);
        let most = (greatest(linear) * coordinate).max(greatest(moved));
        if self.0.iter().all(|c| c.is_finite()) {
            most.max_element()
        } else {
            f32::INFINITY
        }
    }

    /// What this changes otherwise than another.
    #[inline]
    pub(super) fn less(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }

    /// Images of a point.
    #[inline]
    pub(super) fn at(&self, point: Vec3) -> Images {
        let along = self.along(point);
        std::array::from_fn(|row| along[0][row] + along[1][row] + along[2][row] + self.0[9 + row])
    }

    /// Images of three vectors along the axes.
    #[inline]
    pub(super) fn along(&self, lengths: Vec3) -> [Images; 3] {
        let axis = |axis: usize| [0, 1, 2].map(|row| self.0[3 * axis + row] * lengths[axis]);
        [axis(0), axis(1), axis(2)]
    }

    /// Greatest length over the tick, given those that the four matrices give some point; none is NaN.
    #[inline]
    pub(super) fn over(lengths: Vec4) -> f32 {
        let [a, b, c, bend] = lengths.to_array();
        let greater = |a: f32, b: f32| if a > b { a } else { b };
        greater(greater(a, b), c) + BEND_SHARE * bend
    }

    /// How far a vertex is off in a tick, given the changes of all bindings; distances that are not finite
    /// count as 0.
    pub(super) fn of_vertex(changes: &[Self], mesh: &Mesh, vertex: u32) -> f32 {
        let mut own = [Vec4::ZERO; 12];
        for (binding, weight) in influences(mesh, vertex as usize) {
            for (own, of) in own.iter_mut().zip(&changes[binding].0) {
                *own += *of * weight;
            }
        }
        let images = Self(own).at(mesh.positions[vertex as usize]);
        let squared = squared_lengths(&images);
        let squared = Vec4::select(squared.is_finite_mask(), squared, Vec4::ZERO);
        Self::over(Vec4::from_array(squared.to_array().map(f32::sqrt)))
    }
}

/// Squared lengths of vectors.
#[inline]
pub(super) fn squared_lengths([x, y, z]: &Images) -> Vec4 {
    *x * *x + *y * *y + *z * *z
}

impl Looks {
    pub(super) fn new(bindings: usize) -> Self {
        Self {
            changes: Vec::new(),
            bindings,
        }
    }

    pub(super) fn clear(&mut self) {
        self.changes.clear();
    }

    /// Adds a tick with the true and the shown palettes at its begin, its middle and its end.
    pub(super) fn add(&mut self, truth: [&[Affine3A]; 3], shown: [&[Affine3A]; 3]) {
        let pick = |of: [&'_ [Affine3A]; 3], b: usize| of.map(|palette| palette[b]);
        self.changes.extend((0..self.bindings).map(|b| {
            let (truth, shown) = (pick(truth, b), pick(shown, b));
            Change::new(truth.each_ref(), shown.each_ref())
        }));
    }

    /// The changes of each tick.
    pub(super) fn ticks(&self) -> impl Iterator<Item = &[Change]> {
        self.changes.chunks_exact(self.bindings.max(1))
    }

    /// Those of one tick.
    pub(super) fn tick(&self, tick: usize) -> &[Change] {
        &self.changes[tick * self.bindings..][..self.bindings]
    }
}

/// Error of one clip at one level, as the maximum over time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ShownError {
    /// 95th percentile over vertices.
    pub(super) percentile_metres: f32,
    /// Maximum over all vertices.
    pub(super) worst_metres: f32,
}

impl ShownError {
    /// The larger of the percentile and half of the maximum.
    pub(super) fn judged_metres(&self) -> f32 {
        lod_error_metres(self.percentile_metres, self.worst_metres)
    }
}

/// Bindings of a vertex with their weights, without those of no weight.
pub(super) fn influences(mesh: &Mesh, vertex: usize) -> impl Iterator<Item = (usize, f32)> {
    let of = vertex * mesh.influences..(vertex + 1) * mesh.influences;
    let indices = mesh.binding_indices[of.clone()].iter();
    let pairs = indices.zip(&mesh.weights[of]);
    pairs
        .filter(|(_, w)| **w != 0.0)
        .map(|(b, w)| (usize::from(*b), *w))
}

fn difference(a: &Affine3A, b: &Affine3A) -> Affine3A {
    Affine3A {
        matrix3: a.matrix3 - b.matrix3,
        translation: a.translation - b.translation,
    }
}
