//! The layout that FAP and BAP files share: a header line, then two lines per frame.
//!
//! The first line of a frame is its mask, one 0 or 1 for each parameter; the second is the frame
//! number and the values of the parameters that the mask includes. A line that starts with `#` is a
//! comment; blank lines are ignored.

use crate::words::shortened;
use crate::{Limits, ReadError, Warning};
use std::fmt::Write as _;
use std::iter::Enumerate;
use std::slice::Split;

/// Accepted frame rates.
const RATES_HZ: std::ops::RangeInclusive<f32> = 0.01..=1e4;
/// Maximum number of words per line; the rest is ignored.
const MAX_WORDS: usize = 512;

/// Content of the first line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) version: String,
    pub(super) name: String,
    pub(super) rate_hz: f32,
}

/// One frame as in the file; the buffers are reused for the next.
#[derive(Debug, Default)]
pub(super) struct Frame {
    pub(super) number: u32,
    /// Line number of the values.
    pub(super) line: usize,
    pub(super) mask: Vec<bool>,
    /// The fields of every parameter whose mask bit is set, in order.
    pub(super) fields: Vec<i32>,
}

/// Masks and fields of a format.
pub(super) struct Layout {
    /// Name of the format, such as "FAP".
    pub(super) format: &'static str,
    /// Valid mask lengths; all frames of a file have the same.
    pub(super) widths: &'static [usize],
    /// Returns the number of fields of the parameter at an index.
    pub(super) fields: fn(usize) -> usize,
}

/// Iterator over the frames of a file.
pub(super) struct Reader<'a> {
    lines: Lines<'a>,
    layout: &'a Layout,
    limits: &'a Limits,
    announced: Option<u64>,
    header_line: usize,
    found: u64,
    values: u64,
    last: Option<u32>,
    width: Option<usize>,
    warned: Warned,
    pub(super) warnings: Vec<Warning>,
}

/// Warnings that are reported only once per file.
#[derive(Default)]
struct Warned {
    fraction: bool,
    order: bool,
}

impl<'a> Reader<'a> {
    /// Reads the header.
    pub(super) fn new(
        bytes: &'a [u8],
        layout: &'a Layout,
        limits: &'a Limits,
    ) -> Result<(Self, Header), ReadError> {
        Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
        let mut lines = Lines::new(bytes);
        let Some((line, words)) = lines.next() else {
            let what = "no header found; \"VERSION NAME RATE FRAMES\" is expected";
            return Err(ReadError::malformed("line 1", what));
        };
        let mut warnings = Vec::new();
        let (header, announced) = header(line, &words, layout.format, &mut warnings)?;
        let reader = Self {
            lines,
            layout,
            limits,
            announced,
            header_line: line,
            found: 0,
            values: 0,
            last: None,
            width: None,
            warned: Warned::default(),
            warnings,
        };
        Ok((reader, header))
    }

    /// Reads the next frame into `frame`; false at the end of the file.
    pub(super) fn next(&mut self, frame: &mut Frame) -> Result<bool, ReadError> {
        let Some((mask_line, words)) = self.lines.next() else {
            self.end();
            return Ok(false);
        };
        self.mask(mask_line, &words, &mut frame.mask)?;
        let Some((line, words)) = self.lines.next() else {
            let what = "the file ends between a mask and its values; the last frame is left out";
            self.warnings.push(Warning::new(at(mask_line), what));
            self.end();
            return Ok(false);
        };
        self.found += 1;
        self.values += frame.mask.len() as u64;
        Limits::check(at(line), "frames", self.found, self.limits.frames)?;
        Limits::check(at(line), "values", self.values, self.limits.elements)?;
        frame.line = line;
        self.fields(line, &words, frame)?;
        Ok(true)
    }

    fn mask(&mut self, line: usize, words: &[&str], mask: &mut Vec<bool>) -> Result<(), ReadError> {
        let count = words.len();
        let known = match self.width {
            Some(width) => count == width,
            None => self.layout.widths.contains(&count),
        };
        if !known {
            let expected = match self.width {
                Some(width) => format!("{width} as before"),
                None => either(self.layout.widths),
            };
            let format = self.layout.format;
            let what = format!(
                "{count} words found, expected a {format} mask of {expected} digits 0 or 1"
            );
            return Err(ReadError::malformed(at(line), what));
        }
        self.width = Some(count);
        mask.clear();
        for word in words {
            mask.push(match *word {
                "0" => false,
                "1" => true,
                other => {
                    let what = format!("\"{}\" found in a mask, 0 or 1 expected", shortened(other));
                    return Err(ReadError::malformed(at(line), what));
                }
            });
        }
        Ok(())
    }

    fn fields(&mut self, line: usize, words: &[&str], frame: &mut Frame) -> Result<(), ReadError> {
        let set = frame.mask.iter().enumerate().filter(|(_, set)| **set);
        let expected = 1 + set.map(|(i, _)| (self.layout.fields)(i)).sum::<usize>();
        if words.len() != expected {
            let found = words.len();
            let what = format!(
                "{found} numbers found, the mask expects the frame number and {} values",
                expected - 1
            );
            return Err(ReadError::malformed(at(line), what));
        }
        frame.number = self.number(line, words[0])?;
        frame.fields.clear();
        for word in &words[1..] {
            let value = self.value(line, word)?;
            frame.fields.push(value);
        }
        Ok(())
    }

