//! No cyclic imports between the files of a crate, so that a crate can be read from the bottom up.
//!
//! The imports of a file are the paths of its own crate, outside of its tests. A re-exported name
//! (`pub use`) counts as an import of the file that defines it. Imports of a module from the files
//! in its own folder do not count: these files may in turn use what the module defines.

use super::Fault;
use super::tree::Tree;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of re-exports that are followed for one name.
const MAX_HOPS: usize = 8;

/// Finds files that import each other, directly or indirectly.
pub(crate) fn circles(tree: &Tree) -> Vec<Fault> {
    let mut crates: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for (path, text) in tree.sources() {
        if let Some((root, inner)) = path.split_once("/src/") {
            crates.entry(root).or_default().push((inner, text));
        }
    }
    let of_crate = |(root, files): (&str, Vec<(&str, &str)>)| {
        let house = House::new(&files);
        let all = house.circles().into_iter();
        let fault = move |circle: Vec<String>| {
            let others = circle[1..].join(", ");
            let what = format!(
                "circular import through {others}; move the shared items to a module of their own"
            );
            Fault::file(&format!("{root}/src/{}", circle[0]), what)
        };
        all.map(fault).collect::<Vec<_>>()
    };
    crates.into_iter().flat_map(of_crate).collect()
}

/// The files of one crate by their module paths, such as `["crowd", "tick"]`.
struct House {
    files: BTreeMap<Vec<String>, File>,
}

struct File {
    name: String,
    /// Paths used by the file, from the root of the crate.
    paths: Vec<Vec<String>>,
    /// Re-exported names, with their paths.
    handed_on: BTreeMap<String, Vec<String>>,
    /// Modules of which all names are re-exported.
    handed_on_whole: Vec<Vec<String>>,
}

impl House {
    fn new(files: &[(&str, &str)]) -> Self {
        let file = |(name, text): &(&str, &str)| {
            let module = module_of(name);
            (module.clone(), File::new(name, text, &module))
        };
        Self {
            files: files.iter().map(file).collect(),
        }
    }

    /// Returns the cycles of files, each sorted by name.
    fn circles(&self) -> Vec<Vec<String>> {
        let edges: BTreeMap<&Vec<String>, BTreeSet<&Vec<String>>> = self
            .files
            .iter()
            .map(|(module, file)| {
                let all = file.paths.iter().filter_map(|p| self.definer(p));
                (module, all.filter(|to| !to.starts_with(module)).collect())
            })
            .collect();
        let reached = |from: &Vec<String>| {
            let mut seen: BTreeSet<&Vec<String>> = BTreeSet::new();
            let mut next: Vec<&Vec<String>> = edges[from].iter().copied().collect();
            while let Some(at) = next.pop() {
                if seen.insert(at) {
                    next.extend(&edges[at]);
                }
            }
            seen
        };
        let reach: BTreeMap<&Vec<String>, BTreeSet<&Vec<String>>> =
            edges.keys().map(|m| (*m, reached(m))).collect();
        let mut told = BTreeSet::new();
        let mut circles = Vec::new();
        for (module, reached) in &reach {
            if reached.contains(module) && !told.contains(module) {
                let also = reached.iter().filter(|m| reach[*m].contains(module));
                let circle: BTreeSet<&Vec<String>> = also.copied().collect();
                told.extend(circle.iter().copied());
                let mut names: Vec<String> =
                    circle.iter().map(|m| self.files[*m].name.clone()).collect();
                names.sort();
                circles.push(names);
            }
        }
        circles
    }

    /// Returns the module whose file defines the target of a path.
    fn definer(&self, path: &[String]) -> Option<&Vec<String>> {
        let mut path = path.to_vec();
        for _ in 0..MAX_HOPS {
            let depth = (0..=path.len()).rev();
            let module = depth
                .map(|d| &path[..d])
                .find(|m| self.files.contains_key(*m))?;
            let (module, file) = self.files.get_key_value(module)?;
            let rest = &path[module.len()..];
            let Some(name) = rest.first() else {
                return Some(module);
            };
            let whole = || {
                let mut from = file.handed_on_whole.iter();
                from.find(|m| self.files.get(*m).is_some_and(|f| f.defines(name)))
            };
            let from = match file.handed_on.get(name) {
                Some(from) => from.clone(),
                None => match whole() {
                    Some(module) => [module.as_slice(), std::slice::from_ref(name)].concat(),
                    None => return Some(module),
                },
            };
            path = [from.as_slice(), &rest[1..]].concat();
        }
        None
    }
}

impl File {
    fn new(name: &str, text: &str, module: &[String]) -> Self {
        let code = code_of(text);
        let mut file = Self {
            name: name.to_owned(),
            paths: Vec::new(),
            handed_on: BTreeMap::new(),
            handed_on_whole: Vec::new(),
        };
        let mut rest = String::new();
        let mut words = code.as_str();
        // Statements that begin with `use`, and the code between them.
        while let Some(at) = find_use(words) {
            rest.push_str(&words[..at]);
            let is_public = rest.trim_end().ends_with("pub") || rest.trim_end().ends_with(')');
            let statement = &words[at + 4..];
            let end = statement.find(';').unwrap_or(statement.len());
            let mut all = Vec::new();
            expand(&statement[..end], "", &mut all);
            for path in all {
                file.add(&path, module, is_public);
            }
            words = &statement[end..];
        }
        rest.push_str(words);
        for path in inline_paths(&rest) {
            file.add(&path, module, false);
        }
        file
    }

