//! Modules of the thesis map that a command or an example reaches.

use super::Fault;
use super::graph::{Graph, is_below};
use super::items::{Item, Kind};
use super::record::{THESIS_MAP, map_rows, quoted};
use super::tree::Tree;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// The crate of the command line, and the folder of its commands.
const COMMANDS: &str = "crates/articula-cli/src/commands/";

/// Crate of measurements, whose modules are reached by no command.
const LAB: &str = "articula_lab";

/// Finds rows of the thesis map whose modules and items do not exist, or are not reached by the
/// commands and examples that the row names.
///
/// The cell `reached by` has commands (`lod`, `convert --mesh-level`) and examples
/// (`example hero`) in backquotes. A command is a module of `articula-cli`, a flag is one of its
/// arguments. The cell `module` has modules, of which every type, function and constant that is
/// public must be reached, and of each file below at least one; or single items
/// (`articula_stream::decide::NetworkShare`), which narrow the row to these. Modules of the lab need
/// no command, but a row needs a module of another crate.
pub(crate) fn thesis_map(tree: &Tree) -> Vec<Fault> {
    let Some(text) = tree.text(THESIS_MAP) else {
        return Vec::new();
    };
    let graph = Graph::new(tree);
    let mut reached: BTreeMap<String, Option<Vec<bool>>> = BTreeMap::new();
    let mut faults = Vec::new();
    for (line, [_, modules, _, doors, _]) in map_rows(text) {
        let mut wrong = |what: String| faults.push(Fault::line(THESIS_MAP, line, what));
        let mut found = vec![false; graph.items.len()];
        let doors = quoted(doors);
        if doors.is_empty() {
            wrong("a row must name a command or an example in backquotes".to_owned());
            continue;
        }
        for door in doors {
            let items = reached
                .entry(door.to_owned())
                .or_insert_with(|| behind(&graph, tree, door));
            match items {
                Some(items) => found.iter_mut().zip(items).for_each(|(f, i)| *f |= *i),
                None => wrong(format!("there is no command or example {door}")),
            }
        }
        let mut is_lab = true;
        for name in quoted(modules) {
            let unreached = unreached(&graph, name, &found);
            match unreached {
                None => wrong(format!("there is no module or item {name}")),
                Some(_) if name.starts_with(LAB) => continue,
                Some(Unreached::Nothing) => {}
                Some(Unreached::All) => wrong(format!("{name} is {UNREACHED}")),
                Some(Unreached::Some(items)) => {
                    let of = items.join(", ");
                    let mend = "name the items that are meant, or who reaches these";
                    wrong(format!("of {name}, {of} is {UNREACHED}; {mend}"));
                }
            }
            is_lab = false;
        }
        if is_lab {
            wrong("a row must name a module outside of the lab".to_owned());
        }
    }
    faults
}

const UNREACHED: &str = "reached by no command or example of the row";

/// What of a module or item is not reached.
enum Unreached {
    Nothing,
    Some(Vec<String>),
    All,
}

/// What of a module, a file or an item is not found; `None` if there is no such thing.
fn unreached(graph: &Graph, name: &str, found: &[bool]) -> Option<Unreached> {
    let is_own = |file: usize| graph.modules[file] == name || graph.paths[file] == name;
    let files = 0..graph.modules.len();
    let files = files.filter(|f| is_own(*f) || is_below(&graph.modules[*f], name));
    let files: BTreeSet<usize> = files.collect();
    if files.is_empty() {
        let items = graph.meant(name);
        return Some(match items.iter().any(|i| found[*i]) {
            _ if items.is_empty() => return None,
            true => Unreached::Nothing,
            false => Unreached::All,
        });
    }
    let all = graph.items.iter().zip(found);
    let of_module = all.filter(|((file, _), _)| files.contains(file));
    if !of_module.clone().any(|(_, is_found)| *is_found) {
        return Some(Unreached::All);
    }
    let mut missing = Vec::new();
    for file in &files {
        let of_file = of_module.clone().filter(|((f, _), _)| f == file);
        let public = of_file.filter(|((_, i), _)| i.is_public && i.kind == Kind::Named);
        let unfound = public.clone().filter(|(_, is_found)| !**is_found);
        let place = |item: &Item| format!("{} ({}:{})", item.name, graph.paths[*file], item.line);
        if is_own(*file) {
            missing.extend(unfound.map(|((_, item), _)| place(item)));
        } else if unfound.clone().count() == public.count()
            && let Some(((_, item), _)) = unfound.clone().next()
        {
            missing.push(place(item));
        }
    }
    Some(match missing.is_empty() {
        true => Unreached::Nothing,
        false => Unreached::Some(missing),
    })
}

