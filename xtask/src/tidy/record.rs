//! Rules on files other than code: the thesis map, data folders, links, schemas, lock files.

use super::Fault;
use super::tree::Tree;
use std::collections::HashSet;

pub(super) const THESIS_MAP: &str = "docs/thesis-map.md";

/// Finds rows of the thesis map whose test does not exist, or that have no module.
///
/// A row is `| section | module | test | reached by | difference |`. Modules and tests are in backquotes,
/// separated by commas; a module is a Rust path (`articula_core::loa::joint_set`) or the path of a
/// file, a test is the name of a `#[test]` function of any crate. `reach` checks the modules.
pub(crate) fn thesis_map(tree: &Tree) -> Vec<Fault> {
    let Some(text) = tree.text(THESIS_MAP) else {
        return vec![Fault::file(THESIS_MAP, "is missing")];
    };
    let mut faults: Vec<Fault> = text
        .lines()
        .enumerate()
        .filter(|(_, line)| line.trim().starts_with('|') && fields(line).len() != COLUMNS)
        .map(|(index, _)| {
            let what = format!("a row must have {COLUMNS} cells");
            Fault::line(THESIS_MAP, index + 1, what)
        })
        .collect();
    let names = test_names(tree);
    for (line, [_, module, test, _, _]) in map_rows(text) {
        let mut wrong = |what: String| faults.push(Fault::line(THESIS_MAP, line, what));
        let modules = quoted(module);
        let tests = quoted(test);
        if modules.is_empty() || tests.is_empty() {
            wrong("a row must name at least one module and one test in backquotes".to_owned());
        }
        let exists = |test: &str| names.contains(test.rsplit("::").next().unwrap_or(test));
        for test in tests.iter().filter(|test| !exists(test)) {
            wrong(format!("test {test} does not exist"));
        }
    }
    faults
}

/// Returns the rows of the thesis map, each with the number of its line.
pub(super) fn map_rows(text: &str) -> impl Iterator<Item = (usize, [&str; 5])> {
    let lines = text.lines().enumerate();
    lines.filter_map(|(index, line)| Some((index + 1, cells(line)?)))
}

/// Number of columns of the thesis map.
const COLUMNS: usize = 5;

/// Returns the cells of a table row; `None` for its heading and ruler.
fn cells(line: &str) -> Option<[&str; COLUMNS]> {
    let cells: [&str; COLUMNS] = fields(line).try_into().ok()?;
    let heading = cells[1] == "module" || cells[1].starts_with("--");
    (!heading).then_some(cells)
}

/// Returns all cells of a line of a table; none for other lines.
fn fields(line: &str) -> Vec<&str> {
    let inner = line.trim().strip_prefix('|');
    let inner = inner.and_then(|line| line.strip_suffix('|'));
    let cells = inner.into_iter().flat_map(|line| line.split('|'));
    cells.map(str::trim).collect()
}

/// Returns the texts in backquotes.
pub(super) fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

/// Returns the names of all `#[test]` functions of the Rust sources.
fn test_names(tree: &Tree) -> HashSet<&str> {
    let mut names = HashSet::new();
    for (_, text) in tree.sources() {
        let mut marked = false;
        for line in text.lines().map(str::trim) {
            if line == "#[test]" {
                marked = true;
            } else if line.contains("fn ") && std::mem::take(&mut marked) {
                let rest = line.strip_prefix("fn ");
                names.extend(rest.and_then(|rest| rest.split('(').next()));
            }
        }
    }
    names
}

/// Finds data folders without a README that states licence and origin.
///
/// It may be in the `data` folder itself or in the data set's own folder below it.
pub(crate) fn data_readmes(tree: &Tree) -> Vec<Fault> {
    let mut faults: Vec<Fault> = Vec::new();
    for path in tree.paths() {
        let Some((folder, below)) = data_folder(path) else {
            continue;
        };
        let set = below
            .split_once('/')
            .map(|(set, _)| format!("{folder}/{set}"));
        let told = [Some(folder.clone()), set].into_iter().flatten().any(|f| {
            tree.text(&format!("{f}/README.md"))
                .is_some_and(tells_origin)
        });
        let fault = Fault::file(&folder, "has no README.md with licence and origin");
        if !told && !faults.contains(&fault) {
            faults.push(fault);
        }
    }
    faults
}

/// Returns the `data` folder of a file, and the file's path below it.
fn data_folder(path: &str) -> Option<(String, &str)> {
    let (before, below) = match path.strip_prefix("data/") {
        Some(below) => (String::new(), below),
        None => path
            .split_once("/data/")
            .map(|(before, below)| (format!("{before}/"), below))?,
    };
    Some((format!("{before}data"), below))
}

fn tells_origin(readme: &str) -> bool {
    let text = readme.to_lowercase();
    text.contains("licence") && (text.contains("origin") || text.contains("source"))
}

