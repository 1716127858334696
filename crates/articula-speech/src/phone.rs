//! Phones, by their symbols in the International Phonetic Alphabet or in ARPAbet, as visemes.

use articula_core::viseme::Viseme::{self, *};

/// A part of a phone with one shape of the mouth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phone {
    /// The shape; `None` for h, whose shape is that of the next sound.
    pub viseme: Option<Viseme>,
    /// Its share of the duration of the phone, above 0 and at most 1.
    pub share: f32,
}

/// The first of the parts of a sound that glides takes this share.
const GLIDE: [f32; 2] = [0.6, 0.4];

/// The shapes by the symbols of the IPA.
#[rustfmt::skip]
const IPA: [(Viseme, &str); 15] = [
    (Pp, "pbmɓɸβʙ"),
    (Ff, "fvʋɱⱱ"),
    (Th, "θð"),
    (Dd, "tdʈɖɗɾʔ"),
    (Kk, "kgɡŋxɣqɢχʁʀħʕɴc\u{25f}"),
    (Ch, "ʃʒɕʑʂʐɧ"),
    (Ss, "szɬɮ"),
    (Nn, "nlɲɳʎɭɫ"),
    (Rr, "ɹrɻɽɚɝɺ"),
    (Aa, "aɑɐʌæäã"),
    (E, "eɛəɜɘɤẽ"),
    (I, "iɪjɨɯçʝᵻĩ"),
    (O, "oɔɒøœɵõ"),
    (U, "uʊwyʏɥʉũ"),
    (Silence, ""),
];

/// The phones of ARPAbet, in the symbols of the IPA.
#[rustfmt::skip]
const ARPABET: [(&str, &str); 50] = [
    ("p", "p"), ("b", "b"), ("m", "m"), ("em", "m"), ("f", "f"), ("v", "v"), ("th", "θ"), ("dh", "ð"), ("t", "t"),
    ("d", "d"), ("dx", "ɾ"), ("k", "k"), ("g", "ɡ"), ("ng", "ŋ"), ("ch", "tʃ"), ("jh", "dʒ"), ("sh", "ʃ"),
    ("zh", "ʒ"), ("s", "s"), ("z", "z"), ("n", "n"), ("en", "n"), ("l", "l"), ("el", "l"), ("r", "ɹ"), ("aa", "ɑ"),
    ("ae", "æ"), ("ah", "ʌ"), ("ao", "ɔ"), ("aw", "aʊ"), ("ay", "aɪ"), ("ax", "ə"), ("ax-h", "ə"), ("eh", "ɛ"),
    ("er", "ɚ"), ("axr", "ɚ"), ("ey", "eɪ"), ("ih", "ɪ"), ("ix", "ɪ"), ("iy", "i"), ("ow", "oʊ"), ("oy", "ɔɪ"),
    ("uh", "ʊ"), ("uw", "u"), ("ux", "u"), ("w", "w"), ("wh", "w"), ("y", "j"), ("hh", "h"), ("hv", "h"),
];

/// Names of pauses in files of phones.
const PAUSES: [&str; 12] = [
    "", "_", "sil", "sp", "spn", "pau", "ssil", "h#", "#", "<p:>", "<sil>", "+spn+",
];

/// The parts of a phone in the IPA; `None` if no symbol is known. Marks of length, stress and tone
/// are passed over.
pub fn phones_of_ipa(symbol: &str) -> Option<Vec<Phone>> {
    let known: Vec<(char, Option<Viseme>)> = symbol.chars().filter_map(known).collect();
    let whole = |viseme| Some(vec![Phone { viseme, share: 1.0 }]);
    match known.as_slice() {
        [] => None,
        [(_, viseme)] => whole(*viseme),
        [('t' | 'd', _), (_, Some(second @ (Ch | Ss))), ..] => whole(Some(*second)),
        [(_, first), (_, second), ..] => {
            let parts = [*first, *second].into_iter().zip(GLIDE);
            Some(
                parts
                    .map(|(viseme, share)| Phone { viseme, share })
                    .collect(),
            )
        }
    }
}

/// The parts of a phone in ARPAbet, with or without the number of its stress.
pub(crate) fn phones_of_arpabet(symbol: &str) -> Option<Vec<Phone>> {
    let symbol = symbol.to_ascii_lowercase();
    let symbol = symbol.trim_end_matches(|c: char| c.is_ascii_digit());
    let (_, ipa) = ARPABET.iter().find(|(name, _)| *name == symbol)?;
    phones_of_ipa(ipa)
}

/// Whether a label names a pause.
pub(crate) fn is_pause(label: &str) -> bool {
    PAUSES.contains(&label.to_ascii_lowercase().as_str())
}

/// The shape of a symbol; `None` within for h.
fn known(symbol: char) -> Option<(char, Option<Viseme>)> {
    if matches!(symbol, 'h' | 'ɦ') {
        return Some((symbol, None));
    }
    let row = IPA.iter().find(|(_, symbols)| symbols.contains(symbol))?;
    // A mark below a letter is no letter of its own.
    symbol.is_alphabetic().then_some((symbol, Some(row.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes(phones: Option<Vec<Phone>>) -> Vec<Option<Viseme>> {
        phones
            .unwrap_or_default()
            .iter()
            .map(|p| p.viseme)
            .collect()
    }

    #[test]
    fn symbols_have_the_shapes_of_the_standards_examples() {
        for (symbol, viseme) in [
            ("p", Pp),
            ("m", Pp),
            ("v", Ff),
            ("ð", Th),
            ("d", Dd),
            ("ɡ", Kk),
            ("tʃ", Ch),
            ("dʒ", Ch),
            ("ts", Ss),
            ("z", Ss),
            ("l", Nn),
            ("ɹ", Rr),
            ("ɑː", Aa),
            ("ɛ", E),
            ("ˈiː", I),
            ("ç", I),
            ("ɔ", O),
            ("u", U),
            ("ɑ̃", Aa),
            ("œ", O),
        ] {
            assert_eq!(shapes(phones_of_ipa(symbol)), [Some(viseme)], "{symbol}");
        }
        assert_eq!(shapes(phones_of_ipa("aɪ")), [Some(Aa), Some(I)]);
        assert_eq!(shapes(phones_of_ipa("h")), [None]);
        assert_eq!(phones_of_ipa("ː"), None);
    }

    #[test]
    fn each_phone_of_arpabet_is_known_and_its_parts_make_the_whole() {
        for (name, _) in ARPABET {
            let parts = phones_of_arpabet(&format!("{}1", name.to_uppercase())).unwrap();
            let sum: f32 = parts.iter().map(|p| p.share).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{name}");
        }
        assert_eq!(phones_of_arpabet("tʃ"), None);
        assert!(is_pause("SIL") && !is_pause("s"));
    }

    #[test]
    fn no_symbol_has_two_shapes() {
        for (at, (_, symbols)) in IPA.iter().enumerate() {
            for symbol in symbols.chars().filter(|c| c.is_alphabetic()) {
                let first = IPA.iter().position(|(_, symbols)| symbols.contains(symbol));
                assert_eq!(first, Some(at), "{symbol}");
            }
        }
    }
}
