//! The Khronos validator on many files, by a node script of the folder `oracle`.

use crate::peers::node;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::HashMap;
use std::path::PathBuf;
use std::process::Command;

/// Number of errors of each file.
pub(super) type Errors = HashMap<PathBuf, u64>;

/// Counts the errors of the validator in each file; `None` without node or its packages.
pub(super) fn errors(files: &[PathBuf]) -> Result<Option<Errors>> {
    if files.is_empty() || !node::has(&["node_modules/gltf-validator"])? {
        return Ok(None);
    }
    let output = Command::new("node")
        .arg(node::oracle().join("validate.mjs"))
        .args(files)
        .output()
        .context("node")?;
    let verdicts: Value =
        serde_json::from_slice(&output.stdout).context("the validator's answer")?;
    let Some(verdicts) = verdicts.as_array() else {
        bail!("the validator answers no list");
    };
    let verdict = |v: &Value| Some((v["file"].as_str()?.into(), v["errors"].as_u64()?));
    Ok(Some(verdicts.iter().filter_map(verdict).collect()))
}
