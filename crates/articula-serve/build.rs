//! With the feature `studio`: finds the pages that become part of the program.
#![allow(
    clippy::disallowed_methods,
    reason = "a build script reads and writes files"
)]

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Where `npm run embed` puts them, each file compressed under its name with `.gz` behind it.
const FOLDER: &str = "../../web/studio/embedded";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if env::var_os("CARGO_FEATURE_STUDIO").is_none() {
        return;
    }
    let folder = Path::new(&env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join(FOLDER);
    println!("cargo:rerun-if-changed={}", folder.display());
    if let Err(why) = write(&folder) {
        println!(
            "cargo::error=the feature `studio` has no pages to embed ({}: {why}); `cargo xtask studio` makes them, with Node",
            folder.display()
        );
    }
}

/// Writes the table of the pages, as Rust.
fn write(folder: &Path) -> io::Result<()> {
    let mut files = Vec::new();
    find(folder, &mut files)?;
    files.sort();
    let mut table = String::from("const PAGES: Pages = &[\n");
    for file in &files {
        let inside = file.strip_prefix(folder).unwrap_or(file).to_string_lossy();
        let path = inside.trim_end_matches(".gz").replace('\\', "/");
        let absolute = fs::canonicalize(file)?;
        let _ = writeln!(table, "    ({path:?}, include_bytes!({absolute:?})),");
    }
    table.push_str("];\n");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("studio_pages.rs"), table)
}

fn find(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            find(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "gz") {
            files.push(path);
        }
    }
    Ok(())
}
