//! Level and region of standard joint names.
//!
//! Source: H-Anim 1.1 (94 joints, [`articula_core::hanim_table`]) and the 52 joints that H-Anim 2
//! adds (data file `hanim-2.json`); the latter do not exist in the older standard, so they belong
//! to the last level.

use super::names::SIDE;
use articula_core::Region;
use articula_core::hanim_table;
use articula_core::joint_names::{Side, StandardJoint};
use articula_core::loa::MAX_LEVEL;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::LazyLock;

#[derive(Deserialize)]
struct Added {
    feet: Vec<String>,
    hands: Vec<String>,
}

static ADDED: LazyLock<BTreeMap<String, Region>> = LazyLock::new(|| {
    let text = include_str!("../../data/joint_maps/hanim-2.json");
    let added: Added = serde_json::from_str(text).expect("a test parses hanim-2.json");
    let regions = [(added.feet, Region::Feet), (added.hands, Region::Hands)];
    let mut names = BTreeMap::new();
    for (patterns, region) in regions {
        for pattern in patterns {
            for side in Side::BOTH {
                names.insert(pattern.replace(SIDE, side.letter()), region);
            }
        }
    }
    names
});

/// Returns the joint of an H-Anim 1.1 or 2 name, under its older name if it has both, or of a joint
/// scheme.
pub(super) fn joint(name: &str) -> Option<StandardJoint> {
    if let Some(row) = hanim_table::named(name) {
        return Some(StandardJoint::from(row));
    }
    let folded = name.to_ascii_lowercase();
    let region = *ADDED.get(&folded)?;
    Some(StandardJoint {
        name: folded,
        level: MAX_LEVEL,
        region,
    })
}

/// Returns every name of both standards and of the joint schemes, for the joint map that maps each to
/// itself.
pub(super) fn all_names() -> impl Iterator<Item = &'static str> {
    let table = hanim_table::JOINTS.iter();
    let old = table.clone().map(|j| j.name);
    let renamed = table.filter(|j| j.name != j.name_v2).map(|j| j.name_v2);
    let of_schemes = hanim_table::THUMB_BASES.iter().map(|j| j.name);
    old.chain(renamed)
        .chain(of_schemes)
        .chain(ADDED.keys().map(String::as_str))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_standards_are_complete() {
        assert_eq!(hanim_table::JOINTS.len() + ADDED.len(), 146);
        for name in all_names() {
            let found = joint(name).unwrap();
            let twin = found.mirrored();
            assert_eq!(joint(&twin.name), Some(twin), "{name} on the other side");
        }
    }

    #[test]
    fn new_names_of_old_joints_keep_their_level() {
        let wrist = joint("l_radiocarpal").unwrap();
        assert_eq!((wrist.name.as_str(), wrist.level), ("l_wrist", 2));
        let toe = joint("r_metatarsophalangeal_1").unwrap();
        assert_eq!((toe.level, toe.region), (5, Region::Feet));
        assert!(joint("tail").is_none());
    }
}
