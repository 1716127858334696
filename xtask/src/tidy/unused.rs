//! No public item of a library without a user.

use super::Fault;
use super::graph::{Graph, is_below};
use super::imports::tests_of;
use super::items::{Item, Kind};
use super::tree::Tree;
use std::collections::HashSet;

/// Crates whose public items must have a user.
const LIBRARIES: [&str; 9] = [
    "articula",
    "articula_build",
    "articula_core",
    "articula_flat",
    "articula_formats",
    "articula_human",
    "articula_report",
    "articula_serve",
    "articula_stream",
];

/// The library, whose functions are there for programs outside of the workspace too.
const LIBRARY: &str = "articula";

/// Page with the data flows.
const FLOWS: &str = "ARCHITECTURE.md";

/// Finds public items of libraries that nothing uses.
///
/// 1. A program, the lab, an example, a bench or a fuzz target reaches every item. Two kinds stay
///    without: what a data flow of `ARCHITECTURE.md` names, as `Type`, `Type::method` or
///    `module::function`, and constructors beside others, that is methods of a reached type that
///    return it.
/// 2. Another crate or a test outside of the crate names every function, constant and static of the
///    crates below `articula`; what only its own crate uses is `pub(crate)`. Types and methods stay,
///    since they belong to signatures and to types.
pub(crate) fn unused(tree: &Tree) -> Vec<Fault> {
    let graph = Graph::new(tree);
    let flows = flows(tree.text(FLOWS).unwrap_or_default());
    let library = |file: usize| {
        let mut all = LIBRARIES.iter();
        all.find(|name| is_below(&graph.modules[file], name))
    };
    let is_start = |(file, item): &(usize, Item)| {
        let module = graph.modules[*file].rsplit("::").next();
        let in_module = format!("{}::{}", module.unwrap_or_default(), item.name);
        library(*file).is_none()
            || flows.contains(full_name(item).as_str())
            || item.is_value && flows.contains(in_module.as_str())
    };
    let all = graph.items.iter().enumerate();
    let start: Vec<usize> = all
        .clone()
        .filter(|(_, i)| is_start(i))
        .map(|(i, _)| i)
        .collect();
    let reached = graph.reached(&start);
    let named = graph.named_by_other_crates();
    let tests = words_of_tests(tree);
    let mut faults = Vec::new();
    let open = all.filter(|(_, i)| i.1.is_public && !is_start(i));
    for (i, (file, item)) in open {
        let Some(own) = library(*file) else {
            continue;
        };
        let is_tested = || {
            let mut tests = tests.iter();
            tests.any(|(of, words)| of != own && words.contains(item.name.as_str()))
        };
        let constructs = || item.returns_itself && graph.type_of(i).is_some_and(|t| reached[t]);
        let what = if !reached[i] && !constructs() {
            "is reached by no program, example, bench or fuzz target; delete it with its tests"
        } else if *own != LIBRARY && item.is_value && !named.contains(&i) && !is_tested() {
            "is used by its own crate alone; make it pub(crate)"
        } else {
            continue;
        };
        let what = format!("{} {what}", full_name(item));
        faults.push(Fault::line(&graph.paths[*file], item.line, what));
    }
    faults
}

/// Whether a file is a source of a library.
pub(super) fn is_library(path: &str) -> bool {
    let inner = path.strip_prefix("crates/");
    let name = inner.and_then(|inner| inner.split_once("/src/"));
    name.is_some_and(|(name, _)| LIBRARIES.contains(&name.replace('-', "_").as_str()))
}

/// `name`, or `Type::name` of a method.
fn full_name(item: &Item) -> String {
    match &item.kind {
        Kind::Method { of } => {
            let of = of.rsplit("::").next().unwrap_or(of);
            format!("{of}::{}", item.name)
        }
        _ => item.name.clone(),
    }
}

/// The paths that the data flows name, each also without the modules before it. A single word is a
/// type: prose has the words of functions too.
fn flows(page: &str) -> HashSet<&str> {
    let block = page.split("```").nth(1).unwrap_or_default();
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = block.split(|c: char| !is_part(c));
    let ends = words.flat_map(|word| {
        let starts = word.match_indices("::").map(|(at, _)| at + 2);
        let ends = [0].into_iter().chain(starts);
        ends.map(|at| word[at..].trim_end_matches(':'))
    });
    ends.filter(|end| end.contains("::") || end.starts_with(char::is_uppercase))
        .collect()
}

