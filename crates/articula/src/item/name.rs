//! Names of the files of an item.

use crate::error::{Context, Error, Result};
use std::collections::BTreeSet;

/// Maximum length of a name in bytes.
const LONGEST: usize = 255;
/// Maximum length of the part of a name that comes from a clip or picture.
const LONGEST_STEM: usize = 80;

/// Checks that a name is that of a file in the item: a relative path with `/`, without a scheme, a
/// drive, empty parts, `.` or `..`, in characters that all systems allow.
///
/// # Errors
/// [`Error::Unsupported`] with the name.
pub(super) fn check_name(name: &str) -> Result<()> {
    let refused = |what: &str| Err(Error::unsuited(what)).context(format!("\"{}\"", shown(name)));
    if name.is_empty() || name.len() > LONGEST {
        return refused("a name of 1 to 255 bytes is expected");
    }
    if name.starts_with('/') {
        return refused("the path is absolute; files of an item are named inside its folder");
    }
    if name.contains(':') {
        return refused("this is a URL or names a drive; files of an item are in its folder");
    }
    let is_bad = |c: char| c.is_control() || "\\<>\"|?*".contains(c);
    if name.chars().any(is_bad) {
        return refused("a character is not allowed in names of an item");
    }
    for part in name.split('/') {
        if matches!(part, "" | "." | "..") || part.ends_with(['.', ' ']) || part.starts_with(' ') {
            return refused("the path leaves the folder of the item, or has an empty part");
        }
    }
    Ok(())
}

/// A name as part of a message.
fn shown(name: &str) -> String {
    let short: String = name.chars().take(LONGEST_STEM).collect();
    short.escape_debug().to_string()
}

/// Makes names of files from names of clips and pictures: letters, digits, `-`, `_` and `.` stay.
/// No name is given twice, also in other case.
#[derive(Debug, Default)]
pub(super) struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    /// A name without extension for a file in `folder`; `otherwise` if nothing of the name can be
    /// used.
    pub(super) fn stem(&mut self, folder: &str, wanted: &str, otherwise: &str) -> String {
        let plain = |c: char| match c {
            'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' | '.' => c,
            _ => '_',
        };
        let stem: String = wanted.chars().take(LONGEST_STEM).map(plain).collect();
        let stem = stem.trim_matches(['.', '_']);
        let stem = if stem.is_empty() { otherwise } else { stem };
        let mut name = stem.to_owned();
        let mut number = 2;
        while !self.taken.insert(format!("{folder}/{name}").to_lowercase()) {
            name = format!("{stem}-{number}");
            number += 1;
        }
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_inside_the_item_are_taken() {
        for good in [
            "mesh.ams",
            "clips/walk.abp",
            "a b/ü.png",
            "..a",
            "2d/x-2.svg",
        ] {
            assert!(check_name(good).is_ok(), "{good}");
        }
        for bad in [
            "",
            "/etc/passwd",
            "../a",
            "a/../b",
            "a/./b",
            "a//b",
            "a/",
            "https://a/b",
            "C:\\a",
            "file:a",
            "a\\b",
            "a\nb",
            "\u{0}",
            "a.",
            "a /b",
            " a",
            "a?b",
        ] {
            assert!(check_name(bad).is_err(), "{bad:?}");
        }
        assert!(check_name(&"a".repeat(256)).is_err());
        let why = check_name("../\u{1b}[31m").unwrap_err().to_string();
        assert!(!why.contains('\u{1b}'), "{why}");
    }

    #[test]
    fn names_of_clips_become_names_of_files() {
        let mut names = Names::default();
        let mut of = |wanted: &str| names.stem("clips", wanted, "clip");
        assert_eq!(of("walk"), "walk");
        assert_eq!(of("Walk"), "Walk-2");
        assert_eq!(of("Armature|run fast"), "Armature_run_fast");
        assert_eq!(of("../.."), "clip");
        assert_eq!(of(""), "clip-2");
        assert_eq!(names.stem("textures", "walk", "x"), "walk");
        for wanted in ["a/b\\c:d", "né", "..."] {
            let stem = names.stem("x", wanted, "y");
            assert!(check_name(&format!("x/{stem}.abp")).is_ok(), "{stem}");
        }
    }
}