/// Finds schemas that are not valid JSON.
pub(crate) fn schemas(tree: &Tree) -> Vec<Fault> {
    tree.texts()
        .filter(|(path, _)| path.starts_with("docs/formats/") && path.ends_with(".schema.json"))
        .filter_map(|(path, text)| {
            let fault = serde_json::from_str::<serde_json::Value>(text).err()?;
            Some(Fault::line(path, fault.line(), fault.to_string()))
        })
        .collect()
}

/// Finds links between pages whose target does not exist.
pub(crate) fn links(tree: &Tree) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (path, text) in tree.texts().filter(|(path, _)| path.ends_with(".md")) {
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        for (index, line) in text.lines().enumerate() {
            for link in line.split("](").skip(1) {
                let target = link.split([')', '#', ' ']).next().unwrap_or_default();
                let outside = target.is_empty() || target.contains(':');
                if !outside && !tree.has(&joined(folder, target)) {
                    faults.push(Fault::line(
                        path,
                        index + 1,
                        format!("no such file: {target}"),
                    ));
                }
            }
        }
    }
    faults
}

/// Returns `folder/target` with `.` and `..` resolved.
fn joined(folder: &str, target: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(target.split('/')) {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            name => parts.push(name),
        }
    }
    parts.join("/")
}

/// Finds npm lock files that bind the packages to one host; links to folders of the repository are none.
pub(crate) fn lock_files(tree: &Tree) -> Vec<Fault> {
    let names_host = |line: &str| line.contains("\"resolved\"") && line.contains("://");
    tree.texts()
        .filter(|(path, text)| path.ends_with("package-lock.json") && text.lines().any(names_host))
        .map(|(path, _)| {
            Fault::file(
                path,
                "names a registry host; set omit-lockfile-registry-resolved",
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CODE: &str = "//! x\n#[test]\nfn nested() {}\nfn plain() {}\n";

    fn map_faults(row: &str) -> usize {
        let text = format!(
            "| section | module | test | reached by | difference |\n|---|---|---|---|---|\n{row}\n"
        );
        let files = [
            (THESIS_MAP, text.as_str()),
            ("crates/articula-core/src/loa/joint_set.rs", CODE),
        ];
        thesis_map(&Tree::of(&files)).len()
    }

    #[test]
    fn rows_of_the_thesis_map_are_true() {
        let module = "`articula_core::loa::joint_set`";
        assert_eq!(
            map_faults(&format!("| 5.1 | {module} | `nested` | `lod` | – |")),
            0
        );
        assert_eq!(map_faults("| 5.1 | none | `nested` | `lod` | – |"), 1);
        assert_eq!(
            map_faults(&format!("| 5.1 | {module} | `absent` | `lod` | – |")),
            1
        );
        assert_eq!(
            map_faults(&format!("| 5.1 | {module} | `plain` | `lod` | – |")),
            1
        );
        assert_eq!(
            map_faults(&format!("| 5.1 | {module} | none | `lod` | – |")),
            1
        );
        assert_eq!(map_faults(&format!("| 5.1 | {module} | `nested` | – |")), 1);
    }

    #[test]
    fn the_thesis_map_exists() {
        assert_eq!(thesis_map(&Tree::default()).len(), 1);
    }

    #[test]
    fn data_tells_licence_and_origin() {
        let faults = |files: &[(&str, &str)]| data_readmes(&Tree::of(files)).len();
        let good = "Licence: CC0. Origin: made by us.";
        assert_eq!(faults(&[("crates/a/data/x.json", "{}")]), 1);
        assert_eq!(faults(&[("data/set/x.json", "{}")]), 1);
        assert_eq!(
            faults(&[("data/set/x.json", "{}"), ("data/set/README.md", "x")]),
            1
        );
        assert_eq!(
            faults(&[("data/set/x.json", "{}"), ("data/set/README.md", good)]),
            0
        );
        assert_eq!(
            faults(&[
                ("crates/a/data/x.json", "{}"),
                ("crates/a/data/README.md", good)
            ]),
            0
        );
    }

    #[test]
    fn schemas_parse() {
        let faults = |text: &str| schemas(&Tree::of(&[("docs/formats/a.schema.json", text)])).len();
        assert_eq!(faults("{}"), 0);
        assert_eq!(faults("{"), 1);
    }

    #[test]
    fn pages_link_to_what_exists() {
        let faults = |text: &str| {
            let files = [
                ("docs/a.md", text),
                ("README.md", ""),
                ("docs/sub/b.md", ""),
            ];
            links(&Tree::of(&files)).len()
        };
        assert_eq!(
            faults("[up](../README.md) [down](sub/b.md#part) [folder](sub)"),
            0
        );
        assert_eq!(faults("[out](https://example.org/x) [here](#part)"), 0);
        assert_eq!(faults("[gone](c.md) ![gone](pictures/d.png)"), 2);
    }

    #[test]
    fn lock_files_name_no_host() {
        let faults = |text: &str| lock_files(&Tree::of(&[("o/package-lock.json", text)])).len();
        assert_eq!(faults("{\"version\": 1}"), 0);
        assert_eq!(faults("{\"resolved\": \"packages/a\"}"), 0);
        assert_eq!(faults("{\"resolved\": \"https://x/a.tgz\"}"), 1);
    }
}
