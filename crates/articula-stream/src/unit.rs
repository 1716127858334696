//! Codec-independent map of a coded stream: which bits hold what.
//!
//! Source: ISO/IEC 21000-7 (generic bitstream syntax description, gBSD), thesis 3.2 and annex B.
//! Codecs write it while they encode, adaptation reads it while it cuts; a gBSD is its XML form.
//! Strings are owned or static, so that descriptions from other programs fit too.

use crate::coding::Coding;
use articula_core::Mismatch;
use std::borrow::Cow;
use std::ops::Range;

/// A label of a [`Unit`], such as its level, by which an adaptation rule keeps or drops it.
///
/// The schemes of this crate, with the numbers of the codec: `level` of a mesh (0 is the finest),
/// `object`, `mesh`; `loa` (level of articulation of H-Anim, 0 is the coarsest), `joint`, `tier`
/// (tolerance of a motion, 0 is the finest), `parameter` (of a face), `access_unit` (in order of
/// time); `region` of a mesh, body or face.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Marker {
    /// Scale of the number.
    pub scheme: Cow<'static, str>,
    /// The number on this scale.
    pub value: u32,
}

/// What a [`Field`] counts, by which a cut computes its new value.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Meaning {
    /// The bytes from the end of the field to the end of the unit that has it.
    BytesAfter,
    /// The bytes of another unit, by its number in the map: 0 is the whole stream, a unit comes
    /// before its parts. Such a unit is emptied, not removed, if it is dropped.
    BytesOf(u32),
    /// The number of units with this label in the unit that has the field, at any depth.
    CountOf(Cow<'static, str>),
}

/// A number in the stream that must be rewritten when units are dropped, such as a length or a
/// count.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Field {
    /// Name of the number.
    pub name: Cow<'static, str>,
    /// Its bits, counted from the start of the stream.
    pub bits: Range<u64>,
    /// Its value.
    pub value: u64,
    /// Its encoding.
    pub coding: Coding,
    /// What it counts.
    pub meaning: Meaning,
}

/// A bit range of a coded stream with labels and nested units, as in a gBSD (ISO/IEC 21000-7).
///
/// The [crate page](crate) has an example of a unit and a cut.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Unit {
    /// Name in a description.
    pub label: Cow<'static, str>,
    /// Its bits, counted from the start of the stream.
    pub bits: Range<u64>,
    /// Labels by which rules select it.
    pub markers: Vec<Marker>,
    /// Numbers in it that change when the stream is cut.
    pub fields: Vec<Field>,
    /// Its parts, in rising order and disjoint.
    pub children: Vec<Unit>,
    /// Whether the unit is padding up to the next whole byte: its length in bits, 0 to 7, written in
    /// as many bits. A cut makes it anew.
    pub padding: bool,
}

impl Unit {
    /// Creates a unit of whole bytes without parts.
    pub fn of_bytes(label: impl Into<Cow<'static, str>>, bytes: Range<usize>) -> Self {
        Self {
            label: label.into(),
            bits: bits_of(bytes),
            markers: Vec::new(),
            fields: Vec::new(),
            children: Vec::new(),
            padding: false,
        }
    }

    /// Returns the unit with a further marker.
    #[must_use]
    pub fn marked(mut self, scheme: impl Into<Cow<'static, str>>, value: u32) -> Self {
        let scheme = scheme.into();
        self.markers.push(Marker { scheme, value });
        self
    }

    /// Returns the value of its marker of a scheme.
    pub fn marker(&self, scheme: &str) -> Option<u32> {
        let found = self.markers.iter().find(|marker| marker.scheme == scheme);
        found.map(|marker| marker.value)
    }

    /// Calls `visit` for the unit and all units in it, each before its parts.
    pub fn visit<'a>(&'a self, visit: &mut impl FnMut(&'a Unit)) {
        visit(self);
        self.children.iter().for_each(|child| child.visit(visit));
    }

    /// Returns the length in bytes, rounded up.
    pub fn bytes(&self) -> u64 {
        (self.bits.end - self.bits.start).div_ceil(8)
    }

