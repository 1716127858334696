//! Maximum error of blended palettes over every vertex, of which few have to be skinned.
//!
//! Skinning is linear, so a vertex moves by the sum of what its bindings alone would move it by,
//! times their weights. For each binding that is at most what it does to a corner of the box around
//! its vertices, since the length of an affine function of the position is convex. Only vertices
//! whose sum exceeds the greatest error so far are skinned.

use articula_core::{Mesh, skin_points};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Covers f32 rounding in the bound of a vertex, relative to it and in metres.
const ROUNDING: f32 = 1e-3;
const ROUNDING_METRES: f32 = 1e-6;

/// Share of the bend over one tick that is added between its half ticks: a constant curvature would
/// need a quarter.
pub(super) const BEND_SHARE: f32 = 0.5;

/// The greatest error of one clip at one level so far.
#[derive(Debug, Clone)]
pub(super) struct Farthest {
    groups: Vec<Group>,
    /// Bound for the skin of each binding in the current tick, metres.
    bounds: Vec<f32>,
    metres: f32,
}

/// The vertices of one binding, and the box around them in mesh space.
#[derive(Debug, Clone)]
struct Group {
    vertices: Vec<u32>,
    least: Vec3,
    greatest: Vec3,
}

/// True and shown palettes at the same times: one time, or the begin, the middle and the end of a
/// tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Palettes<'a> {
    pub(super) truth: &'a [Vec<Affine3A>],
    pub(super) shown: &'a [Vec<Affine3A>],
}

impl Farthest {
    /// Groups the vertices of a mesh by their bindings.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let nothing = Group {
            vertices: Vec::new(),
            least: Vec3::INFINITY,
            greatest: Vec3::NEG_INFINITY,
        };
        let mut groups = vec![nothing; mesh.bindings.len()];
        for (v, position) in mesh.positions.iter().enumerate() {
            if !position.is_finite() {
                continue;
            }
            for (binding, _) in influences(mesh, v) {
                let group = &mut groups[binding];
                if group.vertices.last() != Some(&(v as u32)) {
                    group.vertices.push(v as u32);
                }
                group.least = group.least.min(*position);
                group.greatest = group.greatest.max(*position);
            }
        }
        Self {
            bounds: vec![0.0; groups.len()],
            groups,
            metres: 0.0,
        }
    }

    /// The greatest error so far in metres.
    pub(super) fn metres(&self) -> f32 {
        self.metres
    }

    /// Adds the errors of all vertices. `known_metres` is an error that one of them is known to have.
    pub(super) fn add(&mut self, mesh: &Mesh, palettes: Palettes<'_>, known_metres: f32) {
        self.metres = self.metres.max(known_metres);
        for (b, group) in self.groups.iter().enumerate() {
            self.bounds[b] = group.bound(b, palettes);
        }
        for b in 0..self.groups.len() {
            // What is not a number exceeds nothing.
            if self.bounds[b] > self.metres {
                self.search(b, mesh, palettes);
            }
        }
    }

    /// Looks at the vertices of one binding.
    fn search(&mut self, binding: usize, mesh: &Mesh, palettes: Palettes<'_>) {
        for v in &self.groups[binding].vertices {
            let of = influences(mesh, *v as usize);
            let bound: f32 = of.map(|(b, weight)| weight.abs() * self.bounds[b]).sum();
            if bound > self.metres {
                self.metres = self.metres.max(error(mesh, *v, palettes));
            }
        }
    }
}

