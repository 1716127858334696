//! A neutral map of a coded stream: which bits are what, without knowing the codec.
//!
//! Source: ISO/IEC 21000-7 (generic bitstream syntax description), thesis 3.2 and annex B. Codecs
//! write it while they encode, adaptation reads it while it cuts: a gBSD is its XML spelling.
//! Words are owned or our own, so that a description that somebody else wrote fits too.

use crate::coding::Coding;
use articula_core::Mismatch;
use std::borrow::Cow;
use std::ops::Range;

/// What a unit stands for, so that a rule can keep or drop it: in the schemes of this
/// crate `level` (0 is the finest), `object`, `mesh`, `region`, with numbers as in the codec.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Marker {
    /// Which scale the number is on.
    pub scheme: Cow<'static, str>,
    /// The number.
    pub value: u32,
}

/// A number in the stream that a cut must write anew, such as a length or a count.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Field {
    /// What it says.
    pub name: Cow<'static, str>,
    /// Its bits, from the start of the stream.
    pub bits: Range<u64>,
    /// What stands there.
    pub value: u64,
    /// How it stands there.
    pub coding: Coding,
}

/// A stretch of a coded stream.
///
/// The example of the crate's page makes one and cuts by it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Unit {
    /// What it is called in a description.
    pub label: Cow<'static, str>,
    /// Its bits, from the start of the stream.
    pub bits: Range<u64>,
    /// What it stands for.
    pub markers: Vec<Marker>,
    /// Numbers in it that change with what is cut.
    pub fields: Vec<Field>,
    /// Its parts, rising and apart.
    pub children: Vec<Unit>,
}

impl Unit {
    /// A unit of whole bytes without parts.
    pub fn of_bytes(label: impl Into<Cow<'static, str>>, bytes: Range<usize>) -> Self {
        Self {
            label: label.into(),
            bits: bits_of(bytes),
            markers: Vec::new(),
            fields: Vec::new(),
            children: Vec::new(),
        }
    }

    /// Length in whole bytes, rounded up.
    pub fn bytes(&self) -> u64 {
        (self.bits.end - self.bits.start).div_ceil(8)
    }

    /// Checks that parts and fields lie within their unit, parts after each other, and that the
    /// value of each field can stand in its bits.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first unit or field that does not.
    pub fn check(&self) -> Result<(), Mismatch> {
        let mut at = self.bits.start;
        for child in &self.children {
            if child.bits.start < at || child.bits.end > self.bits.end {
                let what = format!("bits {:?} in {:?} from {at}", child.bits, self.bits);
                return Err(Mismatch::new(child.label.as_ref(), what));
            }
            at = child.bits.end;
            child.check()?;
        }
        for field in &self.fields {
            let wrong = |what: String| Mismatch::new(field.name.as_ref(), what);
            if field.bits.start < self.bits.start || field.bits.end > self.bits.end {
                return Err(wrong(format!("bits {:?} in {:?}", field.bits, self.bits)));
            }
            let stands = field.coding.check(&field.bits, field.value);
            stands.map_err(wrong)?;
        }
        Ok(())
    }

    /// Checks that a stream holds the value of every field of this unit and its parts.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first field of which it does not, or that lies beyond it.
    pub fn check_values(&self, stream: &[u8]) -> Result<(), Mismatch> {
        for field in &self.fields {
            let found = field.coding.read(stream, &field.bits)?;
            if found != field.value {
                let what = format!("{found}, the map says {}", field.value);
                return Err(Mismatch::new(field.name.as_ref(), what));
            }
        }
        self.children
            .iter()
            .try_for_each(|c| c.check_values(stream))
    }
}

/// The bits of whole bytes.
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
