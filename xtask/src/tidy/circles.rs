//! No cyclic imports between the files of a crate, so that a crate can be read from the bottom up.
//!
//! The imports of a file are the paths of its own crate, outside of its tests. A re-exported name
//! (`pub use`) counts as an import of the file that defines it. Imports of a module from the files
//! in its own folder do not count: these files may in turn use what the module defines.
//!
//! Folders do not import each other either: of the modules below one parent, each with all files of its
//! folder, none reaches itself through another.

use super::Fault;
use super::imports::{code_of, inline_paths, module_of, statements};
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
        let fault = |circle: Vec<String>, what: &str| {
            let others = circle[1..].join(", ");
            let what =
                format!("{what} through {others}; move the shared items to a module of their own");
            Fault::file(&format!("{root}/src/{}", circle[0]), what)
        };
        let files = house.circles();
        let mut folders = house.folder_circles();
        // A circle of files is one of their folders too, and told once.
        folders.retain(|folder| !files.iter().flatten().any(|file| folder.contains(file)));
        let files = files.into_iter().map(|c| fault(c, "circular import"));
        let folders = folders
            .into_iter()
            .map(|c| fault(c, "circular import of folders"));
        files.chain(folders).collect::<Vec<_>>()
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
        let circles = circles_of(&self.edges());
        let name = |module: &&Vec<String>| self.files[*module].name.clone();
        let names = |circle: BTreeSet<&Vec<String>>| {
            let mut names: Vec<String> = circle.iter().map(name).collect();
            names.sort();
            names
        };
        circles.into_iter().map(names).collect()
    }

    /// Returns the cycles of modules below one parent of which at least one is a folder, each as the
    /// files that import from the other folders of the cycle. Files of tests do not count.
    fn folder_circles(&self) -> Vec<Vec<String>> {
        let is_test = |module: &[String]| {
            module
                .iter()
                .any(|m| m == "tests" || m.starts_with("test_"))
        };
        let edges = self.edges();
        let modules = edges.keys().filter(|m| !is_test(m));
        let parents: BTreeSet<&[String]> = modules
            .clone()
            .flat_map(|m| (0..m.len()).map(move |depth| &m[..depth]))
            .collect();
        let mut circles = Vec::new();
        for parent in parents {
            let child = |module: &Vec<String>| {
                let is_below = module.len() > parent.len() && module.starts_with(parent);
                is_below.then(|| module[parent.len()].clone())
            };
            let mut folders: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
            let mut through: BTreeMap<(String, String), &str> = BTreeMap::new();
            for module in modules.clone() {
                let Some(from) = child(module) else { continue };
                let to = edges[*module].iter().filter_map(|to| child(to));
                for to in to.filter(|to| *to != from) {
                    let file = self.files[*module].name.as_str();
                    through.entry((from.clone(), to.clone())).or_insert(file);
                    folders.entry(to.clone()).or_default();
                    folders.entry(from.clone()).or_default().insert(to);
                }
            }
            let is_folder = |name: &String| {
                let mut inner = edges.keys().filter(|m| m.len() > parent.len() + 1);
                inner.any(|m| m.starts_with(parent) && m[parent.len()] == *name)
            };
            let edges = folders.iter().map(|(from, to)| (from, to.iter().collect()));
            for circle in circles_of(&edges.collect()) {
                if circle.iter().any(|name| is_folder(name)) {
                    let between = through
                        .iter()
                        .filter(|((from, to), _)| circle.contains(from) && circle.contains(to));
                    let mut files: Vec<String> =
                        between.map(|(_, file)| (*file).to_owned()).collect();
                    files.dedup();
                    circles.push(files);
                }
            }
        }
        circles
    }

    /// The modules whose files each file imports, without those below its own.
    fn edges(&self) -> BTreeMap<&Vec<String>, BTreeSet<&Vec<String>>> {
        let edges = self.files.iter().map(|(module, file)| {
            let all = file.paths.iter().filter_map(|p| self.definer(p));
            (module, all.filter(|to| !to.starts_with(module)).collect())
        });
        edges.collect()
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
        let (imports, rest) = statements(&code);
        for import in imports {
            for path in import.paths {
                file.add(&path, module, import.is_public);
            }
        }
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

/// Returns the sets of nodes that reach each other.
fn circles_of<'a, T: Ord>(edges: &BTreeMap<&'a T, BTreeSet<&'a T>>) -> Vec<BTreeSet<&'a T>> {
    let reached = |from: &&'a T| {
        let mut seen: BTreeSet<&T> = BTreeSet::new();
        let mut next: Vec<&T> = edges[from].iter().copied().collect();
        while let Some(at) = next.pop() {
            if seen.insert(at) {
                next.extend(&edges[at]);
            }
        }
        seen
    };
    let reach: BTreeMap<&T, BTreeSet<&T>> = edges.keys().map(|m| (*m, reached(m))).collect();
    let mut told = BTreeSet::new();
    let mut circles = Vec::new();
    for (module, reached) in &reach {
        if reached.contains(module) && !told.contains(module) {
            let also = reached.iter().filter(|m| reach[*m].contains(module));
            let circle: BTreeSet<&T> = also.copied().collect();
            told.extend(circle.iter().copied());
            circles.push(circle);
        }
    }
    circles
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
    #[test]
    fn folders_that_need_each_other_are_told_with_their_files() {
        let files = [
            ("lib.rs", "mod a;\nmod b;\n"),
            ("a/mod.rs", "mod high;\nmod low;\n"),
            ("a/high.rs", "use crate::b::B;\npub struct High(B);\n"),
            ("a/low.rs", "pub struct Low;\n"),
            ("b.rs", "use crate::a::low::Low;\npub struct B(Low);\n"),
        ];
        let told = |files: &[(&str, &str)]| House::new(files).folder_circles();
        assert_eq!(told(&files), [["a/high.rs", "b.rs"]]);
        // Tests may use what stands above.
        let mut tests = files;
        tests[4].0 = "b/tests.rs";
        assert!(told(&tests).is_empty());
    }
}
