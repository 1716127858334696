//! Items of a Rust source and the names that each of them uses, as text. Relies on the layout of
//! rustfmt: items begin in the first column, methods in the fifth.

use std::collections::HashSet;

/// Words that may stand before the keyword of an item.
const BEFORE: [&str; 6] = ["pub", "unsafe", "async", "extern", "default", "const"];

/// Keywords of items that have a name.
const KEYWORDS: [&str; 10] = [
    "fn",
    "struct",
    "enum",
    "union",
    "trait",
    "const",
    "static",
    "type",
    "mod",
    "macro_rules",
];

/// What an item is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    /// A function, type, trait, constant or macro.
    Named,
    /// The rest of an implementation, without inherent methods: used wherever the type is.
    Implementation {
        /// The type, as written.
        of: String,
    },
    /// An inherent method.
    Method {
        /// The type, as written.
        of: String,
    },
}

/// One item and the names in it.
#[derive(Debug)]
pub(super) struct Item {
    pub(super) kind: Kind,
    /// Its name; empty for an implementation.
    pub(super) name: String,
    /// Number of its first line, from 1.
    pub(super) line: usize,
    /// Whether it is `pub` without a restriction.
    pub(super) is_public: bool,
    /// Whether it is a function, a constant or a static outside of an implementation.
    pub(super) is_value: bool,
    /// Whether it is a method that returns its type.
    pub(super) returns_itself: bool,
    /// Single words.
    pub(super) words: HashSet<String>,
    /// Paths of several words, as written.
    pub(super) paths: HashSet<String>,
    /// Names after a dot or `::`.
    pub(super) members: HashSet<String>,
}

impl Item {
    fn new(kind: Kind, name: &str, line: usize, text: &str) -> Self {
        let is_of = |word| matches!(word, "fn" | "const" | "static");
        let is_value =
            kind == Kind::Named && keyword(text.trim_start()).is_some_and(|(word, _)| is_of(word));
        let returned = text
            .split('{')
            .next()
            .and_then(|head| head.rsplit_once("->"));
        let returns_itself = returned.is_some_and(|(_, returned)| match &kind {
            Kind::Method { of } => returned.contains("Self") || returned.contains(of.as_str()),
            _ => false,
        });
        let mut item = Self {
            kind,
            name: name.to_owned(),
            line,
            is_value,
            returns_itself,
            is_public: text.trim_start().starts_with("pub "),
            words: HashSet::new(),
            paths: HashSet::new(),
            members: HashSet::new(),
        };
        item.scan(text);
        item
    }

    /// All code of a file as one item without a name.
    pub(super) fn whole(code: &str) -> Self {
        Self::new(Kind::Implementation { of: String::new() }, "", 1, code)
    }

    fn scan(&mut self, text: &str) {
        let is_part = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b == b':';
        let bytes = text.as_bytes();
        let mut at = 0;
        let mut mark = b' ';
        while at < bytes.len() {
            if !is_part(bytes[at]) {
                // Two dots are a range, after which no member stands.
                if !bytes[at].is_ascii_whitespace() {
                    let is_range = mark == b'.' && bytes[at] == b'.';
                    mark = if is_range { b' ' } else { bytes[at] };
                }
                at += 1;
                continue;
            }
            let start = at;
            while at < bytes.len() && is_part(bytes[at]) {
                at += 1;
            }
            let word = text[start..at].trim_matches(':');
            if let Some((_, last)) = word.rsplit_once("::") {
                self.members.insert(last.to_owned());
                self.paths.insert(word.to_owned());
            } else if mark == b'.' {
                self.members.insert(word.to_owned());
            } else if !word.is_empty() {
                self.words.insert(word.to_owned());
            }
            if text[start..at].starts_with("::") {
                self.members.insert(word.to_owned());
            }
            mark = b' ';
        }
    }
}

/// Splits code without imports into its items.
pub(super) fn items(code: &str) -> Vec<Item> {
    let mut out = Vec::new();
    for (line, text) in blocks(code, 0) {
        let head = text.split('{').next().unwrap_or(text);
        if let Some((of, is_trait)) = implemented(head) {
            let methods = if is_trait {
                Vec::new()
            } else {
                blocks(text, 4)
            };
            let mut rest = text;
            if let Some((_, first)) = methods.first() {
                let len = methods.iter().map(|(_, m)| m.len()).sum::<usize>();
                rest = &text[..text.len() - len];
                debug_assert!(text[rest.len()..].starts_with(first));
            }
            for (below, method) in methods {
                let kind = Kind::Method { of: of.clone() };
                let name = name_of(method.trim_start()).unwrap_or_default();
                out.push(Item::new(kind, name, line + below - 1, method));
            }
            out.push(Item::new(Kind::Implementation { of }, "", line, rest));
        } else if let Some((word, _)) = keyword(text)
            && word != "mod"
            && let Some(name) = name_of(text)
        {
            out.push(Item::new(Kind::Named, name, line, text));
        }
    }
    out
}

