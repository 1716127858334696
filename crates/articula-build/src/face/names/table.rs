//! All known names of controls, by their words.

use super::synonyms::{EMOTIONS, SHAPES, Synonym, VISEMES, VOWELS};
use super::words::words;
use crate::joint_names::MappingConfidence;
use articula_core::arkit_table::BLEND_SHAPES;
use articula_core::face_control::FaceControl;
use articula_core::viseme::Viseme;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// What the words of a name mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
    pub(super) control: FaceControl,
    pub(super) confidence: MappingConfidence,
    /// Whether the words are the whole name, without others around them.
    pub(super) alone: bool,
}

/// Names by their words: first in their order, then in any.
pub(super) struct Table {
    ordered: BTreeMap<String, Known>,
    sorted: BTreeMap<String, Known>,
}

pub(super) static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

/// Shapes of which some faces have a half for each side.
const HALVED: [&str; 9] = [
    "browInnerUp",
    "cheekPuff",
    "mouthClose",
    "mouthFunnel",
    "mouthPucker",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
];

impl Table {
    fn new() -> Self {
        let mut table = Self {
            ordered: BTreeMap::new(),
            sorted: BTreeMap::new(),
        };
        let (high, medium) = (MappingConfidence::High, MappingConfidence::Medium);
        for shape in &BLEND_SHAPES {
            table.add(shape.name, shape.name, high, false);
        }
        for name in HALVED {
            table.add(
                &format!("{name} {{s}}"),
                &format!("{name}/{{s}}"),
                high,
                false,
            );
        }
        for viseme in Viseme::ALL {
            let control = FaceControl::Viseme(viseme).to_string();
            table.add(&format!("viseme {}", viseme.name()), &control, high, false);
        }
        let rows = |rows: &'static [Synonym]| rows.iter().copied();
        for (name, control) in rows(SHAPES).chain(rows(VISEMES)).chain(rows(EMOTIONS)) {
            table.add(name, control, medium, false);
        }
        for (name, control) in VOWELS {
            table.add(name, control, MappingConfidence::Low, true);
        }
        for stem in BLEND_SHAPES
            .iter()
            .filter_map(|s| s.name.strip_suffix("Left"))
        {
            if words(stem).len() > 1 {
                table.add(stem, &format!("{stem}Left+{stem}Right"), medium, false);
            }
        }
        table
    }

    /// Adds a name for each side that it may have.
    fn add(&mut self, name: &str, control: &str, confidence: MappingConfidence, alone: bool) {
        for (side, other) in [("left", "right"), ("right", "left")] {
            let name = words(&name.replace("{s}", side).replace("{o}", other));
            let capital = if side == "left" { "Left" } else { "Right" };
            let control = control.replace("{S}", capital).replace("{s}", side);
            let control = control.parse().expect("a test reads every control");
            let known = Known {
                control,
                confidence,
                alone,
            };
            let has = |side: &str| name.iter().any(|word| word == side);
            if !(has("left") && has("right")) {
                self.sorted.entry(sorted(&name)).or_insert(known);
            }
            self.ordered.entry(name.concat()).or_insert(known);
        }
    }

    /// What words mean, in their order or, if they have one side at most, in any.
    pub(super) fn get(&self, words: &[String]) -> Option<&Known> {
        let has = |side: &str| words.iter().any(|word| word == side);
        let in_order = self.ordered.get(&words.concat());
        in_order.or_else(|| {
            (!(has("left") && has("right")))
                .then(|| self.sorted.get(&sorted(words)))
                .flatten()
        })
    }
}

fn sorted(words: &[String]) -> String {
    let mut words = words.to_vec();
    words.sort_unstable();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows and sides of the tables that are hidden by earlier ones of another meaning.
    #[test]
    fn no_two_rows_give_one_name_two_meanings() {
        let all = [SHAPES, VISEMES, EMOTIONS, VOWELS];
        for (name, control) in all.into_iter().flatten() {
            for (side, capital, other) in [("left", "Left", "right"), ("right", "Right", "left")] {
                let name = words(&name.replace("{s}", side).replace("{o}", other));
                let control = control.replace("{S}", capital).replace("{s}", side);
                let found = TABLE.get(&name).map(|known| known.control.to_string());
                assert_eq!(found, Some(control), "{name:?}");
            }
        }
    }

    #[test]
    fn words_in_any_order() {
        let get = |name: &str| {
            TABLE
                .get(&words(name))
                .map(|known| known.control.to_string())
        };
        assert_eq!(
            get("Mouth_Down_Lower_L").as_deref(),
            Some("mouthLowerDownLeft")
        );
        assert_eq!(
            get("Left_Outer_Brow_Up").as_deref(),
            Some("browOuterUpLeft")
        );
        assert_eq!(get("Eye_Left_Look_Right").as_deref(), Some("eyeLookInLeft"));
    }
}
