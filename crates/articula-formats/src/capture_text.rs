//! The text of a line-based capture: its encoding, its line ends and its decimal points.

use crate::error::Warning;
use std::borrow::Cow;

/// Returns the text of a file without a byte order mark, with line ends that
/// [`str::lines`] knows and with decimal points, and says what was replaced. Bytes that are no UTF-8
/// become replacement characters.
pub(crate) fn capture_text(bytes: &[u8], warn: impl FnMut(Warning)) -> Cow<'_, str> {
    match with_line_ends(decoded(bytes)) {
        Cow::Borrowed(text) => with_decimal_points(text, warn),
        Cow::Owned(text) => Cow::Owned(with_decimal_points(&text, warn).into_owned()),
    }
}

fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    String::from_utf8_lossy(bytes)
}

/// Replaces carriage returns that end lines alone, as programs of old Macintosh computers wrote
/// them.
pub(crate) fn with_line_ends(text: Cow<'_, str>) -> Cow<'_, str> {
    let returns = text.bytes().filter(|b| *b == b'\r').count();
    let pairs = text.matches("\r\n").count();
    let feeds = text.bytes().filter(|b| *b == b'\n').count();
    if returns - pairs <= feeds {
        return text;
    }
    Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
}

/// Replaces decimal commas of words such as `0,25`, unless other words have decimal points. Lines of
/// keywords, as `:version 1.10`, are no numbers of the capture.
fn with_decimal_points(text: &str, mut warn: impl FnMut(Warning)) -> Cow<'_, str> {
    let mut first = None;
    let lines = text.lines().enumerate();
    for (index, line) in lines.filter(|(_, line)| !line.starts_with(':')) {
        for word in line.split_whitespace() {
            if is_decimal(word, '.') {
                return Cow::Borrowed(text);
            }
            if first.is_none() && is_decimal(word, ',') {
                first = Some(index + 1);
            }
        }
    }
    let Some(line) = first else {
        return Cow::Borrowed(text);
    };
    let what = "the numbers have decimal commas; they are read as decimal points";
    warn(Warning::new(format!("line {line}"), what));
    let mut pointed = String::with_capacity(text.len());
    for piece in text.split_inclusive(char::is_whitespace) {
        match is_decimal(piece.trim_end(), ',') {
            true => pointed.push_str(&piece.replace(',', ".")),
            false => pointed.push_str(piece),
        }
    }
    Cow::Owned(pointed)
}

/// Whether a word is a number with this sign between its whole part and its fraction.
pub(crate) fn is_decimal(word: &str, sign: char) -> bool {
    let Some((whole, fraction)) = word.split_once(sign) else {
        return false;
    };
    let is_whole = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let whole = whole.strip_prefix(['-', '+']).unwrap_or(whole);
    let (fraction, exponent) = fraction.split_once(['e', 'E']).unwrap_or((fraction, ""));
    let exponent = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
    is_whole(whole) && !fraction.is_empty() && is_whole(fraction) && is_whole(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> (String, usize) {
        let mut said = 0;
        let read = capture_text(text.as_bytes(), |_| said += 1).into_owned();
        (read, said)
    }

    #[test]
    fn commas_become_points_only_where_no_number_has_a_point() {
        let (text, said) = read("a,b 0,25 -1,5e-3\n7 ,5 1,2,3 (4,5)");
        assert_eq!(
            (text.as_str(), said),
            ("a,b 0.25 -1.5e-3\n7 .5 1,2,3 (4,5)", 1)
        );
        let mixed = "0,25 1.5";
        assert_eq!(read(mixed), (mixed.to_owned(), 0));
    }

    proptest! {
        #[test]
        fn every_line_end_gives_the_same_lines(
            lines in prop::collection::vec("[a-z0-9 ]{1,12}", 1..20), at_end: bool,
        ) {
            for line_end in ["\n", "\r\n", "\r"] {
                let mut text = lines.join(line_end);
                if at_end {
                    text.push_str(line_end);
                }
                let (read, said) = read(&text);
                prop_assert_eq!(read.lines().collect::<Vec<_>>(), lines.clone());
                prop_assert_eq!(said, 0);
            }
        }

        #[test]
        fn a_number_is_the_same_with_a_comma_and_a_point(number in -1e6f32..1e6, width in 1..9usize) {
            let point = format!("{number:.width$}");
            let (text, said) = read(&point.replace('.', ","));
            prop_assert_eq!((text, said), (point, 1));
        }
    }
}
