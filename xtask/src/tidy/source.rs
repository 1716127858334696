//! Rules on source files: length, head comment, names, and marks that must not remain.
//!
//! The words that a rule searches for are assembled from halves, so that this file passes.

use super::Fault;
use super::tree::Tree;

/// Maximum number of lines of a hand-written file.
const LINES_MAX: usize = 800;

/// Module names that say nothing about their content.
const EMPTY_NAMES: &[&str] = &[
    "utils", "util", "common", "helpers", "helper", "misc", "types",
];

/// Marks of open work; each needs the number of an issue: `(#12)`.
const MARKS: &[&str] = &[concat!("TO", "DO"), concat!("FIX", "ME")];

/// Prefixes of paths that exist on one machine only.
const MACHINE_ROOTS: &[&str] = &[
    concat!("/ho", "me/"),
    concat!("/Us", "ers/"),
    concat!("/ro", "ot/"),
    concat!("/wo", "rk/"),
    concat!("/t", "mp/"),
    concat!("C:\\Us", "ers"),
];

fn is_table(path: &str) -> bool {
    path.ends_with("_table.rs")
}

/// Finds hand-written Rust files that are too long.
pub(crate) fn length(tree: &Tree) -> Vec<Fault> {
    tree.sources()
        .filter(|(path, _)| !is_table(path))
        .filter_map(|(path, text)| {
            let lines = text.lines().count();
            let what =
                format!("{lines} lines exceed the limit of {LINES_MAX}; split the file by subject");
            (lines > LINES_MAX).then(|| Fault::file(path, what))
        })
        .collect()
}

/// Finds Rust files without a head comment.
pub(crate) fn head(tree: &Tree) -> Vec<Fault> {
    tree.sources()
        .filter(|(path, text)| {
            let starts = if is_table(path) { "//" } else { "//!" };
            !text.starts_with(starts)
        })
        .map(|(path, _)| {
            Fault::file(
                path,
                "must start with a `//!` comment that describes the file",
            )
        })
        .collect()
}

/// Finds modules whose name says nothing about their content.
pub(crate) fn module_names(tree: &Tree) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (path, text) in tree.sources() {
        let stem = path.trim_end_matches(".rs");
        if let Some(name) = stem.split('/').find(|part| EMPTY_NAMES.contains(part)) {
            faults.push(Fault::file(path, empty_name(name)));
        }
        for (index, line) in text.lines().enumerate() {
            let mut words = line.split_whitespace().skip_while(|w| w.starts_with("pub"));
            let module = (words.next() == Some("mod"))
                .then(|| words.next())
                .flatten();
            let name = module.unwrap_or_default().trim_end_matches([';', '{']);
            if EMPTY_NAMES.contains(&name) {
                faults.push(Fault::line(path, index + 1, empty_name(name)));
            }
        }
    }
    faults
}

fn empty_name(name: &str) -> String {
    format!("a module named `{name}`; name it after its subject")
}

/// Finds tests that are disabled.
pub(crate) fn ignored_tests(tree: &Tree) -> Vec<Fault> {
    let off = |line: &str| line.trim_start().starts_with("#[ignore");
    lines(
        tree,
        |path| path.ends_with(".rs"),
        off,
        "a disabled test; enable or delete it",
    )
}

/// Finds marks of open work without the number of an issue.
pub(crate) fn marks(tree: &Tree) -> Vec<Fault> {
    lines(
        tree,
        |_| true,
        has_bare_mark,
        "a note without an issue number",
    )
}

fn has_bare_mark(line: &str) -> bool {
    MARKS.iter().any(|mark| {
        line.match_indices(mark).any(|(at, _)| {
            let word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
            let rest = &line[at + mark.len()..];
            let whole = !word(line[..at].chars().next_back()) && !word(rest.chars().next());
            let issue = rest.trim_start().trim_start_matches('(').strip_prefix('#');
            let numbered = issue.is_some_and(|n| n.starts_with(|c: char| c.is_ascii_digit()));
            whole && !numbered
        })
    })
}

/// Finds absolute paths of one machine.
pub(crate) fn machine_paths(tree: &Tree) -> Vec<Fault> {
    lines(
        tree,
        |_| true,
        has_machine_path,
        "an absolute path of a machine",
    )
}

