//! Words and numbers of line-based text formats, and positions for error messages.

use crate::error::ReadError;
use crate::units::MAX_NUMBER;
use std::fmt::Display;

/// Accepted range of seconds per frame.
pub(crate) const FRAME_TIMES_SECS: std::ops::RangeInclusive<f32> = 1e-6..=1e4;

/// Maximum number of frames; beyond it, neighbouring key times would be equal in `f32`.
pub(crate) const MAX_FRAMES: u64 = 1 << 22;

/// Maximum number of characters of a line that an error message quotes.
const SHOWN_CHARS: usize = 40;

/// Parses a finite number of plausible size; the error names the position.
pub(crate) fn number(at: impl Display, word: &str) -> Result<f32, ReadError> {
    number_up_to(MAX_NUMBER, word).ok_or_else(|| no_number(at.to_string(), MAX_NUMBER, word))
}

/// Parses a finite number of at most this size.
pub(crate) fn number_up_to(most: f32, word: &str) -> Option<f32> {
    let number = word.parse::<f32>().ok();
    number.filter(|v| v.abs() <= most)
}

/// The error of a word that is no number of at most this size.
pub(crate) fn no_number(at: String, most: f32, word: &str) -> ReadError {
    let word = shortened(word);
    ReadError::malformed(
        at,
        format!("\"{word}\" found, a number up to {most:e} expected"),
    )
}

/// Parses the seconds between frames.
pub(crate) fn frame_time(at: impl Display, word: &str) -> Result<f32, ReadError> {
    let secs = number(&at, word)?;
    if FRAME_TIMES_SECS.contains(&secs) {
        return Ok(secs);
    }
    let what = format!("frame time {secs} s found, more than 0 and at most 10000 s expected");
    Err(ReadError::malformed(at.to_string(), what))
}

/// Rates at which motion is recorded, per second.
const RECORDED_HZ: [f32; 15] = [
    12.0, 15.0, 20.0, 24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 75.0, 90.0, 100.0, 120.0, 200.0, 240.0,
];
/// Greatest distance from one of them, as a fraction.
const NEAR: f32 = 0.01;

/// Returns what is odd about seconds between frames that nobody records, with their likely
/// meaning.
pub(crate) fn odd_frame_time(secs: f32) -> Option<String> {
    if (5e-4..=1.0).contains(&secs) {
        return None;
    }
    let is_recorded = |rate: f32| {
        let near = |known: &f32| (rate - known).abs() <= NEAR * known;
        RECORDED_HZ.iter().any(near)
    };
    let likely = match () {
        () if is_recorded(secs) => format!("; {secs} is likely the rate, frames per second"),
        () if is_recorded(1e3 / secs) => {
            format!(
                "; {secs} is likely in milliseconds, {:.2} frames per second",
                1e3 / secs
            )
        }
        () if is_recorded(1e6 / secs) => {
            format!(
                "; {secs} is likely in microseconds, {:.2} frames per second",
                1e6 / secs
            )
        }
        () => String::new(),
    };
    Some(format!(
        "a frame lasts {secs} s, {} frames per second, as nobody records{likely}",
        secs.recip()
    ))
}

/// Returns the beginning of a text, for an error message.
pub(crate) fn shortened(text: &str) -> String {
    text.chars().take(SHOWN_CHARS).collect()
}

/// Returns the text after a keyword of one or more words and its colon, or an error.
pub(crate) fn value_of<'a>(
    at: impl Display,
    text: &'a str,
    keyword: &str,
) -> Result<&'a str, ReadError> {
    let mut rest = text;
    for word in keyword.split(' ') {
        let head = rest
            .get(..word.len())
            .filter(|h| h.eq_ignore_ascii_case(word));
        if head.is_none() {
            let what = format!("\"{}\" found, \"{keyword}:\" expected", shortened(text));
            return Err(ReadError::malformed(at.to_string(), what));
        }
        rest = rest[word.len()..].trim_start();
    }
    Ok(rest.trim_start_matches(':').trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_of_sensible_size() {
        assert_eq!(number("x", "7.62852e-016").unwrap(), 7.628_52e-16);
        for bad in ["", "NaN", "inf", "1e10", "1,5", "0x1", "1.#QNAN"] {
            assert!(number("line 3", bad).is_err(), "{bad}");
        }
        let why = number("line 3", &"9".repeat(99)).unwrap_err().to_string();
        assert!(why.starts_with("line 3: ") && why.len() < 120, "{why}");
    }

    #[test]
    fn odd_times_are_told_with_their_likely_meaning() {
        for fine in [1.0 / 240.0, 0.033_333, 0.04, 0.5, 1.0, 1e-3] {
            assert_eq!(odd_frame_time(fine), None, "{fine}");
        }
        let cases = [
            (33.333, "likely in milliseconds, 30.00"),
            (8.333, "likely in milliseconds, 120.00"),
            (41_666.7, "likely in microseconds, 24.00"),
            (30.0, "30 is likely the rate"),
            (120.0, "120 is likely the rate"),
            (3.0, "a frame lasts 3 s"),
            (1e-5, "a frame lasts 0.00001 s"),
        ];
        for (secs, expected) in cases {
            let said = odd_frame_time(secs).unwrap();
            assert!(said.contains(expected), "{said}");
        }
        assert!(!odd_frame_time(3.0).unwrap().contains("likely"));
    }

    #[test]
    fn keywords_may_be_spaced_and_spelled_freely() {
        let value = |text| value_of("x", text, "frame time").ok();
        assert_eq!(value("Frame Time: .5"), Some(".5"));
        assert_eq!(value("FRAME  time :.5 "), Some(".5"));
        assert_eq!(value("Frames: 2"), None);
    }
}
