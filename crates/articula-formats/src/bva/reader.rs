//! Conversion of the text of a BVA file to unconnected joints in world space.

use crate::capture_text::capture_text;
use crate::damage::{Damage, hold};
use crate::error::{Parsed, ReadError};
use crate::limits::Limits;
use crate::motion_file::{MotionFile, ReadOptions};
use crate::notes::Notes;
use crate::units::{self, MAX_NUMBER, UpAxis};
use crate::words::{MAX_FRAMES, frame_time, odd_frame_time, shortened, value_of};
use articula_core::LibmQuat;
use articula_core::source::{Channel, Character, Interpolation, Joint, Property, RawClip};
use articula_core::{Transform, same_hemisphere};
use glam::{Quat, Vec3};
use std::collections::VecDeque;

/// Maximum number of channels of one segment: translation, rotation and scale.
const MAX_CHANNELS: usize = 9;

/// A scale closer to one than this counts as one.
const SCALED: f32 = 1e-4;

/// Accepted length units: names, and metres.
const LENGTHS: [(&str, f32); 12] = [
    ("INCHES", 0.0254),
    ("INCH", 0.0254),
    ("FEET", 0.3048),
    ("CENTIMETERS", 0.01),
    ("CENTIMETRES", 0.01),
    ("CM", 0.01),
    ("MILLIMETERS", 0.001),
    ("MILLIMETRES", 0.001),
    ("MM", 0.001),
    ("METERS", 1.0),
    ("METRES", 1.0),
    ("M", 1.0),
];

/// Reads a BVA file: one joint without parent for each segment, with its transform in the first
/// frame as rest transform.
///
/// # Errors
/// [`ReadError::Malformed`] naming the line, what was found and what was expected;
/// [`ReadError::LimitExceeded`].
pub fn read(
    bytes: &[u8],
    options: &ReadOptions,
    limits: &Limits,
) -> Result<Parsed<MotionFile>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let mut notes = Notes::default();
    let text = capture_text(bytes, |odd| notes.push(odd));
    let given = options.scale_to_metres;
    if given.is_some() {
        units::scale_to_metres(given, || (1.0, None), &mut Vec::new())?;
    }
    let file = parse(&text, given, limits, &mut notes)?;
    let turn = match options.up {
        UpAxis::Z => units::y_from_z(),
        UpAxis::Y | UpAxis::Auto => Quat::IDENTITY,
    };
    Ok(Parsed {
        value: file.character(turn),
        warnings: notes.into_list(),
    })
}

/// Formats a position in the file for error messages.
fn at(line: usize) -> String {
    format!("line {line}")
}

/// Target of one value of a frame; the number is the axis, 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drives {
    Position(usize),
    Rotation(usize),
    Scale(usize),
}

/// One column of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Column {
    drives: Drives,
    /// Metres, radians or ratio per unit; `None` for a scale given as a length.
    unit: Option<f32>,
}

#[derive(Debug, Clone, PartialEq, Default)]
struct Segment {
    name: String,
    frames: Vec<Transform>,
}

#[derive(Debug, Clone, PartialEq, Default)]
struct File {
    segments: Vec<Segment>,
    frame_time_secs: f32,
}

/// A line with its number, counted from 1.
type Line<'a> = (usize, &'a str);

struct Lines<'a> {
    rest: VecDeque<Line<'a>>,
}

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        let lines = text.lines().enumerate();
        let lines = lines.map(|(index, line)| (index + 1, line.trim()));
        Self {
            rest: lines.filter(|(_, line)| !line.is_empty()).collect(),
        }
    }

    fn expect(&mut self, what: &str) -> Result<Line<'a>, ReadError> {
        let line = self.rest.pop_front();
        line.ok_or_else(|| ReadError::malformed("end of file", format!("{what} expected")))
    }

    /// Returns the next line if it is a row: one that starts with a number, or a damaged one alone
    /// among such. More than one are the beginning of something else.
    fn row(&mut self) -> Option<Line<'a>> {
        let is_alone = match self.rest.get(1) {
            Some((_, next)) => starts_with_number(next) || is_segment(next),
            None => true,
        };
        let is_row = |line: &str| starts_with_number(line) || is_alone && !is_segment(line);
        self.rest.front().filter(|(_, line)| is_row(line))?;
        self.rest.pop_front()
    }
}

