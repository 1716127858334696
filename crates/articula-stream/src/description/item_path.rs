//! References within a digital item.

use articula_core::Mismatch;
use std::fmt;
use std::str::FromStr;

/// Greatest length of a reference in bytes.
const MOST: usize = 1024;

/// A path from the folder of a digital item to a file in it: relative, with `/` between its parts,
/// none of which is `..`, and without scheme, query or escapes. Joined to the folder it never leaves
/// it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemPath(String);

impl ItemPath {
    /// The path as text, with `/`.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Checks a reference; `\` is read as `/`, and parts that are `.` are left out.
impl FromStr for ItemPath {
    type Err = Mismatch;

    fn from_str(text: &str) -> Result<Self, Mismatch> {
        let wrong = |what: &str| {
            let shown: String = text.chars().take(80).flat_map(char::escape_debug).collect();
            Mismatch::new(format!("reference \"{shown}\""), what)
        };
        if text.len() > MOST {
            return Err(wrong("is longer than 1024 bytes"));
        }
        let path = text.trim().replace('\\', "/");
        if path.starts_with('/') {
            return Err(wrong("is absolute, expected a path within the item"));
        }
        if path.contains(':') {
            return Err(wrong(
                "has a scheme or a drive, expected a path within the item",
            ));
        }
        if path.contains(['%', '?', '#', '*', '|', '<', '>', '"'])
            || path.contains(char::is_control)
        {
            return Err(wrong(
                "has characters that a path within the item cannot have",
            ));
        }
        let parts: Vec<&str> = path.split('/').filter(|part| *part != ".").collect();
        if parts.contains(&"..") {
            return Err(wrong("leaves the item by .."));
        }
        // Of parts that end in dots or blanks, some systems forget these.
        let is_name = |part: &&str| !part.is_empty() && !part.ends_with(['.', ' ']);
        if parts.is_empty() || !parts.iter().all(is_name) {
            return Err(wrong("has a part without a name"));
        }
        Ok(Self(parts.join("/")))
    }
}

impl fmt::Display for ItemPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_within_the_item() {
        let path = |text: &str| text.parse::<ItemPath>().map(|path| path.0);
        assert_eq!(path("clip.xml").unwrap(), "clip.xml");
        assert_eq!(
            path(".\\pierra_sequ0101.raw").unwrap(),
            "pierra_sequ0101.raw"
        );
        assert_eq!(path(" a/./b-c_1.x ").unwrap(), "a/b-c_1.x");
        for bad in [
            "",
            ".",
            "/etc/passwd",
            "\\\\host\\share",
            "../x",
            "a/../../x",
            "a/..",
            "..\\x",
            "http://host/x",
            "file:x",
            "C:\\x",
            "a//b",
            "a/",
            "%2e%2e/x",
            "a?b",
            "a#b",
            "a\0b",
            "a\nb",
            ".. /x",
            "... /x",
            "con./x",
        ] {
            assert!(path(bad).is_err(), "{bad:?}");
        }
        assert!(path(&"a".repeat(1025)).is_err());
    }
}
