//! Joint names as people write them, made comparable.
//!
//! Case and separators carry no meaning, a namespace (`Armature|`, `mixamorig:`) neither; left
//! and right are written in four ways, before or behind the rest.

/// Stands in a pattern for either side, in any spelling.
pub(super) const SIDE: &str = "{side}";
/// Stands in a target for the side that a lone hand turns out to be.
pub(super) const HAND: &str = "{hand}";

/// One side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

impl Side {
    pub(super) const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The letter that H-Anim names start with.
    pub(super) fn letter(self) -> &'static str {
        match self {
            Self::Left => "l",
            Self::Right => "r",
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// The side of an H-Anim name, if it has one.
    pub(super) fn of(hanim: &str) -> Option<Self> {
        Self::BOTH.into_iter().find(|s| {
            hanim
                .strip_prefix(s.letter())
                .is_some_and(|r| r.starts_with('_'))
        })
    }

    /// The same H-Anim name on the other side.
    pub(super) fn mirrored(hanim: &str) -> String {
        match Self::of(hanim) {
            Some(Self::Left) => format!("r{}", &hanim[1..]),
            Some(Self::Right) => format!("l{}", &hanim[1..]),
            None => hanim.to_owned(),
        }
    }
}

/// The name without namespace, case and separators.
pub(super) fn folded(name: &str) -> String {
    let own = name.rsplit([':', '|']).find(|part| !part.is_empty());
    own.unwrap_or_default()
        .chars()
        .filter(|c| !matches!(c, ' ' | '-' | '_' | '.'))
        .flat_map(char::to_lowercase)
        .collect()
}

/// The folded name without a prefix (and the digits that number its copies) or a suffix.
pub(super) fn stripped(folded: &str, prefixes: &[String], suffixes: &[String]) -> String {
    let after_prefix = prefixes
        .iter()
        .find_map(|p| folded.strip_prefix(p.as_str()));
    let core = after_prefix.map_or(folded, |rest| {
        rest.trim_start_matches(|c: char| c.is_ascii_digit())
    });
    let before_suffix = suffixes.iter().find_map(|s| core.strip_suffix(s.as_str()));
    before_suffix.unwrap_or(core).to_owned()
}

/// Every folded name that a pattern stands for, with the target it leads to.
///
/// A side at either end of the pattern may stand at either end of the name, so that
/// `{side}Hand` finds `LeftHand`, `L_Hand`, `hand.l` and `Hand Left`.
pub(super) fn spellings(pattern: &str, target: &str) -> Vec<(String, String)> {
    if !pattern.contains(SIDE) {
        return vec![(folded(pattern), target.to_owned())];
    }
    let rest = folded(&pattern.replacen(SIDE, "", 1));
    let at_end = pattern.starts_with(SIDE) || pattern.ends_with(SIDE);
    let mut found = Vec::new();
    for side in Side::BOTH {
        let own_target = target.replace(SIDE, side.letter());
        for spelled in [side.word(), side.letter()] {
            let names = if at_end {
                vec![format!("{spelled}{rest}"), format!("{rest}{spelled}")]
            } else {
                vec![folded(&pattern.replacen(SIDE, spelled, 1))]
            };
            found.extend(names.into_iter().map(|n| (n, own_target.clone())));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fold_to_their_letters() {
        for name in [
            "Armature|mixamorig:Left_Up.Leg",
            "left up-leg",
            "LEFTUPLEG",
            "leftUpLeg",
        ] {
            assert_eq!(folded(name), "leftupleg");
        }
        assert_eq!(folded("Left:"), "left", "an empty last part is no name");
        assert_eq!(folded(""), "");
    }

    #[test]
    fn a_side_is_found_in_every_spelling() {
        let found = spellings("{side}Hand", "{side}_wrist");
        let wrist = |name: &str| {
            let wanted = folded(name);
            let hit = found.iter().find(|(n, _)| *n == wanted);
            hit.map(|(_, t)| t.as_str())
        };
        for name in ["LeftHand", "L_Hand", "hand.l", "Hand Left"] {
            assert_eq!(wrist(name), Some("l_wrist"), "{name}");
        }
        assert_eq!(wrist("hand_r"), Some("r_wrist"));
        assert_eq!(wrist("Hand"), None);
    }

    #[test]
    fn prefix_number_and_suffix_are_dropped() {
        let list = |s: &str| vec![s.to_owned()];
        assert_eq!(stripped("mixamorig12hips", &list("mixamorig"), &[]), "hips");
        assert_eq!(stripped("thighlarmature", &[], &list("armature")), "thighl");
        assert_eq!(stripped("spine1", &list("mixamorig"), &[]), "spine1");
    }

    #[test]
    fn sides_of_standard_names() {
        assert_eq!(Side::of("l_hip"), Some(Side::Left));
        assert_eq!(Side::of("r_hip"), Some(Side::Right));
        assert_eq!(Side::of("sacroiliac"), None);
        assert_eq!(Side::mirrored("r_index0"), "l_index0");
        assert_eq!(Side::mirrored("vl5"), "vl5");
    }
}