fn starts_with_number(line: &str) -> bool {
    let first = line.split_whitespace().next().unwrap_or_default();
    first.parse::<f32>().is_ok()
}

fn parse(
    text: &str,
    scale: Option<f32>,
    limits: &Limits,
    notes: &mut Notes,
) -> Result<File, ReadError> {
    let mut lines = Lines::of(text);
    let mut file = File::default();
    let mut values = 0;
    if !lines.rest.front().is_some_and(|(_, line)| is_segment(line)) {
        let what = "no \"Segment:\" found; is this a BVA file?";
        return Err(ReadError::malformed("line 1", what));
    }
    while let Some((line, text)) = lines.rest.pop_front() {
        let count = file.segments.len() as u64 + 1;
        Limits::check(at(line), "segments", count, limits.nodes)?;
        let name = value_of(at(line), text, "segment")?;
        if name.is_empty() {
            notes.add(at(line), "a segment has no name");
        }
        let (count_line, count) = lines.expect("\"Frames:\"")?;
        let declared = value_of(at(count_line), count, "frames")?;
        file.time(&mut lines, notes)?;
        let columns = columns(&mut lines, scale, notes)?;
        let mut rows = Rows {
            columns: &columns,
            values: Vec::new(),
            damage: Damage::default(),
            all: 0,
            gap: 0,
        };
        while let Some((line, text)) = lines.row() {
            values += columns.len() as u64;
            Limits::check(at(line), "key values", values, limits.elements)?;
            rows.read(line, text);
            let most = limits.frames.min(MAX_FRAMES);
            Limits::check(at(line), "frames", rows.all as u64, most)?;
        }
        let frames = rows.frames(notes)?;
        if declared.parse::<usize>().ok() != Some(frames.len()) {
            let (found, declared) = (frames.len(), shortened(declared));
            let what =
                format!("\"Frames: {declared}\", but the file has {found} frames; all are read");
            notes.add(at(count_line), what);
        }
        if let Some((line, text)) = lines.rest.front().filter(|(_, line)| !is_segment(line)) {
            let text = shortened(text);
            let what = format!("\"{text}\" found, a number or \"Segment:\" expected");
            return Err(ReadError::malformed(at(*line), what));
        }
        file.segments.push(Segment {
            name: name.to_owned(),
            frames,
        });
    }
    Ok(file)
}

fn is_segment(line: &str) -> bool {
    line.get(..7)
        .is_some_and(|w| w.eq_ignore_ascii_case("segment"))
}

/// Reads the two lines that declare the columns and their units.
fn columns(
    lines: &mut Lines<'_>,
    scale: Option<f32>,
    notes: &mut Notes,
) -> Result<Vec<Column>, ReadError> {
    let (line, labels) = lines.expect("the labels of the channels")?;
    let drives = labels.split_whitespace().map(|label| driven(line, label));
    let drives: Vec<Drives> = drives.collect::<Result<_, _>>()?;
    if drives.len() > MAX_CHANNELS {
        let what = format!("{} channels, at most {MAX_CHANNELS} expected", drives.len());
        return Err(ReadError::malformed(at(line), what));
    }
    let mut units: Vec<&str> = Vec::new();
    let mut unit_line = line;
    let is_units = |line: &str| !starts_with_number(line) && !is_segment(line);
    if let Some((line, text)) = lines.rest.pop_front_if(|(_, line)| is_units(line)) {
        units = text.split_whitespace().collect();
        unit_line = line;
        if units.len() != drives.len() {
            let what = format!(
                "{} units found, {} expected (one for each channel)",
                units.len(),
                drives.len()
            );
            return Err(ReadError::malformed(at(line), what));
        }
    } else {
        notes.add(
            at(line),
            "the file has no units; inches and degrees are assumed",
        );
    }
    let mut sizes = false;
    let mut columns = Vec::with_capacity(drives.len());
    for (index, drives) in drives.into_iter().enumerate() {
        let word = units.get(index).copied();
        let mut unit = unit(unit_line, drives, word)?;
        match drives {
            Drives::Position(_) => unit = scale.or(unit),
            Drives::Scale(_) => sizes |= unit.is_none(),
            Drives::Rotation(_) => {}
        }
        columns.push(Column { drives, unit });
    }
    if sizes {
        let what = "a scale in a unit of length is the display size of the segment; ignored";
        notes.add(at(unit_line), what);
    }
    Ok(columns)
}

