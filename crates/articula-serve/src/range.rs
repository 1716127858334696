//! Parts of a body: `Range` of RFC 9110, section 14.

use std::ops::Range;

/// What a request asks for of a body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Asked {
    /// All of it: no range, several, or something else, which a server may ignore.
    Whole,
    /// These bytes.
    Part(Range<usize>),
    /// Bytes that it does not have.
    Unsatisfiable,
}

/// Reads the value of the header.
pub(crate) fn asked(header: Option<&str>, length: usize) -> Asked {
    let Some(range) = header.and_then(|text| text.trim().strip_prefix("bytes=")) else {
        return Asked::Whole;
    };
    let Some((first, last)) = range.trim().split_once('-') else {
        return Asked::Whole;
    };
    let number = |text: &str| text.parse::<usize>().ok();
    let is_number = |text: &str| text.chars().all(|c| c.is_ascii_digit());
    if !is_number(first) || !is_number(last) {
        return Asked::Whole;
    }
    let part = match (number(first), number(last)) {
        (Some(first), Some(last)) if first > last => return Asked::Whole,
        (Some(first), Some(last)) => first..last.saturating_add(1).min(length),
        (Some(first), None) if last.is_empty() => first..length,
        (None, Some(count)) if first.is_empty() => length.saturating_sub(count)..length,
        _ => return Asked::Whole,
    };
    match part.start < part.end {
        true => Asked::Part(part),
        false => Asked::Unsatisfiable,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_as_the_standard_says() {
        let of = |text| asked(Some(text), 100);
        assert_eq!(of("bytes=0-9"), Asked::Part(0..10));
        assert_eq!(of("bytes=90-"), Asked::Part(90..100));
        assert_eq!(of("bytes=-30"), Asked::Part(70..100));
        assert_eq!(of("bytes=-300"), Asked::Part(0..100));
        assert_eq!(of("bytes=99-18446744073709551615"), Asked::Part(99..100));
        assert_eq!(of("bytes=100-"), Asked::Unsatisfiable);
        assert_eq!(of("bytes=-0"), Asked::Unsatisfiable);
        for other in [
            "",
            "bytes=",
            "bytes=-",
            "bytes=9-3",
            "bytes=0-1,4-5",
            "lines=1-2",
            "bytes=a-b",
            "bytes=+1-2",
        ] {
            assert_eq!(of(other), Asked::Whole, "{other}");
        }
        assert_eq!(asked(None, 100), Asked::Whole);
        assert_eq!(asked(Some("bytes=0-0"), 0), Asked::Unsatisfiable);
    }
}
