//! Points that lie near each other, whose errors are bounded together: where the bound is within the
//! tolerance, none of them is looked at.
//!
//! Of a point *p* that follows the bindings *b* with weights *w_b*, a motion moves it by
//! |Σ *w_b* (*M_b* − *N_b*) *p*| from its place, with the matrices *M_b* and *N_b* of the true and the coded
//! pose. That is at most Σ *w_b* times the greatest |(*M_b* − *N_b*) *c*| + ‖*A_b* − *B_b*‖ *r* of the bindings, for all
//! points within *r* of *c*, where *A_b* and *B_b* are the linear parts.
//!
//! Morph targets move *p* by *d* in the true and by *e* in the coded pose before that. With *M_b* (*p* + *d*) − *N_b* (*p* + *e*)
//! = (*M_b* − *N_b*) (*p* + *e*) + *A_b* (*d* − *e*), the bound holds with ‖*A_b*‖ |*d* − *e*| added, *c* moved by the mean
//! of *e* over the points and *r* greater by the farthest that *e* is from it. Of each target the mean of the offsets is known, and the
//! greatest distance of an offset from it: near points are moved alike, so both are close bounds of *e* and *d* − *e*.

mod lanes;

use super::skin_points::SkinPoints;
use glam::{Affine3A, Vec3, Vec3A};
use lanes::PointLanes;
use std::collections::BTreeMap;

/// Most points of a block, and of a group of blocks.
const POINTS: usize = 16;
const POINTS_OF_GROUP: usize = 128;
/// Rounding of the places of points in single precision, as a part of what is summed for them.
const ROUNDING: f32 = 1e-6;

/// Neighbours among the points of a skin.
#[derive(Debug)]
pub(super) struct NearPoints {
    groups: Vec<Group>,
}

/// Blocks that lie near each other, and one around all of them.
#[derive(Debug)]
struct Group {
    whole: Block,
    blocks: Vec<(Block, PointLanes)>,
}

#[derive(Debug)]
struct Block {
    /// The points, ascending.
    points: Vec<u32>,
    centre: Vec3A,
    radius: f32,
    /// Distance from the origin that no point exceeds at rest.
    reach: f32,
    /// The bindings that some of the points follow.
    bindings: Vec<u16>,
    /// The greatest sum of the weights of a point.
    weight: f32,
    /// The morph targets that move some of them.
    offsets: Vec<Offsets>,
}

/// The offsets of some points by a morph target.
#[derive(Debug, Clone, Copy)]
struct Offsets {
    slot: u16,
    mean: Vec3A,
    /// Greatest distance of an offset from the mean.
    spread: f32,
    /// Length of the longest.
    greatest: f32,
}

/// How morph targets move the points of a block.
#[derive(Debug, Clone, Copy, Default)]
struct Moved {
    /// The mean in the coded pose.
    mean: Vec3A,
    /// How far it is from that at most.
    spread: f32,
    /// From the coded to the true pose at most.
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
    /// Of the matrix itself.
    own: Sizes,
}

/// Sizes of a matrix, or the greatest of several.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    linear: f32,
    translation: f32,
}

impl Sizes {
    fn of(apart: &[Apart]) -> Self {
        Self {
            linear: greatest(apart.iter().map(|apart| apart.own.linear)),
            translation: greatest(apart.iter().map(|apart| apart.own.translation)),
        }
    }
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
            own: Sizes {
                linear: size(right),
                translation: right.translation.length(),
            },
        }
    }
}

