//! The table of levels in the extension of the document.

use super::version::{Counts, MAX_LEVELS, VERSION};
use crate::error::ReadError;
use crate::gltf::append::{set, short};
use crate::gltf::extension::CLUSTERED_MESH;
use crate::gltf::place::Place;
use crate::gltf::reader::Reader;
use crate::written::WriteError;
use articula_core::source::RawMesh;
use articula_core::{LevelRow, LevelTable, SurfaceError};
use serde_json::{Value, json};

/// Returns the table as JSON. Unknown errors, infinite in memory, are omitted.
pub(super) fn table(levels: &LevelTable) -> Result<Value, WriteError> {
    let mut rows = Vec::new();
    for (l, level) in levels.levels.iter().enumerate() {
        let mut row = json!({"triangles": level.triangles, "vertices": level.vertices});
        for (name, error) in [("errorRest", &level.rest), ("errorMotion", &level.motion)] {
            let numbers = members(error);
            if numbers.iter().any(|(_, x)| x.is_nan() || *x < 0.0) {
                let what = "an error must be at least 0 and not NaN";
                return Err(WriteError::mismatch(format!("levels[{l}].{name}"), what));
            }
            if numbers.iter().all(|(_, x)| x.is_finite()) {
                let value: Value = numbers.iter().map(|(k, x)| (*k, short(*x))).collect();
                set(&mut row, name, value);
            }
        }
        rows.push(row);
    }
    let mut table = json!({"version": VERSION, "levels": rows});
    if !levels.regions.is_empty() {
        set(&mut table, "regions", levels.regions.clone());
        set(&mut table, "mixableTo", levels.mixable_to);
    }
    Ok(table)
}

fn members(error: &SurfaceError) -> [(&'static str, f32); 4] {
    [
        ("max", error.max_metres),
        ("p99", error.p99_metres),
        ("p95", error.p95_metres),
        ("mean", error.mean_metres),
    ]
}

/// Reads the table, if meshes that were read have levels. A broken one is a warning: the levels can
/// be drawn, but their errors are unknown.
pub(in crate::gltf) fn read_levels(
    reader: &mut Reader<'_>,
    meshes: &[RawMesh],
) -> Option<LevelTable> {
    let extension = reader.root.dig(&["extensions", CLUSTERED_MESH])?;
    let clustered = meshes.iter().flat_map(|m| &m.clustered);
    let levels = clustered.map(|c| c.clusters.levels()).max()?;
    match read_table(&extension, levels) {
        Ok(table) => Some(table),
        Err(error) => {
            reader.warn(&extension, format!("the level table is left out: {error}"));
            None
        }
    }
}

/// Returns the number of levels in the table of the document.
pub(super) fn count(root: &Place<'_>) -> usize {
    let extension = root.dig(&["extensions", CLUSTERED_MESH]);
    extension.map_or(0, |e| e.count("levels").min(MAX_LEVELS + 1))
}

fn read_table(extension: &Place<'_>, levels: usize) -> Result<LevelTable, ReadError> {
    let counts = Counts::of(extension)?;
    let rows = extension.entries("levels")?;
    let rows = rows.iter().map(read_row).collect::<Result<Vec<_>, _>>()?;
    let regions = extension.entries("regions")?;
    let name = |p: &Place<'_>| {
        let name = p.value().as_str().map(str::to_owned);
        name.ok_or_else(|| p.malformed("expected a name"))
    };
    let mixable = match counts {
        Counts::FromFinest => extension.get("mixableTo"),
        Counts::FromCoarsest => extension.get("mixableFrom"),
    };
    let mixable = mixable.map(|p| p.index_below(levels)).transpose()?;
    let mixable = mixable.and_then(|stored| counts.level(stored, levels));
    Ok(LevelTable {
        levels: counts.list(rows),
        regions: regions.iter().map(name).collect::<Result<_, _>>()?,
        mixable_to: mixable.unwrap_or(levels - 1),
    })
}

fn read_row(row: &Place<'_>) -> Result<LevelRow, ReadError> {
    let error = |key| -> Result<SurfaceError, ReadError> {
        let Some(place) = row.get(key) else {
            // The errors of this level are unknown.
            return Ok(SurfaceError {
                max_metres: f32::INFINITY,
                p99_metres: f32::INFINITY,
                p95_metres: f32::INFINITY,
                mean_metres: f32::INFINITY,
            });
        };
        let number = |key| {
            let number = place.require(key)?;
            let metres = number.float()?;
            if metres < 0.0 {
                return Err(number.malformed("a distance must be at least 0"));
            }
            Ok(metres)
        };
        Ok(SurfaceError {
            max_metres: number("max")?,
            p99_metres: number("p99")?,
            p95_metres: number("p95")?,
            mean_metres: number("mean")?,
        })
    };
    Ok(LevelRow {
        triangles: row.require_whole("triangles")?,
        vertices: row.require_whole("vertices")?,
        rest: error("errorRest")?,
        motion: error("errorMotion")?,
    })
}
