//! Libraries from npm that make visemes of speech, in node (`oracle/peers/visemes.mjs`).

use super::corpus::{Clip, shapes};
use crate::peers::node;
use anyhow::{Context, Result, bail};
use articula_speech::{VISEME_COUNT, VisemeFrame};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Message for missing results of the peers.
pub(super) const MISSING: &str =
    "headaudio and wlipsync (no node, or `npm ci` was not run in oracle/peers)";

/// Whether the peers can run.
///
/// # Errors
/// If they are missing and `ARTICULA_REQUIRE_TOOLS` requires them.
pub(super) fn are_there() -> Result<bool> {
    node::has(&[
        "peers/node_modules/@met4citizen/headaudio",
        "peers/node_modules/wlipsync",
    ])
}

/// A library, and the folder of the speech that its profile is made of.
pub(super) struct Peer {
    name: &'static str,
    folder: TempDir,
    profile: Vec<Known>,
}

/// Speech whose shapes are known.
#[derive(Debug, Clone, Serialize)]
struct Known {
    file: PathBuf,
    shapes: Vec<usize>,
}

#[derive(Serialize)]
struct Job<'a> {
    clips: Vec<PathBuf>,
    profile: &'a [Known],
}

impl Peer {
    pub(super) fn new(name: &'static str, profile: &[Clip]) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let known = profile.iter().enumerate().map(|(index, clip)| {
            let frames = clip.sound.samples.len() / 160;
            Ok(Known {
                file: store(folder.path(), &format!("known-{index}"), clip)?,
                shapes: shapes(&clip.segments, frames)
                    .iter()
                    .map(|v| v.number())
                    .collect(),
            })
        });
        Ok(Self {
            name,
            profile: known.collect::<Result<_>>()?,
            folder,
        })
    }

    /// What it hears in clips. It tells no level.
    pub(super) fn tracks(&self, clips: &[Clip]) -> Result<Vec<Vec<VisemeFrame>>> {
        let folder = self.folder.path();
        let stored = clips.iter().enumerate();
        let stored = stored.map(|(index, clip)| store(folder, &format!("clip-{index}"), clip));
        let job = Job {
            clips: stored.collect::<Result<_>>()?,
            profile: &self.profile,
        };
        let path = folder.join("job.json");
        std::fs::write(&path, serde_json::to_vec(&job)?)?;
        let output = Command::new("node")
            .arg(node::oracle().join("peers/visemes.mjs"))
            .arg(self.name)
            .arg(&path)
            .output()
            .context("node does not start")?;
        if !output.status.success() {
            bail!("{}: {}", self.name, String::from_utf8_lossy(&output.stderr));
        }
        let tracks: Vec<Vec<[f32; VISEME_COUNT]>> = serde_json::from_slice(&output.stdout)?;
        let frame = |weights| VisemeFrame {
            weights,
            level_db: 0.0,
        };
        let track = |weights: Vec<_>| weights.into_iter().map(frame).collect();
        Ok(tracks.into_iter().map(track).collect())
    }
}

/// The samples of a clip as a file of 32-bit numbers.
fn store(folder: &Path, name: &str, clip: &Clip) -> Result<PathBuf> {
    let path = folder.join(name);
    let samples = &clip.sound.samples;
    let bytes: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
    std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    Ok(path)
}
