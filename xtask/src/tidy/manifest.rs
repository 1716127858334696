//! Dependencies between crates: siblings never depend on each other, except for the edges listed
//! here; the core depends on one library.
//!
//! Only linked dependencies count; a dev-dependency may be any crate.

use super::Fault;
use super::tree::Tree;

/// Crates that meet only in the library and the programs.
const SIBLINGS: &[&str] = &[
    "articula-formats",
    "articula-build",
    "articula-flat",
    "articula-stream",
    "articula-human",
    "articula-speech",
];

/// Allowed dependencies between siblings, as (crate, dependency). The reference human uses the
/// simplifier of build, so that there is only one.
const SIBLING_EDGES: &[(&str, &str)] = &[("articula-human", "articula-build")];

/// Programs: no crate depends on them.
const PROGRAMS: &[&str] = &["articula-cli", "articula-lab", "articula-wasm"];

/// Crates for web pages: all that they may use of ours, and what they alone may use.
const WEB: &[(&str, &[&str], &str)] = &[
    ("articula-wasm", &["articula"], "wasm-bindgen"),
    ("xtask-web", &[], "wasm-bindgen-cli-support"),
];

/// Reports and the server, above the library: for programs only.
const ABOVE: &[&str] = &["articula-report", "articula-serve"];

/// All allowed dependencies of the core.
const CORE_MAY_USE: &[&str] = &["glam", "libm"];

/// Finds dependencies that the crate map in ARCHITECTURE.md does not have.
pub(crate) fn crate_edges(tree: &Tree) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (path, text) in tree.texts() {
        if !path.ends_with("Cargo.toml") {
            continue;
        }
        let package = package_name(text).unwrap_or_default();
        for (line, dependency) in dependencies(text) {
            if let Some(why) = refusal(&package, &dependency) {
                faults.push(Fault::line(path, line, why));
            }
        }
    }
    faults
}

/// Finds libraries of the root manifest for which deny.toml gives no reason.
pub(crate) fn reasons(tree: &Tree) -> Vec<Fault> {
    let reasons = tree.text("deny.toml").unwrap_or_default();
    let is_name = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    let told: Vec<&str> = reasons.split(|c| !is_name(c)).collect();
    dependencies(tree.text("Cargo.toml").unwrap_or_default())
        .into_iter()
        .filter(|(_, name)| !name.starts_with("articula") && !told.contains(&name.as_str()))
        .map(|(line, name)| {
            let what = format!("deny.toml gives no reason for the dependency {name}");
            Fault::line("Cargo.toml", line, what)
        })
        .collect()
}

/// Returns why `package` may not use `dependency`, if it may not.
fn refusal(package: &str, dependency: &str) -> Option<String> {
    let ours = dependency.starts_with("articula");
    if package == "articula-core" && !CORE_MAY_USE.contains(&dependency) {
        return Some(format!(
            "articula-core may depend on {CORE_MAY_USE:?} only, not on {dependency}"
        ));
    }
    if PROGRAMS.contains(&dependency) {
        return Some(format!(
            "{package} must not depend on the program {dependency}"
        ));
    }
    if package == "articula" && ABOVE.contains(&dependency) {
        return Some(format!(
            "the library must not depend on {dependency}, which is for the programs"
        ));
    }
    if package == "xtask" && ours {
        return Some(format!(
            "xtask must not depend on crates of the workspace, found {dependency}"
        ));
    }
    for (web, may_use, own) in WEB {
        if package == *web && ours && !may_use.contains(&dependency) {
            return Some(format!(
                "{web} may depend on {may_use:?} of ours only, not on {dependency}"
            ));
        }
        // The manifest of the workspace names what all crates use.
        if dependency == *own && package != *web && !package.is_empty() {
            return Some(format!(
                "{package} must not depend on {own}, which is for {web}"
            ));
        }
    }
    let sibling = SIBLINGS.contains(&package);
    let is_told = SIBLING_EDGES.contains(&(package, dependency));
    if sibling && ours && dependency != "articula-core" && !is_told {
        return Some(format!(
            "{package} may depend on articula-core only, not on {dependency}"
        ));
    }
    None
}

fn package_name(manifest: &str) -> Option<String> {
    let mut section = "";
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if section == "[package]"
            && let Some(value) = value_of(line, "name")
        {
            return Some(value);
        }
    }
    None
}

/// Returns every (line, package) below `[dependencies]`, `[build-dependencies]`, their dotted forms
/// and those of one target or of the whole workspace. A renamed dependency has its real name.
fn dependencies(manifest: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut linked = false;
    let mut dotted = false;
    for (index, raw) in manifest.lines().enumerate() {
        let line = raw.split('#').next().unwrap_or_default().trim();
        if line.starts_with('[') {
            let header = line.trim_matches(['[', ']']);
            let name = dependency_table(header);
            linked = name.is_some();
            dotted = name.is_some_and(|n| !n.is_empty());
            if let Some(name) = name.filter(|n| !n.is_empty()) {
                found.push((index + 1, name.trim_matches('"').to_owned()));
            }
        } else if linked && dotted {
            // `package = "…"` of the dotted form is the real name of the entry just found.
            if let (Some(real), Some(last)) = (value_of(line, "package"), found.last_mut()) {
                last.1 = real;
            }
        } else if linked && let Some((key, value)) = line.split_once('=') {
            let key = key.split('.').next().unwrap_or_default().trim();
            let inner = value.split([',', '{', '}']);
            let real = inner
                .into_iter()
                .find_map(|part| value_of(part.trim(), "package"));
            found.push((
                index + 1,
                real.unwrap_or_else(|| key.trim_matches('"').to_owned()),
            ));
        }
    }
    found
}

