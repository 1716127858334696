//! Arrays as elements of few digits, in front of the filter of a compressed view.

use super::super::accessor::{Accessor, Component};
use super::super::append::{set, shortest};
use super::super::place::Place;
use super::super::reader::Reader;
use super::ArrayPrecision;
use super::role::Role;
use crate::error::ReadError;
use crate::meshopt::encode::{exponential, exponential_points, octahedral, quaternions};
use crate::meshopt::filter::undo;
use crate::meshopt::{Filter, Mode};
use articula_core::source::{Channel, Interpolation, Property};
use serde_json::Value;

/// Step of offsets of normals; normals themselves have 8 bits.
const NORMAL_STEP: f32 = 1.0 / 128.0;
const NORMAL_BITS: u32 = 8;

/// An array in the form in which it is stored.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Elements {
    pub(super) mode: Mode,
    pub(super) filter: Filter,
    /// Bytes of an element.
    pub(super) stride: usize,
    pub(super) count: usize,
    pub(super) bytes: Vec<u8>,
    pub(super) component: Component,
    pub(super) normalized: bool,
    /// Whether the format requires its bounds.
    pub(super) is_bounded: bool,
    /// Whether it may be compressed.
    pub(super) is_compressible: bool,
}

impl Elements {
    /// Floats as multiples of a step.
    pub(super) fn stepped(floats: &[f32], width: usize, step: f32) -> Self {
        Self::floating(exponential(floats, step), width)
    }

    /// Points that are within the length of half a step along each axis, with bounds.
    pub(super) fn points(floats: &[f32], step: f32) -> Self {
        Self::floating(exponential_points(floats, step), 3).bounded()
    }

    /// Elements of the exponential filter.
    pub(super) fn floating(bytes: Vec<u8>, width: usize) -> Self {
        Self {
            mode: Mode::Attributes,
            filter: Filter::Exponential,
            stride: 4 * width,
            count: bytes.len() / (4 * width),
            bytes,
            component: Component::F32,
            normalized: false,
            is_bounded: false,
            is_compressible: true,
        }
    }

    /// Bytes whose elements start at multiples of 4.
    pub(super) fn padded(
        bytes: &[u8],
        size: usize,
        component: Component,
        normalized: bool,
    ) -> Self {
        let stride = size.next_multiple_of(4);
        let mut padded = Vec::with_capacity(bytes.len() / size * stride);
        for element in bytes.chunks_exact(size) {
            padded.extend_from_slice(element);
            padded.resize(padded.len().next_multiple_of(4), 0);
        }
        Self {
            mode: Mode::Attributes,
            filter: Filter::None,
            stride,
            count: bytes.len() / size,
            bytes: padded,
            component,
            normalized,
            is_bounded: false,
            is_compressible: true,
        }
    }

    /// The floats that a reader has of it; normalised integers as fractions.
    pub(super) fn floats(&self) -> Vec<f32> {
        let mut bytes = self.bytes.clone();
        undo(self.filter, self.stride, &mut bytes);
        match self.component {
            Component::I16 => {
                let shorts = bytes.as_chunks::<2>().0.iter();
                shorts
                    .map(|b| f32::from(i16::from_le_bytes(*b)) / 32767.0)
                    .collect()
            }
            _ => {
                let words = bytes.as_chunks::<4>().0.iter();
                words.map(|b| f32::from_le_bytes(*b)).collect()
            }
        }
    }

    /// Sets the bounds of the numbers of an accessor, as they are stored.
    pub(super) fn set_bounds(&self, accessor: &mut Value) {
        let floats = self.floats();
        if self.component == Component::F32 {
            let (least, most) = bounds(&floats, self.stride / 4, self.stride / 4);
            set(accessor, "min", shortest(&least));
            set(accessor, "max", shortest(&most));
            return;
        }
        // Three shorts have the space of four.
        let (least, most) = bounds(&floats, 3, self.stride / 2);
        let whole = |floats: Vec<f32>| -> Value {
            let numbers = floats.iter().map(|x| (x * 32767.0).round() as i32);
            numbers.collect()
        };
        set(accessor, "min", whole(least));
        set(accessor, "max", whole(most));
    }

    /// Whether it is a list of triangles whose first has the corners 0, 1 and 2.
    pub(super) fn begins_anew(&self) -> bool {
        let corners = self.bytes.as_chunks::<4>().0.iter().take(3);
        let corners = corners.map(|b| u32::from_le_bytes(*b));
        self.mode == Mode::Triangles && corners.eq(0..3)
    }

    pub(super) fn bounded(self) -> Self {
        Self {
            is_bounded: true,
            ..self
        }
    }
}

/// Least and greatest of each of the first numbers of elements of a size.
fn bounds(numbers: &[f32], width: usize, size: usize) -> (Vec<f32>, Vec<f32>) {
    let of = |c: usize| numbers.iter().skip(c).step_by(size).copied();
    let bound = |start: f32, pick: fn(f32, f32) -> f32| -> Vec<f32> {
        (0..width).map(|c| of(c).fold(start, pick)).collect()
    };
    (
        bound(f32::INFINITY, f32::min),
        bound(f32::NEG_INFINITY, f32::max),
    )
}

