//! Motion tables of a clip.
//!
//! Source: `docs/methods/motion-lod.md` part 9.

use super::options::PrepareOptions;
use super::part::PreparedPart;
use crate::clip_streams::rig_hash::rig_hash;
use crate::prepared::part::{COMPACT, CONTACTS, ERROR_MATRIX, POSE_KEYS, SEGS};
use articula_build::evaluate::error_matrix_table;
use articula_build::{
    Asset, JointLever, contact_table, key_table, levers, pose_keys, table_hashes,
};
use articula_core::{KeyMode, Mismatch};
use articula_formats::{
    write_compact_clip, write_contact_table, write_error_matrix, write_key_table, write_pose_keys,
};
use articula_stream::abp2::{MotionOptions, encode};

/// Number of vertices that whole-pose keys are computed from.
const WATCHED: usize = 700;

/// Encoded motion tables of one clip; a table that was left out is empty.
#[derive(Debug, Default)]
pub struct ClipTables {
    /// Keys of each joint by tolerance, as in `docs/formats/motion-tables.md`.
    pub segs: Vec<u8>,
    /// Keys of the whole pose.
    pub pose_keys: Vec<u8>,
    /// Error of each joint at each frame, after the thesis.
    pub error_matrix: Vec<u8>,
    /// Intervals in which feet stand still.
    pub contacts: Vec<u8>,
    /// Motion stream of the clip.
    pub compact: Vec<u8>,
    /// Greatest error of the motion stream in metres of skin.
    pub compact_error_metres: f64,
    /// Number of keys over all joints at each level, finest first.
    pub keys: Vec<usize>,
}

impl ClipTables {
    /// Size of a part in bytes; 0 if it is none of these tables.
    pub(super) fn bytes(&self, part: PreparedPart) -> usize {
        let own = self.stored().find(|(name, _)| Some(*name) == part.table());
        own.map_or(0, |(_, bytes)| bytes.len())
    }

    /// Names and bytes of the tables that were made.
    pub(super) fn stored(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        let all = [
            (SEGS, self.segs.as_slice()),
            (POSE_KEYS, &self.pose_keys),
            (ERROR_MATRIX, &self.error_matrix),
            (CONTACTS, &self.contacts),
            (COMPACT, &self.compact),
        ];
        all.into_iter().filter(|(_, bytes)| !bytes.is_empty())
    }
}

/// Shared inputs of the tables of all clips.
#[derive(Debug)]
pub(super) struct TableMaker<'a> {
    asset: &'a Asset,
    levers: Vec<JointLever>,
    seed: u64,
}

impl<'a> TableMaker<'a> {
    /// Prepares table making; `seed` selects the vertices of whole-pose keys.
    pub(super) fn new(asset: &'a Asset, seed: u64) -> Self {
        Self {
            asset,
            levers: levers(&asset.rig, &asset.mesh),
            seed,
        }
    }

    /// Computes the tables of one clip.
    ///
    /// # Errors
    /// A [`Mismatch`] if the clip cannot be coded as a motion stream.
    pub(super) fn tables(
        &self,
        clip: usize,
        options: &PrepareOptions,
    ) -> Result<ClipTables, Mismatch> {
        let clip = &self.asset.clips[clip];
        let is_wanted = |part| options.wants(part);
        let mut tables = ClipTables::default();
        if is_wanted(PreparedPart::JointKeys) {
            let table = key_table(self.asset, clip, &self.levers, KeyMode::Hold);
            let at = |level: usize| {
                let lists = table.keys.iter().filter_map(|joint| joint.get(level));
                lists.map(Vec::len).sum()
            };
            tables.segs = write_key_table(&table);
            tables.keys = (0..table.levels()).map(at).collect();
        }
        if is_wanted(PreparedPart::PoseKeys) {
            tables.pose_keys = write_pose_keys(&pose_keys(self.asset, clip, WATCHED, self.seed));
        }
        if is_wanted(PreparedPart::Contacts) {
            tables.contacts = write_contact_table(&contact_table(self.asset, clip));
        }
        if is_wanted(PreparedPart::ErrorMatrix) {
            tables.error_matrix = write_error_matrix(&error_matrix_table(self.asset, clip));
        }
        if let Some(compact) = &options.compact_clips
            && is_wanted(PreparedPart::CompactClips)
        {
            let Asset { rig, mesh, .. } = self.asset;
            let hashes = table_hashes(rig, clip, mesh);
            let options = MotionOptions {
                rig_hash: rig_hash(rig),
                ..compact.clone()
            };
            let coded = encode(rig, mesh, clip, &options).map_err(|mut e| {
                e.at = format!("clip \"{}\": {}", clip.name, e.at);
                e
            })?;
            tables.compact = write_compact_clip(&hashes, &coded.bytes);
            tables.compact_error_metres = coded.errors.first().map_or(0.0, |e| e.max_metres);
        }
        Ok(tables)
    }
}
