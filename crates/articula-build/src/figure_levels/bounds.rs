//! The greatest error of any vertex, of which few are measured.
//!
//! A point of a level is off by a sum over bindings, `d = sum_b M_b q_b`, where `q_b = (x_b, w_b)` is the weighted
//! position of the full skin less that of the level's, which nearly cancel. Relative to one binding `a` and a
//! point `c` about which `a` and `b` turn against each other,
//!
//! ```text
//! |d| <= |L_a| |sum_b x_b| + sum_b (|L_b - L_a| |x_b - w_b c| + |w_b| |M_b c - M_a c|)
//! ```
//!
//! with `L` the linear part of `M`. The norms of matrices are those of a stretch of frames, the others are of the
//! vertex, so a bound is a few products, and no vertex is skinned whose bound is not above what others err.

use crate::surface_distance::SkinPoint;
use articula_core::{Binding, Mesh};
use foldhash::{HashMap, HashMapExt};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Part of the reach of a figure that rounding may add to a measured distance, with a wide margin.
const ROUNDING: f32 = 1e-5;

/// Palettes of a frame: of the full skin, and of the levels' bindings.
pub(super) struct Palettes {
    pub(super) full: Vec<Affine3A>,
    pub(super) level: Vec<Affine3A>,
}

/// Two bindings, and where each is at rest.
#[derive(Debug, Clone, Copy)]
struct Pair {
    bindings: [u32; 2],
    pivots: [Vec3A; 2],
}

/// How much of a point's error comes from two bindings that move against each other.
#[derive(Debug, Clone, Copy)]
struct Term {
    pair: u32,
    /// Distance of the weighted positions from each of the pivots, metres.
    arms: [f32; 2],
    /// Difference of the weights.
    weight: f32,
}

/// The terms of a point of a level.
#[derive(Debug, Clone, Copy)]
struct PointTerms {
    anchor: u32,
    /// Error at rest, metres.
    rest_metres: f32,
    /// What the sums of weights differ by.
    unbalanced: f32,
    first: u32,
    end: u32,
}

/// Bounds of the errors of all points of some levels.
pub(super) struct ErrorBounds {
    full: usize,
    pairs: Vec<Pair>,
    terms: Vec<Term>,
    /// Of each level, its points.
    levels: Vec<Vec<PointTerms>>,
    /// Distance of the farthest vertex from the origin at rest.
    radius: f32,
}

/// The greatest norms in a stretch of frames.
pub(super) struct Motion {
    /// Of the linear part of each binding.
    linear: Vec<f32>,
    /// Of each pair: of the difference of the linear parts, and how far the pivots are apart.
    pairs: Vec<(f32, [f32; 2])>,
    reach: f32,
}

/// Skin of a level, and its points, one for each watched vertex.
pub(super) struct BoundedLevel<'a> {
    pub(super) skin: &'a Mesh,
    pub(super) points: &'a [SkinPoint],
}

impl ErrorBounds {
    /// Finds the terms of all points. The levels' skins have the same bindings.
    pub(super) fn new(full: &Mesh, vertices: &[u32], levels: &[BoundedLevel<'_>]) -> Self {
        let own = &full.bindings;
        let shared = levels.first().map_or(&[][..], |l| &l.skin.bindings[..]);
        let mut builder = Builder {
            pivots: own.iter().chain(shared).map(pivot).collect(),
            places: shared
                .iter()
                .enumerate()
                .map(|(i, b)| place(own, i, b))
                .collect(),
            pairs: HashMap::new(),
            bounds: Self {
                full: own.len(),
                pairs: Vec::new(),
                terms: Vec::new(),
                levels: Vec::with_capacity(levels.len()),
                radius: full
                    .positions
                    .iter()
                    .map(|p| p.length())
                    .fold(0.0, f32::max),
            },
        };
        for level in levels {
            let points = vertices.iter().zip(level.points);
            let points =
                points.map(|(v, point)| builder.point(full, *v as usize, level.skin, point));
            let points = points.collect();
            builder.bounds.levels.push(points);
        }
        builder.bounds
    }

    /// The greatest norms in some frames.
    pub(super) fn motion(&self, frames: &[Palettes]) -> Motion {
        let greatest = |of: &dyn Fn(&Palettes) -> f32| frames.iter().map(of).fold(0.0, most);
        let count = self.full + frames.first().map_or(0, |f| f.level.len());
        let linear = (0..count as u32).map(|b| greatest(&|f| norm(self.matrix(f, b).matrix3)));
        let linear: Vec<f32> = linear.collect();
        let pairs = self.pairs.iter().map(|pair| {
            let turn = greatest(&|f| {
                let [a, b] = self.matrices(f, pair);
                norm(b.matrix3 - a.matrix3)
            });
            let apart = pair.pivots.map(|pivot| {
                greatest(&|f| {
                    let at = self.matrices(f, pair).map(|m| m.transform_point3a(pivot));
                    let [a, b] = at;
                    b.distance(a)
                })
            });
            (turn, apart)
        });
        let far = greatest(&|f| {
            let all = f.full.iter().chain(&f.level);
            all.map(|m| m.translation.length()).fold(0.0, most)
        });
        let reach = far + linear.iter().copied().fold(0.0, most) * self.radius;
        Motion {
            pairs: pairs.collect(),
            linear,
            reach,
        }
    }

    /// An upper bound on the distances that are measured of a level's points in the frames of a motion. NaN
    /// where a matrix is.
    pub(super) fn of_level<'a>(
        &'a self,
        level: usize,
        motion: &'a Motion,
    ) -> impl Iterator<Item = f32> + 'a {
        self.levels[level].iter().map(move |point| {
            let rest = motion.linear[point.anchor as usize] * point.rest_metres;
            let terms = &self.terms[point.first as usize..point.end as usize];
            let moved = terms.iter().map(|term| {
                let (turn, apart) = motion.pairs[term.pair as usize];
                let about = |i: usize| turn * term.arms[i] + term.weight * apart[i];
                let (one, other) = (about(0), about(1));
                if one < other { one } else { other }
            });
            rest + moved.sum::<f32>() + (point.unbalanced + ROUNDING) * motion.reach
        })
    }

    fn matrices<'f>(&self, frame: &'f Palettes, pair: &Pair) -> [&'f Affine3A; 2] {
        pair.bindings.map(|binding| self.matrix(frame, binding))
    }

    fn matrix<'f>(&self, frame: &'f Palettes, binding: u32) -> &'f Affine3A {
        let binding = binding as usize;
        match frame.full.get(binding) {
            Some(matrix) => matrix,
            None => &frame.level[binding - self.full],
        }
    }
}

