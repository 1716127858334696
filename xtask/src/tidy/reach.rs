//! Modules of the thesis map that a command or an example reaches.
//!
//! An item reaches another if it names it outside of tests and comments, by a path or by an import.
//! A type brings its implementations of traits, and those of its methods whose names some reached
//! item calls. Re-exports are followed and do not count as naming. This is an approximation: the
//! type of an expression is unknown, so a method counts as called if any method of that name is.

use super::Fault;
use super::imports::{Import, code_of, module_of, statements};
use super::items::{Item, Kind, items};
use super::record::{THESIS_MAP, map_rows, quoted};
use super::tree::Tree;
use std::collections::{BTreeMap, HashMap, HashSet};

/// The crate of the command line, and the folder of its commands.
const COMMANDS: &str = "crates/articula-cli/src/commands/";

/// Crate of measurements, whose modules are reached by no command.
const LAB: &str = "articula_lab";

/// Maximum number of re-exports that are followed for one name.
const MAX_HOPS: usize = 8;

/// Finds rows of the thesis map whose modules the commands and examples named in the row do not
/// reach.
///
/// The cell `reached by` has commands (`lod`, `convert --mesh-level`) and examples
/// (`example hero`) in backquotes. A command is a module of `articula-cli`, a flag is one of its
/// arguments. Modules of the lab need no command, but a row needs a module of another crate.
pub(crate) fn thesis_map(tree: &Tree) -> Vec<Fault> {
    let Some(text) = tree.text(THESIS_MAP) else {
        return Vec::new();
    };
    let graph = Graph::new(tree);
    let mut reached: BTreeMap<String, Option<HashSet<usize>>> = BTreeMap::new();
    let mut faults = Vec::new();
    for (line, [_, modules, _, doors, _]) in map_rows(text) {
        let mut wrong = |what: String| faults.push(Fault::line(THESIS_MAP, line, what));
        let mut found: HashSet<usize> = HashSet::new();
        let doors = quoted(doors);
        if doors.is_empty() {
            wrong("a row must name a command or an example in backquotes".to_owned());
            continue;
        }
        for door in doors {
            let files = reached
                .entry(door.to_owned())
                .or_insert_with(|| graph.door(tree, door));
            match files {
                Some(files) => found.extend(files.iter()),
                None => wrong(format!("there is no command or example {door}")),
            }
        }
        let modules: Vec<&str> = quoted(modules)
            .into_iter()
            .filter(|m| !m.starts_with(LAB))
            .collect();
        if modules.is_empty() {
            wrong("a row must name a module outside of the lab".to_owned());
        }
        for module in modules {
            if !graph.files_of(module).any(|f| found.contains(&f)) {
                let what = "is reached by no command or example of the row";
                wrong(format!("module {module} {what}"));
            }
        }
    }
    faults
}

