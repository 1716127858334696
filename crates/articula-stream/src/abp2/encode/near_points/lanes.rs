//! The points of a block side by side, so that one instruction is for several of them.

use super::super::skin_points::SkinPoints;
use super::{Apart, POINTS};
use std::collections::BTreeMap;

/// A number for each point.
type Lanes = [f32; POINTS];

/// At most [`POINTS`] points; what is beyond their number is 0.
#[derive(Debug, Default)]
pub(super) struct PointLanes {
    /// Coordinates at rest.
    places: [Lanes; 3],
    /// Weights of the bindings that some of the points follow.
    weights: Vec<(u16, Lanes)>,
    /// Offsets by the morph targets that move some of them.
    offsets: Vec<(u16, [Lanes; 3])>,
}

impl PointLanes {
    pub(super) fn of(points: &SkinPoints, of: &[u32]) -> Self {
        let mut places = [Lanes::default(); 3];
        let mut weights: BTreeMap<u16, Lanes> = BTreeMap::new();
        let mut offsets: BTreeMap<u16, [Lanes; 3]> = BTreeMap::new();
        for (lane, point) in of.iter().map(|point| *point as usize).enumerate() {
            for (axis, x) in points.position(point).to_array().into_iter().enumerate() {
                places[axis][lane] = x;
            }
            for (binding, weight) in points.influences(point) {
                weights.entry(*binding).or_default()[lane] += weight;
            }
            for (slot, offset) in points.offsets(point) {
                let own = offsets.entry(*slot).or_default();
                for (axis, x) in offset.to_array().into_iter().enumerate() {
                    own[axis][lane] += x;
                }
            }
        }
        Self {
            places,
            weights: weights.into_iter().collect(),
            offsets: offsets.into_iter().collect(),
        }
    }

    /// A bound of the distance of each point from its place, but for rounding: exact without morph targets, of
    /// which the difference is lengthened by `stretch` at most.
    pub(super) fn ways(
        &self,
        apart: &[Apart],
        (right, found): (&[f32], &[f32]),
        stretch: f32,
    ) -> Lanes {
        let mut places = self.places;
        let mut moved = [Lanes::default(); 3];
        for (slot, offsets) in &self.offsets {
            let slot = usize::from(*slot);
            let (found, apart) = (found[slot], right[slot] - found[slot]);
            for axis in 0..3 {
                add(&mut places[axis], &offsets[axis], found);
                add(&mut moved[axis], &offsets[axis], apart);
            }
        }
        let mut ways = [Lanes::default(); 3];
        for (binding, weights) in &self.weights {
            let by = apart[usize::from(*binding)].by;
            for (axis, way) in ways.iter_mut().enumerate() {
                let mut turned = [by.translation[axis]; POINTS];
                for (column, place) in places.iter().enumerate() {
                    add(&mut turned, place, by.matrix3.col(column)[axis]);
                }
                for lane in 0..POINTS {
                    way[lane] += turned[lane] * weights[lane];
                }
            }
        }
        let (ways, moved) = (lengths(&ways), lengths(&moved));
        std::array::from_fn(|lane| ways[lane] + stretch * moved[lane])
    }
}

fn add(to: &mut Lanes, from: &Lanes, factor: f32) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += from * factor;
    }
}

fn lengths([x, y, z]: &[Lanes; 3]) -> Lanes {
    std::array::from_fn(|lane| {
        let squares = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
        squares.sqrt()
    })
}