/// Returns the array that an accessor at a place describes, as it is stored for a role.
pub(super) fn elements<'a>(
    reader: &mut Reader<'a>,
    place: Place<'a>,
    role: Role,
    precision: &ArrayPrecision,
) -> Result<Elements, ReadError> {
    let accessor = reader.accessor_at(place)?;
    let width = accessor.width();
    let is_float = accessor.is_float();
    if matches!(role, Role::Triangles | Role::Indices) {
        return corners(reader, &accessor, role);
    }
    if role == Role::Joints && accessor.count > 0 && !is_float {
        return joints(reader, &accessor);
    }
    // Integers were rounded by those who made them.
    if !is_float || role == Role::Exact || accessor.count == 0 {
        return exact(&accessor, role);
    }
    let floats = reader.floats(&accessor)?;
    let made = match role {
        Role::Positions(step) if width == 3 => Some(Elements::points(&floats, step)),
        Role::NormalOffsets => Some(Elements::stepped(&floats, width, NORMAL_STEP)),
        Role::Texcoords => Some(Elements::stepped(&floats, width, precision.texcoords)),
        Role::Values(step) => Some(Elements::stepped(&floats, width, step)),
        Role::Times(step) => Some(key_times(&floats, step)),
        Role::Normals if width == 3 => unit_vectors(&floats, 3),
        Role::Tangents if width == 4 => unit_vectors(&floats, 4),
        Role::Colors => Some(colors(&floats, width)),
        Role::Rotations(step) if width == 4 => rotations(&floats, step),
        _ => None,
    };
    made.map_or_else(|| exact(&accessor, role), Ok)
}

/// An array to the bit.
fn exact(accessor: &Accessor<'_>, role: Role) -> Result<Elements, ReadError> {
    let size = accessor.element_size();
    let overlay = accessor.overlay()?;
    let mut bytes = Vec::with_capacity(accessor.count * size);
    for i in 0..accessor.count {
        let stored = overlay.get(&i).copied().or_else(|| accessor.stored(i));
        match stored {
            Some(element) => bytes.extend_from_slice(element),
            None => bytes.resize(bytes.len() + size, 0),
        }
    }
    let is_bounded = matches!(
        role,
        Role::Positions(_) | Role::Offsets { .. } | Role::Times(_)
    ) || accessor.place().has("min")
        || accessor.place().has("max");
    let whole = size.is_multiple_of(4);
    if whole || role.is_of_vertices() {
        let elements =
            Elements::padded(&bytes, size, accessor.component(), accessor.is_normalized());
        return Ok(Elements {
            is_bounded,
            is_compressible: elements.stride <= 256,
            ..elements
        });
    }
    // Arrays that are not of vertices have no space between their elements.
    Ok(Elements {
        mode: Mode::Attributes,
        filter: Filter::None,
        stride: size,
        count: accessor.count,
        bytes,
        component: accessor.component(),
        normalized: accessor.is_normalized(),
        is_bounded,
        is_compressible: false,
    })
}

/// Indices, as 32-bit numbers for the encoder; stored in 16 bits where they fit.
fn corners<'a>(
    reader: &mut Reader<'a>,
    accessor: &Accessor<'a>,
    role: Role,
) -> Result<Elements, ReadError> {
    let corners = reader.integers(accessor)?;
    // 65535 restarts a strip.
    let is_short = corners.iter().all(|c| *c < 0xffff);
    let is_list = role == Role::Triangles && corners.len().is_multiple_of(3);
    Ok(Elements {
        mode: if is_list {
            Mode::Triangles
        } else {
            Mode::Indices
        },
        filter: Filter::None,
        stride: if is_short { 2 } else { 4 },
        count: corners.len(),
        bytes: corners.iter().flat_map(|c| c.to_le_bytes()).collect(),
        component: if is_short {
            Component::U16
        } else {
            Component::U32
        },
        normalized: false,
        is_bounded: false,
        is_compressible: !corners.is_empty(),
    })
}

/// Joints of influences, in bytes where they fit.
fn joints<'a>(reader: &mut Reader<'a>, accessor: &Accessor<'a>) -> Result<Elements, ReadError> {
    let joints = reader.integers(accessor)?;
    if joints.iter().any(|joint| *joint > 255) {
        return exact(accessor, Role::Joints);
    }
    let bytes: Vec<u8> = joints.iter().map(|joint| *joint as u8).collect();
    Ok(Elements::padded(
        &bytes,
        accessor.width(),
        Component::U8,
        false,
    ))
}

/// Step of times of keys that is at most `step` and a 32nd of the shortest time between two keys: two keys
/// that are close together make a jump, whose moment shows.
fn key_time_step(secs: &[f32], step: f32) -> f32 {
    let intervals = secs.windows(2).map(|pair| pair[1] - pair[0]);
    let shortest = intervals.filter(|s| *s > 0.0).fold(f32::INFINITY, f32::min);
    step.min(shortest / 32.0)
}

