//! The words of a morph target's name.

/// Splits a name at separators, digits and capitals (`Mouth_Smile_L`, `mouthSmileLeft`,
/// `mouthFunnelUL`): words in lower case, those of one meaning in one spelling. Digits are left out.
pub(super) fn words(name: &str) -> Vec<String> {
    let split = split(name);
    let spelled = split.iter().flat_map(|word| spelled_out(word));
    spelled.map(str::to_owned).collect()
}

fn split(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut word = String::new();
    let letters: Vec<char> = name.chars().collect();
    for (index, letter) in letters.iter().enumerate() {
        let before = index.checked_sub(1).map(|i| letters[i]);
        let after = letters.get(index + 1);
        let rises = before.is_some_and(char::is_lowercase) && letter.is_uppercase();
        // The last of several capitals begins the next word, as in `eCTRLMouthOpen`.
        let ends = before.is_some_and(char::is_uppercase)
            && letter.is_uppercase()
            && after.is_some_and(|a| a.is_lowercase());
        if (rises || ends || !letter.is_alphabetic()) && !word.is_empty() {
            words.push(std::mem::take(&mut word));
        }
        if letter.is_alphabetic() {
            word.extend(letter.to_lowercase());
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    words
}

/// One spelling for words of one meaning, and several words for those that stand for them.
fn spelled_out(word: &str) -> Vec<&str> {
    let one = match word {
        "eyes" => "eye",
        "brows" | "eyebrow" | "eyebrows" | "brw" => "brow",
        "lips" => "lip",
        "cheeks" => "cheek",
        "mth" => "mouth",
        "l" | "lft" => "left",
        "r" | "rgt" => "right",
        "lwr" | "bottom" => "lower",
        "upr" | "top" => "upper",
        "fwd" => "forward",
        "closed" => "close",
        "widen" => "wide",
        "raiser" => "raise",
        "lowerer" => "lower",
        "depressor" => "depress",
        "puller" => "pull",
        "stretcher" => "stretch",
        "pressor" => "press",
        "funneler" => "funnel",
        "dimpler" => "dimple",
        "wrinkler" => "wrinkle",
        "tightener" => "tighten",
        // `eCTRLvAA` is split as `e`, `CTR`, `Lv`, `AA`.
        "v" | "vis" | "visemes" | "lv" => "viseme",
        "ul" | "lt" => return vec!["upper", "left"],
        "ur" | "rt" => return vec!["upper", "right"],
        "dl" | "lb" => return vec!["lower", "left"],
        "dr" | "rb" => return vec!["lower", "right"],
        other => other,
    };
    vec![one]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_into_words() {
        for (name, wanted) in [
            ("mouthSmileLeft", "mouth smile left"),
            ("Mouth_Smile_L", "mouth smile left"),
            ("eCTRLEyesClosedL", "e ctrl eye close left"),
            ("eCTRLvAA", "e ctr viseme aa"),
            ("mouthFunnelUL", "mouth funnel upper left"),
            ("A25_Jaw_Open", "a jaw open"),
            ("viseme_PP", "viseme pp"),
            ("あ", "あ"),
            ("12", ""),
        ] {
            assert_eq!(words(name).join(" "), wanted, "{name}");
        }
    }
}
