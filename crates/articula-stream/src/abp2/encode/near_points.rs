//! Points that lie near each other, whose errors are bounded together: where the bound is within the
//! tolerance, none of them is looked at.
//!
//! Of a point *p* that follows the bindings *b* with weights *w_b*, a motion moves it by
//! |Σ *w_b* (*M_b* − *N_b*) *p*| from its place, with the matrices *M_b* and *N_b* of the true and the coded
//! pose. That is at most Σ *w_b* times the greatest |(*M_b* − *N_b*) *c*| + ‖*A_b* − *B_b*‖ *r* of the bindings, for all
//! points within *r* of *c*, where *A_b* and *B_b* are the linear parts.
//!
//! Morph targets move *p* by *d* in the true and by *e* in the coded pose before that. With *M_b* (*p* + *d*) − *N_b* (*p* + *e*)
//! = (*M_b* − *N_b*) (*p* + *e*) + *A_b* (*d* − *e*), the bound holds with *r* greater by |*e*|, and ‖*A_b*‖ |*d* − *e*| added.

use super::skin_points::{Posed, SkinPoints};
use glam::{Affine3A, Vec3A};
use std::collections::BTreeMap;
use std::ops::Range;

/// Points of a block.
const POINTS: usize = 16;
/// Rounding of the places of points in single precision, as a part of what is summed for them.
const ROUNDING: f32 = 1e-6;

/// Neighbours among the points of a skin.
#[derive(Debug)]
pub(super) struct NearPoints {
    blocks: Vec<Block>,
}

#[derive(Debug)]
struct Block {
    points: Range<usize>,
    centre: Vec3A,
    radius: f32,
    /// The bindings that some of the points follow.
    bindings: Vec<u16>,
    /// The greatest sum of the weights of a point.
    weight: f32,
    /// The morph targets that move some of them, with the greatest offset.
    offsets: Vec<(u16, f32)>,
}

/// How far morph targets move the points of a block at most.
#[derive(Debug, Clone, Copy, Default)]
struct Moved {
    /// In the coded pose.
    reach: f32,
    /// From the coded to the true pose.
    apart: f32,
    /// What the rounding of sums of offsets is a part of.
    rounded: f32,
}

/// How far the matrices of a binding differ.
#[derive(Debug, Clone, Copy)]
struct Apart {
    by: Affine3A,
    linear: f32,
    /// A bound of what the matrix itself lengthens.
    stretch: f32,
    /// Sizes of the matrix itself.
    own_linear: f32,
    own_translation: f32,
}

impl Apart {
    fn of(right: &Affine3A, found: &Affine3A) -> Self {
        let size = |m: &Affine3A| {
            let axes = m.matrix3;
            let squares = axes.x_axis.length_squared() + axes.y_axis.length_squared();
            (squares + axes.z_axis.length_squared()).sqrt()
        };
        let by = Affine3A {
            matrix3: right.matrix3 - found.matrix3,
            translation: right.translation - found.translation,
        };
        Self {
            by,
            linear: size(&by),
            stretch: stretch(right).min(size(right)) * (1.0 + ROUNDING),
            own_linear: size(right),
            own_translation: right.translation.length(),
        }
    }
}

impl NearPoints {
    /// Neighbours in the order of the points.
    pub(super) fn of(points: &SkinPoints) -> Self {
        let starts = (0..points.len()).step_by(POINTS);
        let blocks = starts.map(|start| Block::of(points, start..points.len().min(start + POINTS)));
        Self {
            blocks: blocks.collect(),
        }
    }

    /// The first of the points that are farthest from their places in a pose, if that is more than
    /// `limit`. Both poses have their matrices.
    pub(super) fn farthest(
        &self,
        points: &SkinPoints,
        (right, right_weights): (&Posed, &[f32]),
        (found, found_weights): (&Posed, &[f32]),
        limit: f64,
    ) -> Option<usize> {
        let pairs = right.palette.iter().zip(&found.palette);
        let apart: Vec<Apart> = pairs.map(|(a, b)| Apart::of(a, b)).collect();
        let weights = (right_weights, found_weights);
        let mut farthest = None;
        let mut most = limit;
        for block in &self.blocks {
            let moved = block.moved(weights);
            let rounding = block.rounding(&apart, moved);
            if f64::from(block.bound(&apart, moved) + rounding) <= most {
                continue;
            }
            let stretch = block.weight * greatest(block.apart(&apart).map(|apart| apart.stretch));
            for point in block.points.clone() {
                let bound = way(points, point, &apart, weights, stretch);
                if f64::from(bound + rounding) <= most {
                    continue;
                }
                let right = points.skinned(point, right_weights, &right.palette);
                let found = points.skinned(point, found_weights, &found.palette);
                let distance = f64::from(right.distance(found));
                if distance > most {
                    (farthest, most) = (Some(point), distance);
                }
            }
        }
        farthest
    }
}

