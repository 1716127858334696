//! Names of public items are the terms of the field.

use super::Fault;
use super::imports::{code_of, statements};
use super::items::items;
use super::tree::Tree;
use super::unused::is_library;

/// Pictures in place of terms, each with the terms to choose from.
const PICTURES: [(&str, &str); 14] = [
    ("cast", "characters"),
    ("door", "command, entry"),
    ("ladder", "levels"),
    ("look", "view, appearance"),
    ("menu", "options"),
    ("notice", "event, warning"),
    ("offer", "option"),
    ("purse", "budget"),
    ("seat", "slot, index"),
    ("sight", "view, visibility"),
    ("stray", "unused, unmatched"),
    ("voice", "character, channel"),
    ("wake", "cull margin"),
    ("way", "path, method"),
];

/// Terms of which one word is such a picture.
const TERMS: [&str; 3] = ["look_up", "one_way", "two_way"];

/// Finds public items of libraries, other than fields, whose names have a word that the glossary
/// replaces. Words end at underscores and before capitals; a plural counts as its singular.
pub(crate) fn pictures(tree: &Tree) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (path, text) in tree.sources().filter(|(path, _)| is_library(path)) {
        let (_, code) = statements(&code_of(text));
        for item in items(&code).iter().filter(|item| item.is_public) {
            if let Some((word, terms)) = picture(&item.name) {
                let what = format!(
                    "{}: \"{word}\" is no term of docs/glossary.md; choose one, such as {terms}",
                    item.name
                );
                faults.push(Fault::line(path, item.line, what));
            }
        }
    }
    faults
}

/// The first picture in a name.
fn picture(name: &str) -> Option<(&'static str, &'static str)> {
    let mut plain = String::new();
    for c in name.chars() {
        let begins = c.is_uppercase() && plain.ends_with(|c: char| c.is_lowercase());
        plain.extend(begins.then_some('_'));
        plain.push(c);
    }
    let mut plain = plain.to_lowercase();
    for term in TERMS {
        plain = plain.replace(term, "");
    }
    let words = plain.split('_').map(|word| word.trim_end_matches('s'));
    let of = |word| PICTURES.into_iter().find(|(picture, _)| *picture == word);
    words.into_iter().find_map(of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_in_names_of_either_form() {
        let found = |name| picture(name).map(|(word, _)| word);
        assert_eq!(found("CastMember"), Some("cast"));
        assert_eq!(found("MAX_CAST"), Some("cast"));
        assert_eq!(found("error_sights"), Some("sight"));
        assert_eq!(found("look_from"), Some("look"));
        for name in [
            "LookUpTable",
            "one_way_delay",
            "always",
            "Forecast",
            "seated",
            "lookout",
        ] {
            assert_eq!(found(name), None, "{name}");
        }
    }

    #[test]
    fn public_items_of_libraries_are_named_by_terms() {
        let faults = |path: &str, text: &str| {
            let faults = pictures(&Tree::of(&[(path, text)])).into_iter();
            faults.map(|f| f.to_string()).collect::<Vec<_>>()
        };
        let text = "//! x\npub struct A;\nimpl A {\n    pub fn sights(&self) {}\n\n    \
                    fn cast(&self) {}\n}\n";
        assert_eq!(
            faults("crates/articula-core/src/a.rs", text),
            [
                "crates/articula-core/src/a.rs:4: sights: \"sight\" is no term of docs/glossary.md; \
                 choose one, such as view, visibility"
            ]
        );
        assert!(faults("crates/articula-cli/src/a.rs", text).is_empty());
    }
}
