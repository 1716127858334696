//! Fields by their names in the standard, so that errors name byte and field.

use crate::bits::BitReader;
use crate::error::StreamError;

#[derive(Debug, Clone)]
pub(super) struct Fields<'a> {
    pub(super) reader: BitReader<'a>,
}

impl Fields<'_> {
    pub(super) fn place(&self, field: &str) -> String {
        format!("byte {}, {field}", self.reader.at() / 8)
    }

    pub(super) fn bad(&self, field: &str, what: impl Into<String>) -> StreamError {
        StreamError::malformed(self.place(field), what)
    }

    pub(super) fn unsupported(&self, field: &str, what: &str, mend: &str) -> StreamError {
        StreamError::Unsupported {
            at: self.place(field),
            what: what.to_owned(),
            mend: mend.to_owned(),
        }
    }

    pub(super) fn take(&mut self, field: &str, count: u32) -> Result<u64, StreamError> {
        let taken = self.reader.take(count);
        taken.map_err(|_| self.bad(field, "unexpected end"))
    }

    pub(super) fn flag(&mut self, field: &str) -> Result<bool, StreamError> {
        Ok(self.take(field, 1)? == 1)
    }

    /// Reads a bit that is always 1.
    pub(super) fn marker(&mut self, field: &str) -> Result<(), StreamError> {
        if self.flag(field)? {
            return Ok(());
        }
        Err(self.bad(field, "a marker bit of 0, expected 1"))
    }

    /// Returns the start code that is next, after stuffing or none, and the bit after it.
    pub(super) fn start_code(&self) -> Option<(u32, u64)> {
        let code_at = |at: u64| {
            let mut reader = self.reader.clone();
            reader.go_to(at);
            let code = reader.take(32).ok()? as u32;
            (code >> 8 == 1).then_some((code, at + 32))
        };
        let at = self.reader.at();
        if at.is_multiple_of(8)
            && let Some(found) = code_at(at)
        {
            return Some(found);
        }
        let count = 8 - at % 8;
        let stuffing = self.reader.clone().take(count as u32).ok()?;
        (stuffing == (1 << (count - 1)) - 1).then(|| code_at(at + count))?
    }
}