    fn add(&mut self, path: &str, module: &[String], is_public: bool) {
        let (path, alias) = path.split_once(" as ").unwrap_or((path, ""));
        let Some(full) = resolved(path.trim(), module) else {
            return;
        };
        let Some((last, above)) = full.split_last() else {
            return;
        };
        match (is_public, last.as_str()) {
            (true, "*") => self.handed_on_whole.push(above.to_vec()),
            (true, last) => {
                let name = if alias.is_empty() { last } else { alias.trim() };
                self.handed_on.insert(name.to_owned(), full.clone());
            }
            (false, "*") => self.paths.push(above.to_vec()),
            (false, _) => self.paths.push(full.clone()),
        }
    }

    fn defines(&self, name: &str) -> bool {
        self.handed_on.contains_key(name)
    }
}

/// Returns the module path of a file below `src`.
fn module_of(name: &str) -> Vec<String> {
    let stem = name.trim_end_matches(".rs");
    let parts = stem.split('/').map(str::to_owned);
    let mut parts: Vec<String> = parts.collect();
    let is_root = |p: &String| matches!(p.as_str(), "lib" | "main" | "mod");
    if parts.last().is_some_and(is_root) {
        parts.pop();
    }
    parts
}

/// Returns a path from the root of the crate; `None` for a path of another crate.
fn resolved(path: &str, module: &[String]) -> Option<Vec<String>> {
    let mut parts = path.split("::").map(str::trim).peekable();
    // A path with any other beginning names a child of this module, or another crate.
    let from_root = parts.next_if_eq(&"crate").is_some();
    let _ = parts.next_if_eq(&"self");
    let mut base = if from_root {
        Vec::new()
    } else {
        module.to_vec()
    };
    let is_relative = path.starts_with("crate") || path.starts_with("self");
    if !is_relative && !path.starts_with("super") && path.split("::").count() < 2 {
        return None;
    }
    while parts.next_if_eq(&"super").is_some() {
        base.pop()?;
    }
    base.extend(parts.filter(|p| *p != "self").map(str::to_owned));
    Some(base)
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
fn inline_paths(code: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = code.split(|c: char| !is_part(c));
    let ours = words.filter(|w| w.starts_with("crate::") || w.starts_with("super::"));
    ours.map(|w| w.trim_end_matches(':').to_owned()).collect()
}

/// Returns the code without comments and without the tests at its end.
fn code_of(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let lines = code
        .lines()
        .map(|l| l.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let texts: Vec<(String, &str)> = files
            .iter()
            .map(|(name, text)| (format!("crates/x/src/{name}"), *text))
            .collect();
        let texts: Vec<(&str, &str)> = texts.iter().map(|(n, t)| (n.as_str(), *t)).collect();
        let faults = circles(&Tree::of(&texts));
        faults.into_iter().map(|f| f.file).collect()
    }

    #[test]
    fn a_straight_line_is_no_circle() {
        let files = [
            ("lib.rs", "mod a;\nmod b;\npub use a::A;\npub use b::B;\n"),
            ("a.rs", "use crate::b::B;\npub struct A(B);\n"),
            (
                "b.rs",
                "pub struct B;\n#[cfg(test)]\nmod tests { use crate::a::A; }\n",
            ),
        ];
        assert!(found(&files).is_empty());
    }

    #[test]
    fn files_that_need_each_other_are_told_once() {
        let files = [
            ("a.rs", "use crate::{c::C, b::{B, other}};\n"),
            ("b.rs", "fn b() { super::a::call(); }\n"),
            ("c.rs", "pub struct C;\n"),
        ];
        assert_eq!(found(&files), ["crates/x/src/a.rs"]);
    }

    #[test]
    fn a_name_that_is_handed_on_leads_to_its_file() {
        let files = [
            (
                "m/mod.rs",
                "mod a;\nmod b;\npub use a::A;\npub(crate) use b::*;\nfn own() {}\n",
            ),
            ("m/a.rs", "use super::B;\npub struct A(B);\n"),
            ("m/b.rs", "pub struct B;\n"),
        ];
        assert!(found(&files).is_empty());
        let files = [
            ("m/mod.rs", "mod a;\nuse a::A;\npub struct Own(A);\n"),
            ("m/a.rs", "use super::Own;\npub struct A;\n"),
        ];
        assert!(found(&files).is_empty());
        let files = [
            ("m/mod.rs", "mod a;\npub use a::A;\n"),
            ("m/a.rs", "use crate::n::N;\npub struct A(N);\n"),
            ("n.rs", "use crate::m::A;\npub struct N;\n"),
        ];
        assert_eq!(found(&files), ["crates/x/src/m/a.rs"]);
    }
}