/// The sources of the workspace, their items, and what each item names.
struct Graph {
    paths: Vec<String>,
    /// Module path of each file, with the crate in front; empty for examples.
    modules: Vec<String>,
    index: HashMap<String, usize>,
    imports: Vec<Imports>,
    /// Items of all files.
    items: Vec<(usize, Item)>,
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
    fn new(tree: &Tree) -> Self {
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
        for (path, text) in tree.sources() {
            let Some(module) = module_path(path) else {
                continue;
            };
            let file = graph.paths.len();
            if !module.is_empty() {
                graph.index.insert(module.clone(), file);
            }
            graph.paths.push(path.to_owned());
            graph.modules.push(module);
            let (imports, rest) = statements(&code_of(text));
            statements_of.push(imports);
            graph
                .items
                .extend(items(&rest).into_iter().map(|item| (file, item)));
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

    /// The files with an item that a command or an example reaches; `None` if there is none of that
    /// name, or a flag does not exist.
    fn door(&self, tree: &Tree, door: &str) -> Option<HashSet<usize>> {
        let mut words = door.split_whitespace();
        let name = words.next()?;
        let is_of: Box<dyn Fn(&str) -> bool> = if name == "example" {
            let file = format!("crates/articula/examples/{}.rs", words.next()?);
            Box::new(move |path| path == file)
        } else {
            let (file, folder) = (format!("{COMMANDS}{name}.rs"), format!("{COMMANDS}{name}/"));
            Box::new(move |path| path == file || path.starts_with(&folder))
        };
        let start: Vec<usize> = (0..self.items.len())
            .filter(|i| is_of(&self.paths[self.items[*i].0]))
            .collect();
        let files = self.reached(&start);
        let in_program = |f: &&usize| self.paths[**f].starts_with("crates/articula-cli/");
        let has_flag = |flag: &str| {
            let field = format!(" {}:", flag.replace('-', "_"));
            let long = format!("long = \"{flag}\"");
            let texts = files.iter().filter(in_program);
            let mut texts = texts.filter_map(|f| tree.text(&self.paths[*f]));
            texts.any(|text| text.contains(&field) || text.contains(&long))
        };
        let mut flags = words.filter_map(|w| w.strip_prefix("--"));
        (!start.is_empty() && flags.all(has_flag)).then_some(files)
    }

    /// The files of all items that are reached from some.
    fn reached(&self, start: &[usize]) -> HashSet<usize> {
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
        let seen = search.seen.iter().zip(&self.items);
        seen.filter(|(seen, _)| **seen)
            .map(|(_, (file, _))| *file)
            .collect()
    }

    /// The files of a module: its own and, for a folder, all below it.
    fn files_of<'a>(&'a self, module: &'a str) -> impl Iterator<Item = usize> + 'a {
        let below = format!("{module}::");
        self.modules.iter().enumerate().filter_map(move |(f, m)| {
            let is_own = m == module || m.starts_with(&below) || self.paths[f] == module;
            is_own.then_some(f)
        })
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

/// Module path of a source with its crate in front; empty for an example, `None` for tests and for
/// sources outside of the crates.
fn module_path(path: &str) -> Option<String> {
    let inner = path.strip_prefix("crates/")?;
    if inner.contains("/examples/") {
        return Some(String::new());
    }
    let (name, file) = inner.split_once("/src/")?;
    let mut parts = vec![name.replace('-', "_")];
    parts.extend(module_of(file));
    Some(parts.join("::"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faults of a map with one row; `cli` is the code of the command `play`.
    fn faults(row: &str, cli: &str) -> Vec<String> {
        let map = format!(
            "| section | module | test | reached by | difference |\n|---|---|---|---|---|\n{row}\n"
        );
        let lib = "mod held;\nmod moved;\npub mod open;\npub use held::Hold;\npub use moved::*;\n";
        let files = [
            (THESIS_MAP, map.as_str()),
            ("crates/articula-core/src/lib.rs", lib),
            (
                "crates/articula-core/src/held.rs",
                "pub struct Hold;\nimpl Hold {\n    pub fn rest(&self) {}\n}\n",
            ),
            (
                "crates/articula-core/src/moved.rs",
                "use crate::open::deep::Ease;\npub fn moved(e: Ease) {}\n",
            ),
            ("crates/articula-core/src/open/mod.rs", "pub mod deep;\n"),
            (
                "crates/articula-core/src/open/deep.rs",
                "pub enum Ease { Linear }\n",
            ),
            ("crates/articula-cli/src/commands/play.rs", cli),
            (
                "crates/articula/examples/hero.rs",
                "fn main() { articula_core::open::deep::Ease::Linear; }\n",
            ),
        ];
        let faults = thesis_map(&Tree::of(&files)).into_iter();
        faults.map(|f| f.what).collect()
    }

    fn row(module: &str, door: &str) -> String {
        format!("| 5.1 | `{module}` | `t` | `{door}` | – |")
    }

    #[test]
    fn what_a_command_names_is_reached() {
        let held = row("articula_core::held", "play");
        let by_import = "use articula_core::Hold;\nfn f(_: Hold) {}\n";
        assert_eq!(faults(&held, by_import).len(), 0);
        let inline = "fn f() { articula_core::Hold.rest(); }\n";
        assert_eq!(faults(&held, inline).len(), 0);
        let file = row("crates/articula-core/src/held.rs", "play");
        assert_eq!(faults(&file, inline).len(), 0);
        // Through another item, and a folder by a file in it.
        let moved = "use articula_core::moved;\nfn f() { moved(); }\n";
        for module in ["articula_core::open::deep", "articula_core::open"] {
            assert_eq!(faults(&row(module, "play"), moved).len(), 0);
            assert_eq!(faults(&row(module, "example hero"), "").len(), 0);
        }
        let alias = "use articula_core::open::{self};\nfn f() { open::deep::Ease::Linear; }\n";
        let deep = row("articula_core::open::deep", "play");
        assert_eq!(faults(&deep, alias).len(), 0);
    }

    #[test]
    fn what_nobody_names_is_told() {
        let held = row("articula_core::held", "play");
        let unreached = "module articula_core::held is reached by no command or example of the row";
        let told = |cli: &str| assert_eq!(faults(&held, cli), [unreached], "{cli}");
        told("fn f() {}\n");
        told("fn f() {} // articula_core::Hold\n");
        told("fn f() {}\n#[cfg(test)]\nmod tests {\n    fn f() { articula_core::Hold; }\n}\n");
        told("use articula_core::moved;\nfn f() { moved(); }\n");
        told("pub use articula_core::Hold;\nfn f() {}\n");
        // A method of a type that nothing names.
        told("fn f(x: X) { x.rest(); }\n");
        let door = |door| {
            let cli = "fn f() { articula_core::Hold; }\n";
            faults(&row("articula_core::held", door), cli)
        };
        assert_eq!(door("example hero"), [unreached]);
    }

    #[test]
    fn a_method_is_reached_if_it_is_called() {
        // `Hold::rest` names what its type does not.
        let lib = "mod held;\nmod kept;\npub use held::Hold;\n";
        let of = |cli: &str| {
            let map = "| s | module | t | r | d |\n|--|--|--|--|--|\n\
                       | 5 | `articula_core::kept` | `t` | `play` | – |\n";
            let hold = "pub struct Hold;\n\nimpl Hold {\n    pub fn rest(&self) {\n        \
                        crate::kept::keep();\n    }\n\n    pub fn go(&self) {}\n}\n";
            let files = [
                (THESIS_MAP, map),
                ("crates/articula-core/src/lib.rs", lib),
                ("crates/articula-core/src/held.rs", hold),
                ("crates/articula-core/src/kept.rs", "pub fn keep() {}\n"),
                ("crates/articula-cli/src/commands/play.rs", cli),
            ];
            thesis_map(&Tree::of(&files)).len()
        };
        assert_eq!(of("fn f(h: articula_core::Hold) { h.rest(); }\n"), 0);
        assert_eq!(of("fn f() { articula_core::Hold::rest(); }\n"), 0);
        assert_eq!(of("fn f(h: articula_core::Hold) { h.go(); }\n"), 1);
    }

    #[test]
    fn doors_and_flags_exist() {
        let cli = "struct Args {\n    far_from: articula_core::Hold,\n}\n";
        let door = |door| faults(&row("articula_core::held", door), cli);
        assert_eq!(door("play --far-from").len(), 0);
        assert_eq!(
            door("play --near")[0],
            "there is no command or example play --near"
        );
        assert_eq!(door("sing")[0], "there is no command or example sing");
        assert_eq!(
            door("example sing")[0],
            "there is no command or example example sing"
        );
        let none = "| 5.1 | `articula_core::held` | `t` | by hand | – |";
        assert!(faults(none, cli)[0].contains("must name a command"));
        let lab = row("articula_lab::tables", "play");
        assert!(faults(&lab, cli)[0].contains("outside of the lab"));
    }
}