impl Group {
    /// Upper bound on the error of the skin of the binding.
    fn bound(&self, binding: usize, palettes: Palettes<'_>) -> f32 {
        if self.vertices.is_empty() {
            return 0.0;
        }
        let Palettes { truth, shown } = palettes;
        let pairs = truth.iter().zip(shown);
        let apart = pairs.map(|(t, s)| self.farthest(&difference(&t[binding], &s[binding])));
        let mut bound = apart.fold(0.0, f32::max);
        if let [before, middle, after] = truth {
            let mut line = Affine3A::ZERO;
            for end in [before, after] {
                line.matrix3 += end[binding].matrix3 * 0.5;
                line.translation += end[binding].translation * 0.5;
            }
            bound += BEND_SHARE * self.farthest(&difference(&middle[binding], &line));
        }
        bound * (1.0 + ROUNDING) + ROUNDING_METRES
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

fn difference(a: &Affine3A, b: &Affine3A) -> Affine3A {
    Affine3A {
        matrix3: a.matrix3 - b.matrix3,
        translation: a.translation - b.translation,
    }
}

/// Bindings of a vertex with their weights, without those of no weight.
fn influences(mesh: &Mesh, vertex: usize) -> impl Iterator<Item = (usize, f32)> {
    let of = vertex * mesh.influences..(vertex + 1) * mesh.influences;
    let indices = mesh.binding_indices[of.clone()].iter();
    let pairs = indices.zip(&mesh.weights[of]);
    pairs
        .filter(|(_, w)| **w != 0.0)
        .map(|(b, w)| (usize::from(*b), *w))
}

/// Error of one vertex; distances that are not finite count as 0.
fn error(mesh: &Mesh, vertex: u32, palettes: Palettes<'_>) -> f32 {
    let at = |palette: &Vec<Affine3A>| {
        let mut point = [Vec3::ZERO];
        skin_points(mesh, palette, &[vertex], &mut point);
        point[0]
    };
    let finite = |d: f32| if d.is_finite() { d } else { 0.0 };
    let pairs = palettes.truth.iter().zip(palettes.shown);
    let apart = pairs.map(|(t, s)| finite(at(t).distance(at(s))));
    let bend = match palettes.truth {
        [before, middle, after] => finite(at(middle).distance(at(before).midpoint(at(after)))),
        _ => 0.0,
    };
    apart.fold(0.0, f32::max) + BEND_SHARE * bend
}

#[cfg(test)]
mod tests {
    use super::super::super::joint_lods::test_figures::arm;
    use super::*;
    use crate::split_mix::SplitMix;
    use glam::Quat;

    /// Every vertex, one after the other.
    fn plain(mesh: &Mesh, palettes: Palettes<'_>) -> f32 {
        let all = (0..mesh.len() as u32).map(|v| error(mesh, v, palettes));
        all.fold(0.0, f32::max)
    }

    #[test]
    fn is_the_maximum_over_every_vertex() {
        let mut random = SplitMix(1);
        let mut number = |size: f32| size * (random.below(2001) as f32 / 1000.0 - 1.0);
        let mut mesh = Mesh::clone(&arm(5).mesh);
        for position in &mut mesh.positions {
            *position += Vec3::new(number(0.3), number(0.3), number(0.3));
        }
        let mut farthest = Farthest::new(&mesh);
        let mut expected = 0.0f32;
        for tick in 0..300 {
            // Most ticks are calmer than some before, and only bounds are needed.
            let size = if tick % 50 == 0 { 0.02 } else { 0.01 };
            let mut palette = |size: f32| -> Vec<Affine3A> {
                let mut matrix = || {
                    let axis = Vec3::new(number(size), number(size), number(size));
                    let offset = Vec3::new(number(size), number(size), number(size));
                    Affine3A::from_rotation_translation(Quat::from_scaled_axis(axis), offset)
                };
                mesh.bindings.iter().map(|_| matrix()).collect()
            };
            let count = if tick % 3 == 0 { 1 } else { 3 };
            let [truth, shown] = [0, 1].map(|_| (0..count).map(|_| palette(size)).collect());
            let (truth, shown): (Vec<_>, Vec<_>) = (truth, shown);
            let palettes = Palettes {
                truth: &truth,
                shown: &shown,
            };
            expected = expected.max(plain(&mesh, palettes));
            farthest.add(&mesh, palettes, 0.0);
            assert_eq!(farthest.metres(), expected, "tick {tick}");
        }
    }

    #[test]
    fn what_is_not_finite_counts_as_nothing() {
        let mut mesh = Mesh::clone(&arm(2).mesh);
        mesh.positions[3] = Vec3::NAN;
        let same = vec![vec![Affine3A::IDENTITY; 2]];
        let lost = vec![vec![Affine3A::from_translation(Vec3::NAN); 2]];
        let mut farthest = Farthest::new(&mesh);
        let palettes = Palettes {
            truth: &same,
            shown: &lost,
        };
        farthest.add(&mesh, palettes, 0.25);
        assert_eq!(farthest.metres(), 0.25);
    }
}