fn driven(line: usize, label: &str) -> Result<Drives, ReadError> {
    let lower = label.to_ascii_lowercase();
    let axis = lower.chars().next().and_then(|c| "xyz".find(c));
    match (axis, lower.get(1..)) {
        (Some(axis), Some("tran")) => Ok(Drives::Position(axis)),
        (Some(axis), Some("rot")) => Ok(Drives::Rotation(axis)),
        (Some(axis), Some("scale")) => Ok(Drives::Scale(axis)),
        _ => {
            let what = format!(
                "channel \"{}\" found; [XYZ]TRAN, [XYZ]ROT or [XYZ]SCALE expected",
                shortened(label)
            );
            Err(ReadError::malformed(at(line), what))
        }
    }
}

/// Returns metres, radians or ratio per unit; `None` for a scale in a unit of length.
fn unit(line: usize, drives: Drives, word: Option<&str>) -> Result<Option<f32>, ReadError> {
    let name = word.map(str::to_ascii_uppercase);
    let length = |name: &str| LENGTHS.iter().find(|(n, _)| *n == name).map(|(_, m)| *m);
    let known = match (drives, name.as_deref()) {
        (Drives::Position(_), name) => length(name.unwrap_or("INCHES")).map(Some),
        (Drives::Rotation(_), None | Some("DEGREES" | "DEG")) => Some(Some(1f32.to_radians())),
        (Drives::Rotation(_), Some("RADIANS" | "RAD")) => Some(Some(1.0)),
        (Drives::Rotation(_), _) => None,
        (Drives::Scale(_), Some("PERCENT")) => Some(Some(0.01)),
        // Anything that is not a length is taken as a ratio, which has many names.
        (Drives::Scale(_), name) => Some(if name.is_some_and(|n| length(n).is_some()) {
            None
        } else {
            Some(1.0)
        }),
    };
    known.ok_or_else(|| {
        let word = shortened(word.unwrap_or_default());
        let wanted = match drives {
            Drives::Position(_) => "INCHES, FEET, CENTIMETERS, MILLIMETERS or METERS",
            _ => "DEGREES or RADIANS",
        };
        ReadError::malformed(
            at(line),
            format!("unit \"{word}\" found, {wanted} expected"),
        )
    })
}

/// Reads the rows of a segment; a damaged one holds the one before, or at the beginning is as the first
/// one, so that the times of the later ones stay those of the other segments.
struct Rows<'a> {
    columns: &'a [Column],
    values: Vec<f32>,
    damage: Damage,
    all: usize,
    /// Number of damaged rows since the last frame.
    gap: usize,
}

impl Rows<'_> {
    fn read(&mut self, line: usize, text: &str) {
        self.all += 1;
        let start = self.values.len();
        let width = self.columns.len();
        let found = text.split_whitespace().count();
        let read = if found == width {
            let words = text.split_whitespace();
            self.damage
                .values(|_| at(line), MAX_NUMBER, words, &mut self.values)
        } else {
            let what = format!("{found} values found, {width} expected (one for each channel)");
            Err(ReadError::malformed(at(line), what))
        };
        if let Err(error) = read {
            self.damage.row(error);
            self.gap += 1;
            return;
        }
        let held = start.saturating_sub(width);
        for _ in 0..std::mem::take(&mut self.gap) {
            self.values.extend_from_within(held..held + width);
        }
        self.values[start..].rotate_left(width);
    }

    fn frames(mut self, notes: &mut Notes) -> Result<Vec<Transform>, ReadError> {
        let (width, count) = (self.columns.len().max(1), self.values.len());
        if self.damage.has_values() {
            (0..width).for_each(|c| hold(&mut self.values, (c..count).step_by(width)));
        }
        let fate =
            "the row before it is held, at the beginning the first one; at the end it is left out";
        self.damage.told(self.all, fate, |odd| notes.push(odd))?;
        let rows = self.values.chunks_exact(width);
        Ok(rows.map(|row| frame(row, self.columns)).collect())
    }
}

