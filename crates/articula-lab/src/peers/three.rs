//! three.js in node: mixer, world matrices and joint matrices of a crowd
//! (`oracle/crowd_times.mjs`).

use super::node;
use crate::measure::Timing;
use anyhow::{Context, Result, bail};
use serde::Deserialize;
use std::path::Path;
use std::process::Command;

/// Times in nanoseconds per character and frame.
#[derive(Debug, Deserialize)]
pub(crate) struct ThreeTimes {
    /// Number of joints of its skeletons.
    pub(crate) joints: usize,
    /// Sampling only.
    mixer: Timing,
    /// Sampling and the world matrices of all nodes.
    world: Timing,
    /// Sampling, world matrices and joint matrices for skinning on the GPU.
    joint_matrices: Timing,
}

impl ThreeTimes {
    /// The three times, each including the previous steps.
    pub(crate) fn steps(&self) -> [Timing; 3] {
        [self.mixer, self.world, self.joint_matrices]
    }
}

/// Amount of work in a timing run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) count: usize,
    pub(crate) frames: usize,
    pub(crate) rounds: usize,
}

/// Times a crowd of characters of one file. `None` where node or its packages are missing and
/// `ARTICULA_REQUIRE_TOOLS` does not require them.
pub(crate) fn times(file: &Path, clip: &str, effort: Effort) -> Result<Option<ThreeTimes>> {
    if !node::has(&["node_modules/three"])? {
        return Ok(None);
    }
    let numbers = [effort.count, effort.frames, effort.rounds].map(|n| n.to_string());
    let output = Command::new("node")
        .arg(node::oracle().join("crowd_times.mjs"))
        .arg(file)
        .arg(clip)
        .args(numbers)
        .output()
        .context("node does not start")?;
    if !output.status.success() {
        bail!("three.js: {}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(Some(
        serde_json::from_slice(&output.stdout).context("what crowd_times.mjs prints")?,
    ))
}