/// The words of tests by crate, which is empty for tests outside of the sources of a crate.
fn words_of_tests(tree: &Tree) -> Vec<(String, HashSet<&str>)> {
    let sources = tree.sources().filter_map(|(path, text)| {
        let name = path.strip_prefix("crates/")?.split('/').next()?;
        Some(match path.contains("/src/") {
            true => (name.replace('-', "_"), tests_of(text)),
            false => (String::new(), text),
        })
    });
    let words = |text| {
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        str::split(text, move |c: char| !is_part(c)).collect()
    };
    sources.map(|(of, text)| (of, words(text))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faults of a core with `held.rs`, of which `game` is the code of the lab.
    fn faults(held: &str, game: &str) -> Vec<String> {
        let page = "# x\n\n```text\n  Hold ─ Hold::flow ─▶ articula_core::held::step: prose\n```\n";
        let files = [
            (FLOWS, page),
            ("crates/articula-core/src/lib.rs", "pub mod held;\n"),
            ("crates/articula-core/src/held.rs", held),
            (
                "crates/articula-core/src/used.rs",
                "use crate::held::inner;\n\npub(crate) fn used() {\n    inner();\n}\n",
            ),
            (
                "crates/articula-core/tests/it/main.rs",
                "#[test]\nfn t() {\n    articula_core::held::tested();\n}\n",
            ),
            ("crates/articula-lab/src/main.rs", game),
        ];
        let faults = unused(&Tree::of(&files)).into_iter();
        faults.map(|f| f.to_string()).collect()
    }

    fn told(line: usize, what: &str) -> String {
        format!("crates/articula-core/src/held.rs:{line}: {what}")
    }

    const DEAD: &str =
        "is reached by no program, example, bench or fuzz target; delete it with its tests";

    #[test]
    fn what_tests_alone_reach_is_refused() {
        let held = "//! x\n\npub struct A;\n\nimpl A {\n    pub fn a(&self) {}\n\n    \
                    pub fn b(&self) {}\n}\n\npub fn tested() {}\n";
        let use_a = "fn main(a: articula_core::held::A) {\n    a.a();\n}\n";
        let dead = |line, name: &str| told(line, &format!("{name} {DEAD}"));
        assert_eq!(faults(held, use_a), [dead(8, "A::b"), dead(11, "tested")]);
        let none = faults(held, "fn main() {}\n");
        assert_eq!(none[..2], [dead(3, "A"), dead(6, "A::a")]);
        // What is no part of the public interface is left to the compiler.
        assert!(faults("pub(crate) fn f() {}\nfn g() {}\n", "").is_empty());
    }

    #[test]
    fn constructors_and_data_flows_stay() {
        let held = "pub struct A;\nimpl A {\n    pub fn with_b(self) -> Self {\n        self\n    \
                    }\n}\npub fn step() {}\npub struct Hold;\nimpl Hold {\n    \
                    pub fn flow(&self) {}\n}\n";
        let use_a = "fn main(_: articula_core::held::A) {}\n";
        assert!(faults(held, use_a).is_empty());
        let without = faults(held, "fn main() {}\n");
        let dead = ["A", "A::with_b"].map(|name| format!("{name} {DEAD}"));
        assert_eq!(without, [told(1, &dead[0]), told(3, &dead[1])]);
    }

    #[test]
    fn what_only_its_own_crate_uses_is_not_public() {
        let held = "pub fn inner() {}\npub fn tested() {}\npub fn outer() {}\n";
        let game = "use articula_core::{held::outer, used};\nfn main() {\n    outer();\n    \
                    used::used();\n    articula_core::held::step();\n}\n";
        let step = "pub fn step() {\n    inner();\n    tested();\n}\n";
        let inner = "inner is used by its own crate alone; make it pub(crate)";
        assert_eq!(faults(&format!("{held}{step}"), game), [told(1, inner)]);
    }
}
