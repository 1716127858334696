//! Name patterns of joints: four spellings of left and right, before or after the rest.

use articula_core::joint_names::{Side, folded};

/// Placeholder in a pattern for either side, in any spelling.
pub(super) const SIDE: &str = "{side}";
/// Placeholder in a target for the side of a lone hand, which is determined later.
pub(super) const HAND: &str = "{hand}";

/// Returns every folded name that a pattern matches, with its target.
///
/// A side at either end of the pattern may be at either end of the name, so `{side}Hand` matches
/// `LeftHand`, `L_Hand`, `hand.l` and `Hand Left`.
pub(super) fn spellings(pattern: &str, target: &str) -> Vec<(String, String)> {
    if !pattern.contains(SIDE) {
        return vec![(folded(pattern), target.to_owned())];
    }
    let rest = folded(&pattern.replacen(SIDE, "", 1));
    let at_end = pattern.starts_with(SIDE) || pattern.ends_with(SIDE);
    let mut found = Vec::new();
    for side in Side::BOTH {
        let own_target = target.replace(SIDE, side.letter());
        let word = match side {
            Side::Left => "left",
            Side::Right => "right",
        };
        for spelled in [word, side.letter()] {
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
}
