//! Offsets by morph targets, rounded with the positions that they move.
//!
//! Rounded by itself, an offset adds its error to that of its position. Rounded so that the sum of both is near
//! the sum as it was, a vertex is as near its place at a weight of 1 as at 0, and between them nearer than at the
//! farther end.

use super::super::accessor::Component;
use super::super::place::Place;
use super::super::reader::Reader;
use super::ArrayPrecision;
use super::element::{Elements, elements};
use super::role::Role;
use crate::error::ReadError;
use crate::meshopt::encode::units;
use std::collections::BTreeMap;

/// Largest multiple of 1/32767 as which shorts store a step: with a larger one, their lower bits are wasted.
const MOST_SHORT_STEP: f32 = 2.0;
const WHOLE_SHORT: f32 = 32767.0;
/// Multiples below this fill one byte of a float, and need no short.
const OF_ONE_BYTE: i32 = 0x80;

/// Positions of the primitives, read once for all of their targets.
#[derive(Debug)]
pub(super) struct Offsets {
    /// Whether offsets may be normalised shorts: bitstream v1 stores the change of 16 bits as one number, but has
    /// no place for those of a float.
    pub(super) has_shorts: bool,
    positions: BTreeMap<usize, Option<Vec<f32>>>,
}

impl Offsets {
    pub(super) fn new(has_shorts: bool) -> Self {
        Self {
            has_shorts,
            positions: BTreeMap::new(),
        }
    }

    /// Offsets of the positions of an accessor, which err with them by no more than half of a step along each axis.
    /// Those that are integers are kept to the bit.
    pub(super) fn elements<'a>(
        &mut self,
        reader: &mut Reader<'a>,
        place: Place<'a>,
        (base, step): (usize, f32),
        precision: &ArrayPrecision,
    ) -> Result<Elements, ReadError> {
        let accessor = reader.accessor_at(place.clone())?;
        if !accessor.is_float() || accessor.width() != 3 || accessor.count == 0 {
            return elements(reader, place, Role::Offsets { step, base }, precision);
        }
        let offsets = reader.floats(&accessor)?;
        self.rounded(reader, (base, step), &offsets)
    }

    fn rounded(
        &mut self,
        reader: &mut Reader<'_>,
        (base, step): (usize, f32),
        offsets: &[f32],
    ) -> Result<Elements, ReadError> {
        let positions = match self.positions.get(&base) {
            Some(known) => known,
            None => {
                let read = read(reader, base)?;
                self.positions.entry(base).or_insert(read)
            }
        };
        let Some(positions) = positions.as_ref().filter(|p| p.len() == offsets.len()) else {
            // Without floats for positions, half of the step is left for each.
            return Ok(Elements::points(offsets, 0.5 * step));
        };
        let sizes = units(positions, step);
        let moved = Moved {
            positions,
            sizes,
            offsets,
            step,
        };
        let multiples = moved.multiples(sizes);
        let factor = (step * WHOLE_SHORT).floor();
        let is_short = self.has_shorts
            && (1.0..=MOST_SHORT_STEP).contains(&factor)
            && offsets.iter().all(|offset| offset.abs() < 0.999)
            && multiples.iter().any(|m| m.abs() >= OF_ONE_BYTE);
        if is_short {
            let multiples = moved.multiples([f64::from(factor / WHOLE_SHORT); 3]);
            return Ok(shorts(&multiples, factor as i32).bounded());
        }
        let sizes = sizes.iter().cycle();
        let floats = multiples.iter().zip(sizes);
        let floats: Vec<f32> = floats.map(|(m, s)| (f64::from(*m) * s) as f32).collect();
        Ok(Elements::points(&floats, step))
    }
}

/// Offsets of positions, all in steps, as whole steps: with the position rounded to whole steps they err by no more
/// than half of one along each axis.
pub(in crate::gltf) fn moved_multiples(positions: &[f32], offsets: &[f32]) -> Vec<i32> {
    let sizes = [1.0; 3];
    let moved = Moved {
        positions,
        sizes,
        offsets,
        step: 1.0,
    };
    moved.multiples(sizes)
}

fn read(reader: &mut Reader<'_>, accessor: usize) -> Result<Option<Vec<f32>>, ReadError> {
    let Some(place) = reader.root.entry("accessors", accessor) else {
        return Ok(None);
    };
    let accessor = reader.accessor_at(place)?;
    match accessor.is_float() && accessor.width() == 3 {
        true => Ok(Some(reader.floats(&accessor)?)),
        false => Ok(None),
    }
}