/// The transform of a row: translation, then rotations in the order Z X Y, then scale.
fn frame(values: &[f32], columns: &[Column]) -> Transform {
    let mut angles = Vec3::ZERO;
    let mut transform = Transform::IDENTITY;
    for (column, value) in columns.iter().zip(values) {
        match (column.drives, column.unit) {
            (Drives::Position(axis), Some(unit)) => transform.translation[axis] = value * unit,
            (Drives::Rotation(axis), Some(unit)) => angles[axis] = value * unit,
            (Drives::Scale(axis), Some(unit)) => transform.scale[axis] = value * unit,
            _ => {}
        }
    }
    let turns = [
        Quat::libm_rotation_z(angles.z),
        Quat::libm_rotation_x(angles.x),
        Quat::libm_rotation_y(angles.y),
    ];
    transform.rotation = (turns[0] * turns[1] * turns[2]).normalize();
    transform
}

impl File {
    /// Reads the line of the frame time; all segments take that of the first.
    fn time(&mut self, lines: &mut Lines<'_>, notes: &mut Notes) -> Result<(), ReadError> {
        let (line, text) = lines.expect("\"Frame Time:\"")?;
        // The note that came with the files calls it "Frames Time".
        let plural = text.to_ascii_lowercase().starts_with("frames");
        let keyword = if plural { "frames time" } else { "frame time" };
        let secs = frame_time(at(line), value_of(at(line), text, keyword)?)?;
        if self.segments.is_empty() {
            self.frame_time_secs = secs;
            if let Some(what) = odd_frame_time(secs) {
                notes.add(at(line), what);
            }
        } else if secs != self.frame_time_secs {
            let first = self.frame_time_secs;
            let what = format!(
                "the frame time {secs} s differs from the first segment; its {first} s are used"
            );
            notes.add(at(line), what);
        }
        Ok(())
    }

    /// Builds the character; `turn` rotates the file's world, and the axes of its segments, to +Y
    /// up.
    fn character(self, turn: Quat) -> MotionFile {
        let frames = self.segments.iter().map(|s| s.frames.len()).max();
        let last_frame = frames.and_then(|f| f.checked_sub(1));
        let mut character = Character::default();
        let mut channels = Vec::new();
        for (index, segment) in self.segments.iter().enumerate() {
            let placed = |frame: &Transform| Transform {
                translation: turn * frame.translation,
                rotation: (turn * frame.rotation * turn.inverse()).normalize(),
                scale: (turn * frame.scale).abs(),
            };
            let first = segment.frames.first().map_or(Transform::IDENTITY, placed);
            character.skeleton.joints.push(Joint {
                name: segment.name.clone(),
                parent: None,
                rest: first,
                in_skin: true,
            });
            channels.extend(keys(
                index,
                self.frame_time_secs,
                segment.frames.iter().map(placed),
            ));
        }
        character.clips.extend(last_frame.map(|frame| RawClip {
            name: "motion".to_owned(),
            duration_secs: time_secs(frame, self.frame_time_secs),
            channels,
        }));
        MotionFile {
            end_sites: Vec::new(),
            frame_time_secs: last_frame.map_or(0.0, |_| self.frame_time_secs),
            character,
        }
    }
}

fn time_secs(frame: usize, frame_time_secs: f32) -> f32 {
    (frame as f64 * f64::from(frame_time_secs)) as f32
}

/// Returns keys of translation and rotation for each frame, and of scale if there is any.
pub(super) fn keys(
    target: usize,
    frame_time_secs: f32,
    frames: impl Iterator<Item = Transform>,
) -> Vec<Channel> {
    let mut last = Quat::IDENTITY;
    let (mut places, mut turns, mut scales) = (Vec::new(), Vec::new(), Vec::new());
    let mut times_secs = Vec::new();
    let mut scaled = false;
    for (index, frame) in frames.enumerate() {
        last = same_hemisphere(last, frame.rotation);
        times_secs.push(time_secs(index, frame_time_secs));
        places.extend(frame.translation.to_array());
        turns.extend(last.to_array());
        scales.extend(frame.scale.to_array());
        scaled |= frame.scale.distance(Vec3::ONE) > SCALED;
    }
    let keyed = |property, values| Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: times_secs.clone(),
        values,
    };
    let mut channels = Vec::new();
    if !times_secs.is_empty() {
        channels.push(keyed(Property::Translation, places));
        channels.push(keyed(Property::Rotation, turns));
        if scaled {
            channels.push(keyed(Property::Scale, scales));
        }
    }
    channels
}
