//! Errors of the program, printed as `FILE: place: what; remedy` on one line, and the exit status.
//!
//! Errors of the libraries name the place inside the file; the file name is prepended here.

use std::fmt;

/// An error in the command line itself: exit status 2.
#[derive(Debug)]
pub(crate) struct Usage(String);

impl fmt::Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// A usage error.
pub(crate) fn usage(what: impl Into<String>) -> anyhow::Error {
    anyhow::Error::new(Usage(what.into()))
}

/// Returns the exit status of an error.
pub(crate) fn status(fault: &anyhow::Error) -> u8 {
    let is_argument = |e: &articula::Error| e.is_argument();
    let of_library = fault.downcast_ref().is_some_and(is_argument);
    if of_library || fault.downcast_ref::<Usage>().is_some() {
        2
    } else {
        1
    }
}

/// Formats the whole chain of an error on one line.
pub(crate) fn line(fault: &anyhow::Error) -> String {
    format!("error: {}", clean(&text(fault)))
}

/// Formats the whole chain of an error; where an argument of the library is the remedy, its flag
/// is named.
pub(crate) fn text(fault: &anyhow::Error) -> String {
    let text = format!("{fault:#}");
    let cause = fault.downcast_ref::<articula::Error>().map(|e| e.cause());
    match cause {
        Some(articula::Error::Unmapped(_)) => text.replace("a joint map", "--joint-map F.json"),
        Some(articula::Error::Skeleton(_)) => {
            let or = if text.ends_with(')') {
                "; name one"
            } else {
                " or name it"
            };
            format!("{text}{or} with --read skeleton=F.asf")
        }
        Some(articula::Error::Exists(_)) => format!("{text}, or replace it with --force"),
        _ => text,
    }
}

/// Maximum bytes of text from a file that are shown; longer text is cut.
const LONGEST: usize = 2000;

/// Makes text from a file safe for a terminal: control characters are escaped, so that a name
/// can neither break a line nor control the terminal, and very long text is cut.
pub(crate) fn clean(text: &str) -> String {
    let mut out = String::with_capacity(text.len().min(LONGEST));
    for c in text.chars() {
        if out.len() >= LONGEST {
            out.push('…');
            break;
        }
        // Not only control characters: also marks that change the direction of writing.
        let steers = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if c.is_control() || steers {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn a_very_long_name_is_cut() {
        assert_eq!(clean(&"x".repeat(1999)).len(), 1999);
        assert_eq!(clean(&"é".repeat(100_000)).chars().count(), 1001);
    }

    #[test]
    fn one_line_names_the_file_first_and_keeps_the_status() {
        let inner: anyhow::Result<()> = Err(usage("no such clip\n\u{1b}[31mred"));
        let outer = inner.context("a.glb").unwrap_err();
        assert_eq!(line(&outer), "error: a.glb: no such clip\\n\\u{1b}[31mred");
        assert_eq!(status(&outer), 2);
        assert_eq!(status(&anyhow::anyhow!("gone")), 1);
    }
}
