//! Imports and paths of Rust sources, as text.

/// A `use` statement with its groups expanded.
pub(super) struct Import {
    /// Paths as written, `a::b` or `a::b as c`.
    pub(super) paths: Vec<String>,
    /// Whether the names are re-exported.
    pub(super) is_public: bool,
}

/// Splits code into its `use` statements and the rest, in which every line keeps its number.
pub(super) fn statements(code: &str) -> (Vec<Import>, String) {
    let mut imports = Vec::new();
    let mut rest = String::new();
    let mut words = code;
    while let Some(at) = find_use(words) {
        rest.push_str(&words[..at]);
        let is_public = rest.trim_end().ends_with("pub") || rest.trim_end().ends_with(')');
        let statement = &words[at + 4..];
        let end = statement.find(';').unwrap_or(statement.len());
        let mut paths = Vec::new();
        expand(&statement[..end], "", &mut paths);
        imports.push(Import { paths, is_public });
        let lines = statement[..end].matches('\n');
        rest.extend(lines);
        words = &statement[end..];
    }
    rest.push_str(words);
    (imports, rest)
}

/// Returns the module path of a file below `src`.
pub(super) fn module_of(name: &str) -> Vec<String> {
    let stem = name.trim_end_matches(".rs");
    let parts = stem.split('/').map(str::to_owned);
    let mut parts: Vec<String> = parts.collect();
    let is_root = |p: &String| matches!(p.as_str(), "lib" | "main" | "mod");
    if parts.last().is_some_and(is_root) {
        parts.pop();
    }
    parts
}

/// Appends all paths of a `use`, with groups expanded.
fn expand(text: &str, before: &str, out: &mut Vec<String>) {
    let text = text.trim();
    let Some(open) = text.find('{') else {
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            out.push(format!("{before}{part}"));
        }
        return;
    };
    // Parts before the first group, then the group with its own prefix, then the rest.
    let (head, rest) = text.split_at(open);
    let (plain, prefix) = head.rsplit_once(',').map_or(("", head), |(p, q)| (p, q));
    expand(plain, before, out);
    let mut depth = 0usize;
    let close = rest.char_indices().find(|(_, c)| {
        depth = match c {
            '{' => depth + 1,
            '}' => depth - 1,
            _ => depth,
        };
        depth == 0
    });
    let close = close.map_or(rest.len(), |(at, _)| at);
    let inner = rest.get(1..close).unwrap_or_default();
    let prefix = format!("{before}{}", prefix.trim());
    let mut level = 0i32;
    let mut start = 0;
    for (at, c) in inner.char_indices().chain([(inner.len(), ',')]) {
        match c {
            '{' => level += 1,
            '}' => level -= 1,
            ',' if level == 0 => {
                expand(&inner[start..at], &prefix, out);
                start = at + 1;
            }
            _ => {}
        }
    }
    expand(rest.get(close + 1..).unwrap_or_default(), before, out);
}

/// Returns the position of the next `use …` statement.
fn find_use(code: &str) -> Option<usize> {
    let starts = |at: usize| {
        let before = code[..at].trim_end();
        before.is_empty() || before.ends_with([';', '}', '{', ']', ')']) || before.ends_with("pub")
    };
    let mut from = 0;
    while let Some(found) = code[from..].find("use ") {
        let at = from + found;
        let is_word = !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if is_word && starts(at) {
            return Some(at);
        }
        from = at + 4;
    }
    None
}

/// Returns the paths in code that begin with `crate::` or `super::`.
pub(super) fn inline_paths(code: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = code.split(|c: char| !is_part(c));
    let ours = words.filter(|w| w.starts_with("crate::") || w.starts_with("super::"));
    ours.map(|w| w.trim_end_matches(':').to_owned()).collect()
}

/// Returns the code without comments and without the tests at its end.
pub(super) fn code_of(text: &str) -> String {
    let code = match tests_at(text) {
        Some(at) => &text[..at],
        None => text,
    };
    let lines = code
        .lines()
        .map(|l| l.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns the tests at the end of a source.
pub(super) fn tests_of(text: &str) -> &str {
    tests_at(text).map_or("", |at| &text[at..])
}

/// Returns the position of the first module of tests that has a body.
fn tests_at(text: &str) -> Option<usize> {
    const MARK: &str = "#[cfg(test)]\nmod ";
    let marks = text.match_indices(MARK);
    let has_body = |at: usize| {
        let rest = &text[at + MARK.len()..];
        rest.find(['{', ';'])
            .is_some_and(|i| rest[i..].starts_with('{'))
    };
    let mut positions = marks.map(|(at, _)| at);
    positions.find(|at| has_body(*at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_expanded_and_tests_are_left_out() {
        let text = "mod a; // use x;\n#[cfg(test)]\nmod slow;\npub use a::{B, c::{D, E as F}};\n\
                    fn f() { a::g(); }\n#[cfg(test)]\nmod tests {\n    use super::*;\n}\n";
        let (imports, rest) = statements(&code_of(text));
        assert_eq!(imports.len(), 1);
        assert!(imports[0].is_public);
        assert_eq!(imports[0].paths, ["a::B", "a::c::D", "a::c::E as F"]);
        assert!(rest.contains("a::g()") && !rest.contains("tests"));
    }
}
