//! Captures of Live Link Face as CSV: the blend shapes of ARKit, the head and the eyes, row by row.
//!
//! Source: the files that the app Live Link Face for iOS writes (`docs/formats/live-link.md`); there
//! is no published standard. Columns are found by their names, in any case and order.

mod time;

use crate::capture_text::{is_decimal, with_line_ends};
use crate::damage::{Damage, hold};
use crate::words::shortened;
use crate::{Limits, Parsed, ReadError, Warning};
use articula_core::arkit_table::{BLEND_SHAPE_COUNT, BLEND_SHAPES};
use std::borrow::Cow;
use std::fmt::Write as _;
use time::{Time, ascending, times};

/// Names of the angles, in the order of the app's columns.
const ANGLES: [&str; ANGLE_COUNT] = [
    "HeadYaw",
    "HeadPitch",
    "HeadRoll",
    "LeftEyeYaw",
    "LeftEyePitch",
    "LeftEyeRoll",
    "RightEyeYaw",
    "RightEyePitch",
    "RightEyeRoll",
];
/// Number of angles.
pub const ANGLE_COUNT: usize = 9;
/// Greatest size of a weight or an angle.
const LARGEST: f32 = 1e3;

/// One row of a capture.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveLinkFrame {
    /// Time since the first row, in seconds.
    pub secs: f64,
    /// Weight of each blend shape, in the order of [`BLEND_SHAPES`]; 0 for those without column.
    pub shapes: [f32; BLEND_SHAPE_COUNT],
    /// Yaw (towards the right of the subject), pitch (downwards) and roll (towards its left) of the
    /// head, the left and the right eye, in radians; 0 for those without column.
    pub angles: [f32; ANGLE_COUNT],
}

/// A capture.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveLinkClip {
    /// Rate at which its time codes count frames, per second.
    pub rate_hz: f64,
    /// Which blend shapes have a column.
    pub has_shapes: [bool; BLEND_SHAPE_COUNT],
    /// The rows, times ascending.
    pub frames: Vec<LiveLinkFrame>,
}

impl LiveLinkClip {
    /// Leaves out the first row; times then begin with the second one.
    pub fn skip_first_frame(&mut self) {
        if !self.frames.is_empty() {
            self.frames.remove(0);
        }
        let begin = self.frames.first().map_or(0.0, |f| f.secs);
        self.frames.iter_mut().for_each(|f| f.secs -= begin);
    }
}

/// Meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Time,
    Shape(usize),
    Angle(usize),
    Other,
}

/// Reads a capture. Columns that are not known are left out, and so are damaged rows; a value that is
/// no finite number below 1000 is that of the row before; all with a warning.
///
/// # Errors
/// [`ReadError`] with line and column: no header with a time code and a blend shape, half of the rows
/// or more damaged (of another length, without a time, out of order), times of no
/// known unit, text that is not UTF-8, or more rows than the limits allow.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Parsed<LiveLinkClip>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let before = &bytes[..e.valid_up_to()];
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        ReadError::malformed(format!("line {line}"), "the text is not valid UTF-8")
    })?;
    let text = with_line_ends(Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text)));
    let lines = text.lines().enumerate();
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let Some((_, header)) = lines.next() else {
        return Err(ReadError::malformed("line 1", "the file is empty"));
    };
    let mut warnings = Vec::new();
    let separator = separator(header);
    let columns = columns(header, separator, &mut warnings)?;
    let mut rows = Rows::new(&columns, separator);
    let mut elements = 0;
    for (index, line) in lines {
        elements += columns.len() as u64;
        let at = format!("line {}", index + 1);
        Limits::check(&at, "values", elements, limits.elements)?;
        rows.read(line, at);
    }
    Ok(Parsed {
        value: rows.finish(&mut warnings)?,
        warnings,
    })
}

/// The sign between the values: a comma, or that of spreadsheets in whose language the comma is the
/// decimal sign.
fn separator(header: &str) -> char {
    let found = [',', ';', '\t']
        .into_iter()
        .find(|sign| header.contains(*sign));
    found.unwrap_or(',')
}

