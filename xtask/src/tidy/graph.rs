//! The items of the workspace and what each of them names.
//!
//! An item reaches another if it names it outside of tests and comments, by a path or by an import.
//! A type brings its implementations of traits, and those of its methods whose names some reached
//! item calls. Re-exports are followed and do not count as naming. This is an approximation: the
//! type of an expression is unknown, so a method counts as called if any method of that name is.

use super::imports::{Import, code_of, module_of, statements};
use super::items::{Item, Kind, items};
use super::tree::Tree;
use std::collections::{HashMap, HashSet};

/// Maximum number of re-exports that are followed for one name.
const MAX_HOPS: usize = 8;

/// The sources of the workspace, their items, and what each item names.
pub(super) struct Graph {
    pub(super) paths: Vec<String>,
    /// Module path of each file, with the crate in front; empty for examples, benches and fuzz
    /// targets.
    pub(super) modules: Vec<String>,
    index: HashMap<String, usize>,
    imports: Vec<Imports>,
    /// Items of all files, each with the index of its file.
    pub(super) items: Vec<(usize, Item)>,
    /// Names of the items of each file, with their groups.
    named: Vec<HashMap<String, usize>>,
    groups: Vec<Group>,
    /// Groups that each item names.
    edges: Vec<Vec<usize>>,
    /// Inherent methods by name, with the groups of their types.
    methods: HashMap<String, Vec<(usize, usize)>>,
}

/// A named item and what comes with it.
#[derive(Default)]
struct Group {
    /// The item; several where a file gives several one name.
    items: Vec<usize>,
    /// Implementations, without inherent methods.
    implementations: Vec<usize>,
    /// Inherent methods.
    methods: Vec<usize>,
}

/// Names that a file imports.
#[derive(Default)]
struct Imports {
    /// Full paths by the name that they have here.
    names: HashMap<String, String>,
    /// Modules of which all names are imported.
    whole: Vec<String>,
    /// Re-exported names, with their full paths.
    handed_on: HashMap<String, String>,
    /// Modules of which all names are re-exported.
    handed_on_whole: Vec<String>,
}

impl Graph {
    pub(super) fn new(tree: &Tree) -> Self {
        let mut graph = Self {
            paths: Vec::new(),
            modules: Vec::new(),
            index: HashMap::new(),
            imports: Vec::new(),
            items: Vec::new(),
            named: Vec::new(),
            groups: Vec::new(),
            edges: Vec::new(),
            methods: HashMap::new(),
        };
        let mut statements_of = Vec::new();
        let tests = test_modules(tree);
        for (path, text) in tree.sources() {
            let Some(module) = module_path(path) else {
                continue;
            };
            if tests.iter().any(|test| is_below(&module, test)) {
                continue;
            }
            let file = graph.paths.len();
            if !module.is_empty() {
                graph.index.insert(module.clone(), file);
            }
            graph.paths.push(path.to_owned());
            graph.modules.push(module);
            let (imports, rest) = statements(&code_of(text));
            statements_of.push(imports);
            let is_program = graph.modules[file].is_empty();
            // Not all of such a file need be items: a fuzz target is the call of a macro.
            let all = if is_program {
                vec![Item::whole(&rest)]
            } else {
                items(&rest)
            };
            graph.items.extend(all.into_iter().map(|item| (file, item)));
        }
        graph.named = vec![HashMap::new(); graph.paths.len()];
        for (i, (file, item)) in graph.items.iter().enumerate() {
            if item.kind != Kind::Named {
                continue;
            }
            let of_file = &mut graph.named[*file];
            let group = *of_file.entry(item.name.clone()).or_insert_with(|| {
                graph.groups.push(Group::default());
                graph.groups.len() - 1
            });
            graph.groups[group].items.push(i);
        }
        for (file, imports) in statements_of.iter().enumerate() {
            let imports = graph.imports_of(file, imports);
            graph.imports.push(imports);
        }
        for (i, (file, item)) in graph.items.iter().enumerate() {
            let (Kind::Implementation { of } | Kind::Method { of }) = &item.kind else {
                continue;
            };
            let Some(group) = graph.defined(*file, of) else {
                continue;
            };
            if item.name.is_empty() {
                graph.groups[group].implementations.push(i);
            } else {
                graph.groups[group].methods.push(i);
                let all = graph.methods.entry(item.name.clone()).or_default();
                all.push((group, i));
            }
        }
        graph.edges = graph
            .items
            .iter()
            .map(|(f, item)| graph.names(*f, item))
            .collect();
        graph
    }

