//! The motion tables of a GLB: made by `build`, checked whenever the file is played.
//!
//! Source: `spec/motion-lod.md` 9. A table that was made for another rig, clip or mesh is an
//! error, never a warning.

use crate::console::Console;
use crate::prepared::Prepared;
use anyhow::Context;
use articula_build::Asset;
use articula_build::evaluate::Points;
use articula_build::motion_error::levers;
use articula_build::motion_error::pose_keys;
use articula_build::motion_error::{hashes, key_table};
use articula_core::{KeyMode, KeyTable, Mismatch, PoseKeys};
use articula_formats::Limits;
use articula_formats::motion_table::{read_pose_keys, read_segs, write_pose_keys, write_segs};
use rayon::prelude::*;
use serde::Serialize;

/// Names of the tables in the file.
pub(crate) const SEGS: &str = "segs";
pub(crate) const POSE_KEYS: &str = "posekeys";
/// Vertices that whole-pose keys watch.
const WATCHED: usize = 700;

/// The tables of one clip, as bytes.
#[derive(Debug)]
pub(crate) struct ClipTables {
    pub(crate) segs: Vec<u8>,
    pub(crate) pose_keys: Vec<u8>,
    /// Keys of all joints at each level, from the finest.
    pub(crate) keys: Vec<usize>,
}

/// Makes the tables of every clip; `seed` chooses the vertices that pose keys watch.
pub(crate) fn made(asset: &Asset, seed: u64, console: &Console) -> Vec<ClipTables> {
    let bar = console.progress("making motion tables", asset.clips.len());
    let levers = levers(&asset.rig, &asset.mesh);
    let points = Points::draw(asset, WATCHED, seed);
    let of_clip = |clip| {
        let table = key_table(asset, clip, &levers, KeyMode::Hold);
        let at = |level: usize| {
            let lists = table.keys.iter().filter_map(|joint| joint.get(level));
            lists.map(Vec::len).sum()
        };
        let tables = ClipTables {
            segs: write_segs(&table),
            pose_keys: write_pose_keys(&pose_keys(asset, clip, &points)),
            keys: (0..table.levels()).map(at).collect(),
        };
        bar.inc(1);
        tables
    };
    let tables = asset.clips.par_iter().map(of_clip).collect();
    bar.finish_and_clear();
    tables
}

/// Bytes of the tables that a clip has in its file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Stored {
    pub(crate) segs: usize,
    pub(crate) posekeys: usize,
}

impl Stored {
    /// Whether the clip has any table.
    pub(crate) fn any(self) -> bool {
        self.segs + self.posekeys > 0
    }
}

/// Reads and checks the tables of every clip of a file as it was stored; empty for files that
/// have none.
pub(crate) fn checked(prepared: &Prepared) -> anyhow::Result<Vec<Stored>> {
    let asset = &prepared.asset;
    let all = (0..asset.clips.len()).map(|clip| of_clip(prepared, clip));
    all.collect::<anyhow::Result<_>>()
        .with_context(|| prepared.loaded.place())
}

fn of_clip(prepared: &Prepared, clip: usize) -> anyhow::Result<Stored> {
    let Some(behind) = &prepared.loaded.behind else {
        return Ok(Stored::default());
    };
    let limits = Limits::default();
    let at =
        |name: &str| format!("animations[{clip}].extensions.ARTICULA_articulation.tables.{name}");
    let mut stored = Stored::default();
    if let Some(bytes) = behind.document.motion_table(clip, SEGS) {
        let table = read_segs(bytes, &limits).with_context(|| at(SEGS))?;
        check_segs(&prepared.asset, clip, &table).with_context(|| at(SEGS))?;
        stored.segs = bytes.len();
    }
    if let Some(bytes) = behind.document.motion_table(clip, POSE_KEYS) {
        let keys = read_pose_keys(bytes, &limits).with_context(|| at(POSE_KEYS))?;
        check_pose_keys(&prepared.asset, clip, &keys).with_context(|| at(POSE_KEYS))?;
        stored.posekeys = bytes.len();
    }
    Ok(stored)
}

fn check_segs(asset: &Asset, clip: usize, table: &KeyTable) -> Result<(), Mismatch> {
    let played = &asset.clips[clip];
    table.check(&hashes(&asset.rig, played, &asset.mesh))?;
    let last = table.keys.iter().flatten().filter_map(|keys| keys.last());
    if last.max().is_some_and(|k| *k as usize >= played.frames()) {
        let what = "a key lies beyond the clip; build the asset again";
        return Err(Mismatch::new("keys", what));
    }
    Ok(())
}

fn check_pose_keys(asset: &Asset, clip: usize, keys: &PoseKeys) -> Result<(), Mismatch> {
    // The hashes of both tables are checked by the one rule that is there.
    let as_table = KeyTable {
        hashes: keys.hashes,
        rate_hz: keys.tick_hz,
        frames: keys.ticks,
        base_metres: keys.base_metres,
        mode: KeyMode::Linear,
        keys: Vec::new(),
    };
    as_table.check(&hashes(&asset.rig, &asset.clips[clip], &asset.mesh))
}
