//! Bits in the order in which they are written, the most significant of a byte first: MPEG's
//! `uimsbf`.

#[cfg(feature = "codecs")]
use crate::error::StreamError;
use std::ops::Range;

/// Writes bits to bytes.
#[derive(Debug, Default)]
pub(crate) struct BitWriter {
    pub(crate) bytes: Vec<u8>,
    pub(crate) bits: u64,
}

impl BitWriter {
    /// Writes the low `count` bits (at most 64) of a value.
    pub(crate) fn push(&mut self, count: u32, value: u64) {
        let mut left = count;
        while left > 0 {
            let free = 8 - (self.bits % 8) as u32;
            if free == 8 {
                self.bytes.push(0);
            }
            let taken = left.min(free);
            left -= taken;
            let part = (value >> left) & ((1 << taken) - 1);
            if let Some(last) = self.bytes.last_mut() {
                *last |= (part as u8) << (free - taken);
            }
            self.bits += u64::from(taken);
        }
    }

    /// Writes the number of bits up to the next whole byte in as many bits.
    pub(crate) fn pad(&mut self) {
        let count = (8 - self.bits % 8) as u32 % 8;
        self.push(count, u64::from(count));
    }

    /// Copies bits of a stream: whole bytes of the output at a time.
    pub(crate) fn copy(&mut self, stream: &[u8], bits: Range<u64>) {
        let mut at = bits.start;
        let to_whole = (8 - self.bits % 8) % 8;
        let few = to_whole.min(bits.end.saturating_sub(at));
        self.copy_few(stream, at..at + few);
        at += few;
        let whole = (bits.end.saturating_sub(at) / 8) as usize;
        if whole > 0 {
            let (from, shift) = ((at / 8) as usize, at % 8);
            if shift == 0 {
                self.bytes.extend_from_slice(&stream[from..from + whole]);
            } else {
                let pairs = stream[from..=from + whole].windows(2);
                let byte = |pair: &[u8]| pair[0] << shift | pair[1] >> (8 - shift);
                self.bytes.extend(pairs.map(byte));
            }
            self.bits += 8 * whole as u64;
            at += 8 * whole as u64;
        }
        self.copy_few(stream, at..bits.end);
    }

    /// Copies less than eight bits.
    fn copy_few(&mut self, stream: &[u8], bits: Range<u64>) {
        let mut at = bits.start;
        while at < bits.end {
            let part = (8 - at % 8).min(bits.end - at);
            let byte = stream[(at / 8) as usize] >> (8 - at % 8 - part);
            self.push(part as u32, u64::from(byte));
            at += part;
        }
    }
}

/// Reads bits of a stream from a whole byte on.
#[cfg(feature = "codecs")]
#[derive(Debug, Clone)]
pub(crate) struct BitReader<'a> {
    stream: &'a [u8],
    at: u64,
    end: u64,
}

#[cfg(feature = "codecs")]
impl<'a> BitReader<'a> {
    /// Creates a reader of some bytes of a stream; positions count from the start of the stream.
    pub(crate) fn new(stream: &'a [u8], bytes: Range<usize>) -> Self {
        let end = bytes.end.min(stream.len());
        Self {
            stream,
            at: 8 * bytes.start.min(end) as u64,
            end: 8 * end as u64,
        }
    }

    /// Returns the position of the next bit.
    pub(crate) fn at(&self) -> u64 {
        self.at
    }

    /// Goes on at another bit, at most the end.
    pub(crate) fn go_to(&mut self, at: u64) {
        self.at = at.min(self.end);
    }

    /// Returns the position of the end.
    pub(crate) fn end_at(&self) -> u64 {
        self.end
    }

    /// Returns an error at the next bit.
    pub(crate) fn bad(&self, what: impl Into<String>) -> StreamError {
        StreamError::malformed(format!("bit {}", self.at), what)
    }

