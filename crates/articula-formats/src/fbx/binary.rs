//! Walk of the binary encoding.
//!
//! A record is its end as an absolute offset, the number and the bytes of its values, the length of its name,
//! its name, its values and the records within it, which an empty header ends. From version 7.5 on the first
//! three are 64 bits wide.

use super::records::{Level, MOST_VALUES, Record, Value, version};
use std::ops::Range;

/// First version with wide headers.
const WIDE: u32 = 7500;

/// Visits the records; returns the offset at which one breaks the rules.
pub(super) fn walk(
    bytes: &[u8],
    depth: usize,
    visit: &mut dyn FnMut(&Record<'_>),
) -> Option<usize> {
    let mut cursor = Cursor {
        bytes,
        at: 27,
        is_big: bytes.get(22) == Some(&1),
        width: match version(bytes) {
            Some(v) if v < WIDE => 4,
            _ => 8,
        },
    };
    // Ends and levels of the records around.
    let mut around: Vec<(usize, Level)> = Vec::new();
    let mut values = Vec::new();
    loop {
        let start = cursor.at;
        let level = around.last().map(|(_, level)| *level);
        match cursor.record(level, &mut values) {
            Some(Step::Record(header)) => {
                let room = around.last().map_or(bytes.len(), |(end, _)| *end);
                if header.end > room || header.end < cursor.at {
                    return Some(start);
                }
                visit(&Record {
                    level: header.level,
                    name: header.name,
                    values: &values,
                });
                if cursor.at < header.end {
                    if around.len() >= depth {
                        return Some(start);
                    }
                    around.push((header.end, header.level));
                }
            }
            Some(Step::End) => match around.pop() {
                None => return None,
                Some((end, _)) if end == cursor.at => {}
                Some(_) => return Some(start),
            },
            None => return Some(start),
        }
    }
}

enum Step {
    Record(Header),
    /// The header without content behind the last record of a block.
    End,
}

struct Header {
    end: usize,
    level: Level,
    name: Range<usize>,
}

struct Cursor<'b> {
    bytes: &'b [u8],
    at: usize,
    is_big: bool,
    /// Bytes of a number in a header.
    width: usize,
}

impl Cursor<'_> {
    /// Reads the header and the values of a record.
    fn record(&mut self, around: Option<Level>, values: &mut Vec<Value>) -> Option<Step> {
        let end = self.size(self.width)?;
        let count = self.size(self.width)?;
        let length = self.size(self.width)?;
        let name = self.size(1)?;
        if end == 0 {
            return (count == 0 && length == 0 && name == 0).then_some(Step::End);
        }
        let name = self.take(name)?;
        let level = Level::of(around, &self.bytes[name.clone()]);
        let behind = self.at.checked_add(length)?;
        values.clear();
        if level.has_values() {
            for _ in 0..count.min(MOST_VALUES) {
                let value = self.value()?;
                values.push(value);
            }
        }
        if self.at > behind || behind > self.bytes.len() {
            return None;
        }
        self.at = behind;
        Some(Step::Record(Header { end, level, name }))
    }

    fn value(&mut self) -> Option<Value> {
        let tag = self.at;
        let kind = self.bytes[self.take(1)?.start];
        Some(match kind {
            b'B' | b'C' => Value::Integer(self.unsigned(1)? as i64),
            b'Y' => Value::Integer(i64::from(self.unsigned(2)? as i16)),
            b'I' => Value::Integer(i64::from(self.unsigned(4)? as i32)),
            b'L' => Value::Integer(self.unsigned(8)? as i64),
            b'F' => Value::Real(f64::from(f32::from_bits(self.unsigned(4)? as u32))),
            b'D' => Value::Real(f64::from_bits(self.unsigned(8)?)),
            b'S' | b'R' => {
                let length = self.size(4)?;
                let bytes = self.take(length)?;
                match kind {
                    b'S' => Value::Text(bytes),
                    _ => Value::Raw { tag, bytes },
                }
            }
            b'f' | b'd' | b'l' | b'i' | b'b' | b'c' => {
                let count = self.unsigned(4)?;
                self.take(4)?;
                let stored = self.size(4)?;
                self.take(stored)?;
                Value::List(count)
            }
            _ => return None,
        })
    }

    fn size(&mut self, width: usize) -> Option<usize> {
        usize::try_from(self.unsigned(width)?).ok()
    }

    fn unsigned(&mut self, width: usize) -> Option<u64> {
        let range = self.take(width)?;
        let digits = self.bytes[range].iter().map(|b| u64::from(*b));
        let joined = |value: u64, digit: u64| value << 8 | digit;
        Some(match self.is_big {
            true => digits.fold(0, joined),
            false => digits.rev().fold(0, joined),
        })
    }

    fn take(&mut self, length: usize) -> Option<Range<usize>> {
        let end = self.at.checked_add(length)?;
        let range = self.at..end;
        self.bytes.get(range.clone())?;
        self.at = end;
        Some(range)
    }
}
