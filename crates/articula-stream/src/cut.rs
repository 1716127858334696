//! The cut: removes units from a stream by its map alone, without the codec.
//!
//! Source: ISO/IEC 21000-7 (adaptation of a stream by its generic description), thesis 3.2.

use crate::bits::BitWriter;
use crate::unit::{Field, Meaning, Unit};
use articula_core::Mismatch;
use std::borrow::Cow;
use std::ops::{Range, RangeInclusive};

/// Which units a cut keeps, by their markers.
///
/// A unit is dropped if it has a marker that a condition does not allow; its parts go with it.
/// Units without such a marker stay.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CutRule {
    conditions: Vec<(Cow<'static, str>, Allowed)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Allowed {
    Within(RangeInclusive<u32>),
    Mask(u64),
    Among(Vec<u32>),
}

impl CutRule {
    /// Keeps values up to `most` of a scheme.
    #[must_use]
    pub fn at_most(self, scheme: impl Into<Cow<'static, str>>, most: u32) -> Self {
        self.within(scheme, 0..=most)
    }

    /// Keeps values from `least` of a scheme.
    #[must_use]
    pub fn at_least(self, scheme: impl Into<Cow<'static, str>>, least: u32) -> Self {
        self.within(scheme, least..=u32::MAX)
    }

    /// Keeps values in a range of a scheme.
    #[must_use]
    pub fn within(self, scheme: impl Into<Cow<'static, str>>, values: RangeInclusive<u32>) -> Self {
        self.and(scheme, Allowed::Within(values))
    }

    /// Keeps the values of a scheme whose bit is set; values from 64 on are dropped.
    #[must_use]
    pub fn in_mask(self, scheme: impl Into<Cow<'static, str>>, mask: u64) -> Self {
        self.and(scheme, Allowed::Mask(mask))
    }

    /// Keeps the listed values of a scheme.
    #[must_use]
    pub fn among(self, scheme: impl Into<Cow<'static, str>>, mut values: Vec<u32>) -> Self {
        values.sort_unstable();
        self.and(scheme, Allowed::Among(values))
    }

    fn and(mut self, scheme: impl Into<Cow<'static, str>>, allowed: Allowed) -> Self {
        self.conditions.push((scheme.into(), allowed));
        self
    }

    /// Returns whether a unit stays, seen by itself.
    pub fn keeps(&self, unit: &Unit) -> bool {
        unit.markers.iter().all(|marker| {
            let of_scheme = |c: &&(Cow<'static, str>, Allowed)| c.0 == marker.scheme;
            let mut conditions = self.conditions.iter().filter(of_scheme);
            conditions.all(|(_, allowed)| allowed.has(marker.value))
        })
    }
}

impl Allowed {
    fn has(&self, value: u32) -> bool {
        match self {
            Self::Within(values) => values.contains(&value),
            Self::Mask(mask) => value < 64 && mask >> value & 1 == 1,
            Self::Among(values) => values.binary_search(&value).is_ok(),
        }
    }
}

/// A stream that was cut, with its map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cut {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Map of the bytes.
    pub unit: Unit,
}

/// Removes the units for which `keeps` is false, and their parts, from a stream; sets the numbers
/// that its map names, and renews padding. All other bits stay as they are.
///
/// Time is linear in the stream and its map.
///
/// # Errors
/// A [`Mismatch`] if the map contradicts itself or the stream (see [`Unit::check`]), if it does not
/// begin and end with a whole byte, or if a number that must be rewritten was removed or does not
/// fit its bits.
pub fn cut(stream: &[u8], map: &Unit, keeps: impl Fn(&Unit) -> bool) -> Result<Cut, Mismatch> {
    map.check()?;
    let ends = [map.bits.start, map.bits.end];
    if ends.iter().any(|bit| !bit.is_multiple_of(8)) || ends[1] > 8 * stream.len() as u64 {
        let what = format!(
            "bits {:?} must be whole bytes of the {} of the stream",
            map.bits,
            stream.len()
        );
        return Err(Mismatch::new(map.label.as_ref(), what));
    }
    let mut state = State {
        stream,
        out: BitWriter::default(),
        waiting: 0..0,
        moved: Vec::new(),
        numbers: Vec::new(),
        counted: 0,
        named: named(map),
    };
    let mut unit = state.unit(map, &keeps);
    state.flush();
    let State {
        out,
        moved,
        numbers,
        ..
    } = state;
    let mut bytes = out.bytes;
    let starts = lengths(&unit);
    set_fields(&mut unit, &mut bytes, &moved, &numbers, &starts)?;
    Ok(Cut { bytes, unit })
}

/// The numbers of the units that [`Meaning::BytesOf`] names, rising.
fn named(map: &Unit) -> Vec<u32> {
    let mut named = Vec::new();
    map.visit(&mut |unit| {
        named.extend(unit.fields.iter().filter_map(|field| match field.meaning {
            Meaning::BytesOf(number) => Some(number),
            _ => None,
        }));
    });
    named.sort_unstable();
    named
}

/// The bytes of all units, by number.
fn lengths(unit: &Unit) -> Vec<u64> {
    let mut lengths = Vec::new();
    unit.visit(&mut |unit| lengths.push(unit.bytes()));
    lengths
}

