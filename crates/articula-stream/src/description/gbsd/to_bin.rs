//! gBSDtoBin: from a description and the original stream to the stream that it describes.
//!
//! It knows no codec. Source: ISO/IEC 21000-7, 9 (generation of a bitstream by its gBSD).

use super::names::ACCESS_UNIT;
use super::parse::Parsed;
use crate::bits::BitWriter;
use crate::error::StreamError;
use crate::limits::DescriptionLimits;
use std::ops::Range;

/// What becomes of bits in a unit with parts that no part has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Holes {
    /// They are left out, as the standard says: units that were removed leave holes.
    #[default]
    Skip,
    /// They are copied.
    Copy,
    /// They are an error, for descriptions of whole streams.
    Refuse,
}

/// Writes the stream that a description describes: units without parts are copied from the original
/// stream, parameters are written by their values, of units with parts only the parts are written.
/// Bytes that the description carries itself are written instead of those of the stream.
///
/// The output is never longer than the original and the values together: ranges rise.
///
/// # Errors
/// A [`StreamError`] that names line and unit, for XML that cannot be read, a range beyond the
/// stream or before the range ahead of it, a hole if they are refused, and an access unit or an
/// output that ends within a byte.
pub fn gbsd_to_bin(
    description: &[u8],
    stream: &[u8],
    holes: Holes,
    limits: &DescriptionLimits,
) -> Result<Vec<u8>, StreamError> {
    let parsed = Parsed::read(description, limits)?;
    to_bin(&parsed, stream, holes)
}

pub(super) fn to_bin(
    parsed: &Parsed<'_>,
    stream: &[u8],
    holes: Holes,
) -> Result<Vec<u8>, StreamError> {
    let mut state = State {
        parsed,
        stream,
        holes,
        out: BitWriter::default(),
        copied: 0,
    };
    state.items(None)?;
    state.whole("the description")?;
    Ok(state.out.bytes)
}

struct State<'a> {
    parsed: &'a Parsed<'a>,
    stream: &'a [u8],
    holes: Holes,
    out: BitWriter,
    /// End of the last range that was copied.
    copied: u64,
}

impl State<'_> {
    fn items(&mut self, of: Option<usize>) -> Result<(), StreamError> {
        let parsed = self.parsed;
        let mut at = of.map(|item| parsed.items[item].bits.start);
        let mut last = None;
        for item in parsed.inside(of) {
            let bits = parsed.items[item].bits.clone();
            self.hole(item, at.unwrap_or(bits.start)..bits.start)?;
            at = Some(bits.end);
            last = Some(item);
            self.item(item)?;
        }
        if let (Some(of), Some(at), Some(last)) = (of, at, last) {
            self.hole(last, at..parsed.items[of].bits.end)?;
        }
        Ok(())
    }

    fn hole(&mut self, item: usize, bits: Range<u64>) -> Result<(), StreamError> {
        match self.holes {
            _ if bits.is_empty() => Ok(()),
            Holes::Skip => Ok(()),
            Holes::Copy => self.copy(item, bits),
            Holes::Refuse => {
                let what = format!("beside it, no unit has the bits {bits:?}");
                Err(self.parsed.bad(item, what))
            }
        }
    }

    fn item(&mut self, item: usize) -> Result<(), StreamError> {
        let here = &self.parsed.items[item];
        if let Some(parameter) = &here.parameter {
            self.out.push(parameter.width, parameter.value);
        } else if let Some(bytes) = &here.carried {
            self.out.copy(bytes, 0..here.bits.end - here.bits.start);
        } else if here.end > item + 1 {
            self.items(Some(item))?;
        } else {
            self.copy(item, here.bits.clone())?;
        }
        let marker = self.parsed.document.value(here.element, "marker");
        let is_access_unit = marker.is_some_and(|marker| {
            let mut tokens = marker.split_ascii_whitespace();
            tokens.any(|token| token.eq_ignore_ascii_case(ACCESS_UNIT))
        });
        if is_access_unit && !self.out.bits.is_multiple_of(8) {
            let what = format!(
                "the access unit ends at bit {} of the output",
                self.out.bits
            );
            let mend = "expected a whole byte; renew its padding";
            return Err(self.parsed.bad(item, format!("{what}, {mend}")));
        }
        Ok(())
    }

    fn copy(&mut self, item: usize, bits: Range<u64>) -> Result<(), StreamError> {
        if bits.is_empty() {
            return Ok(());
        }
        let all = 8 * self.stream.len() as u64;
        if bits.end > all {
            let what = format!("bits {bits:?} are beyond the stream of {all} bits");
            return Err(self.parsed.bad(item, what));
        }
        if bits.start < self.copied {
            let what = format!(
                "bits {bits:?} begin before {}, the end of the unit ahead",
                self.copied
            );
            return Err(self.parsed.bad(item, what));
        }
        self.copied = bits.end;
        self.out.copy(self.stream, bits);
        Ok(())
    }

    fn whole(&self, what: &str) -> Result<(), StreamError> {
        if self.out.bits.is_multiple_of(8) {
            return Ok(());
        }
        let end = format!("{what} gives {} bits, expected whole bytes", self.out.bits);
        Err(self.parsed.document.bad(self.parsed.description, end))
    }
}