    /// The groups that an item names.
    fn names(&self, file: usize, item: &Item) -> Vec<usize> {
        let all = item.words.iter().chain(&item.paths);
        let mut found: Vec<usize> = all.filter_map(|name| self.defined(file, name)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    fn imports_of(&self, file: usize, statements: &[Import]) -> Imports {
        let mut out = Imports::default();
        for import in statements {
            for path in &import.paths {
                let (path, alias) = path.split_once(" as ").unwrap_or((path, ""));
                let path = path.trim().trim_end_matches("::self");
                let Some(full) = self.full(file, path) else {
                    continue;
                };
                let (above, last) = full.rsplit_once("::").unwrap_or(("", &full));
                let name = if alias.is_empty() { last } else { alias.trim() };
                match (import.is_public, last) {
                    (true, "*") => out.handed_on_whole.push(above.to_owned()),
                    (true, _) => drop(out.handed_on.insert(name.to_owned(), full.clone())),
                    (false, "*") => out.whole.push(above.to_owned()),
                    (false, _) => drop(out.names.insert(name.to_owned(), full.clone())),
                }
            }
        }
        out
    }

    /// The full path of a path that a file uses; `None` outside of the workspace.
    fn full(&self, file: usize, path: &str) -> Option<String> {
        let module = &self.modules[file];
        let own = module.split("::").next().unwrap_or_default();
        let (first, rest) = path.split_once("::").unwrap_or((path, ""));
        let joined = |base: &str| match rest {
            "" => base.to_owned(),
            rest => format!("{base}::{rest}"),
        };
        match first {
            "crate" => Some(joined(own)),
            "self" => Some(joined(module)),
            "super" => {
                let mut base = module.as_str();
                let mut rest = path;
                while let Some(below) = rest.strip_prefix("super") {
                    base = base.rsplit_once("::")?.0;
                    rest = below.trim_start_matches("::");
                }
                Some(format!("{base}::{rest}").trim_end_matches(':').to_owned())
            }
            _ if self.index.contains_key(first) => Some(path.to_owned()),
            _ => {
                let child = format!("{module}::{first}");
                self.index.contains_key(&child).then(|| joined(&child))
            }
        }
    }

    /// The group that a name or a path of a file means, if it is one of the workspace.
    fn defined(&self, file: usize, path: &str) -> Option<usize> {
        let (first, rest) = path.split_once("::").unwrap_or((path, ""));
        if let Some(own) = self.named[file].get(first) {
            return Some(*own);
        }
        let imports = &self.imports[file];
        let alias = imports.names.get(first).or(imports.handed_on.get(first));
        let full = match (alias, rest) {
            (Some(alias), "") => Some(alias.clone()),
            (Some(alias), rest) => Some(format!("{alias}::{rest}")),
            (None, _) => self.full(file, path),
        };
        let by_glob = || {
            let mut all = imports.whole.iter();
            all.find_map(|module| self.definer(&format!("{module}::{path}")))
        };
        full.and_then(|full| self.definer(&full)).or_else(by_glob)
    }

    /// The items that a full path names, which may be methods of a type; none if there are none of
    /// that name.
    pub(super) fn meant(&self, path: &str) -> Vec<usize> {
        let group = |path: &str| self.definer(path).map(|group| &self.groups[group]);
        let Some(whole) = group(path) else {
            return Vec::new();
        };
        let name = path.rsplit("::").next().unwrap_or_default();
        let is_of = |i: &&usize| self.items[**i].1.name == name;
        let own: Vec<usize> = whole.items.iter().filter(is_of).copied().collect();
        if !own.is_empty() {
            return own;
        }
        whole.methods.iter().filter(is_of).copied().collect()
    }

    /// The type of a method.
    pub(super) fn type_of(&self, item: usize) -> Option<usize> {
        let (file, Item { kind, .. }) = &self.items[item];
        let Kind::Method { of } = kind else {
            return None;
        };
        let group = &self.groups[self.defined(*file, of)?];
        group.items.first().copied()
    }

    /// The items that those of another crate name, or those of a program.
    pub(super) fn named_by_other_crates(&self) -> HashSet<usize> {
        let crate_of = |file: usize| self.modules[file].split("::").next();
        let mut named = HashSet::new();
        for ((from, _), edges) in self.items.iter().zip(&self.edges) {
            let items = edges.iter().flat_map(|group| &self.groups[*group].items);
            named.extend(items.filter(|i| crate_of(self.items[**i].0) != crate_of(*from)));
        }
        named
    }

    /// The group of a full path.
    fn definer(&self, path: &str) -> Option<usize> {
        let mut path = path.to_owned();
        for _ in 0..MAX_HOPS {
            // A module and an item may have the same name, so the last word is never a module.
            let mut end = path.rfind("::")?;
            let file = loop {
                if let Some(file) = self.index.get(&path[..end]) {
                    break *file;
                }
                end = path[..end].rfind("::")?;
            };
            let rest = path[end..].trim_start_matches("::");
            let (name, below) = rest.split_once("::").unwrap_or((rest, ""));
            if let Some(group) = self.named[file].get(name) {
                return Some(*group);
            }
            let from = self.imports.get(file)?;
            let whole = || {
                let has = |m: &&String| {
                    let found = self.index.get(*m).copied();
                    found.is_some_and(|f| {
                        let handed_on = |i: &Imports| i.handed_on.contains_key(name);
                        self.named[f].contains_key(name)
                            || self.imports.get(f).is_some_and(handed_on)
                    })
                };
                let module = from.handed_on_whole.iter().find(has);
                module.map(|m| format!("{m}::{name}"))
            };
            let next = from.handed_on.get(name).cloned().or_else(whole)?;
            path = match below {
                "" => next,
                below => format!("{next}::{below}"),
            };
        }
        None
    }

    /// Whether each item is reached from some, these included.
    pub(super) fn reached(&self, start: &[usize]) -> Vec<bool> {
        let mut search = Search {
            seen: vec![false; self.items.len()],
            groups: vec![false; self.groups.len()],
            members: HashSet::new(),
            next: start.to_vec(),
        };
        while let Some(i) = search.next.pop() {
            if std::mem::replace(&mut search.seen[i], true) {
                continue;
            }
            let (file, item) = &self.items[i];
            let own = self.named[*file].get(&item.name);
            for group in own.into_iter().chain(&self.edges[i]) {
                search.meet(self, *group);
            }
            for member in &item.members {
                if search.members.insert(member) {
                    let methods = self.methods.get(member).into_iter().flatten();
                    let known = methods.filter(|(of, _)| search.groups[*of]);
                    search.next.extend(known.map(|(_, method)| method));
                }
            }
        }
        search.seen
    }
}

/// What was found so far.
struct Search<'a> {
    seen: Vec<bool>,
    groups: Vec<bool>,
    members: HashSet<&'a str>,
    next: Vec<usize>,
}

impl Search<'_> {
    /// Adds an item with its implementations, and those of its methods that are called somewhere.
    fn meet(&mut self, graph: &Graph, group: usize) {
        if std::mem::replace(&mut self.groups[group], true) {
            return;
        }
        let group = &graph.groups[group];
        self.next.extend(&group.items);
        self.next.extend(&group.implementations);
        let is_called = |i: &&usize| self.members.contains(graph.items[**i].1.name.as_str());
        let called: Vec<usize> = group.methods.iter().filter(is_called).copied().collect();
        self.next.extend(called);
    }
}