/// Texts of the items that begin at a column, each up to the next and with the number of its line.
fn blocks(code: &str, column: usize) -> Vec<(usize, &str)> {
    let mut starts = Vec::new();
    let mut at = 0;
    for (index, line) in code.split_inclusive('\n').enumerate() {
        let blanks = line.len() - line.trim_start_matches(' ').len();
        let text = &line[blanks.min(line.len())..];
        let is_item = match column {
            0 => name_of(text).is_some() || text.starts_with("impl"),
            _ => keyword(text).is_some_and(|(k, _)| k == "fn"),
        };
        if blanks == column && is_item {
            starts.push((index + 1, at));
        }
        at += line.len();
    }
    let ends = starts.iter().skip(1).map(|(_, at)| *at);
    let spans = starts.iter().zip(ends.chain([code.len()]));
    spans
        .map(|((line, at), end)| (*line, &code[*at..end]))
        .collect()
}

/// The keyword of an item and what follows it.
fn keyword(text: &str) -> Option<(&str, &str)> {
    let mut rest = text;
    loop {
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'))?;
        let word = &rest[..end];
        let after = rest[end..].trim_start_matches('!').trim_start();
        let is_constant =
            word == "const" && !after.starts_with("fn ") && !after.starts_with("unsafe ");
        if KEYWORDS.contains(&word) && (word != "const" || is_constant) {
            return Some((word, after));
        }
        if !BEFORE.contains(&word) {
            return None;
        }
        rest = match after.strip_prefix('(') {
            Some(inner) => inner.split_once(')')?.1.trim_start(),
            None => after,
        };
        if let Some(quoted) = rest.strip_prefix('"') {
            rest = quoted.split_once('"')?.1.trim_start();
        }
    }
}

fn name_of(text: &str) -> Option<&str> {
    let (_, rest) = keyword(text)?;
    let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    Some(&rest[..end.unwrap_or(rest.len())])
}

/// The type that the head of an `impl` names, and whether it implements a trait.
fn implemented(head: &str) -> Option<(String, bool)> {
    let rest = head.trim_start_matches("unsafe ").strip_prefix("impl")?;
    let rest = match rest.strip_prefix('<') {
        None => rest,
        Some(generics) => {
            let mut depth = 1;
            let mut last = ' ';
            let close = generics.char_indices().find(|(_, c)| {
                let closes = *c == '>' && last != '-';
                depth += i32::from(*c == '<') - i32::from(closes);
                last = *c;
                depth == 0
            });
            &generics[close.map_or(0, |(at, _)| at + 1)..]
        }
    };
    let (of, is_trait) = match rest.split_once(" for ") {
        Some((_, of)) => (of, true),
        None => (rest, false),
    };
    let of = of.trim().trim_start_matches(['&', ' ']);
    let of = of.strip_prefix("mut ").unwrap_or(of);
    let end = of.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    Some((of[..end.unwrap_or(of.len())].to_owned(), is_trait))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_its_items_and_their_names() {
        let code = "pub(crate) const fn a(x: B) -> c::D {\n    x.e(0..Z)\n}\n\
                    impl<'a, T: Fn() -> U> Plain<'a, T> {\n    const K: V = W;\n    \
                    pub fn f(&self) -> G {\n        g()\n    }\n\n    fn h() {}\n}\n\
                    impl I for crate::j::J {\n    fn k() -> L {}\n}\npub const M: N = 1;\n";
        let found = items(code);
        let names: Vec<(&str, &Kind)> = found.iter().map(|i| (i.name.as_str(), &i.kind)).collect();
        let plain = || "Plain".to_owned();
        let expected = [
            ("a", Kind::Named),
            ("f", Kind::Method { of: plain() }),
            ("h", Kind::Method { of: plain() }),
            ("", Kind::Implementation { of: plain() }),
            (
                "",
                Kind::Implementation {
                    of: "crate::j::J".into(),
                },
            ),
            ("M", Kind::Named),
        ];
        assert_eq!(names.len(), expected.len(), "{names:?}");
        for (found, expected) in names.iter().zip(&expected) {
            assert_eq!((found.0, found.1), (expected.0, &expected.1));
        }
        assert!(found[0].paths.contains("c::D") && found[0].members.contains("e"));
        assert!(found[0].words.contains("B") && !found[0].words.contains("e"));
        assert!(found[0].words.contains("Z") && !found[0].members.contains("Z"));
        assert!(found[1].words.contains("G") && !found[1].words.contains("W"));
        assert!(found[3].words.contains("W"));
        assert!(found[4].words.contains("L"));
    }
}
