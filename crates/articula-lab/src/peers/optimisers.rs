//! Other optimisers of glTF files, and the judge of all files, in node (`oracle/peers`).

use super::node;
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Message for missing results of the peers.
pub(crate) const MISSING: &str = "gltfpack, glTF-Transform, Babylon.js and three.js (no node, or `npm ci` was not run in oracle and oracle/peers)";

/// The file of a peer.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct PeerFile {
    pub(crate) peer: String,
    pub(crate) setting: String,
    /// `None` if there is a fault.
    pub(crate) file: Option<PathBuf>,
    pub(crate) fault: Option<String>,
}

/// The error and the size of a file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Judged {
    /// Greatest error in motion; `None` if the file cannot be read.
    pub(crate) error_mm: Option<f64>,
    /// Height of the source at rest.
    pub(crate) height_mm: f64,
    /// Bytes without pictures.
    pub(crate) bytes: usize,
    /// Bytes of the JSON document.
    pub(crate) json: usize,
    /// Bytes of the pictures.
    pub(crate) pictures: usize,
    /// Bytes without pictures, after brotli.
    pub(crate) brotli: usize,
}

/// How Babylon.js shows a file beside three.js.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Shown {
    /// Greatest distance of a vertex between the two in any pose; `None` if Babylon.js cannot read the file.
    pub(crate) apart_mm: Option<f64>,
    /// Why it cannot.
    pub(crate) fault: Option<String>,
}

/// Whether the peers and the judge can run.
///
/// # Errors
/// If they are missing and `ARTICULA_REQUIRE_TOOLS` requires them.
pub(crate) fn are_there() -> Result<bool> {
    node::has(&[
        "node_modules/three",
        "peers/node_modules/gltfpack",
        "peers/node_modules/@babylonjs/loaders",
    ])
}

/// How files are judged beside their source.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Judge<'a> {
    /// Vertices are followed.
    Vertices,
    /// Vertices of this character are followed, which plays the clips of the files.
    VerticesOf(&'a Path),
    /// Surfaces are compared, whatever their triangles.
    Surfaces,
}

/// Writes the file of every peer for a source into a folder, with a part of its triangles if one is given.
pub(crate) fn files(source: &Path, folder: &Path, part: Option<&str>) -> Result<Vec<PeerFile>> {
    let part = part.map(Path::new);
    let words: Vec<&Path> = [source, folder].into_iter().chain(part).collect();
    answer("files.mjs", &words)
}

/// Judges files beside their source.
pub(crate) fn judged(judge: Judge<'_>, source: &Path, files: &[&Path]) -> Result<Vec<Judged>> {
    let (script, mut words) = match judge {
        Judge::Vertices => ("errors.mjs", vec![]),
        Judge::VerticesOf(skin) => ("errors.mjs", vec![Path::new("--skin"), skin]),
        Judge::Surfaces => ("surfaces.mjs", vec![]),
    };
    words.push(source);
    words.extend(files);
    let rows: Vec<Judged> = answer(script, &words)?;
    ensure!(rows.len() == files.len(), "{script} left files out");
    Ok(rows)
}

/// Compares how Babylon.js shows a file with how three.js does.
pub(crate) fn shown_by_babylon(file: &Path) -> Result<Shown> {
    let rows: Vec<Shown> = answer("babylon.mjs", &[file])?;
    rows.into_iter()
        .next()
        .context("babylon.mjs printed no row")
}

fn answer<T: DeserializeOwned>(script: &str, words: &[&Path]) -> Result<T> {
    let mut command = Command::new("node");
    let output = command
        .arg(node::oracle().join("peers").join(script))
        .args(words);
    let output = output.output().context("node does not start")?;
    if !output.status.success() {
        bail!("{script}: {}", String::from_utf8_lossy(&output.stderr));
    }
    serde_json::from_slice(&output.stdout).with_context(|| format!("what {script} prints"))
}