impl NearPoints {
    /// Groups points by their places at rest.
    pub(super) fn of(points: &SkinPoints) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let groups = parts(points, &mut order, POINTS_OF_GROUP).into_iter();
        let block = |of: &mut [u32]| (Block::of(points, of), PointLanes::of(points, of));
        let group = |of: &mut [u32]| Group {
            whole: Block::of(points, of),
            blocks: parts(points, of, POINTS).into_iter().map(block).collect(),
        };
        Self {
            groups: groups.map(group).collect(),
        }
    }

    /// The first of the points that are farthest from their places in a pose, if that is more than
    /// `limit`. Both poses are the matrices of the bindings and the weights of the morph targets.
    pub(super) fn farthest(
        &self,
        points: &SkinPoints,
        right: (&[Affine3A], &[f32]),
        found: (&[Affine3A], &[f32]),
        limit: f64,
    ) -> Option<usize> {
        let pairs = right.0.iter().zip(found.0);
        let apart: Vec<Apart> = pairs.map(|(a, b)| Apart::of(a, b)).collect();
        let mut search = Search {
            points,
            right,
            found,
            sizes: Sizes::of(&apart),
            apart: &apart,
            farthest: None,
            most: limit,
        };
        for group in &self.groups {
            if search.is_out(&group.whole) {
                continue;
            }
            for (block, lanes) in &group.blocks {
                search.look(block, lanes);
            }
        }
        search.farthest
    }
}

/// A search for the farthest point of a pose.
struct Search<'a> {
    points: &'a SkinPoints,
    right: (&'a [Affine3A], &'a [f32]),
    found: (&'a [Affine3A], &'a [f32]),
    /// How far each binding is apart, and the greatest sizes of all.
    apart: &'a [Apart],
    sizes: Sizes,
    farthest: Option<usize>,
    /// Distance of the farthest, or the limit.
    most: f64,
}

impl Search<'_> {
    /// Whether a point within this distance is not the one that is looked for.
    fn is_too_near(&self, distance: f32) -> bool {
        let distance = f64::from(distance);
        // Of equal ones the first counts.
        distance < self.most || self.farthest.is_none() && distance <= self.most
    }

    fn weights(&self) -> (&[f32], &[f32]) {
        (self.right.1, self.found.1)
    }

    /// Whether a block has no point that is looked for.
    fn is_out(&self, block: &Block) -> bool {
        let moved = block.moved(self.weights());
        let bound = block.bound(self.apart, moved);
        // Most blocks are out with what rounding adds where matrices are greatest.
        self.is_too_near(bound + block.rounding_of(self.sizes, moved))
            || self.is_too_near(bound + block.rounding(self.apart, moved))
    }

    fn look(&mut self, block: &Block, lanes: &PointLanes) {
        if self.is_out(block) {
            return;
        }
        let weights = self.weights();
        let rounding = block.rounding(self.apart, block.moved(weights));
        let apart = block.apart(self.apart);
        let stretch = block.weight * greatest(apart.map(|apart| apart.stretch));
        let bounds = lanes.ways(self.apart, weights, stretch);
        for (point, bound) in block.points.iter().zip(bounds) {
            if self.is_too_near(bound + rounding) {
                continue;
            }
            let point = *point as usize;
            let [right, found] = [self.right, self.found]
                .map(|(palette, weights)| self.points.skinned(point, weights, palette));
            let distance = f64::from(right.distance(found));
            let is_first = self.farthest.is_some_and(|farthest| point < farthest);
            if distance > self.most || distance == self.most && is_first {
                (self.farthest, self.most) = (Some(point), distance);
            }
        }
    }
}

/// Parts of at most so many points, halved along their longest side.
fn parts<'a>(points: &SkinPoints, order: &'a mut [u32], most: usize) -> Vec<&'a mut [u32]> {
    if order.len() <= most {
        order.sort_unstable();
        return match order.is_empty() {
            true => Vec::new(),
            false => vec![order],
        };
    }
    let place = |point: &u32| points.position(*point as usize);
    let places = order.iter().map(place).filter(|place| place.is_finite());
    let (low, high) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let axis = (high - low).max_position();
    let along = |point: &u32| place(point)[axis];
    let half = order
        .len()
        .div_ceil(2)
        .next_multiple_of(most)
        .min(order.len() - 1);
    order.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(half);
    let mut all = parts(points, left, most);
    all.append(&mut parts(points, right, most));
    all
}

