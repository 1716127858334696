//! EPF text: parameters for the encoder of a face and body stream, frame by frame.
//!
//! Source: the format of the reference encoder as `docs/formats/mpeg4.md` describes it: words of
//! capital letters, each followed by its numbers; `FBM` opens a frame. Values that a frame omits
//! are those of the previous frame. No known source gives the sizes of the body's parameter groups,
//! so body masks stay a list of numbers.

use crate::words::shortened;
use crate::{Limits, Parsed, ReadError, Warning};
use articula_core::fap_table::GROUPS;

/// Keywords of the masks, face first.
const MASKS: [&str; 2] = ["FMT", "BMT"];
const QUANTISERS: [&str; 2] = ["FQU", "BQU"];
/// Keywords of the maximum and minimum of intra frames, then of predicted ones.
const RANGES: [[&str; 4]; 2] = [["FIX", "FIN", "FPX", "FPN"], ["BIX", "BIN", "BPX", "BPN"]];
const QUANTISER_HIGHEST: i32 = 31;
/// Maximum length of a word.
const LONGEST_WORD: usize = 4;
/// Maximum number of unknown words; a file with more does not have this format.
const MAX_UNKNOWN: u64 = 16;

/// Coding of one group of parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GroupMask {
    /// Type 0: no parameter is coded; the receiver holds.
    AbsentPolicy,
    /// Type 1: those that are set; the receiver holds the others.
    Hold(Vec<bool>),
    /// Type 2: those that are set; the receiver interpolates the others.
    Interpolate(Vec<bool>),
    /// Type 3: all parameters.
    All,
}

/// Masks, quantiser and value ranges for coding the parameters of a face or body.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct EpfCoding {
    /// One mask for each group of the face; empty for a body or if the file has none.
    pub groups: Vec<GroupMask>,
    /// The numbers of a body's masks, uninterpreted.
    pub body_masks: Vec<i32>,
    /// Global quantiser, 0 to 31.
    pub quantiser: Option<i32>,
    /// Maximum and minimum values in intra frames, then in predicted ones.
    pub ranges: [Vec<i32>; 4],
}

/// MPEG-4 encoder parameters of one frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpfFrame {
    /// `FBM`: whether it carries parameters of the face.
    pub carries_face: bool,
    /// `FBM`: whether it carries parameters of the body.
    pub carries_body: bool,
    /// `FFR`: frame number.
    pub number: Option<i32>,
    /// `ISI`: whether it is an intra frame.
    pub intra: Option<bool>,
    /// `FRR`: frames per second, including sixteenths and the factor of 1000/1001.
    pub rate_hz: Option<f32>,
    /// `TC`: time code, uninterpreted.
    pub time_code: Vec<i32>,
    /// `SKN`: number of frames to skip.
    pub skip: Option<i32>,
    /// Coding of the face.
    pub face: EpfCoding,
    /// Coding of the body.
    pub body: EpfCoding,
}

/// Reads an EPF file and returns its frames in order.
///
/// # Errors
/// [`ReadError`] with the line, if the text does not have this format or exceeds the limits.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Parsed<Vec<EpfFrame>>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let mut file = File {
        limits,
        frames: Vec::new(),
        unknown: Vec::new(),
        warnings: Vec::new(),
    };
    let mut open: Option<Statement> = None;
    for (index, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let words = text.split_whitespace();
        for word in words.take_while(|word| !word.starts_with('#')) {
            let next = step(index + 1, word, &mut open)?;
            if let Some(ended) = next.and_then(|next| open.replace(next)) {
                file.apply(&ended)?;
            }
        }
    }
    if let Some(ended) = open {
        file.apply(&ended)?;
    }
    if file.frames.is_empty() {
        let what = "no frame found; each begins with FBM";
        return Err(ReadError::malformed("line 1", what));
    }
    Ok(Parsed {
        value: file.frames,
        warnings: file.warnings,
    })
}

/// The content read so far.
struct File<'a> {
    limits: &'a Limits,
    frames: Vec<EpfFrame>,
    unknown: Vec<String>,
    warnings: Vec<Warning>,
}

impl File<'_> {
    fn apply(&mut self, statement: &Statement) -> Result<(), ReadError> {
        let at = statement.at();
        if statement.word == "FBM" {
            self.frames.push(EpfFrame::default());
            let count = self.frames.len() as u64;
            Limits::check(&at, "frames", count, self.limits.frames)?;
        }
        let word = &statement.word;
        let Some(frame) = self.frames.last_mut() else {
            let what = format!("{word} found before the first FBM, which begins a frame");
            return Err(ReadError::malformed(at, what));
        };
        if !frame.apply(statement)? && !self.unknown.contains(word) {
            let count = self.unknown.len() as u64 + 1;
            Limits::check(&at, "unknown words", count, MAX_UNKNOWN)?;
            let what = format!("unknown word {word}; its numbers are ignored");
            self.warnings.push(Warning::new(at, what));
            self.unknown.push(word.clone());
        }
        Ok(())
    }
}