/// Whether a module is another or lies in it.
pub(super) fn is_below(module: &str, above: &str) -> bool {
    let rest = module.strip_prefix(above);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}

/// Modules that are compiled for tests alone and have files of their own.
fn test_modules(tree: &Tree) -> Vec<String> {
    const MARK: &str = "#[cfg(test)]\n";
    let mut out = Vec::new();
    for (path, text) in tree.sources() {
        let Some(module) = module_path(path) else {
            continue;
        };
        for (at, _) in text.match_indices(MARK) {
            let line = text[at + MARK.len()..].lines().next().unwrap_or_default();
            let name = line.strip_suffix(';').and_then(|l| l.rsplit_once("mod "));
            if let Some((_, name)) = name {
                out.push(format!("{module}::{name}"));
            }
        }
    }
    out
}

/// Module path of a source with its crate in front; empty for an example, a bench or a fuzz target,
/// `None` for tests and for sources outside of the crates.
fn module_path(path: &str) -> Option<String> {
    if path.starts_with("fuzz/fuzz_targets/") {
        return Some(String::new());
    }
    let inner = path.strip_prefix("crates/")?;
    if inner.contains("/examples/") || inner.contains("/benches/") {
        return Some(String::new());
    }
    let (name, file) = inner.split_once("/src/")?;
    let mut parts = vec![name.replace('-', "_")];
    parts.extend(module_of(file));
    Some(parts.join("::"))
}