impl Block {
    fn of(points: &SkinPoints, of: Range<usize>) -> Self {
        let places = || of.clone().map(|point| Vec3A::from(points.position(point)));
        let centre = places().sum::<Vec3A>() / of.len().max(1) as f32;
        let radius = places().map(|p| p.distance(centre)).fold(0.0, f32::max);
        let influences = of.clone().flat_map(|point| points.influences(point));
        let mut bindings: Vec<u16> = influences.map(|(binding, _)| *binding).collect();
        bindings.sort_unstable();
        bindings.dedup();
        let weight = |point| points.influences(point).iter().map(|(_, w)| w).sum();
        Self {
            centre,
            // The radius and the centre are rounded too.
            radius: radius * (1.0 + ROUNDING) + ROUNDING * centre.length(),
            bindings,
            weight: of.clone().map(weight).fold(0.0, f32::max),
            offsets: greatest_offsets(points, of.clone()),
            points: of,
        }
    }

    /// How far the bindings that some of the points follow differ.
    fn apart<'a>(&self, apart: &'a [Apart]) -> impl Iterator<Item = &'a Apart> {
        let bindings = self.bindings.iter();
        bindings.map(|binding| &apart[usize::from(*binding)])
    }

    /// How far morph targets move its points, by the weights of the true and the coded pose.
    fn moved(&self, (right, found): (&[f32], &[f32])) -> Moved {
        let mut moved = Moved::default();
        for (slot, offset) in &self.offsets {
            let (right, found) = (right[usize::from(*slot)], found[usize::from(*slot)]);
            moved.reach += found.abs() * offset;
            moved.apart += (right - found).abs() * offset;
            moved.rounded += (right.abs() + found.abs()) * offset;
        }
        moved.rounded *= self.offsets.len() as f32;
        moved
    }

    /// A bound of the distance of its points from their places, but for rounding.
    fn bound(&self, apart: &[Apart], moved: Moved) -> f32 {
        let bounds = self.apart(apart).map(|apart| {
            let centre = apart.by.transform_point3a(self.centre).length();
            centre + apart.linear * (self.radius + moved.reach) + apart.stretch * moved.apart
        });
        self.weight * greatest(bounds)
    }

    /// What rounding adds to the distance of a point at most.
    fn rounding(&self, apart: &[Apart], moved: Moved) -> f32 {
        let reach = self.centre.length() + self.radius + moved.rounded;
        let apart = self.apart(apart);
        let sizes = apart.map(|apart| apart.own_linear * reach + apart.own_translation);
        ROUNDING * self.weight * greatest(sizes)
    }
}

/// The morph targets that move some points, with the greatest offset of each.
fn greatest_offsets(points: &SkinPoints, of: Range<usize>) -> Vec<(u16, f32)> {
    let mut greatest: BTreeMap<u16, f32> = BTreeMap::new();
    for point in of {
        // Several parts of a target may move a point.
        let mut own: BTreeMap<u16, f32> = BTreeMap::new();
        for (slot, offset) in points.offsets(point) {
            *own.entry(*slot).or_default() += offset.length() * (1.0 + ROUNDING);
        }
        for (slot, offset) in own {
            let most = greatest.entry(slot).or_default();
            *most = most.max(offset);
        }
    }
    greatest.into_iter().collect()
}

/// A bound of the distance of a point from its place, but for rounding: exact without morph targets, of which
/// the difference is lengthened by `stretch` at most.
fn way(
    points: &SkinPoints,
    point: usize,
    apart: &[Apart],
    (right, found): (&[f32], &[f32]),
    stretch: f32,
) -> f32 {
    let mut place = Vec3A::from(points.position(point));
    let mut moved = Vec3A::ZERO;
    for (slot, offset) in points.offsets(point) {
        let (right, found) = (right[usize::from(*slot)], found[usize::from(*slot)]);
        place += Vec3A::from(*offset) * found;
        moved += Vec3A::from(*offset) * (right - found);
    }
    let influences = points.influences(point).iter();
    let ways = influences.map(|(binding, weight)| {
        apart[usize::from(*binding)].by.transform_point3a(place) * *weight
    });
    ways.sum::<Vec3A>().length() + stretch * moved.length()
}

/// A bound of what a matrix lengthens a vector by: the root of the greatest sum of a row of *AᵀA*.
fn stretch(matrix: &Affine3A) -> f32 {
    let axes = matrix.matrix3;
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
    let row = |a: &Vec3A| axes.iter().map(|b| a.dot(*b).abs()).sum::<f32>();
    greatest(axes.iter().map(row)).sqrt()
}