/// A word and its numbers.
struct Statement {
    line: usize,
    word: String,
    numbers: Vec<i32>,
}

/// Adds a number to the open statement, or returns the new statement that a word begins.
fn step(
    line: usize,
    word: &str,
    open: &mut Option<Statement>,
) -> Result<Option<Statement>, ReadError> {
    let malformed = |what: String| ReadError::malformed(format!("line {line}"), what);
    if let Ok(number) = word.parse::<i32>() {
        let Some(statement) = open else {
            return Err(malformed(format!("{number} found before any word")));
        };
        statement.numbers.push(number);
        return Ok(None);
    }
    if word.len() > LONGEST_WORD || !word.bytes().all(|b| b.is_ascii_alphabetic()) {
        let shown = shortened(word);
        let what = format!("\"{shown}\" found, a word such as FQU or a whole number expected");
        return Err(malformed(what));
    }
    Ok(Some(Statement {
        line,
        word: word.to_ascii_uppercase(),
        numbers: Vec::new(),
    }))
}

impl Statement {
    fn at(&self) -> String {
        format!("line {}", self.line)
    }

    /// Returns its only number, within bounds.
    fn one(&self, lowest: i32, highest: i32) -> Result<i32, ReadError> {
        match self.numbers[..] {
            [number] if (lowest..=highest).contains(&number) => Ok(number),
            _ => Err(self.wrong(&format!("one number of {lowest} to {highest}"))),
        }
    }

    fn wrong(&self, expected: &str) -> ReadError {
        let found: Vec<String> = self.numbers.iter().take(4).map(i32::to_string).collect();
        let more = if self.numbers.len() > 4 { " ..." } else { "" };
        let found = if found.is_empty() {
            "nothing".to_owned()
        } else {
            found.join(" ")
        };
        let what = format!(
            "{found}{more} found after {}, {expected} expected",
            self.word
        );
        ReadError::malformed(self.at(), what)
    }
}

impl EpfFrame {
    /// Applies a statement; returns false if its word is unknown.
    fn apply(&mut self, statement: &Statement) -> Result<bool, ReadError> {
        match statement.word.as_str() {
            "FBM" => {
                let carried = statement.one(0, 3)?;
                (self.carries_face, self.carries_body) = (carried & 1 > 0, carried & 2 > 0);
            }
            "FFR" => self.number = Some(statement.one(0, i32::MAX)?),
            "ISI" => self.intra = Some(statement.one(0, 1)? == 1),
            "FRR" => self.rate_hz = Some(rate_hz(statement)?),
            "TC" => self.time_code.clone_from(&statement.numbers),
            "SKN" => self.skip = Some(statement.one(0, i32::MAX)?),
            _ => {
                let face = self.face.apply(statement, 0)?;
                return Ok(face || self.body.apply(statement, 1)?);
            }
        }
        Ok(true)
    }
}

impl EpfCoding {
    fn apply(&mut self, statement: &Statement, stream: usize) -> Result<bool, ReadError> {
        let word = statement.word.as_str();
        if word == QUANTISERS[stream] {
            self.quantiser = Some(statement.one(0, QUANTISER_HIGHEST)?);
        } else if word == MASKS[0] && stream == 0 {
            self.groups = groups(statement)?;
        } else if word == MASKS[stream] {
            self.body_masks.clone_from(&statement.numbers);
        } else if let Some(which) = RANGES[stream].iter().position(|name| *name == word) {
            self.ranges[which].clone_from(&statement.numbers);
        } else {
            return Ok(false);
        }
        Ok(true)
    }
}

/// Returns frames per second from the integer part, sixteenths, and a flag for 1000/1001.
fn rate_hz(statement: &Statement) -> Result<f32, ReadError> {
    let [rate, sixteenths @ 0..=15, offset @ 0..=1] = statement.numbers[..] else {
        return Err(statement.wrong("a rate, sixteenths from 0 to 15 and a flag"));
    };
    let plain = f64::from(rate) + f64::from(sixteenths) / 16.0;
    let factor = if offset == 1 { 1000.0 / 1001.0 } else { 1.0 };
    Ok((plain * factor) as f32)
}

