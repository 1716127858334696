//! The check that a program that only plays links no codec: the library without its features needs none.
//!
//! That the library compiles so is checked where it is built for WebAssembly (`wasm`).

use crate::outcome::Outcome;
use crate::processes::output;
use crate::workspace::cargo;
use anyhow::{Result, ensure};
use std::collections::BTreeSet;

/// Codecs, compressors, rasterisers and the reader of FBX, and the crates of the workspace that need them.
const REFUSED: &[&str] = &[
    "articula-flat",
    "articula-stream",
    "brotli",
    "fbx-rs",
    "flate2",
    "gif",
    "image-webp",
    "png",
    "resvg",
    "shiguredo_mp4",
    "tiny-skia",
    "usvg",
    "zune-jpeg",
];

/// Judges what the library links on any platform, without its features and with them.
pub(crate) fn check() -> Result<Outcome> {
    let without = tree(&["--no-default-features"])?;
    let faults = faults(&names(&without), &names(&tree(&[])?));
    for fault in &faults {
        println!("{fault}");
    }
    ensure!(faults.is_empty(), "{} faults of playback", faults.len());
    Ok(Outcome::Done)
}

/// Packages that the library links, one a line.
fn tree(features: &[&str]) -> Result<String> {
    let words = ["tree", "--offline", "--locked", "--package", "articula"];
    let form = ["--edges", "normal", "--target", "all", "--prefix", "none"];
    output(cargo().args(words).args(form).args(features))
}

/// Names of the packages; each line has a name, a version and remarks.
fn names(tree: &str) -> BTreeSet<&str> {
    let lines = tree.lines();
    lines.filter_map(|l| l.split_whitespace().next()).collect()
}

fn faults(playback: &BTreeSet<&str>, whole: &BTreeSet<&str>) -> Vec<String> {
    let mut faults = Vec::new();
    for name in REFUSED {
        if playback.contains(name) {
            faults.push(format!(
                "articula links {name} without any feature; only programs that do more than play may need it"
            ));
        } else if !whole.contains(name) {
            faults.push(format!(
                "articula links no {name}; name in its place what it links (xtask/src/playback.rs)"
            ));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_codec_is_refused_to_playback_alone() {
        let whole: BTreeSet<&str> = REFUSED.iter().copied().chain(["glam"]).collect();
        assert!(faults(&names("glam v0.34.2\nserde v1.0.0 (*)"), &whole).is_empty());
        let faults = faults(&names("glam v0.34.2\npng v0.18.1 (*)"), &whole);
        assert_eq!(faults.len(), 1);
        assert!(faults[0].starts_with("articula links png without"));
    }

    #[test]
    fn a_refused_name_that_nothing_links_is_told() {
        let mut whole: BTreeSet<&str> = REFUSED.iter().copied().collect();
        whole.remove("resvg");
        assert_eq!(faults(&names(""), &whole).len(), 1);
    }
}
