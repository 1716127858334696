//! three.js in node: mixer, world matrices and joint matrices of a crowd (`oracle/crowd_times.mjs`).

use crate::measure::Timing;
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::path::Path;
use std::process::Command;

/// Nanoseconds for each character and frame.
#[derive(Debug, Deserialize)]
pub(crate) struct ThreeTimes {
    /// Joints that its skeletons have.
    pub(crate) joints: usize,
    /// Sampling alone.
    mixer: Timing,
    /// And the matrices of all nodes.
    world: Timing,
    /// And the matrices that a GPU skins with.
    joint_matrices: Timing,
}

impl ThreeTimes {
    /// The three steps, each with those before it.
    pub(crate) fn steps(&self) -> [Timing; 3] {
        [self.mixer, self.world, self.joint_matrices]
    }
}

/// How much is run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) count: usize,
    pub(crate) frames: usize,
    pub(crate) rounds: usize,
}

/// Times a crowd of one file's characters. `None` where node or its packages are missing and
/// `ARTICULA_REQUIRE_TOOLS` does not ask for them.
pub(crate) fn times(file: &Path, clip: &str, effort: Effort) -> Result<Option<ThreeTimes>> {
    let oracle = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../oracle");
    let node = Command::new("node").arg("--version").output();
    if node.is_err() || !oracle.join("node_modules/three").is_dir() {
        let required = std::env::var_os("ARTICULA_REQUIRE_TOOLS").is_some_and(|v| v == "1");
        ensure!(
            !required,
            "ARTICULA_REQUIRE_TOOLS=1, but no three.js in node"
        );
        return Ok(None);
    }
    let numbers = [effort.count, effort.frames, effort.rounds].map(|n| n.to_string());
    let output = Command::new("node")
        .arg(oracle.join("crowd_times.mjs"))
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