impl Block {
    fn of(points: &SkinPoints, of: &[u32]) -> Self {
        let all = || of.iter().map(|point| *point as usize);
        let places = || all().map(|point| Vec3A::from(points.position(point)));
        let centre = places().sum::<Vec3A>() / of.len().max(1) as f32;
        let radius = places().map(|p| p.distance(centre)).fold(0.0, f32::max);
        let influences = all().flat_map(|point| points.influences(point));
        let mut bindings: Vec<u16> = influences.map(|(binding, _)| *binding).collect();
        bindings.sort_unstable();
        bindings.dedup();
        let weight = |point| points.influences(point).iter().map(|(_, w)| w).sum();
        // The radius and the centre are rounded too.
        let radius = radius * (1.0 + ROUNDING) + ROUNDING * centre.length();
        Self {
            centre,
            radius,
            reach: centre.length() + radius,
            bindings,
            weight: all().map(weight).fold(0.0, f32::max),
            offsets: offsets(points, of),
            points: of.to_vec(),
        }
    }

    /// How far the bindings that some of the points follow differ.
    fn apart<'a>(&self, apart: &'a [Apart]) -> impl Iterator<Item = &'a Apart> {
        let bindings = self.bindings.iter();
        bindings.map(|binding| &apart[usize::from(*binding)])
    }

    /// How morph targets move its points, by the weights of the true and the coded pose.
    fn moved(&self, (right, found): (&[f32], &[f32])) -> Moved {
        let mut moved = Moved::default();
        let (mut apart, mut spread) = (Vec3A::ZERO, 0.0);
        for of in &self.offsets {
            let slot = usize::from(of.slot);
            let (right, found) = (right[slot], found[slot]);
            moved.mean += of.mean * found;
            moved.spread += found.abs() * of.spread;
            apart += of.mean * (right - found);
            spread += (right - found).abs() * of.spread;
            moved.rounded += (right.abs() + found.abs()) * of.greatest;
        }
        moved.apart = apart.length() + spread;
        moved.rounded *= self.offsets.len() as f32;
        moved
    }

    /// A bound of the distance of its points from their places, but for rounding.
    fn bound(&self, apart: &[Apart], moved: Moved) -> f32 {
        let centre = self.centre + moved.mean;
        let radius = self.radius + moved.spread;
        let bounds = self.apart(apart).map(|apart| {
            let centre = apart.by.transform_point3a(centre).length();
            centre + apart.linear * radius + apart.stretch * moved.apart
        });
        self.weight * greatest(bounds)
    }

    /// What rounding adds to the distance of a point at most.
    fn rounding(&self, apart: &[Apart], moved: Moved) -> f32 {
        let sizes = self.apart(apart).map(|apart| apart.own);
        greatest(sizes.map(|own| self.rounding_of(own, moved)))
    }

    /// The same for matrices of at most these sizes.
    fn rounding_of(&self, own: Sizes, moved: Moved) -> f32 {
        let reach = self.reach + moved.rounded;
        ROUNDING * self.weight * (own.linear * reach + own.translation)
    }
}

/// The morph targets that move some points.
fn offsets(points: &SkinPoints, of: &[u32]) -> Vec<Offsets> {
    // Several parts of a target may move a point.
    let mut by_slot: BTreeMap<u16, BTreeMap<u32, Vec3A>> = BTreeMap::new();
    for point in of {
        for (slot, offset) in points.offsets(*point as usize) {
            let own = by_slot.entry(*slot).or_default();
            *own.entry(*point).or_default() += Vec3A::from(*offset);
        }
    }
    let of_slot = |(slot, own): (u16, BTreeMap<u32, Vec3A>)| {
        let mean = own.values().sum::<Vec3A>() / of.len() as f32;
        let is_still = own.len() < of.len();
        let still = is_still.then_some(Vec3A::ZERO);
        let apart = own.values().copied().chain(still).map(|o| o.distance(mean));
        let greatest = greatest(own.values().map(|offset| offset.length()));
        Offsets {
            slot,
            mean,
            // The mean and the distances are rounded too.
            spread: self::greatest(apart) * (1.0 + ROUNDING) + ROUNDING * greatest,
            greatest: greatest * (1.0 + ROUNDING),
        }
    };
    by_slot.into_iter().map(of_slot).collect()
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
pub(super) mod tests;
