//! Files that tell when each phone is spoken.

use crate::phone::{is_pause, phones_of_arpabet, phones_of_ipa};

/// Largest file that is read, and most phones in one.
const MAX_BYTES: usize = 16 << 20;
const MAX_PHONES: usize = 500_000;
/// Longest time, in seconds.
const MAX_SECS: f64 = 36_000.0;
/// Names of the tier of phones in a TextGrid file.
const TIERS: [&str; 6] = ["phones", "phone", "phonemes", "phoneme", "mau", "segments"];

/// A phone and when it is spoken.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedPhone {
    /// Begin in seconds.
    pub start_secs: f32,
    /// End in seconds, after the begin.
    pub end_secs: f32,
    /// Its symbol in the IPA or in ARPAbet; empty for a pause.
    pub symbol: String,
}

/// Error of [`read_phone_times`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PhoneTimesError {
    /// A line is none of a label file.
    #[error("line {0}: expected a begin, an end and a phone, such as `0.10 0.18 AH0`")]
    Line(usize),
    /// A TextGrid file has no tier of intervals or ends early.
    #[error(
        "the TextGrid has no whole tier of intervals; export one with a tier called \"phones\""
    )]
    TextGrid,
    /// Times run backwards or are no times.
    #[error("phone {0}: its end is not after its begin, or before the end of the one before it")]
    Order(usize),
    /// A symbol is not known.
    #[error("phone {0}: \"{1}\" is a symbol neither of the IPA nor of ARPAbet")]
    Symbol(usize, String),
    /// The file names no phone.
    #[error("the file has no phone")]
    Empty,
    /// The file is larger than what is read.
    #[error("the file is larger than 16 MB or has more than 500,000 phones")]
    Large,
}

/// Reads phones with their times: a TextGrid of Praat, as the Montreal Forced Aligner writes it; lines of
/// begin, end and phone in seconds (Audacity) or in 100 ns (HTK); or lines of end, colour and phone below
/// a `#` (ESPS, Festival). Symbols are those of the IPA or of ARPAbet.
///
/// ```
/// let phones = articula_speech::read_phone_times("0.00 0.08 HH\n0.08 0.21 AY1\n".as_bytes())?;
/// assert_eq!(phones[1].symbol, "AY1");
/// # Ok::<(), articula_speech::PhoneTimesError>(())
/// ```
///
/// # Errors
/// A [`PhoneTimesError`].
pub fn read_phone_times(bytes: &[u8]) -> Result<Vec<TimedPhone>, PhoneTimesError> {
    if bytes.len() > MAX_BYTES {
        return Err(PhoneTimesError::Large);
    }
    let text = decoded(bytes);
    let rows = if text.contains("ooTextFile") {
        text_grid(&text).ok_or(PhoneTimesError::TextGrid)?
    } else if text.lines().any(|line| line.trim() == "#") {
        esps(&text)?
    } else {
        labels(&text)?
    };
    checked(rows)
}

/// Begin, end and symbol.
type Row = (f64, f64, String);

/// Text in UTF-8, or in UTF-16 with a mark, as Praat writes it where there are other letters.
fn decoded(bytes: &[u8]) -> String {
    let wide = |from: fn([u8; 2]) -> u16| {
        let (pairs, _) = bytes[2..].as_chunks::<2>();
        let units: Vec<u16> = pairs.iter().map(|pair| from(*pair)).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => String::from_utf8_lossy(bytes)
            .trim_start_matches('\u{feff}')
            .to_owned(),
    }
}