/// Returns the dependency in the header of a table of linked dependencies, or `""` if it lists
/// several.
fn dependency_table(header: &str) -> Option<&str> {
    let header = match header.strip_prefix("target.") {
        // The target's own name may contain dots.
        Some(rest) => &rest[rest.find("dependencies")?..],
        None => header.strip_prefix("workspace.").unwrap_or(header),
    };
    let rest = header
        .strip_prefix("build-dependencies")
        .or_else(|| header.strip_prefix("dependencies"))?;
    rest.strip_prefix('.').or(rest.is_empty().then_some(""))
}

/// Returns the quoted value of `key = "value"`.
fn value_of(line: &str, key: &str) -> Option<String> {
    let (found, value) = line.split_once('=')?;
    (found.trim() == key).then(|| value.trim().trim_matches('"').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(package: &str, rest: &str) -> usize {
        let text = format!("[package]\nname = \"{package}\"\n{rest}");
        crate_edges(&Tree::of(&[("crates/x/Cargo.toml", &text)])).len()
    }

    #[test]
    fn siblings_never_name_each_other() {
        let core = "[dependencies]\narticula-core.workspace = true\n";
        assert_eq!(faults("articula-build", core), 0);
        let sibling = "[dependencies]\narticula-flat = { path = \"../articula-flat\" }\n";
        assert_eq!(faults("articula-build", sibling), 1);
        let dotted = "[dependencies.articula-flat]\npath = \"../articula-flat\"\n";
        assert_eq!(faults("articula-build", dotted), 1);
        assert_eq!(faults("articula-human", sibling), 1);
        let told = "[dependencies]\narticula-build.workspace = true\n";
        assert_eq!(faults("articula-human", told), 0);
        assert_eq!(faults("articula-stream", told), 1);
        let target = "[target.'cfg(unix)'.dependencies]\narticula-stream.workspace = true\n";
        assert_eq!(faults("articula-formats", target), 1);
        let renamed = "[dependencies]\nflat = { package = \"articula-flat\", path = \"..\" }\n";
        assert_eq!(faults("articula-build", renamed), 1);
        let renamed = "[dependencies.flat]\npackage = \"articula-flat\"\n";
        assert_eq!(faults("articula-build", renamed), 1);
        let to_build = "[dependencies]\narticula-build.workspace = true\n";
        assert_eq!(faults("articula-human", to_build), 0);
        assert_eq!(faults("articula-human", sibling), 1);
        let to_human = "[dependencies]\narticula-human.workspace = true\n";
        assert_eq!(faults("articula-build", to_human), 1);
    }

    #[test]
    fn tests_may_name_any_crate() {
        let dev = "[dev-dependencies]\narticula-build.workspace = true\n";
        assert_eq!(faults("articula-formats", dev), 0);
        assert_eq!(faults("articula-core", dev), 0);
    }

    #[test]
    fn the_core_uses_one_library_at_most() {
        let allowed = "[dependencies]\nglam.workspace = true\n";
        assert_eq!(faults("articula-core", allowed), 0);
        assert_eq!(
            faults("articula-core", "[dependencies]\nserde = \"1\"\n"),
            1
        );
    }

    #[test]
    fn nothing_stands_on_a_program_and_the_library_draws_no_reports() {
        let on = |dependency: &str| format!("[dependencies]\n{dependency}.workspace = true\n");
        assert_eq!(faults("articula-lab", &on("articula-cli")), 1);
        assert_eq!(faults("articula", &on("articula-report")), 1);
        assert_eq!(faults("articula", &on("articula-serve")), 1);
        assert_eq!(faults("articula", &on("articula-build")), 0);
        assert_eq!(faults("articula-cli", &on("articula-report")), 0);
    }

    #[test]
    fn what_is_for_web_pages_stays_apart() {
        let on = |dependency: &str| format!("[dependencies]\n{dependency}.workspace = true\n");
        assert_eq!(faults("articula-wasm", &on("articula")), 0);
        assert_eq!(faults("articula-wasm", &on("articula-core")), 1);
        assert_eq!(faults("articula-wasm", &on("wasm-bindgen")), 0);
        assert_eq!(faults("articula", &on("wasm-bindgen")), 1);
        assert_eq!(faults("xtask", &on("wasm-bindgen-cli-support")), 1);
        assert_eq!(faults("xtask-web", &on("wasm-bindgen-cli-support")), 0);
        assert_eq!(faults("xtask-web", &on("articula")), 1);
        assert_eq!(faults("articula-cli", &on("articula-wasm")), 1);
        let all = "[workspace.dependencies]\nwasm-bindgen = \"=0.2.130\"\n";
        assert!(crate_edges(&Tree::of(&[("Cargo.toml", all)])).is_empty());
    }

    #[test]
    fn every_library_has_a_reason() {
        let libraries = "[workspace.dependencies]\nglam = \"1\"\narticula-core = \"1\"\n";
        let faults =
            |deny: &str| reasons(&Tree::of(&[("Cargo.toml", libraries), ("deny.toml", deny)]));
        assert_eq!(faults("#   glam   vectors").len(), 0);
        assert_eq!(faults("#   glamour   vectors").len(), 1);
    }

    #[test]
    fn xtask_uses_nothing_of_ours() {
        assert_eq!(faults("xtask", "[dependencies]\nanyhow = \"1\"\n"), 0);
        assert_eq!(
            faults("xtask", "[dependencies]\narticula-core = \"1\"\n"),
            1
        );
    }
}
