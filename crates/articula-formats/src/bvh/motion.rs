//! Parser of the second half of a BVH file: frame count, frame time and one line of values per
//! frame.

use super::hierarchy::at;
use crate::damage::{Damage, hold};
use crate::error::{ReadError, Warning};
use crate::limits::Limits;
use crate::units::MAX_NUMBER;
use crate::words::{self, MAX_FRAMES, frame_time, value_of};

/// The values of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Motion {
    pub(super) frame_time_secs: f32,
    pub(super) frames: usize,
    /// `frames` times the number of channels of all joints.
    pub(super) values: Vec<f32>,
}

/// Parses the text after the line `MOTION` (its number counted from 1).
pub(super) fn parse(
    text: &str,
    motion_line: usize,
    channels: usize,
    limits: &Limits,
) -> Result<(Motion, Vec<Warning>), ReadError> {
    let lines = text.lines().enumerate().skip(motion_line);
    let mut lines = lines
        .map(|(index, line)| (index + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty());
    let mut header = |keyword: &str| -> Result<(usize, String), ReadError> {
        let (line, text) = lines.next().ok_or_else(|| {
            ReadError::malformed("end of file", format!("\"{keyword}:\" expected"))
        })?;
        Ok((line, value_of(at(line), text, keyword)?.to_owned()))
    };
    let (_, declared) = header("frames")?;
    let (time_line, time) = header("frame time")?;
    let mut motion = Motion {
        frame_time_secs: frame_time(at(time_line), &time)?,
        ..Motion::default()
    };
    let mut rows = Rows {
        channels,
        limits,
        damage: Damage::default(),
        all: 0,
        gap: 0,
    };
    for (line, text) in lines {
        rows.read(&mut motion, line, text)?;
    }
    let mut warnings = Vec::new();
    rows.finish(&mut motion, &mut warnings)?;
    warnings.extend(odd_frame_time(at(time_line), &motion));
    if declared.parse::<usize>().ok() != Some(motion.frames) {
        let what = format!(
            "\"Frames: {declared}\", but the file has {} frames; all are read",
            motion.frames
        );
        warnings.push(Warning::new(at(motion_line), what));
    }
    Ok((motion, warnings))
}

fn odd_frame_time(at: String, motion: &Motion) -> Option<Warning> {
    let what = words::odd_frame_time(motion.frame_time_secs).filter(|_| motion.frames > 1)?;
    Some(Warning::new(at, what))
}

/// Reader of the rows.
struct Rows<'a> {
    channels: usize,
    limits: &'a Limits,
    damage: Damage,
    /// Number of rows so far, damaged or not.
    all: usize,
    /// Number of damaged rows after the last frame.
    gap: usize,
}

impl Rows<'_> {
    /// Reads a row. Damaged rows before it hold the frame before, so that the times of all later
    /// frames stay.
    fn read(&mut self, motion: &mut Motion, line: usize, text: &str) -> Result<(), ReadError> {
        self.all += 1;
        let start = motion.values.len();
        if let Err(error) = self.values(motion, line, text) {
            self.damage.row(error);
            self.gap += usize::from(motion.frames > 0);
            return Ok(());
        }
        motion.frames += self.gap + 1;
        let frames = motion.frames as u64;
        let most = self.limits.frames.min(MAX_FRAMES);
        Limits::check(at(line), "frames", frames, most)?;
        let elements = frames.saturating_mul(self.channels as u64);
        Limits::check(at(line), "key values", elements, self.limits.elements)?;
        for _ in 0..self.gap {
            let held = start - self.channels..start;
            motion.values.extend_from_within(held);
        }
        motion.values[start..].rotate_left(self.channels);
        self.gap = 0;
        Ok(())
    }

    fn values(&mut self, motion: &mut Motion, line: usize, text: &str) -> Result<(), ReadError> {
        let found = text.split_whitespace().count();
        if found != self.channels {
            let channels = self.channels;
            let what = format!("{found} values found, {channels} expected (one for each channel)");
            return Err(ReadError::malformed(at(line), what));
        }
        let words = text.split_whitespace();
        self.damage
            .values(|_| at(line), MAX_NUMBER, words, &mut motion.values)
    }

    fn finish(self, motion: &mut Motion, warnings: &mut Vec<Warning>) -> Result<(), ReadError> {
        if self.damage.has_values() {
            let count = motion.values.len();
            for channel in 0..self.channels {
                hold(&mut motion.values, (channel..count).step_by(self.channels));
            }
        }
        let fate = "the row before it is held; at the beginning and at the end it is left out";
        self.damage.told(self.all, fate, |odd| warnings.push(odd))
    }
}
