//! Unique names that X3D allows (XML name tokens, and IDs for `DEF`).
//!
//! Source: ISO/IEC 19776-1, 4.3.13; XML 1.0, 2.3.

use std::collections::HashSet;

/// Returns a name as a valid XML ID: letters, digits, `_`, `-` and `.`, beginning with a letter or
/// `_`. Other characters become `_`.
pub(super) fn token(name: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    let name = name.trim();
    let mut token: String = name
        .chars()
        .map(|c| if allowed(c) { c } else { '_' })
        .collect();
    if token.starts_with(|c: char| !c.is_ascii_alphabetic() && c != '_') {
        token.insert(0, '_');
    }
    token
}

/// Names used so far.
#[derive(Debug, Default)]
pub(super) struct Names {
    given: HashSet<String>,
}

impl Names {
    /// Returns the token of a name, with a number appended if it is already used; `usual` replaces
    /// an empty name.
    pub(super) fn give(&mut self, name: &str, usual: &str) -> String {
        let mut wanted = token(name);
        if wanted.is_empty() {
            wanted = usual.to_owned();
        }
        let mut unique = wanted.clone();
        let mut number = 2;
        while !self.given.insert(unique.clone()) {
            unique = format!("{wanted}_{number}");
            number += 1;
        }
        unique
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_legal_and_unique() {
        let mut names = Names::default();
        assert_eq!(
            names.give("mixamorig:Left Hand", "x"),
            "mixamorig_Left_Hand"
        );
        assert_eq!(
            names.give("mixamorig|Left Hand", "x"),
            "mixamorig_Left_Hand_2"
        );
        assert_eq!(names.give("3rd", "x"), "_3rd");
        assert_eq!(names.give("", "joint"), "joint");
        assert_eq!(names.give(" ", "joint"), "joint_2");
        assert_eq!(token("Kö"), "K_");
    }
}