struct State<'a> {
    stream: &'a [u8],
    out: BitWriter,
    /// Bits of the stream that stay and are not yet written: those next to each other at once.
    waiting: Range<u64>,
    /// Bits of the stream that stayed, and where they begin in the output.
    moved: Vec<(Range<u64>, u64)>,
    /// For each unit of the map its new number, unless it was removed.
    numbers: Vec<Option<u32>>,
    /// Number of units of the output.
    counted: u32,
    named: Vec<u32>,
}

impl State<'_> {
    fn copy(&mut self, bits: Range<u64>) {
        if bits.is_empty() {
            return;
        }
        self.moved.push((bits.clone(), self.at()));
        if self.waiting.end != bits.start {
            self.flush();
            self.waiting.start = bits.start;
        }
        self.waiting.end = bits.end;
    }

    fn flush(&mut self) {
        self.out.copy(self.stream, self.waiting.clone());
        self.waiting = 0..0;
    }

    /// Number of bits of the output.
    fn at(&self) -> u64 {
        self.out.bits + (self.waiting.end - self.waiting.start)
    }

    fn number(&mut self) {
        self.numbers.push(Some(self.counted));
        self.counted += 1;
    }

    /// Writes a unit that stays; its fields keep their old places and values.
    fn unit(&mut self, unit: &Unit, keeps: &impl Fn(&Unit) -> bool) -> Unit {
        self.number();
        let start = self.at();
        let mut children = Vec::with_capacity(unit.children.len());
        if unit.padding {
            self.flush();
            self.out.pad();
        } else {
            let mut at = unit.bits.start;
            for child in &unit.children {
                self.copy(at..child.bits.start);
                at = child.bits.end;
                if keeps(child) {
                    children.push(self.unit(child, keeps));
                } else {
                    children.extend(self.dropped(child));
                }
            }
            self.copy(at..unit.bits.end);
        }
        Unit {
            label: unit.label.clone(),
            bits: start..self.at(),
            markers: unit.markers.clone(),
            fields: unit.fields.clone(),
            children,
            padding: unit.padding,
        }
    }

    /// Leaves out a unit; one whose length is told elsewhere stays, empty, and so does one with such a
    /// part.
    fn dropped(&mut self, unit: &Unit) -> Option<Unit> {
        let number = self.numbers.len() as u32;
        let next = number + units_in(unit);
        let first = self.named.partition_point(|named| *named < number);
        if self.named.get(first).is_none_or(|named| *named >= next) {
            self.numbers.resize(next as usize, None);
            return None;
        }
        self.number();
        let children = unit.children.iter();
        Some(Unit {
            label: unit.label.clone(),
            bits: self.at()..self.at(),
            markers: unit.markers.clone(),
            fields: Vec::new(),
            children: children.filter_map(|child| self.dropped(child)).collect(),
            padding: false,
        })
    }
}

/// Number of units in a unit, itself included.
fn units_in(unit: &Unit) -> u32 {
    let mut count = 0;
    unit.visit(&mut |_| count += 1);
    count
}

/// Moves the fields of a unit and its parts to their new places, and writes their new values.
fn set_fields(
    unit: &mut Unit,
    bytes: &mut [u8],
    moved: &[(Range<u64>, u64)],
    numbers: &[Option<u32>],
    lengths: &[u64],
) -> Result<(), Mismatch> {
    let mut fields = std::mem::take(&mut unit.fields);
    for field in &mut fields {
        field.bits = place(field, moved)?;
        field.value = match &mut field.meaning {
            Meaning::BytesAfter => (unit.bits.end - field.bits.end) / 8,
            Meaning::BytesOf(number) => {
                let renewed = numbers.get(*number as usize).copied().flatten();
                *number = renewed.ok_or_else(|| {
                    Mismatch::new(field.name.as_ref(), format!("there is no unit {number}"))
                })?;
                lengths[*number as usize]
            }
            Meaning::CountOf(label) => {
                let mut count = 0;
                unit.visit(&mut |unit| count += u64::from(unit.label == *label));
                count
            }
        };
        let written = field.coding.write(bytes, &field.bits, field.value);
        written.map_err(|e| Mismatch::new(field.name.as_ref(), e.to_string()))?;
    }
    unit.fields = fields;
    let mut parts = unit.children.iter_mut();
    parts.try_for_each(|child| set_fields(child, bytes, moved, numbers, lengths))
}

/// The new bits of a field.
fn place(field: &Field, moved: &[(Range<u64>, u64)]) -> Result<Range<u64>, Mismatch> {
    let after = moved.partition_point(|(bits, _)| bits.start <= field.bits.start);
    let found = after.checked_sub(1).map(|i| &moved[i]);
    match found {
        Some((bits, to)) if field.bits.end <= bits.end => {
            let start = to + (field.bits.start - bits.start);
            Ok(start..start + (field.bits.end - field.bits.start))
        }
        _ => {
            let what = "the number is in a unit that was removed, or across the edge of one";
            Err(Mismatch::new(field.name.as_ref(), what))
        }
    }
}

#[cfg(test)]
mod tests;
