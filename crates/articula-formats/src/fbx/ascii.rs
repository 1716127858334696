//! Walk of the text encoding: `Name: value, value { records }`, arrays as `*3 { a: 1,2,3 }` or as bare lists.

use super::records::{Level, MOST_VALUES, Record, Value};
use std::ops::Range;

/// Visits the records; returns the offset at which one breaks the rules.
pub(super) fn walk(
    bytes: &[u8],
    depth: usize,
    visit: &mut dyn FnMut(&Record<'_>),
) -> Option<usize> {
    let mut cursor = Cursor { bytes, at: 0 };
    if bytes.starts_with(b"\xef\xbb\xbf") {
        cursor.at = 3;
    }
    let mut around: Vec<Level> = Vec::new();
    let mut values = Vec::new();
    loop {
        cursor.space();
        let start = cursor.at;
        match cursor.peek() {
            None if around.is_empty() => return None,
            None => return Some(start),
            Some(b'}') => {
                cursor.at += 1;
                if around.pop().is_none() {
                    return Some(start);
                }
                continue;
            }
            Some(_) => {}
        }
        let Some(name) = cursor.name() else {
            return Some(start);
        };
        let level = Level::of(around.last().copied(), &bytes[name.clone()]);
        let Some(opens) = cursor.values(&mut values) else {
            return Some(cursor.at);
        };
        visit(&Record {
            level,
            name,
            values: if level.has_values() { &values } else { &[] },
        });
        if opens {
            if around.len() >= depth {
                return Some(start);
            }
            around.push(level);
        }
    }
}

struct Cursor<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Cursor<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    /// Skips blanks, line ends and comments.
    fn space(&mut self) {
        while let Some(byte) = self.peek() {
            match byte {
                b';' => {
                    while !matches!(self.peek(), None | Some(b'\n')) {
                        self.at += 1;
                    }
                }
                byte if byte.is_ascii_whitespace() => self.at += 1,
                _ => return,
            }
        }
    }

    /// Reads a name and its colon.
    fn name(&mut self) -> Option<Range<usize>> {
        let start = self.at;
        while !matches!(self.peek(), None | Some(b':' | b'\n' | b'{' | b'}')) {
            self.at += 1;
        }
        let name = &self.bytes[start..self.at];
        let length = name.trim_ascii_end().len();
        let is_name = self.peek() == Some(b':') && length > 0;
        self.at += 1;
        is_name.then_some(start..start + length)
    }

    /// Reads the values of a record; returns whether records within it follow.
    fn values(&mut self, values: &mut Vec<Value>) -> Option<bool> {
        values.clear();
        self.first_value();
        loop {
            self.blanks();
            match self.peek() {
                None | Some(b'\n' | b';' | b'}') => break,
                Some(b'{') => {
                    self.at += 1;
                    return Some(true);
                }
                Some(_) => {}
            }
            let is_list = self.peek() == Some(b'*');
            let value = self.value()?;
            if values.len() < MOST_VALUES {
                values.push(value);
            }
            if is_list || !self.comma() {
                self.blanks();
                match self.peek() {
                    None | Some(b'\n' | b';' | b'}' | b'{') => {}
                    Some(_) => return None,
                }
                if is_list {
                    break;
                }
            }
        }
        Some(false)
    }

    /// Goes to the first value, which may stand on the next line or behind a comma; what a colon follows is
    /// the next name.
    fn first_value(&mut self) {
        self.blanks();
        if matches!(self.peek(), Some(b'\n' | b';')) {
            let line = self.at;
            self.space();
            let value = self.at;
            let is_word = |b: u8| b.is_ascii_alphanumeric() || b == b'_';
            while self.peek().is_some_and(is_word) {
                self.at += 1;
            }
            self.space();
            self.at = match self.peek() {
                Some(b':') => line,
                _ => value,
            };
        }
        if self.peek() == Some(b',') {
            self.at += 1;
            self.space();
        }
    }

    /// Skips a comma, before which old files break the line.
    fn comma(&mut self) -> bool {
        let end = self.at;
        self.space();
        if self.peek() == Some(b',') {
            self.at += 1;
            self.space();
            return true;
        }
        self.at = end;
        false
    }

    fn value(&mut self) -> Option<Value> {
        match self.peek()? {
            b'"' => {
                let start = self.at + 1;
                self.find(start, b'"').map(|end| {
                    self.at = end + 1;
                    Value::Text(start..end)
                })
            }
            b'*' => {
                let start = self.at + 1;
                let open = self.find(start, b'{')?;
                let close = self.find(open, b'}')?;
                self.at = close + 1;
                let digits = std::str::from_utf8(&self.bytes[start..open]).ok()?;
                Some(Value::List(digits.trim().parse().ok()?))
            }
            _ => {
                let start = self.at;
                let ends = |b: u8| b",;{}".contains(&b) || b.is_ascii_whitespace();
                while self.peek().is_some_and(|b| !ends(b)) {
                    self.at += 1;
                }
                let token = self.bytes.get(start..self.at).filter(|t| !t.is_empty())?;
                let text = std::str::from_utf8(token).unwrap_or_default();
                Some(match (text.parse(), text.parse()) {
                    (Ok(integer), _) => Value::Integer(integer),
                    (_, Ok(real)) => Value::Real(real),
                    _ => Value::Real(f64::NAN),
                })
            }
        }
    }

    fn find(&self, from: usize, byte: u8) -> Option<usize> {
        let rest = self.bytes.get(from..)?;
        Some(from + rest.iter().position(|b| *b == byte)?)
    }
}