fn has_machine_path(line: &str) -> bool {
    MACHINE_ROOTS.iter().any(|root| {
        line.match_indices(root).any(|(at, _)| {
            let before = line[..at].chars().next_back();
            // A relative path or a URL may contain the same letters: `../home/x`, `a.org/home/`.
            !before.is_some_and(|c| c.is_alphanumeric() || "._-})~*".contains(c))
        })
    })
}

/// Returns a fault for each line for which `is_bad` is true, of the files selected by path.
fn lines(
    tree: &Tree,
    counts: impl Fn(&str) -> bool,
    is_bad: impl Fn(&str) -> bool,
    what: &str,
) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (path, text) in tree.texts().filter(|(path, _)| counts(path)) {
        for (index, line) in text.lines().enumerate().filter(|(_, line)| is_bad(line)) {
            faults.push(Fault::line(
                path,
                index + 1,
                format!("{what}: {}", line.trim()),
            ));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(path: &str, text: &str) -> Tree {
        Tree::of(&[(path, text)])
    }

    #[test]
    fn long_files_are_split_but_tables_stay() {
        let long = "//! x\n".repeat(LINES_MAX + 1);
        let fits = "//! x\n".repeat(LINES_MAX);
        assert_eq!(length(&tree("a.rs", &long)).len(), 1);
        assert_eq!(length(&tree("a.rs", &fits)).len(), 0);
        assert_eq!(length(&tree("a_table.rs", &long)).len(), 0);
    }

    #[test]
    fn every_file_says_what_it_is() {
        assert_eq!(head(&tree("a.rs", "use std;\n")).len(), 1);
        assert_eq!(head(&tree("a.rs", "//! A.\nuse std;\n")).len(), 0);
        assert_eq!(head(&tree("a_table.rs", "// Generated by x.\n")).len(), 0);
        assert_eq!(head(&tree("a_table.rs", "const A: u8 = 1;\n")).len(), 1);
    }

    #[test]
    fn modules_are_named_after_something() {
        assert_eq!(module_names(&tree("src/utils.rs", "//! x")).len(), 1);
        assert_eq!(module_names(&tree("src/misc/a.rs", "//! x")).len(), 1);
        assert_eq!(
            module_names(&tree("src/lib.rs", "pub(crate) mod types {\n}")).len(),
            1
        );
        assert_eq!(module_names(&tree("src/lib.rs", "mod helpers;")).len(), 1);
        assert_eq!(
            module_names(&tree("src/lib.rs", "mod joint;\n// mod helps")).len(),
            0
        );
    }

    #[test]
    fn no_test_is_switched_off() {
        assert_eq!(
            ignored_tests(&tree("a.rs", "  #[ignore]\nfn a() {}")).len(),
            1
        );
        assert_eq!(
            ignored_tests(&tree("a.rs", "  #[ignore = \"slow\"]")).len(),
            1
        );
        assert_eq!(
            ignored_tests(&tree("a.rs", "// `#[ignore]`d never")).len(),
            0
        );
    }

    #[test]
    fn notes_carry_an_issue() {
        let mark = MARKS[0];
        assert_eq!(marks(&tree("a.rs", &format!("// {mark}: later"))).len(), 1);
        assert_eq!(
            marks(&tree("a.rs", &format!("// {mark}(#12): later"))).len(),
            0
        );
        assert_eq!(
            marks(&tree("a.rs", &format!("// {mark} #12 later"))).len(),
            0
        );
        assert_eq!(marks(&tree("a.rs", &format!("// MAS{mark}N"))).len(), 0);
    }

    #[test]
    fn paths_of_one_machine_are_found() {
        let home = MACHINE_ROOTS[0];
        assert_eq!(
            machine_paths(&tree("a.md", &format!("see `{home}me/x`"))).len(),
            1
        );
        assert_eq!(
            machine_paths(&tree("a.md", &format!("{home}me/x"))).len(),
            1
        );
        assert_eq!(
            machine_paths(&tree("a.md", &format!("file://{home}x"))).len(),
            1
        );
        assert_eq!(machine_paths(&tree("a.md", &format!("..{home}x"))).len(), 0);
        assert_eq!(
            machine_paths(&tree("a.md", &format!("a.org{home}x"))).len(),
            0
        );
    }
}
