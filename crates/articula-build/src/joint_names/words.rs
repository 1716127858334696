//! The words in joint names.
//!
//! Names are split at separators, between letters and digits, and where capitals begin a word:
//! `L_armUpper0001_bind_JNT` is l, arm, upper, 0001, bind, jnt.

use articula_core::joint_names::Side;
use std::collections::{BTreeMap, BTreeSet};

/// Share of the joints of a rig above which a word says nothing about one of them.
const COMMON: f32 = 0.5;

/// The words of a joint name, without namespace, in lower case.
pub(super) fn split(name: &str) -> Vec<String> {
    let own = name.rsplit([':', '|']).find(|part| !part.is_empty());
    let chars: Vec<char> = own.unwrap_or_default().chars().collect();
    let mut words: Vec<String> = Vec::new();
    for (i, c) in chars.iter().enumerate() {
        if !c.is_alphanumeric() {
            continue;
        }
        let before = i.checked_sub(1).map(|b| chars[b]);
        let begins = match before {
            None => true,
            Some(b) if !b.is_alphanumeric() => true,
            Some(b) if b.is_numeric() != c.is_numeric() => true,
            // A capital after a small letter, or the last of several before a small letter.
            Some(b) => {
                let small_follows = chars.get(i + 1).is_some_and(|n| n.is_lowercase());
                c.is_uppercase() && (b.is_lowercase() || small_follows)
            }
        };
        let lower = c.to_lowercase();
        match words.last_mut().filter(|_| !begins) {
            Some(word) => word.extend(lower),
            None => words.push(lower.collect()),
        }
    }
    words
}

/// The side that a word means.
pub(super) fn side(word: &str) -> Option<Side> {
    match word {
        "l" | "left" | "lft" | "lf" | "lt" => Some(Side::Left),
        "r" | "right" | "rgt" | "rt" => Some(Side::Right),
        _ => None,
    }
}

/// Removes the words that most joints of the rig have, such as the name of the character or
/// `bind`. Those that `is_known` are kept.
pub(super) fn without_common(names: &mut [Vec<String>], is_known: impl Fn(&str) -> bool) {
    let mut counts = BTreeMap::<String, usize>::new();
    for words in names.iter() {
        let distinct: BTreeSet<&String> = words.iter().collect();
        for word in distinct {
            *counts.entry(word.clone()).or_default() += 1;
        }
    }
    let most = COMMON * names.len() as f32;
    let is_common = |word: &String| counts[word] as f32 > most && !is_known(word);
    for words in names {
        words.retain(|word| !is_common(word));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_split_at_separators_digits_and_capitals() {
        for (name, words) in [
            ("mixamorig:LeftUpLeg_047", "left up leg 047"),
            ("Armature|Bip01 L UpperArm", "bip 01 l upper arm"),
            ("Bip01 L UpperArm", "bip 01 l upper arm"),
            ("lShldr", "l shldr"),
            ("L_armUpper0001_bind_JNT", "l arm upper 0001 bind jnt"),
            ("LThumb1", "l thumb 1"),
            ("DEF-upper_arm.L.001", "def upper arm l 001"),
            ("", ""),
        ] {
            assert_eq!(split(name).join(" "), words);
        }
    }

    #[test]
    fn what_most_joints_are_called_is_dropped() {
        let mut names = ["ada_hips_jnt", "ada_head_jnt", "ada_hand_l_jnt", "hair"].map(split);
        without_common(&mut names, |word| word == "hips");
        assert_eq!(
            names.map(|words| words.join(" ")),
            ["hips", "head", "hand l", "hair"]
        );
    }
}