/// Times of keys, with a step at which none of them become equal.
pub(super) fn key_times(secs: &[f32], step: f32) -> Elements {
    let mut step = key_time_step(secs, step);
    let is_rising = |bytes: &[u8]| {
        let mut before = i64::MIN;
        bytes.as_chunks::<4>().0.iter().all(|b| {
            let mantissa = (i32::from_le_bytes(*b) << 8) >> 8;
            let rises = i64::from(mantissa) > before;
            before = i64::from(mantissa);
            rises
        })
    };
    let mut elements = Elements::stepped(secs, 1, step);
    while !is_rising(&elements.bytes) {
        let finer = Elements::stepped(secs, 1, 0.5 * step);
        if finer.bytes == elements.bytes || step < 1e-7 {
            let bytes: Vec<u8> = secs.iter().flat_map(|t| t.to_le_bytes()).collect();
            return Elements::padded(&bytes, 4, Component::F32, false).bounded();
        }
        (step, elements) = (0.5 * step, finer);
    }
    elements.bounded()
}

/// Values of the keys of a channel with a step.
pub(super) fn key_values(channel: &Channel, step: f32) -> Elements {
    let values = &channel.values;
    let width = match channel.property {
        Property::Rotation => 4,
        Property::Weights => 1,
        _ => 3,
    };
    let made = match (channel.interpolation, channel.property) {
        (Interpolation::CubicSpline, _) => None,
        (_, Property::Rotation) => rotations(values, step),
        _ => Some(Elements::stepped(values, width, step)),
    };
    made.unwrap_or_else(|| {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        Elements::padded(&bytes, 4 * width, Component::F32, false)
    })
}

/// Vectors of length 1, and a sign for those of four numbers. `None` if one has no length.
fn unit_vectors(floats: &[f32], width: usize) -> Option<Elements> {
    let vectors: Vec<[f32; 4]> = floats
        .chunks_exact(width)
        .map(|v| {
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            let sign = v.get(3).copied().unwrap_or(0.0);
            (length > 1e-6).then(|| [v[0] / length, v[1] / length, v[2] / length, sign])
        })
        .collect::<Option<_>>()?;
    Some(Elements {
        mode: Mode::Attributes,
        filter: Filter::Octahedral,
        stride: 4,
        count: vectors.len(),
        bytes: octahedral(&vectors, NORMAL_BITS)?,
        component: Component::I8,
        normalized: true,
        is_bounded: false,
        is_compressible: true,
    })
}

fn colors(floats: &[f32], width: usize) -> Elements {
    let byte = |x: &f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    let bytes: Vec<u8> = floats.iter().map(byte).collect();
    Elements::padded(&bytes, width, Component::U8, true)
}

/// Rotations with as many bits as keep them within a step. `None` if one has no length.
fn rotations(floats: &[f32], step: f32) -> Option<Elements> {
    let turns: Vec<[f32; 4]> = floats
        .as_chunks::<4>()
        .0
        .iter()
        .map(|q| {
            let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
            (length > 1e-6).then(|| q.map(|x| x / length))
        })
        .collect::<Option<_>>()?;
    Some(Elements {
        mode: Mode::Attributes,
        filter: Filter::Quaternion,
        stride: 8,
        count: turns.len(),
        bytes: quaternions(&turns, rotation_bits(step))?,
        component: Component::I16,
        normalized: true,
        is_bounded: false,
        is_compressible: true,
    })
}

/// Bits of the quaternion filter whose rounding turns by at most `step` radians.
///
/// Three components are within half of a unit, 1/sqrt(2) over 2^(bits-1) - 1, and the fourth follows: the
/// quaternion errs by at most sqrt(3)/2 units times sqrt(2), and the turn by twice that, sqrt(3) over
/// 2^(bits-1) - 1.
fn rotation_bits(step: f32) -> u32 {
    let units = 3.0f32.sqrt() / step.max(1e-6);
    let bits = (units + 1.0).log2().ceil() as i32 + 1;
    bits.clamp(4, 16) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_that_would_fall_together_get_a_finer_step() {
        let secs = [0.0, 0.001, 0.0012, 1.0];
        let elements = key_times(&secs, 0.01);
        assert_eq!(elements.filter, Filter::Exponential);
        let mantissas = elements.bytes.as_chunks::<4>().0.iter();
        let all: Vec<i32> = mantissas
            .map(|b| (i32::from_le_bytes(*b) << 8) >> 8)
            .collect();
        assert!(all.is_sorted_by(|a, b| a < b), "{all:?}");
        // Two times that are equal stay so, to the bit.
        assert_eq!(key_times(&[0.0, 0.5, 0.5], 0.01).filter, Filter::None);
    }

    #[test]
    fn finer_steps_take_more_bits() {
        assert_eq!(rotation_bits(1.0), 4);
        assert_eq!(rotation_bits(0.0), 16);
        let bits: Vec<u32> = [0.1, 0.01, 0.001].map(rotation_bits).into();
        assert_eq!(bits, [6, 9, 12]);
    }
}