/// Multiples of `factor` as normalised shorts, three to an element.
fn shorts(multiples: &[i32], factor: i32) -> Elements {
    let short = |m: &i32| (m * factor).clamp(-32767, 32767) as i16;
    let bytes: Vec<u8> = multiples
        .iter()
        .flat_map(|m| short(m).to_le_bytes())
        .collect();
    Elements::padded(&bytes, 6, Component::I16, true)
}

/// Positions, the units of which they are stored as multiples, and offsets that move them.
struct Moved<'a> {
    positions: &'a [f32],
    sizes: [f64; 3],
    offsets: &'a [f32],
    step: f32,
}

impl Moved<'_> {
    /// Offsets as multiples of sizes along each axis. Of those that are near enough, the first is taken of none, those
    /// of the vertex before, since the codec stores what changes, and the nearest to the offset alone.
    fn multiples(&self, sizes: [f64; 3]) -> Vec<i32> {
        // The length of half a step along each axis.
        let far = 0.25 * 3.0 * f64::from(self.step) * f64::from(self.step);
        let mut before = [0i32; 3];
        let mut out = Vec::with_capacity(self.offsets.len());
        let positions = self.positions.as_chunks::<3>().0.iter();
        for (position, offset) in positions.zip(self.offsets.as_chunks::<3>().0) {
            let wanted: [f64; 3] = std::array::from_fn(|axis| {
                let (position, unit) = (f64::from(position[axis]), self.sizes[axis]);
                let stored = (position / unit).round() * unit;
                (position + f64::from(offset[axis]) - stored) / sizes[axis]
            });
            let error = |found: &[i32; 3]| -> f64 {
                let apart = |axis: usize| sizes[axis] * (wanted[axis] - f64::from(found[axis]));
                (0..3).map(|axis| apart(axis) * apart(axis)).sum()
            };
            let alone =
                std::array::from_fn(|axis| (f64::from(offset[axis]) / sizes[axis]).round() as i32);
            let found = [[0; 3], before, alone]
                .into_iter()
                .find(|found| error(found) <= far);
            before = found.unwrap_or_else(|| nearer(alone, &wanted, |found| error(found) <= far));
            out.extend_from_slice(&before);
        }
        out
    }
}

/// The multiples nearest to what is wanted, along as few axes as are enough.
fn nearer(mut found: [i32; 3], wanted: &[f64; 3], is_near: impl Fn(&[i32; 3]) -> bool) -> [i32; 3] {
    let apart = |found: &[i32; 3], axis: usize| (wanted[axis] - f64::from(found[axis])).abs();
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| apart(&found, *b).total_cmp(&apart(&found, *a)));
    for axis in axes {
        found[axis] = wanted[axis].round() as i32;
        if is_near(&found) {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn moved_by(positions: &[f32], offsets: &[f32], step: f32, part: f64) -> Vec<i32> {
        let sizes = units(positions, step);
        let moved = Moved {
            positions,
            sizes,
            offsets,
            step,
        };
        moved.multiples(sizes.map(|size| part * size))
    }

    proptest! {
        #[test]
        fn moved_positions_are_within_half_a_step_of_each_axis(
            pairs in prop::collection::vec((-1.0f32..1.0, -0.1f32..0.1), 3..99),
            step in 0.001f32..0.03,
            part in 0.5f64..1.0,
        ) {
            let whole = pairs.len() / 3 * 3;
            let positions: Vec<f32> = pairs[..whole].iter().map(|(p, _)| *p).collect();
            let offsets: Vec<f32> = pairs[..whole].iter().map(|(_, o)| *o).collect();
            let sizes = units(&positions, step);
            let multiples = moved_by(&positions, &offsets, step, part);
            for v in (0..whole).step_by(3) {
                let apart = |axis: usize| {
                    let (unit, i) = (sizes[axis], v + axis);
                    let stored = (f64::from(positions[i]) / unit).round() * unit;
                    stored + f64::from(multiples[i]) * part * unit
                        - f64::from(positions[i])
                        - f64::from(offsets[i])
                };
                let error = (0..3).map(|axis| apart(axis) * apart(axis)).sum::<f64>().sqrt();
                prop_assert!(error <= 0.5 * 3.0f64.sqrt() * f64::from(step) + 1e-9, "{error}");
            }
        }
    }

    #[test]
    fn what_does_not_move_has_no_offset() {
        let positions = [0.26, 0.74, 0.1, 0.26, 0.74, 0.1];
        let offsets = [0.0, 0.0, 0.0, 0.0, 0.0, 0.9];
        assert_eq!(moved_by(&positions, &offsets, 0.5, 1.0), [0, 0, 0, 0, 0, 2]);
    }
}