    /// Checks that parts and fields lie inside their unit, that parts are in order, that each
    /// field's value fits its bits, and that padding has less than 8 bits.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first unit or field that violates this.
    pub fn check(&self) -> Result<(), Mismatch> {
        let mut at = self.bits.start;
        if self.bits.end < at || self.padding && self.bits.end - at > 7 {
            let what = format!("bits {:?} must rise, padding by at most 7", self.bits);
            return Err(Mismatch::new(self.label.as_ref(), what));
        }
        for child in &self.children {
            if child.bits.start < at || child.bits.end > self.bits.end {
                let what = format!(
                    "bits {:?} must lie in {:?} and not begin before {at}",
                    child.bits, self.bits
                );
                return Err(Mismatch::new(child.label.as_ref(), what));
            }
            at = child.bits.end;
            child.check()?;
        }
        for field in &self.fields {
            let wrong = |what: String| Mismatch::new(field.name.as_ref(), what);
            if field.bits.start < self.bits.start || field.bits.end > self.bits.end {
                return Err(wrong(format!(
                    "bits {:?} must lie in {:?}",
                    field.bits, self.bits
                )));
            }
            let stands = field.coding.check(&field.bits, field.value);
            stands.map_err(wrong)?;
        }
        Ok(())
    }

    /// Checks that a stream holds the value of every field of this unit and its parts.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first field with another value or beyond the end.
    pub fn check_values(&self, stream: &[u8]) -> Result<(), Mismatch> {
        for field in &self.fields {
            let found = field.coding.read(stream, &field.bits)?;
            if found != field.value {
                let what = format!("the stream holds {found}, the map {}", field.value);
                return Err(Mismatch::new(field.name.as_ref(), what));
            }
        }
        self.children
            .iter()
            .try_for_each(|c| c.check_values(stream))
    }
}

/// Converts a byte range to a bit range.
pub(crate) fn bits_of(bytes: Range<usize>) -> Range<u64> {
    8 * bytes.start as u64..8 * bytes.end as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_within_and_after_each_other() {
        let parts = |parts: &[(usize, usize)]| Unit {
            children: parts
                .iter()
                .map(|(start, end)| Unit::of_bytes("part", *start..*end))
                .collect(),
            ..Unit::of_bytes("whole", 2..10)
        };
        assert_eq!(parts(&[(2, 4), (4, 4), (6, 10)]).check(), Ok(()));
        assert!(parts(&[(1, 4)]).check().is_err());
        assert!(parts(&[(2, 5), (4, 6)]).check().is_err());
        assert!(parts(&[(2, 11)]).check().is_err());
        assert_eq!(parts(&[]).bytes(), 8);
    }

    #[test]
    fn fields_lie_within_and_hold_their_values() {
        let field = |bits, value, coding| Unit {
            fields: vec![Field {
                name: String::from("length").into(),
                bits,
                value,
                coding,
                meaning: Meaning::BytesAfter,
            }],
            ..Unit::of_bytes("whole", 2..10)
        };
        let whole = field(16..48, 7, Coding::LittleEndian);
        assert_eq!(whole.check(), Ok(()));
        let at = |unit: Unit| unit.check().unwrap_err().at;
        assert_eq!(at(field(8..48, 7, Coding::LittleEndian)), "length");
        assert_eq!(at(field(17..49, 7, Coding::LittleEndian)), "length");
        assert_eq!(at(field(16..19, 8, Coding::BigEndian)), "length");
        let stream = [0, 0, 7, 0, 0, 0, 1, 1, 1, 1];
        assert_eq!(whole.check_values(&stream), Ok(()));
        assert!(whole.check_values(&stream[..5]).is_err());
        let other = field(16..48, 8, Coding::LittleEndian);
        assert_eq!(other.check_values(&stream).unwrap_err().at, "length");
        let inner = Unit {
            children: vec![other],
            ..Unit::of_bytes("outer", 0..10)
        };
        assert_eq!(inner.check_values(&stream).unwrap_err().at, "length");
    }
}
