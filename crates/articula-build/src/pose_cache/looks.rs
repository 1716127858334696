//! What a palette that is shown changes, binding by binding, against the true one.

use articula_core::{Mesh, lod_error_metres};
use glam::{Affine3A, Vec3A};

/// Share of the bend over one tick that is added between its half ticks: a constant curvature would
/// need a quarter.
const BEND_SHARE: f32 = 0.5;

/// Difference of the shown and the true matrix of one binding in one tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    /// At the begin, the middle and the end of the tick.
    apart: [Affine3A; 3],
    /// Of the true matrix in the middle, against the mean of both ends.
    bend: Affine3A,
}

/// Changes of ticks, one after the other, each of so many bindings.
#[derive(Debug, Default)]
pub(super) struct Looks {
    changes: Vec<Change>,
    bindings: usize,
}

impl Change {
    const NONE: Self = Self {
        apart: [Affine3A::ZERO; 3],
        bend: Affine3A::ZERO,
    };

    pub(super) fn new(truth: [&Affine3A; 3], shown: [&Affine3A; 3]) -> Self {
        let [before, middle, after] = truth;
        let mut line = Affine3A::ZERO;
        for end in [before, after] {
            add(&mut line, end, 0.5);
        }
        Self {
            apart: [0, 1, 2].map(|at| difference(truth[at], shown[at])),
            bend: difference(middle, &line),
        }
    }

    /// Greatest length over the tick, given the length that each matrix gives some point.
    #[inline]
    pub(super) fn over(&self, length: impl Fn(&Affine3A) -> f32) -> f32 {
        let apart = self.apart.iter().map(&length).fold(0.0, f32::max);
        apart + BEND_SHARE * length(&self.bend)
    }

    /// How far a vertex is off in a tick, given the changes of all bindings; distances that are not finite
    /// count as 0.
    pub(super) fn of_vertex(changes: &[Self], mesh: &Mesh, vertex: u32) -> f32 {
        let mut own = Self::NONE;
        for (binding, weight) in influences(mesh, vertex as usize) {
            let of = &changes[binding];
            for (own, of) in own.apart.iter_mut().zip(&of.apart) {
                add(own, of, weight);
            }
            add(&mut own.bend, &of.bend, weight);
        }
        let at = Vec3A::from(mesh.positions[vertex as usize]);
        own.over(|map| {
            let length = map.transform_point3a(at).length();
            if length.is_finite() { length } else { 0.0 }
        })
    }
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

fn add(to: &mut Affine3A, of: &Affine3A, weight: f32) {
    to.matrix3 += of.matrix3 * weight;
    to.translation += of.translation * weight;
}

fn difference(a: &Affine3A, b: &Affine3A) -> Affine3A {
    Affine3A {
        matrix3: a.matrix3 - b.matrix3,
        translation: a.translation - b.translation,
    }
}