/// Lines of begin, end and label.
fn labels(text: &str) -> Result<Vec<Row>, PhoneTimesError> {
    let mut rows = Vec::new();
    let mut whole = true;
    for (number, line) in filled(text) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let time = |at: usize| words.get(at).and_then(|word| word.parse().ok());
        let (Some(start), Some(end)) = (time(0), time(1)) else {
            return Err(PhoneTimesError::Line(number));
        };
        whole &= words[..2]
            .iter()
            .all(|w| w.bytes().all(|b| b.is_ascii_digit()));
        rows.push((
            start,
            end,
            words.get(2).copied().unwrap_or_default().to_owned(),
        ));
    }
    let last = rows.last().map_or(0.0, |row: &Row| row.1);
    if whole && last > MAX_SECS {
        rows.iter_mut()
            .for_each(|row| (row.0, row.1) = (row.0 * 1e-7, row.1 * 1e-7));
    }
    Ok(rows)
}

/// Lines of end, colour and label, below a line of `#`.
fn esps(text: &str) -> Result<Vec<Row>, PhoneTimesError> {
    let mut rows = Vec::new();
    let mut start = 0.0;
    for (number, line) in filled(text).skip_while(|(_, line)| *line != "#").skip(1) {
        let mut words = line.split_whitespace();
        let end = words.next().and_then(|word| word.parse().ok());
        let end: f64 = end.ok_or(PhoneTimesError::Line(number))?;
        rows.push((start, end, words.nth(1).unwrap_or_default().to_owned()));
        start = end;
    }
    Ok(rows)
}

fn filled(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text
        .lines()
        .enumerate()
        .map(|(at, line)| (at + 1, line.trim()));
    lines.filter(|(_, line)| !line.is_empty())
}

/// A word of a TextGrid: of its text only numbers, quoted texts and flags count.
enum Word {
    Number(f64),
    Text(String),
}

fn words(text: &str) -> Vec<Word> {
    let mut words = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if first == '"' {
            let (word, length) = quoted(rest);
            words.push(Word::Text(word));
            length
        } else {
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            words.extend(rest[..end].parse().ok().map(Word::Number));
            end
        };
        rest = rest[length..].trim_start();
    }
    words
}

/// A text in quotes, in which two quotes are one, and its length with them.
fn quoted(text: &str) -> (String, usize) {
    let mut word = String::new();
    let mut chars = text.char_indices().skip(1).peekable();
    while let Some((at, c)) = chars.next() {
        if c != '"' {
            word.push(c);
        } else if chars.next_if(|(_, next)| *next == '"').is_some() {
            word.push('"');
        } else {
            return (word, at + 1);
        }
    }
    (word, text.len())
}

/// The tier of phones of a TextGrid, or its last one.
fn text_grid(text: &str) -> Option<Vec<Row>> {
    let mut words = words(text).into_iter();
    let mut tiers: Vec<(String, Vec<Row>)> = Vec::new();
    while let Some(word) = words.next() {
        let Word::Text(class) = word else { continue };
        if class != "IntervalTier" {
            continue;
        }
        let Some(Word::Text(name)) = words.next() else {
            return None;
        };
        let mut number = || match words.next() {
            Some(Word::Number(number)) => Some(number),
            _ => None,
        };
        let [_, _, count] = [number()?, number()?, number()?];
        let mut rows = Vec::new();
        for _ in 0..(count.max(0.0) as usize).min(MAX_PHONES) {
            let (Some(Word::Number(start)), Some(Word::Number(end)), Some(Word::Text(label))) =
                (words.next(), words.next(), words.next())
            else {
                return None;
            };
            rows.push((start, end, label.trim().to_owned()));
        }
        tiers.push((name.to_lowercase(), rows));
    }
    let named = tiers.iter().position(|(name, _)| {
        TIERS
            .iter()
            .any(|tier| name == tier || name.ends_with(&format!("- {tier}")))
    });
    let chosen = named.or(tiers.len().checked_sub(1))?;
    Some(tiers.swap_remove(chosen).1)
}