struct Builder {
    /// Origin of the joint of each binding at rest.
    pivots: Vec<Vec3A>,
    /// Index of each binding of the levels among all: the one of the full skin where it is the same.
    places: Vec<u32>,
    pairs: HashMap<[u32; 2], u32>,
    bounds: ErrorBounds,
}

impl Builder {
    fn point(&mut self, full: &Mesh, v: usize, skin: &Mesh, point: &SkinPoint) -> PointTerms {
        let mut sums: Vec<(u32, Vec3, f32)> = Vec::with_capacity(16);
        let mut add = |binding: u32, weight: f32, position: Vec3| {
            let at = sums.iter().position(|s| s.0 == binding);
            let at = at.unwrap_or_else(|| {
                sums.push((binding, Vec3::ZERO, 0.0));
                sums.len() - 1
            });
            sums[at].1 += weight * position;
            sums[at].2 += weight;
        };
        let mut anchor = (f32::NEG_INFINITY, 0);
        for (binding, weight) in influences(full, v) {
            if weight > anchor.0 {
                anchor = (weight, binding);
            }
            add(binding, weight, full.positions[v]);
        }
        for (corner, share) in point.corners.into_iter().zip(point.weights) {
            if share == 0.0 {
                continue;
            }
            let corner = corner as usize;
            for (binding, weight) in influences(skin, corner) {
                let binding = self.places[binding as usize];
                add(binding, -share * weight, skin.positions[corner]);
            }
        }
        let rest: Vec3 = sums.iter().map(|s| s.1).sum();
        let unbalanced: f32 = sums.iter().map(|s| s.2).sum();
        let first = self.bounds.terms.len() as u32;
        for (binding, position, weight) in sums {
            if binding != anchor.1 && (weight != 0.0 || position != Vec3::ZERO) {
                self.term([anchor.1, binding], position, weight);
            }
        }
        PointTerms {
            anchor: anchor.1,
            rest_metres: rest.length(),
            unbalanced: unbalanced.abs(),
            first,
            end: self.bounds.terms.len() as u32,
        }
    }

    fn term(&mut self, bindings: [u32; 2], position: Vec3, weight: f32) {
        let pivots = bindings.map(|b| self.pivots[b as usize]);
        let known = &mut self.bounds.pairs;
        let pair = *self.pairs.entry(bindings).or_insert_with(|| {
            known.push(Pair { bindings, pivots });
            known.len() as u32 - 1
        });
        self.bounds.terms.push(Term {
            pair,
            arms: pivots.map(|pivot| (Vec3A::from(position) - weight * pivot).length()),
            weight: weight.abs(),
        });
    }
}

/// Bindings of a vertex with their weights, without those of no weight.
fn influences(mesh: &Mesh, vertex: usize) -> impl Iterator<Item = (u32, f32)> {
    let of = vertex * mesh.influences..(vertex + 1) * mesh.influences;
    let indices = mesh.binding_indices[of.clone()]
        .iter()
        .map(|b| u32::from(*b));
    let pairs = indices.zip(mesh.weights[of].iter().copied());
    pairs.filter(|(_, weight)| *weight != 0.0)
}

fn place(own: &[Binding], level: usize, binding: &Binding) -> u32 {
    let same = |b: &Binding| b.joint == binding.joint && b.inverse_bind == binding.inverse_bind;
    own.iter().position(same).unwrap_or(own.len() + level) as u32
}

