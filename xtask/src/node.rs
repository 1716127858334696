//! The independent programs that check results in node: the glTF validator, three.js,
//! meshoptimizer, and Chromium for animated pictures (folder `oracle`).

use crate::outcome::{Outcome, lacking};
use crate::processes::{answer, run};
use crate::workspace::root;
use anyhow::Result;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

/// First node version with everything that the scripts use.
const NODE_MAJOR: u32 = 18;

/// Names of the Chromium executable, as in `oracle/chromium.mjs`.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Installs the packages pinned by `oracle/package-lock.json`, unless they are installed already.
///
/// Runs before the tests because tests of `crates/articula-cli` call the scripts.
pub(crate) fn install() -> Result<Outcome> {
    install_in("oracle", "node oracle")
}

/// Installs the packages that a folder pins, unless they are installed already; `what` needs them.
pub(crate) fn install_in(folder: &str, what: &str) -> Result<Outcome> {
    if let Some(why) = missing() {
        return lacking(format!("{what} ({why})"));
    }
    let folder = root().join(folder);
    if up_to_date(&folder) {
        return Ok(Outcome::Done);
    }
    let npm = run(Command::new("npm")
        .args(["ci", "--loglevel", "error"])
        .current_dir(&folder));
    match npm {
        Ok(()) => Ok(Outcome::Done),
        Err(fault) => lacking(format!("{what} (npm ci failed: {fault:#})")),
    }
}

/// Checks that a browser for animated pictures is available: the program given by `CHROMIUM`, else
/// the first of the usual names that starts.
pub(crate) fn browser() -> Result<Outcome> {
    let named = std::env::var("CHROMIUM").ok();
    let programs = named.map_or_else(
        || BROWSERS.map(str::to_owned).to_vec(),
        |program| vec![program],
    );
    let starts = |program: &String| answer(program, &["--version"]).is_some();
    if programs.iter().any(starts) {
        return Ok(Outcome::Done);
    }
    lacking("browser oracle (Chromium not found; set CHROMIUM)".to_owned())
}

/// Runs the scripts on cases worked by hand, valid and invalid.
pub(crate) fn self_test() -> Result<Outcome> {
    if let Some(why) = missing() {
        return lacking(format!("node oracle ({why})"));
    }
    let folder = root().join("oracle");
    if !up_to_date(&folder) {
        return lacking("node oracle (its packages are not installed)".to_owned());
    }
    run(Command::new("npm")
        .args(["test", "--silent"])
        .current_dir(folder))?;
    Ok(Outcome::Done)
}

/// Returns why the scripts cannot run on this machine, if they cannot.
fn missing() -> Option<String> {
    let Some(version) = answer("node", &["--version"]) else {
        return Some("node not found".to_owned());
    };
    if major(&version).is_none_or(|m| m < NODE_MAJOR) {
        return Some(format!("node {version} is older than {NODE_MAJOR}"));
    }
    let npm = answer("npm", &["--version"]);
    npm.is_none().then(|| "npm not found".to_owned())
}

/// Returns the major number of a version as printed by node (`v20.1.0`).
fn major(version: &str) -> Option<u32> {
    version
        .trim_start_matches('v')
        .split('.')
        .next()?
        .parse()
        .ok()
}

/// Returns whether the installed packages are those of the lock file: npm writes a file when it is
/// done.
fn up_to_date(folder: &Path) -> bool {
    let changed =
        |name: &str| -> Option<SystemTime> { folder.join(name).metadata().ok()?.modified().ok() };
    let installed = changed("node_modules/.package-lock.json");
    installed.is_some() && installed >= changed("package-lock.json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_major_version() {
        assert_eq!(major("v20.20.2"), Some(20));
        assert_eq!(major("18.0.0"), Some(18));
        assert_eq!(major("none"), None);
    }
}
