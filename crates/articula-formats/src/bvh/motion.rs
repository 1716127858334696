//! The second half of a BVH file: frame count, frame time and one line of values a frame.

use super::hierarchy::{at, number};
use crate::error::{ReadError, Warning};
use crate::limits::Limits;

/// Seconds a frame that a motion made by people can have.
const FRAME_TIMES_SECS: std::ops::RangeInclusive<f32> = 1e-6..=1e4;

/// Above this many frames neighbouring key times would be one and the same number.
const MAX_FRAMES: u64 = 1 << 22;

/// The values of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Motion {
    pub(super) frame_time_secs: f32,
    pub(super) frames: usize,
    /// `frames` times the channels of all joints.
    pub(super) values: Vec<f32>,
}

/// Reads what follows the line `MOTION` (its number from 1).
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
    let mut header = |keyword: &str| {
        let (line, text) = lines.next().ok_or_else(|| {
            ReadError::malformed("end of file", format!("\"{keyword}:\" expected"))
        })?;
        Ok((line, value_of(line, text, keyword)?.to_owned()))
    };
    let (_, declared) = header("frames")?;
    let (time_line, time) = header("frame time")?;
    let mut motion = Motion {
        frame_time_secs: frame_time(time_line, &time)?,
        ..Motion::default()
    };
    for (line, text) in lines {
        frame(&mut motion, line, text, channels)?;
        let frames = motion.frames as u64;
        Limits::check(&at(line), "frames", frames, limits.frames.min(MAX_FRAMES))?;
        let elements = motion.values.len() as u64;
        Limits::check(&at(line), "key values", elements, limits.elements)?;
    }
    let mut warnings = Vec::new();
    if declared.parse::<usize>().ok() != Some(motion.frames) {
        let what = format!(
            "\"Frames: {declared}\", but {} are there and were read",
            motion.frames
        );
        warnings.push(Warning::new(at(motion_line), what));
    }
    Ok((motion, warnings))
}

fn value_of<'a>(line: usize, text: &'a str, keyword: &str) -> Result<&'a str, ReadError> {
    let mut rest = text;
    for word in keyword.split(' ') {
        let head = rest
            .get(..word.len())
            .filter(|h| h.eq_ignore_ascii_case(word));
        if head.is_none() {
            let what = format!("\"{}\" found, \"{keyword}:\" expected", shortened(text));
            return Err(ReadError::malformed(at(line), what));
        }
        rest = rest[word.len()..].trim_start();
    }
    Ok(rest.trim_start_matches(':').trim())
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

fn frame_time(line: usize, word: &str) -> Result<f32, ReadError> {
    let secs = number(line, word)?;
    if FRAME_TIMES_SECS.contains(&secs) {
        return Ok(secs);
    }
    let what = format!("a frame time of {secs} s; more than 0 and at most 10000 s expected");
    Err(ReadError::malformed(at(line), what))
}

fn frame(motion: &mut Motion, line: usize, text: &str, channels: usize) -> Result<(), ReadError> {
    let before = motion.values.len();
    for word in text.split_whitespace() {
        // A line may be as long as the file; no more is kept than one frame may hold.
        if motion.values.len() - before < channels {
            motion.values.push(number(line, word)?);
        }
    }
    let found = text.split_whitespace().count();
    if found != channels {
        let what = format!("{found} values found, {channels} expected (one for each channel)");
        return Err(ReadError::malformed(at(line), what));
    }
    motion.frames += 1;
    Ok(())
}