/// Parses ten mask types, each followed by its bits if it is 1 or 2.
fn groups(statement: &Statement) -> Result<Vec<GroupMask>, ReadError> {
    let wrong = || statement.wrong("ten mask types from 0 to 3, types 1 and 2 with their bits");
    let mut numbers = statement.numbers.iter().copied();
    let mut groups = Vec::new();
    for (_, size) in GROUPS {
        let kind = numbers.next().ok_or_else(wrong)?;
        let mut bits = || -> Result<Vec<bool>, ReadError> {
            let bits: Vec<i32> = numbers.by_ref().take(size).collect();
            let good = bits.len() == size && bits.iter().all(|b| (0..=1).contains(b));
            if good {
                Ok(bits.iter().map(|b| *b == 1).collect())
            } else {
                Err(wrong())
            }
        };
        groups.push(match kind {
            0 => GroupMask::AbsentPolicy,
            1 => GroupMask::Hold(bits()?),
            2 => GroupMask::Interpolate(bits()?),
            3 => GroupMask::All,
            _ => return Err(wrong()),
        });
    }
    if numbers.next().is_some() {
        return Err(wrong());
    }
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Parsed<Vec<EpfFrame>>, ReadError> {
        read(text.as_bytes(), &Limits::default())
    }

    const TWO: &str = "# two frames\nFBM 1\nFFR 0\nISI 1\nFRR 29 15 1\nTC 0 1 2\nSKN 0\n\
        FMT 3 0 1 1 1 1 0 0 0 0 0 0 0 0 1 2 0 0 0 0 0 0 0 1 0 0 0 0 0 0\nFQU 2\nFIX 60 60\n\
        fbm 3 FFR 1 ISI 0 BQU 31 BMT 1 0 1\n";

    #[test]
    fn two_frames_by_hand() {
        let read = parse(TWO).unwrap();
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        let [a, b] = &read.value[..] else {
            panic!("{} frames", read.value.len())
        };
        assert_eq!(
            (a.carries_face, a.carries_body, a.number, a.intra),
            (true, false, Some(0), Some(true))
        );
        // 29 15/16 frames a second, a thousandth less: 29.9375 x 1000 / 1001.
        assert!((a.rate_hz.unwrap() - 29.907_592).abs() < 1e-5);
        assert_eq!(
            (a.time_code.as_slice(), a.skip),
            ([0, 1, 2].as_slice(), Some(0))
        );
        let mut eyes = vec![false; 12];
        (eyes[0], eyes[1], eyes[2], eyes[11]) = (true, true, true, true);
        assert_eq!(
            a.face.groups[..3],
            [
                GroupMask::All,
                GroupMask::AbsentPolicy,
                GroupMask::Hold(eyes)
            ]
        );
        let mut brows = vec![false; 8];
        brows[7] = true;
        assert_eq!(a.face.groups[3], GroupMask::Interpolate(brows));
        assert_eq!(a.face.groups[4..], vec![GroupMask::AbsentPolicy; 6]);
        assert_eq!(
            (a.face.quantiser, a.face.ranges[0].as_slice()),
            (Some(2), [60, 60].as_slice())
        );
        assert_eq!(
            (b.carries_face && b.carries_body, b.intra, b.body.quantiser),
            (true, Some(false), Some(31))
        );
        assert_eq!(b.body.body_masks, [1, 0, 1]);
        assert_eq!(b.face, EpfCoding::default());
    }

    #[test]
    fn faults_name_their_line() {
        let cases = [
            ("", "line 1: no frame found"),
            ("FFR 0", "line 1: FFR found before the first FBM"),
            ("7 FBM 1", "line 1: 7 found before any word"),
            ("FBM 4", "line 1: 4 found after FBM, one number of 0 to 3"),
            ("FBM", "line 1: nothing found after FBM"),
            (
                "FBM 1\nFQU 32",
                "line 2: 32 found after FQU, one number of 0 to 31",
            ),
            ("FBM 1\nFQU 1 2", "line 2: 1 2 found after FQU"),
            ("FBM 1\nFRR 25", "line 2: 25 found after FRR"),
            (
                "FBM 1\nFMT 3 3 3",
                "line 2: 3 3 3 found after FMT, ten mask types",
            ),
            ("FBM 1\nFMT 1 0", "line 2: 1 0 found after FMT"),
            (
                "FBM 1\nFMT 0 0 0 0 0 0 0 0 0 0 0",
                "line 2: 0 0 0 0 ... found after FMT",
            ),
            ("FBM 1\nFQU 1.5", "line 2: \"1.5\" found"),
            ("FBM 1\n99999999999", "line 2: \"99999999999\" found"),
        ];
        for (text, wanted) in cases {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.starts_with(wanted), "{text:?}: {error}");
        }
        let read = parse("FBM 1\nXYZ 1 2\nXYZ 3\n").unwrap();
        assert_eq!(read.warnings.len(), 1);
        assert!(read.warnings[0].what.contains("unknown word XYZ"));
    }
}