    /// Parses the frame number, which must ascend; if it does not, the frame gets the next number.
    fn number(&mut self, line: usize, word: &str) -> Result<u32, ReadError> {
        let Ok(number) = word.parse::<u32>() else {
            let what = format!(
                "frame number \"{}\" found, 0 or above expected",
                shortened(word)
            );
            return Err(ReadError::malformed(at(line), what));
        };
        let next = self.last.map_or(0, |last| last.saturating_add(1));
        let number = if number < next {
            if !self.warned.order {
                self.warned.order = true;
                let what = format!(
                    "frame {number} found after frame {}; frames that do not rise are renumbered",
                    next - 1
                );
                self.warnings.push(Warning::new(at(line), what));
            }
            next
        } else {
            number
        };
        Limits::check(
            at(line),
            "frames up to this number",
            number.into(),
            self.limits.frames,
        )?;
        self.last = Some(number);
        Ok(number)
    }

    fn value(&mut self, line: usize, word: &str) -> Result<i32, ReadError> {
        if let Ok(value) = word.parse::<i32>() {
            return Ok(value);
        }
        let number = word
            .parse::<f64>()
            .ok()
            .filter(|v| v.abs() < f64::from(i32::MAX));
        let Some(number) = number else {
            let what = format!("\"{}\" found, a whole number expected", shortened(word));
            return Err(ReadError::malformed(at(line), what));
        };
        if !self.warned.fraction {
            self.warned.fraction = true;
            let what = format!(
                "\"{}\" found, a whole number expected; the values are rounded",
                shortened(word)
            );
            self.warnings.push(Warning::new(at(line), what));
        }
        Ok(number.round() as i32)
    }

    fn end(&mut self) {
        let place = at(self.header_line);
        let found = self.found;
        if let Some(announced) = self.announced.filter(|a| *a != found) {
            let what =
                format!("{announced} frames declared, but the file has {found}; all are read");
            self.warnings.push(Warning::new(place, what));
        }
    }
}

/// Parses version, name, rate and the number of frames; a name may contain blanks.
fn header(
    line: usize,
    words: &[&str],
    format: &str,
    warnings: &mut Vec<Warning>,
) -> Result<(Header, Option<u64>), ReadError> {
    let [version, name @ .., rate, frames] = words else {
        let what = format!(
            "{} words found; the header of a {format} file is \"VERSION NAME RATE FRAMES\"",
            words.len()
        );
        return Err(ReadError::malformed(at(line), what));
    };
    let rate_hz = rate.parse::<f32>().ok();
    let Some(rate_hz) = rate_hz.filter(|r| RATES_HZ.contains(r)) else {
        let what = format!(
            "frame rate \"{}\" found, 0.01 to 10000 expected",
            shortened(rate)
        );
        return Err(ReadError::malformed(at(line), what));
    };
    let announced = frames.parse::<u64>().ok();
    if announced.is_none() {
        let what = format!(
            "number of frames \"{}\" found; the frames in the file are counted instead",
            shortened(frames)
        );
        warnings.push(Warning::new(at(line), what));
    }
    let header = Header {
        version: (*version).to_owned(),
        name: name.join(" "),
        rate_hz,
    };
    Ok((header, announced))
}

/// Warns if the version is none of those known.
pub(super) fn check_version(header: &Header, known: &[&str], warnings: &mut Vec<Warning>) {
    if !known.contains(&header.version.as_str()) {
        let what = format!(
            "version \"{}\" is read as {}",
            shortened(&header.version),
            known.join(" and ")
        );
        warnings.push(Warning::new("header", what));
    }
}

/// Writes the header, with the name as a single word.
pub(super) fn write_header(
    text: &mut String,
    version: &str,
    name: &str,
    rate_hz: f32,
    frames: usize,
) {
    let odd = |c: char| c.is_whitespace() || c.is_control();
    let name = match name.trim() {
        "" => "clip".to_owned(),
        name => name.replace(odd, "_"),
    };
    let _ = writeln!(text, "{version} {name} {rate_hz} {frames}");
}

/// Writes one frame.
pub(super) fn write_frame(
    text: &mut String,
    mask: &str,
    number: u32,
    fields: impl IntoIterator<Item = i32>,
) {
    let _ = write!(text, "{mask}\n{number}");
    for field in fields {
        let _ = write!(text, " {field}");
    }
    text.push('\n');
}

/// Returns the text line of a mask.
pub(super) fn mask_line(mask: &[bool]) -> String {
    let words: Vec<&str> = mask
        .iter()
        .map(|set| if *set { "1" } else { "0" })
        .collect();
    words.join(" ")
}

/// Whether a byte ends a line.
type Ends = fn(&u8) -> bool;

/// Non-empty lines as words, with their numbers from 1.
struct Lines<'a> {
    lines: Enumerate<Split<'a, u8, Ends>>,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        // Some editors put a byte order mark before text.
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let ends: Ends = |b| *b == b'\n';
        Self {
            lines: bytes.split(ends).enumerate(),
        }
    }

    fn next(&mut self) -> Option<(usize, Vec<&'a str>)> {
        for (index, line) in &mut self.lines {
            // Bytes that are not UTF-8 (a path in an old encoding) separate words like blanks do.
            let chunks = line.utf8_chunks().map(|chunk| chunk.valid());
            let words = chunks.flat_map(str::split_whitespace).take(MAX_WORDS);
            let words: Vec<&str> = words.collect();
            if words.first().is_some_and(|word| !word.starts_with('#')) {
                return Some((index + 1, words));
            }
        }
        None
    }
}

fn at(line: usize) -> String {
    format!("line {line}")
}

fn either(widths: &[usize]) -> String {
    let words: Vec<String> = widths.iter().map(usize::to_string).collect();
    words.join(" or ")
}