/// The items that a command or an example reaches; `None` if there is none of that
/// name, or a flag does not exist.
fn behind(graph: &Graph, tree: &Tree, door: &str) -> Option<Vec<bool>> {
    let mut words = door.split_whitespace();
    let name = words.next()?;
    let is_of: Box<dyn Fn(&str) -> bool> = if name == "example" {
        let file = format!("crates/articula/examples/{}.rs", words.next()?);
        Box::new(move |path| path == file)
    } else {
        let (file, folder) = (format!("{COMMANDS}{name}.rs"), format!("{COMMANDS}{name}/"));
        Box::new(move |path| path == file || path.starts_with(&folder))
    };
    let start: Vec<usize> = (0..graph.items.len())
        .filter(|i| is_of(&graph.paths[graph.items[*i].0]))
        .collect();
    let items = graph.reached(&start);
    let seen = items.iter().zip(&graph.items).filter(|(seen, _)| **seen);
    let files: HashSet<usize> = seen.map(|(_, (file, _))| *file).collect();
    let in_program = |f: &&usize| graph.paths[**f].starts_with("crates/articula-cli/");
    let has_flag = |flag: &str| {
        let field = format!(" {}:", flag.replace('-', "_"));
        let long = format!("long = \"{flag}\"");
        let texts = files.iter().filter(in_program);
        let mut texts = texts.filter_map(|f| tree.text(&graph.paths[*f]));
        texts.any(|text| text.contains(&field) || text.contains(&long))
    };
    let mut flags = words.filter_map(|w| w.strip_prefix("--"));
    (!start.is_empty() && flags.all(has_flag)).then_some(items)
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
            ("crates/articula-lab/src/tables.rs", "fn row() {}\n"),
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
        let unreached = "articula_core::held is reached by no command or example of the row";
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
    fn all_of_a_module_or_the_items_of_the_row_are_reached() {
        let told = |module: &str, cli: &str| {
            let map = format!(
                "| s | module | t | r | d |\n|--|--|--|--|--|\n\
                 | 5 | `{module}` | `t` | `play` | – |\n"
            );
            let files = [
                (THESIS_MAP, map.as_str()),
                (
                    "crates/articula-core/src/lib.rs",
                    "mod ratio;\npub use ratio::*;\npub use ratio::{Net, Device};\n",
                ),
                (
                    "crates/articula-core/src/ratio/mod.rs",
                    "mod below;\npub struct Net;\npub struct Device;\nimpl Device {\n    \
                     pub fn share(&self) {}\n\n    pub fn rest(&self) {}\n}\n",
                ),
                (
                    "crates/articula-core/src/ratio/below.rs",
                    "pub fn one() {}\npub fn other() {}\n",
                ),
                ("crates/articula-cli/src/commands/play.rs", cli),
            ];
            let faults = thesis_map(&Tree::of(&files)).into_iter();
            faults.map(|f| f.what).collect::<Vec<_>>()
        };
        let net = "fn f(_: articula_core::Net) { articula_core::ratio::below::one(); }\n";
        let mend = "name the items that are meant, or who reaches these";
        let of = |what: &str| format!("of articula_core::ratio, {what} is {UNREACHED}; {mend}");
        assert_eq!(
            told("articula_core::ratio", net),
            [of("Device (crates/articula-core/src/ratio/mod.rs:3)")]
        );
        let both = "fn f(_: articula_core::Net, d: articula_core::Device) { d.share(); }\n";
        let below = "one (crates/articula-core/src/ratio/below.rs:1)";
        assert_eq!(told("articula_core::ratio", both), [of(below)]);
        let all = both.replace(
            "d.share()",
            "d.share(); articula_core::ratio::below::other()",
        );
        assert!(told("articula_core::ratio", &all).is_empty());
        // Single items, by the path of their file or by that of a re-export.
        for name in ["articula_core::Net", "articula_core::ratio::Net"] {
            assert!(told(name, net).is_empty());
            assert_eq!(
                told(name, "fn f() {}\n"),
                [format!("{name} is {UNREACHED}")]
            );
        }
        assert!(told("articula_core::Device::share", both).is_empty());
        let rest = "articula_core::Device::rest";
        assert_eq!(told(rest, both), [format!("{rest} is {UNREACHED}")]);
        for absent in ["articula_core::Device::none", "articula_core::none", "none"] {
            let what = format!("there is no module or item {absent}");
            assert_eq!(told(absent, both)[0], what);
        }
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
