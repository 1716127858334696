//! Points that lie near each other, whose errors are bounded together: where the bound is within the
//! tolerance, none of them is looked at.
//!
//! Of a point *p* that follows the bindings *b* with weights *w_b*, a motion moves it by
//! |Σ *w_b* (*M_b* − *N_b*) *p*| from its place, with the matrices *M_b* and *N_b* of the true and the coded
//! pose. That is at most Σ *w_b* times the greatest |(*M_b* − *N_b*) *c*| + ‖*A_b* − *B_b*‖ *r* of the bindings, for all
//! points within *r* of *c*, where *A_b* and *B_b* are the linear parts.

use super::skin_points::{Posed, SkinPoints};
use glam::{Affine3A, Vec3A};
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
    /// Whether morph targets can move some of them, which no bound counts.
    has_offsets: bool,
}

/// How far the matrices of a binding differ.
#[derive(Debug, Clone, Copy)]
struct Apart {
    by: Affine3A,
    linear: f32,
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
        // Morph targets whose weights are zero move nothing.
        let mut weights = right_weights.iter().chain(found_weights);
        let is_plain = weights.all(|weight| *weight == 0.0);
        let mut farthest = None;
        let mut most = limit;
        for block in &self.blocks {
            let rounding = block.rounding(&apart);
            let is_bounded = is_plain || !block.has_offsets;
            if is_bounded && f64::from(block.bound(&apart) + rounding) <= most {
                continue;
            }
            for point in block.points.clone() {
                if is_bounded && f64::from(way(points, point, &apart) + rounding) <= most {
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
            has_offsets: of.clone().any(|point| !points.offsets(point).is_empty()),
            points: of,
        }
    }

    /// A bound of the distance of its points from their places, but for rounding.
    fn bound(&self, apart: &[Apart]) -> f32 {
        let apart = self
            .bindings
            .iter()
            .map(|binding| &apart[usize::from(*binding)]);
        let bounds = apart.map(|apart| {
            let centre = apart.by.transform_point3a(self.centre).length();
            centre + apart.linear * self.radius
        });
        self.weight * greatest(bounds)
    }

    /// What rounding adds to the distance of a point at most.
    fn rounding(&self, apart: &[Apart]) -> f32 {
        let reach = self.centre.length() + self.radius;
        let apart = self
            .bindings
            .iter()
            .map(|binding| &apart[usize::from(*binding)]);
        let sizes = apart.map(|apart| apart.own_linear * reach + apart.own_translation);
        ROUNDING * self.weight * greatest(sizes)
    }
}

/// The distance of a point without morph targets from its place, but for rounding.
fn way(points: &SkinPoints, point: usize, apart: &[Apart]) -> f32 {
    let place = Vec3A::from(points.position(point));
    let influences = points.influences(point).iter();
    let ways = influences.map(|(binding, weight)| {
        apart[usize::from(*binding)].by.transform_point3a(place) * *weight
    });
    ways.sum::<Vec3A>().length()
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

    /// A tube around the chain that follows two joints everywhere; one vertex has a morph target.
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
            vertices: vec![100],
            positions: vec![Vec3::Y],
            normals: vec![Vec3::ZERO],
        });
        mesh
    }

    #[test]
    fn bounds_miss_no_point() {
        for weight in [0.0, 0.5] {
            check(weight);
        }
    }

    fn check(weight: f32) {
        let (rig, mesh) = (rig(), tube());
        let points =
            SkinPoints::of_vertices(&mesh, &offsets_by_vertex(&mesh), 0..mesh.positions.len());
        let near = NearPoints::of(&points);
        let weights = &[weight][..];
        let mut dice = Dice::new(7);
        let mut turned = |most: f32| {
            let mut posed = points.posed(&rig);
            for rotation in &mut posed.local.rotations {
                let axis = Vec3::from([(); 3].map(|()| dice.roll(2001) as f32 / 1000.0 - 1.0));
                *rotation *= Quat::from_scaled_axis(most * axis);
            }
            points.skin(&rig, weights, &mut posed);
            posed
        };
        let right = turned(0.0);
        let mut left_out = 0;
        for most in [1e-5, 1e-4, 1e-3, 1e-2] {
            let found = turned(most);
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
                let (right, found) = ((&right, weights), (&found, weights));
                assert_eq!(near.farthest(&points, right, found, limit), expected.0);
            }
            let pairs = right.palette.iter().zip(&found.palette);
            let apart: Vec<Apart> = pairs.map(|(a, b)| Apart::of(a, b)).collect();
            let bounds = near
                .blocks
                .iter()
                .map(|block| f64::from(block.bound(&apart)));
            left_out += bounds.filter(|bound| *bound <= greatest).count();
        }
        // Bounds are of use: the blocks of the upper arm move less than the hand.
        assert!(left_out > 2 * near.blocks.len(), "{left_out}");
    }
}