fn pivot(binding: &Binding) -> Vec3A {
    binding.inverse_bind.inverse().translation
}

/// An upper bound on the factor by which a matrix lengthens a vector: the root of the greatest sum of a row of
/// its product with its transpose.
fn norm(m: Mat3A) -> f32 {
    let product = m.transpose() * m;
    let row = |i: usize| product.row(i).abs().element_sum();
    most(most(row(0), row(1)), row(2)).sqrt()
}

/// The greater of two, or NaN if one is.
fn most(a: f32, b: f32) -> f32 {
    if a >= b || a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn binding(joint: u16, at: Vec3) -> Binding {
        Binding {
            joint,
            inverse_bind: Affine3A::from_translation(-at),
        }
    }

    fn mesh(influences: &[[(u16, f32); 2]], bindings: Vec<Binding>) -> Mesh {
        let count = influences.len();
        Mesh {
            positions: (0..count)
                .map(|v| Vec3::new(0.1 * v as f32, 1.0, 0.05))
                .collect(),
            influences: 2,
            binding_indices: influences.iter().flatten().map(|i| i.0).collect(),
            weights: influences.iter().flatten().map(|i| i.1).collect(),
            bindings,
            ..Mesh::default()
        }
    }

    /// Two joints, of which the second turns about its origin and both are carried about; of the level all
    /// vertices follow the first.
    #[test]
    fn no_measured_error_exceeds_its_bound_and_the_greatest_bound_is_near() {
        let bindings = || vec![binding(0, Vec3::ZERO), binding(1, Vec3::new(0.2, 1.0, 0.0))];
        let weights = [[0.9, 0.1], [0.7, 0.3], [0.5, 0.5], [0.2, 0.8], [0.0, 1.0]];
        let full: Vec<_> = weights.map(|[a, b]| [(0, a), (1, b)]).to_vec();
        let full = mesh(&full, bindings());
        let level = mesh(&[[(0, 1.0), (1, 0.0)]; 5], bindings());
        let mut points: Vec<SkinPoint> = (0..4).map(SkinPoint::at).collect();
        points.push(SkinPoint {
            corners: [0, 2, 4],
            weights: [0.25, 0.25, 0.5],
        });
        let vertices = [0, 1, 2, 3, 4];
        let bounded = BoundedLevel {
            skin: &level,
            points: &points,
        };
        let bounds = ErrorBounds::new(&full, &vertices, &[bounded]);
        let frame = |f: u32| {
            let turn = 0.02 * f as f32;
            let carried = Affine3A::from_rotation_translation(
                Quat::from_rotation_y(5.0 * turn),
                Vec3::new(3.0, 0.0, turn),
            );
            let pivot = Affine3A::from_translation(Vec3::new(0.2, 1.0, 0.0));
            let bent = pivot * Affine3A::from_rotation_z(turn) * pivot.inverse();
            let matrices = vec![carried, carried * bent];
            Palettes {
                full: matrices.clone(),
                level: matrices,
            }
        };
        let frames: Vec<Palettes> = (0..20).map(frame).collect();
        let motion = bounds.motion(&frames);
        let found: Vec<f32> = bounds.of_level(0, &motion).collect();
        let mut worst = vec![0.0_f32; 5];
        let (mut truth, mut posed) = ([Vec3::ZERO; 5], [Vec3::ZERO; 5]);
        for frame in &frames {
            articula_core::skin_points(&full, &frame.full, &vertices, &mut truth);
            articula_core::skin_points(&level, &frame.level, &vertices, &mut posed);
            for (v, worst) in worst.iter_mut().enumerate() {
                *worst = worst.max(truth[v].distance(points[v].posed(&posed)));
            }
        }
        for (v, (bound, worst)) in found.iter().zip(&worst).enumerate() {
            assert!(bound >= worst, "vertex {v}: {bound} m, {worst} m");
            assert!(
                *bound < 2.0 * worst + 0.03,
                "vertex {v}: {bound} m, {worst} m"
            );
        }
    }

    #[test]
    fn norms_are_no_less_than_what_a_matrix_does() {
        let turned = Mat3A::from_quat(Quat::from_rotation_x(0.7));
        assert!((norm(turned) - 1.0).abs() < 1e-5);
        let odd = Mat3A::from_cols(
            Vec3A::new(1.0, 2.0, -1.0),
            Vec3A::new(0.5, 0.1, 3.0),
            Vec3A::new(-2.0, 0.3, 0.2),
        );
        for v in [
            Vec3A::X,
            Vec3A::Y,
            Vec3A::Z,
            Vec3A::ONE,
            Vec3A::new(1.0, -2.0, 0.5),
        ] {
            assert!((odd * v).length() <= norm(odd) * v.length() * 1.000_01);
        }
        assert!(norm(Mat3A::from_cols(Vec3A::NAN, Vec3A::Y, Vec3A::Z)).is_nan());
    }
}