/// Writes a capture in the columns of the app.
pub fn write(clip: &LiveLinkClip) -> Vec<u8> {
    let mut text = "Timecode,BlendShapeCount".to_owned();
    for shape in &BLEND_SHAPES {
        let (first, rest) = shape.name.split_at(1);
        let _ = write!(text, ",{}{rest}", first.to_ascii_uppercase());
    }
    for angle in ANGLES {
        let _ = write!(text, ",{angle}");
    }
    text.push('\n');
    let rate = clip.rate_hz.max(1.0);
    for frame in &clip.frames {
        // Thousandths of a frame as whole numbers, so that they carry over.
        let all = (frame.secs * rate * 1e3).round() as u64;
        let per_second = (rate.round() as u64) * 1000;
        let (secs, rest) = (all / per_second, all % per_second);
        let _ = write!(
            text,
            "{:02}:{:02}:{:02}:{:02}.{:03},{}",
            secs / 3600,
            secs / 60 % 60,
            secs % 60,
            rest / 1000,
            rest % 1000,
            BLEND_SHAPE_COUNT + ANGLE_COUNT
        );
        for value in frame.shapes.iter().chain(&frame.angles) {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text.into_bytes()
}

/// Meaning of each column of the header.
fn columns(
    header: &str,
    separator: char,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Column>, ReadError> {
    let mut columns = Vec::new();
    let mut unknown = Vec::new();
    for (index, name) in header.split(separator).enumerate() {
        let name = name.trim().trim_matches('"');
        let is = |known: &str| name.eq_ignore_ascii_case(known);
        let shape = BLEND_SHAPES.iter().position(|s| is(s.name));
        let angle = ANGLES.iter().position(|a| is(a));
        let column = match (shape, angle) {
            (Some(shape), _) => Column::Shape(shape),
            (_, Some(angle)) => Column::Angle(angle),
            _ if is("timecode") => Column::Time,
            _ => Column::Other,
        };
        if column != Column::Other && columns.contains(&column) {
            let what = format!(
                "column {}: \"{}\" is given twice",
                index + 1,
                shortened(name)
            );
            return Err(ReadError::malformed("line 1", what));
        }
        if column == Column::Other && !is("blendshapecount") {
            unknown.push(shortened(name));
        }
        columns.push(column);
    }
    let has_shape = columns.iter().any(|c| matches!(c, Column::Shape(_)));
    if !columns.contains(&Column::Time) || !has_shape {
        let what =
            "no header of Live Link Face found, expected Timecode,BlendShapeCount,EyeBlinkLeft,...";
        return Err(ReadError::malformed("line 1", what));
    }
    if !unknown.is_empty() {
        let what = format!(
            "{} columns are not known and left out: {}",
            unknown.len(),
            unknown[..unknown.len().min(8)].join(", ")
        );
        warnings.push(Warning::new("line 1", what));
    }
    Ok(columns)
}

/// The rows of a file.
struct Rows<'a> {
    columns: &'a [Column],
    /// Columns of values, in their order.
    valued: Vec<usize>,
    separator: char,
    /// Time and position of each row that was read, and its values.
    times: Vec<(Time, String)>,
    values: Vec<f32>,
    damage: Damage,
    all: usize,
}

impl<'a> Rows<'a> {
    fn new(columns: &'a [Column], separator: char) -> Self {
        let is_valued = |c: &usize| matches!(columns[*c], Column::Shape(_) | Column::Angle(_));
        Self {
            columns,
            valued: (0..columns.len()).filter(is_valued).collect(),
            separator,
            times: Vec::new(),
            values: Vec::new(),
            damage: Damage::default(),
            all: 0,
        }
    }

    fn read(&mut self, line: &str, at: String) {
        self.all += 1;
        match self.row(line, &at) {
            Ok(time) => self.times.push((time, at)),
            Err(error) => self.damage.row(error),
        }
    }

    fn row(&mut self, line: &str, at: &str) -> Result<Time, ReadError> {
        let words: Vec<Cow<'_, str>> = line
            .split(self.separator)
            .map(|word| self.pointed(word))
            .collect();
        if words.len() != self.columns.len() {
            let what = format!(
                "{} values found, the header has {} columns",
                words.len(),
                self.columns.len()
            );
            return Err(ReadError::malformed(at, what));
        }
        let time = self.time(&words, at)?;
        let place = |i: usize| format!("{at}: column {}", self.valued[i] + 1);
        let valued = self.valued.iter().map(|column| words[*column].as_ref());
        self.damage
            .values(place, LARGEST, valued, &mut self.values)?;
        Ok(time)
    }

    /// A word without quotes, and with a decimal point where the comma is free for decimals.
    fn pointed<'w>(&self, word: &'w str) -> Cow<'w, str> {
        let word = word.trim().trim_matches('"');
        match self.separator != ',' && is_decimal(word, ',') {
            true => Cow::Owned(word.replace(',', ".")),
            false => Cow::Borrowed(word),
        }
    }

    fn time(&self, words: &[Cow<'_, str>], at: &str) -> Result<Time, ReadError> {
        let column = self.columns.iter().position(|c| *c == Column::Time);
        let column = column.unwrap_or(0);
        let first = self.times.first().map(|(time, _)| time);
        let time = Time::of(&words[column]);
        let time = time.filter(|time| first.is_none_or(|first| first.is_like(time)));
        time.ok_or_else(|| {
            let shown = shortened(&words[column]);
            let what = match first {
                None => "expected a time code such as 14:03:27:12.345",
                Some(_) => "expected a time code like that of the rows before",
            };
            let what = format!("column {}: \"{shown}\" found, {what}", column + 1);
            ReadError::malformed(at, what)
        })
    }

    /// Builds the capture, of the rows whose times ascend.
    fn finish(mut self, warnings: &mut Vec<Warning>) -> Result<LiveLinkClip, ReadError> {
        let width = self.valued.len();
        let count = self.values.len();
        if self.damage.has_values() {
            (0..width).for_each(|c| hold(&mut self.values, (c..count).step_by(width)));
        }
        let column: Vec<Time> = self.times.iter().map(|(time, _)| *time).collect();
        let place = || self.times.first().map_or("", |(_, at)| at);
        let found = times(&column).map_err(|what| ReadError::malformed(place(), what))?;
        if let Some(unit) = found.read_as {
            let what = format!("the times are plain numbers; they are read as {unit}");
            warnings.push(Warning::new(place(), what));
        }
        let mut clip = LiveLinkClip {
            rate_hz: found.rate_hz,
            has_shapes: [false; BLEND_SHAPE_COUNT],
            frames: Vec::with_capacity(column.len()),
        };
        for column in self.columns {
            if let Column::Shape(shape) = column {
                clip.has_shapes[*shape] = true;
            }
        }
        let rows = self.values.chunks_exact(width.max(1));
        let kept = ascending(&found.secs);
        let mut begin = None;
        for (((values, secs), kept), (_, at)) in rows.zip(&found.secs).zip(kept).zip(&self.times) {
            if kept {
                let begin = *begin.get_or_insert(*secs);
                clip.frames.push(frame(secs - begin, self.columns, values));
            } else {
                let what = "the time is not between those of the rows around it";
                self.damage.row(ReadError::malformed(at, what));
            }
        }
        let fate = "the row is left out";
        self.damage.told(self.all, fate, |odd| warnings.push(odd))?;
        Ok(clip)
    }
}

/// A frame of the values of a row, which are in the order of their columns.
fn frame(secs: f64, columns: &[Column], values: &[f32]) -> LiveLinkFrame {
    let mut frame = LiveLinkFrame {
        secs,
        shapes: [0.0; BLEND_SHAPE_COUNT],
        angles: [0.0; ANGLE_COUNT],
    };
    let mut values = values.iter();
    for column in columns {
        let slot = match column {
            Column::Shape(shape) => &mut frame.shapes[*shape],
            Column::Angle(angle) => &mut frame.angles[*angle],
            Column::Time | Column::Other => continue,
        };
        *slot = values.next().copied().unwrap_or(0.0);
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parsed(text: &str) -> Result<Parsed<LiveLinkClip>, ReadError> {
        read(text.as_bytes(), &Limits::default())
    }

    #[test]
    fn columns_by_name_in_any_order() {
        let text = "\u{feff}Timecode,BlendShapeCount,jawOpen,EYEBLINKLEFT,HeadYaw,Mood\r\n\
                    00:59:59:58.500,61,0.25,1,-0.5,3\r\n01:00:00:00.5,61,0.5,0,0,4\r\n\r\n";
        let found = parsed(text).unwrap();
        let clip = found.value;
        let shape = |name: &str| BLEND_SHAPES.iter().position(|s| s.name == name).unwrap();
        let (jaw, blink) = (shape("jawOpen"), shape("eyeBlinkLeft"));
        assert_eq!(
            (clip.frames[0].shapes[jaw], clip.frames[0].shapes[blink]),
            (0.25, 1.0)
        );
        assert_eq!(clip.frames[0].angles[0], -0.5);
        assert!(clip.has_shapes[jaw] && !clip.has_shapes[shape("tongueOut")]);
        assert_eq!(clip.rate_hz, 60.0);
        // From frame 58.5 of one second to 0.5 of the next: two frames.
        assert!((clip.frames[1].secs - 2.0 / 60.0).abs() < 1e-9);
        assert_eq!(found.warnings.len(), 1);
        assert!(
            found.warnings[0]
                .what
                .contains("1 columns are not known and left out: Mood")
        );
    }

    #[test]
    fn the_rate_is_that_which_the_frames_count() {
        let text = |most: u32| {
            let codes = [(0, 0), (0, most), (1, 3), (2, 1)];
            let row = |(s, f): (u32, u32)| format!("00:00:{s:02}:{f:02}.0,0\n");
            "Timecode,JawOpen\n".to_owned() + &codes.map(row).concat()
        };
        for (most, rate) in [(23, 24.0), (24, 25.0), (29, 30.0), (59, 60.0)] {
            assert_eq!(parsed(&text(most)).unwrap().value.rate_hz, rate);
        }
        // Plain numbers count at the rate of the app, and a clip past midnight goes on.
        let plain = parsed("Timecode,JawOpen\n100,0\n106,0\n").unwrap().value;
        assert!((plain.frames[1].secs - 0.1).abs() < 1e-9);
        let late = parsed("Timecode,JawOpen\n23:59:59:59.0,0\n00:00:00:00.0,0\n")
            .unwrap()
            .value;
        assert!((late.frames[1].secs - 1.0 / 60.0).abs() < 1e-9);
    }

    #[test]
    fn one_wrong_time_costs_one_row() {
        for wrong in 1..8 {
            for hour in [0, 1, 13, 15, 23] {
                let row = |f: usize| {
                    let hour = if f == wrong { hour } else { 14 };
                    format!("{hour:02}:00:00:{f:02}.0,{f}\n")
                };
                let text = "Timecode,JawOpen\n".to_owned() + &(0..9).map(row).collect::<String>();
                let found = parsed(&text).unwrap();
                let frames = found.value.frames;
                let expected = (0..9).filter(|f| *f != wrong).map(|f| f as f64 / 60.0);
                let off = frames
                    .iter()
                    .zip(expected)
                    .map(|(f, secs)| (f.secs - secs).abs());
                assert!(frames.len() == 8 && off.fold(0.0, f64::max) < 1e-9);
                let at = format!("line {}", wrong + 2);
                assert_eq!(found.warnings[0].at, at, "{hour}:00");
            }
        }
    }

    #[test]
    fn errors_name_line_and_column() {
        let head = "Timecode,JawOpen,HeadYaw\n";
        let cases = [
            ("", "line 1: the file is empty"),
            ("a,b\n1,2\n", "line 1: no header of Live Link Face"),
            (
                "Timecode,JawOpen,jawopen\n",
                "line 1: column 3: \"jawopen\" is given twice",
            ),
            (
                &format!("{head}0,0\n"),
                "line 2: 2 values found, the header has 3 columns",
            ),
            (
                &format!("{head}0,x,NaN\n"),
                "line 2: column 2: \"x\" found, a number up to 1e3 expected",
            ),
            (
                &format!("{head}1:2,0,0\n"),
                "line 2: column 1: \"1:2\" found, expected a time code",
            ),
            (
                &format!("{head}5,0,0\n5,0,0\n"),
                "line 3: the time is not between",
            ),
        ];
        for (text, expected) in cases {
            let error = parsed(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
        let error = read(b"Timecode,JawOpen\n0,\xff\n", &Limits::default()).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("line 2: the text is not valid UTF-8")
        );
    }

    proptest! {
        #[test]
        fn captures_come_back(
            rows in prop::collection::vec((prop::array::uniform32(0.0_f32..1.0), -3.0_f32..3.0), 1..8),
            rate in prop::sample::select(&[24.0, 30.0, 60.0][..]),
        ) {
            let mut clip = LiveLinkClip {
                rate_hz: rate,
                has_shapes: [true; BLEND_SHAPE_COUNT],
                frames: Vec::new(),
            };
            for (index, (shapes, angle)) in rows.iter().enumerate() {
                let mut frame = LiveLinkFrame {
                    secs: index as f64 / rate,
                    shapes: [0.0; BLEND_SHAPE_COUNT],
                    angles: [*angle; ANGLE_COUNT],
                };
                frame.shapes[..32].copy_from_slice(shapes);
                clip.frames.push(frame);
            }
            let back = read(&write(&clip), &Limits::default()).unwrap();
            prop_assert!(back.warnings.is_empty());
            // A clip below two seconds does not tell its rate.
            let scale = back.value.rate_hz / rate;
            for (a, b) in clip.frames.iter().zip(&back.value.frames) {
                prop_assert!((a.secs - scale * b.secs).abs() < 1e-4);
                prop_assert_eq!((&a.shapes, &a.angles), (&b.shapes, &b.angles));
            }
        }
    }
}
