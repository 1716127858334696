//! Draco in node: coded sizes of meshes (`oracle/draco.mjs`).

use super::node;
use crate::wire_mesh::{PRECISION, WireMesh};
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use serde_json::{Value, json};
use std::process::Command;

/// Message for missing results of Draco.
pub(crate) const MISSING: &str = "Draco (no node, or `npm ci` was not run in oracle)";

/// Coded size of one mesh in bytes.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Coded {
    /// All attributes and the connectivity.
    pub(crate) bytes: usize,
    /// If requested: bytes with only the first of [`kinds`], with the first two, and so on.
    #[serde(default)]
    pub(crate) steps: Vec<usize>,
    /// If requested: bytes with positions of one bit per coordinate, an estimate of the connectivity.
    #[serde(default)]
    pub(crate) connectivity: usize,
}

/// Kinds of values of a mesh, in the order of [`Coded::steps`].
pub(crate) fn kinds(mesh: &WireMesh) -> Vec<&'static str> {
    let has = [
        ("position", true),
        ("normal", !mesh.normals.is_empty()),
        ("texcoord", !mesh.texcoords.is_empty()),
        ("color", !mesh.colors.is_empty()),
        ("joints", !mesh.joints.is_empty()),
        ("weights", !mesh.weights.is_empty()),
    ];
    has.iter().filter(|(_, h)| *h).map(|(k, _)| *k).collect()
}

/// A mesh to code, and whether to measure its kinds of values separately.
pub(crate) struct Task<'a> {
    pub(crate) mesh: &'a WireMesh,
    pub(crate) steps: bool,
}

/// Codes each mesh. `None` where node or its packages are missing and `ARTICULA_REQUIRE_TOOLS`
/// does not require them.
pub(crate) fn code(tasks: &[Task<'_>]) -> Result<Option<Vec<Coded>>> {
    if !node::has(&["node_modules/draco3dgltf"])? {
        return Ok(None);
    }
    let path = std::env::temp_dir().join(format!("articula-draco-{}.bin", std::process::id()));
    std::fs::write(&path, file(tasks)).with_context(|| path.display().to_string())?;
    let output = Command::new("node")
        .arg(node::oracle().join("draco.mjs"))
        .arg(&path)
        .output();
    std::fs::remove_file(&path)?;
    let output = output.context("node does not start")?;
    if !output.status.success() {
        bail!("Draco: {}", String::from_utf8_lossy(&output.stderr));
    }
    let coded: Vec<Coded> =
        serde_json::from_slice(&output.stdout).context("what draco.mjs prints")?;
    ensure!(coded.len() == tasks.len(), "Draco left meshes out");
    Ok(Some(coded))
}

/// Header and arrays in the form that the script reads.
fn file(tasks: &[Task<'_>]) -> Vec<u8> {
    let mut body = Vec::new();
    let entries: Vec<Value> = tasks.iter().map(|task| entry(task, &mut body)).collect();
    let head = json!({ "meshes": entries }).to_string();
    let mut file = (head.len() as u32).to_le_bytes().to_vec();
    file.extend(head.as_bytes());
    file.extend(body);
    file
}

fn entry(task: &Task<'_>, body: &mut Vec<u8>) -> Value {
    let mesh = task.mesh;
    let mut attributes = Vec::new();
    let mut add = |kind: &str, size: usize, kept: &str, bytes: Vec<u8>, more: Value| {
        if bytes.is_empty() {
            return;
        }
        let mut entry = json!({ "kind": kind, "size": size, "type": kept, "offset": body.len() });
        if let (Some(entry), Value::Object(more)) = (entry.as_object_mut(), more) {
            entry.extend(more);
        }
        attributes.push(entry);
        body.extend(bytes);
    };
    // Whole numbers on their own grid: rounding does not change them.
    let grid = |bits: u8, size: usize| json!({ "bits": bits, "origin": vec![0; size], "range": (1u32 << bits) - 1 });
    let positions = floats(mesh.positions.iter().flatten().map(|x| f32::from(*x)));
    add(
        "POSITION",
        3,
        "f32",
        positions,
        grid(PRECISION.position_bits, 3),
    );
    let normals = floats(mesh.normals.iter().flat_map(|n| n.to_array()));
    add(
        "NORMAL",
        3,
        "f32",
        normals,
        json!({ "bits": PRECISION.normal_bits }),
    );
    let texcoords = floats(mesh.texcoords.iter().flatten().map(|x| f32::from(*x)));
    add(
        "TEX_COORD",
        2,
        "f32",
        texcoords,
        grid(PRECISION.texcoord_bits, 2),
    );
    let colors = mesh.colors.iter().flatten().copied().collect();
    add("COLOR", 4, "u8", colors, json!({}));
    let joints = mesh.joints.iter().flatten();
    if joints.clone().all(|j| *j < 256) {
        add(
            "GENERIC",
            4,
            "u8",
            joints.map(|j| *j as u8).collect(),
            json!({}),
        );
    } else {
        let bytes = joints.flat_map(|j| j.to_le_bytes()).collect();
        add("GENERIC", 4, "u16", bytes, json!({}));
    }
    let weights = mesh.weights.iter().flatten().copied().collect();
    add("GENERIC", 4, "u8", weights, json!({}));
    let indices = body.len();
    body.extend(
        mesh.triangles
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes()),
    );
    json!({
        "name": "",
        "steps": task.steps,
        "vertices": mesh.vertices(),
        "triangles": mesh.triangles.len(),
        "indices": indices,
        "attributes": attributes,
    })
}

fn floats(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(f32::to_le_bytes).collect()
}
