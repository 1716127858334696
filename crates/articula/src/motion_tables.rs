//! Motion tables of a GLB: made by `prepare`, checked whenever the file is played.
//!
//! Source: `docs/methods/motion-lod.md` part 9. A table that was made for another rig, clip or mesh
//! is an error, not a warning.

use crate::error::{Context, Result};
use crate::figure::Figure;
use articula_build::Asset;
use articula_build::pose_keys;
use articula_build::{JointLever, levers};
use articula_build::{key_table, table_hashes};
use articula_core::{KeyMode, KeyTable, Mismatch, PoseKeys};
use articula_formats::Limits;
use articula_formats::{read_key_table, read_pose_keys, write_key_table, write_pose_keys};
use serde::Serialize;

/// Names of the tables in the file.
pub(crate) const SEGS: &str = "segs";
pub(crate) const POSE_KEYS: &str = "posekeys";
/// Number of vertices that whole-pose keys are computed from.
const WATCHED: usize = 700;

/// Encoded motion tables of one clip: joint keys and whole-pose keys for a series of tolerances.
#[derive(Debug)]
pub struct ClipTables {
    /// Keys of each joint by tolerance, as in `docs/formats`.
    pub segs: Vec<u8>,
    /// Keys of the whole pose.
    pub pose_keys: Vec<u8>,
    /// Number of keys over all joints at each level, finest first.
    pub keys: Vec<usize>,
}

/// Shared inputs of the tables of all clips.
#[derive(Debug)]
pub(crate) struct TableMaker<'a> {
    asset: &'a Asset,
    levers: Vec<JointLever>,
    seed: u64,
}

impl<'a> TableMaker<'a> {
    /// Prepares table making; `seed` selects the vertices of whole-pose keys.
    pub(crate) fn new(asset: &'a Asset, seed: u64) -> Self {
        Self {
            asset,
            levers: levers(&asset.rig, &asset.mesh),
            seed,
        }
    }

    /// Computes the tables of one clip.
    pub(crate) fn tables(&self, clip: usize) -> ClipTables {
        let clip = &self.asset.clips[clip];
        let table = key_table(self.asset, clip, &self.levers, KeyMode::Hold);
        let pose_keys = pose_keys(self.asset, clip, WATCHED, self.seed);
        let at = |level: usize| {
            let lists = table.keys.iter().filter_map(|joint| joint.get(level));
            lists.map(Vec::len).sum()
        };
        ClipTables {
            segs: write_key_table(&table),
            pose_keys: write_pose_keys(&pose_keys),
            keys: (0..table.levels()).map(at).collect(),
        }
    }
}

/// Sizes of the motion tables stored for one clip, in bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct StoredTables {
    /// Size of the key table.
    pub segs: usize,
    /// Size of the whole-pose keys.
    pub posekeys: usize,
}

impl StoredTables {
    /// Returns whether the clip has any table.
    pub fn any(self) -> bool {
        self.segs + self.posekeys > 0
    }
}

/// Reads and checks the stored tables of every clip; sizes are 0 where a clip has none.
///
/// # Errors
/// An [`Error`](crate::Error) that names a table that is malformed or was made for another rig,
/// clip or mesh.
pub fn stored_tables(figure: &Figure) -> Result<Vec<StoredTables>> {
    let asset = &figure.asset;
    let all = (0..asset.clips.len()).map(|clip| of_clip(figure, clip));
    all.collect::<Result<_>>()
        .with_context(|| &figure.opened.name)
}

/// Reads the stored key table of a clip; `None` if there is none that fits the rig, clip and mesh.
pub(crate) fn stored_key_table(figure: &Figure, clip: usize) -> Option<KeyTable> {
    let gltf = figure.opened.gltf.as_ref()?;
    let bytes = gltf.document.motion_table(clip, SEGS)?;
    let table = read_key_table(bytes, &Limits::default()).ok()?;
    check_segs(&figure.asset, clip, &table).ok()?;
    Some(table)
}

fn of_clip(figure: &Figure, clip: usize) -> Result<StoredTables> {
    let Some(gltf) = &figure.opened.gltf else {
        return Ok(StoredTables::default());
    };
    let limits = Limits::default();
    let at =
        |name: &str| format!("animations[{clip}].extensions.ARTICULA_articulation.tables.{name}");
    let mut stored = StoredTables::default();
    if let Some(bytes) = gltf.document.motion_table(clip, SEGS) {
        let table = read_key_table(bytes, &limits).with_context(|| at(SEGS))?;
        check_segs(&figure.asset, clip, &table).with_context(|| at(SEGS))?;
        stored.segs = bytes.len();
    }
    if let Some(bytes) = gltf.document.motion_table(clip, POSE_KEYS) {
        let keys = read_pose_keys(bytes, &limits).with_context(|| at(POSE_KEYS))?;
        check_pose_keys(&figure.asset, clip, &keys).with_context(|| at(POSE_KEYS))?;
        stored.posekeys = bytes.len();
    }
    Ok(stored)
}

fn check_segs(asset: &Asset, clip: usize, table: &KeyTable) -> Result<(), Mismatch> {
    let played = &asset.clips[clip];
    table.check(&table_hashes(&asset.rig, played, &asset.mesh))?;
    let last = table.keys.iter().flatten().filter_map(|keys| keys.last());
    if last.max().is_some_and(|k| *k as usize >= played.frames()) {
        let what = "a key is after the end of the clip; rebuild the asset";
        return Err(Mismatch::new("keys", what));
    }
    Ok(())
}

fn check_pose_keys(asset: &Asset, clip: usize, keys: &PoseKeys) -> Result<(), Mismatch> {
    // Pose keys have the same hashes, so they are checked by the same rule.
    let as_table = KeyTable {
        hashes: keys.hashes,
        rate_hz: keys.tick_hz,
        frames: keys.ticks,
        base_metres: keys.base_metres,
        mode: KeyMode::Linear,
        keys: Vec::new(),
    };
    as_table.check(&table_hashes(&asset.rig, &asset.clips[clip], &asset.mesh))
}
