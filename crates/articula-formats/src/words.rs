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
    let number = word.parse::<f32>().ok();
    number.filter(|v| v.abs() <= MAX_NUMBER).ok_or_else(|| {
        let word = shortened(word);
        let what = format!("\"{word}\" found, a number up to {MAX_NUMBER:e} expected");
        ReadError::malformed(at.to_string(), what)
    })
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
    fn keywords_may_be_spaced_and_spelled_freely() {
        let value = |text| value_of("x", text, "frame time").ok();
        assert_eq!(value("Frame Time: .5"), Some(".5"));
        assert_eq!(value("FRAME  time :.5 "), Some(".5"));
        assert_eq!(value("Frames: 2"), None);
    }
}