/// The greatest of some numbers; what is no number stays none, and is no bound.
fn greatest(numbers: impl Iterator<Item = f32>) -> f32 {
    numbers.fold(0.0, |a, b| if a.is_nan() || b <= a { a } else { b })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abp2::encode::skin_points::offsets_by_vertex;
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{
        Articulation, Binding, JointArticulation, Mesh, Morph, Region, Rig, Transform,
    };
    use articula_mutate::Dice;
    use glam::{Quat, Vec3};

    /// Joints of a chain along an arm of one metre, which ends at `x = 1`.
    const JOINTS: usize = 5;
    const RINGS: usize = 60;
    const AROUND: usize = 8;

    fn rig() -> Rig {
        let joint = |j: usize| Joint {
            name: format!("joint {j}"),
            parent: j.checked_sub(1),
            rest: Transform {
                translation: Vec3::X * if j == 0 { 0.0 } else { 1.0 / JOINTS as f32 },
                ..Transform::default()
            },
            in_skin: true,
        };
        let known = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::ALL[0],
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![known; JOINTS],
        };
        let joints = (0..JOINTS).map(joint).collect();
        Rig::new(&Skeleton { joints }, articulation).unwrap()
    }

    /// A tube around the chain that follows two joints everywhere; a morph target moves part of it.
    fn tube() -> Mesh {
        let mut mesh = Mesh {
            influences: 2,
            morph_weights: vec![0.5],
            ..Mesh::default()
        };
        for ring in 0..RINGS {
            let along = ring as f32 / RINGS as f32 * JOINTS as f32;
            let joint = along.floor();
            for side in 0..AROUND {
                let angle = std::f32::consts::TAU * side as f32 / AROUND as f32;
                let around = 0.04 * Vec3::new(0.0, angle.cos(), angle.sin());
                mesh.positions
                    .push(Vec3::X * along / JOINTS as f32 + around);
                let next = (joint as u16 + 1).min(JOINTS as u16 - 1);
                mesh.binding_indices.extend([joint as u16, next]);
                mesh.weights.extend([1.0 - (along - joint), along - joint]);
            }
        }
        let binding = |joint: usize| Binding {
            joint: joint as u16,
            inverse_bind: Affine3A::from_translation(Vec3::NEG_X * joint as f32 / JOINTS as f32),
        };
        mesh.bindings = (0..JOINTS).map(binding).collect();
        mesh.morphs.push(Morph {
            slot: 0,
            vertices: (100..180).collect(),
            positions: (0..80).map(|v| Vec3::Y * v as f32 / 800.0).collect(),
            normals: vec![Vec3::ZERO; 80],
        });
        mesh
    }

    #[test]
    fn bounds_miss_no_point() {
        for weights in [
            (0.0, 0.0),
            (0.5, 0.5),
            (0.5, 0.4999),
            (0.2, 0.3),
            (-0.1, 0.0),
        ] {
            check(weights);
        }
    }

    /// Weights of the morph target in the true and the coded pose.
    fn check((right_weight, found_weight): (f32, f32)) {
        let (rig, mesh) = (rig(), tube());
        let points =
            SkinPoints::of_vertices(&mesh, &offsets_by_vertex(&mesh), 0..mesh.positions.len());
        let near = NearPoints::of(&points);
        let (right_weights, found_weights) = (&[right_weight][..], &[found_weight][..]);
        let weights = (right_weights, found_weights);
        let mut dice = Dice::new(7);
        let mut turned = |most: f32, weights: &[f32]| {
            let mut posed = points.posed(&rig);
            for rotation in &mut posed.local.rotations {
                let axis = Vec3::from([(); 3].map(|()| dice.roll(2001) as f32 / 1000.0 - 1.0));
                *rotation *= Quat::from_scaled_axis(most * axis);
            }
            points.skin(&rig, weights, &mut posed);
            posed
        };
        let right = turned(0.0, right_weights);
        let mut left_out = 0;
        for most in [1e-5, 1e-4, 1e-3, 1e-2] {
            let found = turned(most, found_weights);
            let pairs = right.points.iter().zip(&found.points);
            let distances: Vec<f64> = pairs.map(|(a, b)| f64::from(a.distance(*b))).collect();
            let greatest = distances.iter().copied().fold(0.0, f64::max);
            assert!(greatest > 0.0);
            for part in [0.0, 0.5, 0.9, 0.999, 1.0, 1.1] {
                let limit = part * greatest;
                let mut expected = (None, limit);
                for (point, distance) in distances.iter().enumerate() {
                    if *distance > expected.1 {
                        expected = (Some(point), *distance);
                    }
                }
                let (right, found) = ((&right, right_weights), (&found, found_weights));
                assert_eq!(near.farthest(&points, right, found, limit), expected.0);
            }
            let pairs = right.palette.iter().zip(&found.palette);
            let apart: Vec<Apart> = pairs.map(|(a, b)| Apart::of(a, b)).collect();
            let bounds = near
                .blocks
                .iter()
                .map(|block| f64::from(block.bound(&apart, block.moved(weights))));
            left_out += bounds.filter(|bound| *bound <= greatest).count();
        }
        // Bounds are of use: the blocks of the upper arm move less than the hand.
        assert!(left_out > 2 * near.blocks.len(), "{left_out}");
    }
}
