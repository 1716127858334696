//! Names that X3D allows (XML name tokens, and IDs for `DEF`), each given once.
//!
//! Source: ISO/IEC 19776-1, 4.3.13; XML 1.0, 2.3.

use std::collections::HashSet;

/// A name as an XML ID may be: letters, digits, `_`, `-` and `.`, none of the last three and no
/// digit at the start. Everything else becomes `_`.
pub(in crate::x3d) fn token(name: &str) -> String {
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

/// Names given so far.
#[derive(Debug, Default)]
pub(super) struct Names {
    given: HashSet<String>,
}

impl Names {
    /// The token of a name, with a number behind it if it is taken; `usual` stands for an
    /// empty name.
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