    /// Reads `count` bits, at most 64.
    pub(crate) fn take(&mut self, count: u32) -> Result<u64, StreamError> {
        if self.end - self.at < u64::from(count) {
            return Err(self.bad(format!("unexpected end, expected {count} more bits")));
        }
        let (mut value, mut left) = (0, count);
        while left > 0 {
            let there = 8 - (self.at % 8) as u32;
            let taken = left.min(there);
            let byte = self.stream[(self.at / 8) as usize];
            let part = byte >> (there - taken) & (0xff >> (8 - taken));
            value = value << taken | u64::from(part);
            left -= taken;
            self.at += u64::from(taken);
        }
        Ok(value)
    }

    /// Reads one bit.
    pub(crate) fn flag(&mut self) -> Result<bool, StreamError> {
        Ok(self.take(1)? == 1)
    }

    /// Reads bits that have only one valid value.
    pub(crate) fn expect(&mut self, count: u32, value: u64, what: &str) -> Result<(), StreamError> {
        let found = self.take(count)?;
        if found == value {
            return Ok(());
        }
        Err(self.bad(format!("found {found:#x}, expected {what}, {value:#x}")))
    }

    /// Reads bits up to and with the first that is not `bit`, and returns the number of those before
    /// it. After `most` of them, none further is read.
    pub(crate) fn run(&mut self, bit: bool, most: u32) -> Result<u32, StreamError> {
        let mut count = 0;
        while count < most && self.flag()? == bit {
            count += 1;
        }
        Ok(count)
    }

    /// Reads the padding up to the next whole byte and returns its bits.
    pub(crate) fn padding(&mut self) -> Result<Range<u64>, StreamError> {
        let start = self.at;
        let count = (8 - start % 8) as u32 % 8;
        let found = self.take(count)?;
        if found != u64::from(count) {
            return Err(self.bad(format!("padding of {found}, expected {count}")));
        }
        Ok(start..self.at)
    }

    /// Checks that no bits remain.
    pub(crate) fn end(&self) -> Result<(), StreamError> {
        if self.at == self.end {
            return Ok(());
        }
        Err(self.bad(format!("{} unexpected bits at the end", self.end - self.at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        let mut out = BitWriter::default();
        out.push(3, 0b101);
        out.push(0, 9);
        out.push(7, 0b1_1111_1111);
        out.pad();
        // 101 1111111, then 6 in six bits.
        assert_eq!(out.bytes, [0b1011_1111, 0b1100_0110]);
        out.pad();
        assert_eq!(out.bits, 16);
    }

    proptest! {
        #[test]
        fn bits_are_copied_from_any_place_to_any_place(
            stream in prop::collection::vec(any::<u8>(), 6),
            edges in prop::collection::vec(0u64..=48, 8),
        ) {
            let mut edges = edges;
            edges.sort_unstable();
            let mut out = BitWriter::default();
            let mut expected = Vec::new();
            for pair in edges.chunks(2) {
                out.copy(&stream, pair[0]..pair[1]);
                expected.extend((pair[0]..pair[1]).map(|bit| stream[(bit / 8) as usize] >> (7 - bit % 8) & 1));
            }
            prop_assert_eq!(out.bits, expected.len() as u64);
            let found: Vec<u8> = (0..out.bits).map(|bit| out.bytes[(bit / 8) as usize] >> (7 - bit % 8) & 1).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[cfg(feature = "codecs")]
    proptest! {
        #[test]
        fn what_was_written_is_read(parts in prop::collection::vec((0u32..=64, any::<u64>()), 0..40)) {
            let mut out = BitWriter::default();
            for (count, value) in &parts {
                out.push(*count, *value);
            }
            out.pad();
            let mut reader = BitReader::new(&out.bytes, 0..out.bytes.len());
            for (count, value) in &parts {
                let kept = if *count == 0 { 0 } else { value & (u64::MAX >> (64 - count)) };
                prop_assert_eq!(reader.take(*count), Ok(kept));
            }
            reader.padding().unwrap();
            prop_assert_eq!(reader.end(), Ok(()));
            prop_assert!(reader.take(1).is_err());
        }
    }
}
