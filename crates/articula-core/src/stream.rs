//! A neutral map of a coded stream: which bits are what, without knowing the codec.
//!
//! Source: ISO/IEC 21000-7 (generic bitstream syntax description), thesis 3.2 and annex B. Codecs
//! write it while they encode, adaptation reads it while it cuts: a gBSD is its XML spelling.

use crate::Mismatch;
use std::ops::Range;

/// What a unit stands for, so that a rule can keep or drop it: in the schemes of this
/// crate `level`, `object`, `mesh`, `region`, with numbers as in the codec.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Marker {
    /// Which scale the number is on.
    pub scheme: &'static str,
    /// The number.
    pub value: u32,
}

/// A number in the stream that a cut must write anew, such as a length or a count.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Field {
    /// What it says.
    pub name: &'static str,
    /// Its bits, from the start of the stream.
    pub bits: Range<u64>,
}

/// A stretch of a coded stream.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Unit {
    /// What it is called in a description.
    pub label: &'static str,
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
    pub fn of_bytes(label: &'static str, bytes: Range<usize>) -> Self {
        Self {
            label,
            bits: bits_of(bytes),
            markers: Vec::new(),
            fields: Vec::new(),
            children: Vec::new(),
        }
    }

    /// The number on one of its scales.
    pub fn marker(&self, scheme: &str) -> Option<u32> {
        let of_scheme = |m: &&Marker| m.scheme == scheme;
        self.markers.iter().find(of_scheme).map(|m| m.value)
    }

    /// Length in whole bytes, rounded up.
    pub fn bytes(&self) -> u64 {
        (self.bits.end - self.bits.start).div_ceil(8)
    }

    /// Checks that parts and fields lie within their unit, and parts after each other.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first unit that does not.
    pub fn check(&self) -> Result<(), Mismatch> {
        let mut at = self.bits.start;
        for child in &self.children {
            if child.bits.start < at || child.bits.end > self.bits.end {
                let what = format!("bits {:?} in {:?} from {at}", child.bits, self.bits);
                return Err(Mismatch::new(child.label, what));
            }
            at = child.bits.end;
            child.check()?;
        }
        let outside = |f: &&Field| f.bits.start < self.bits.start || f.bits.end > self.bits.end;
        match self.fields.iter().find(outside) {
            Some(field) => {
                let what = format!("bits {:?} in {:?}", field.bits, self.bits);
                Err(Mismatch::new(field.name, what))
            }
            None => Ok(()),
        }
    }
}

/// The bits of whole bytes.
pub fn bits_of(bytes: Range<usize>) -> Range<u64> {
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
        let field = |bits| Unit {
            fields: vec![Field {
                name: "length",
                bits,
            }],
            ..Unit::of_bytes("whole", 2..10)
        };
        assert_eq!(field(16..48).check(), Ok(()));
        assert_eq!(field(8..48).check().unwrap_err().at, "length");
    }
}
