//! Parser of the second half of a BVH file: frame count, frame time and one line of values per
//! frame.

use super::hierarchy::at;
use crate::error::{ReadError, Warning};
use crate::limits::Limits;
use crate::words::{MAX_FRAMES, frame_time, number, value_of};

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
    for (line, text) in lines {
        frame(&mut motion, line, text, channels)?;
        let frames = motion.frames as u64;
        Limits::check(at(line), "frames", frames, limits.frames.min(MAX_FRAMES))?;
        let elements = motion.values.len() as u64;
        Limits::check(at(line), "key values", elements, limits.elements)?;
    }
    let mut warnings = Vec::new();
    if declared.parse::<usize>().ok() != Some(motion.frames) {
        let what = format!(
            "\"Frames: {declared}\", but the file has {} frames; all are read",
            motion.frames
        );
        warnings.push(Warning::new(at(motion_line), what));
    }
    Ok((motion, warnings))
}

fn frame(motion: &mut Motion, line: usize, text: &str, channels: usize) -> Result<(), ReadError> {
    let before = motion.values.len();
    for word in text.split_whitespace() {
        // A line may be as long as the file; at most the values of one frame are kept.
        if motion.values.len() - before < channels {
            motion
                .values
                .push(number(format_args!("line {line}"), word)?);
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