/// Phones whose times follow one another and whose symbols are known.
fn checked(rows: Vec<Row>) -> Result<Vec<TimedPhone>, PhoneTimesError> {
    if rows.len() > MAX_PHONES {
        return Err(PhoneTimesError::Large);
    }
    let mut phones: Vec<TimedPhone> = Vec::with_capacity(rows.len());
    for (index, (start, end, label)) in rows.into_iter().enumerate() {
        let before = phones.last().map_or(0.0, |phone| phone.end_secs);
        let in_time = start.is_finite() && end > start && end <= MAX_SECS;
        if !in_time || (start as f32) < before - 1e-3 {
            return Err(PhoneTimesError::Order(index + 1));
        }
        let symbol = if is_pause(&label) {
            String::new()
        } else {
            label
        };
        let known = phones_of_ipa(&symbol).or_else(|| phones_of_arpabet(&symbol));
        if !symbol.is_empty() && known.is_none() {
            return Err(PhoneTimesError::Symbol(index + 1, symbol));
        }
        phones.push(TimedPhone {
            start_secs: start as f32,
            end_secs: end as f32,
            symbol,
        });
    }
    let speaks = phones.iter().any(|phone| !phone.symbol.is_empty());
    if speaks {
        Ok(phones)
    } else {
        Err(PhoneTimesError::Empty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LONG: &str = r#"File type = "ooTextFile"
Object class = "TextGrid"

xmin = 0
xmax = 0.5
tiers? <exists>
size = 2
item []:
    item [1]:
        class = "IntervalTier"
        name = "words"
        xmin = 0
        xmax = 0.5
        intervals: size = 1
        intervals [1]:
            xmin = 0
            xmax = 0.5
            text = "say ""ah"""
    item [2]:
        class = "IntervalTier"
        name = "phones"
        xmin = 0
        xmax = 0.5
        intervals: size = 2
        intervals [1]:
            xmin = 0
            xmax = 0.2
            text = "S"
        intervals [2]:
            xmin = 0.2
            xmax = 0.5
            text = "EY1"
"#;

    fn phones(text: &str) -> Vec<TimedPhone> {
        read_phone_times(text.as_bytes()).unwrap()
    }

    #[test]
    fn all_forms_tell_the_same() {
        let expected = phones("0 0.2 S\n0.2 0.5 EY1\n");
        assert_eq!(expected[1].start_secs, 0.2);
        assert_eq!(phones(LONG), expected);
        let short = "File type = \"ooTextFile\"\n\"TextGrid\"\n0\n0.5\n<exists>\n1\n\"IntervalTier\"\n\"phones\"\n0\n0.5\n2\n0\n0.2\n\"S\"\n0.2\n0.5\n\"EY1\"\n";
        assert_eq!(phones(short), expected);
        assert_eq!(phones("0 2000000 S\n2000000 5000000 EY1\n"), expected);
        assert_eq!(phones("separator ;\n#\n0.2 26 S\n0.5 26 EY1\n"), expected);
        let wide: Vec<u8> = std::iter::once(0xfeff)
            .chain(LONG.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect();
        assert_eq!(read_phone_times(&wide).unwrap(), expected);
    }

    #[test]
    fn faults_name_their_place() {
        let fault = |text: &str| read_phone_times(text.as_bytes()).unwrap_err();
        assert_eq!(fault("0 0.2 S\nhello"), PhoneTimesError::Line(2));
        assert_eq!(fault("0 0.2 S\n0.1 0.4 T"), PhoneTimesError::Order(2));
        assert_eq!(fault("0 0.2 %"), PhoneTimesError::Symbol(1, "%".to_owned()));
        assert_eq!(fault("0 0.2 sil"), PhoneTimesError::Empty);
        assert_eq!(fault(&LONG[..LONG.len() - 20]), PhoneTimesError::TextGrid);
    }

    proptest! {
        #[test]
        fn anything_gives_phones_in_order_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200), cut in 0..LONG.len()) {
            let mut text = LONG.as_bytes()[..cut].to_vec();
            text.extend(bytes);
            if let Ok(phones) = read_phone_times(&text) {
                prop_assert!(phones.windows(2).all(|w| w[0].end_secs <= w[1].start_secs + 2e-3));
            }
        }
    }
}
