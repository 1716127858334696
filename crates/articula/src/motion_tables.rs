//! Motion tables of a GLB: made by `prepare`, checked whenever they are played.
//!
//! Source: `docs/methods/motion-lod.md` part 9. A table that was made for another rig, clip or mesh
//! is not used.

use crate::figure::Figure;
use crate::prepared::PrepareOptions;
use crate::prepared::part::{COMPACT, CONTACTS, ERROR_MATRIX, POSE_KEYS, PreparedPart, SEGS};
use articula_build::evaluate::error_matrix_table;
use articula_build::{
    Asset, JointLever, contact_table, key_table, levers, pose_keys, table_hashes,
};
use articula_core::playback::ErrorMatrixTable;
use articula_core::{ContactTable, KeyMode, KeyTable, Mismatch, PoseKeys};
use articula_formats::{Limits, ReadError};
use articula_formats::{
    read_compact_clip, read_contact_table, read_error_matrix, read_key_table, read_pose_keys,
    write_compact_clip, write_contact_table, write_error_matrix, write_key_table, write_pose_keys,
};
use articula_stream::StreamLimits;
use articula_stream::abp2::{MotionOptions, MotionReceiver, encode};
use serde::Serialize;

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
    pub(crate) fn bytes(&self, part: PreparedPart) -> usize {
        let own = self.stored().find(|(name, _)| Some(*name) == part.table());
        own.map_or(0, |(_, bytes)| bytes.len())
    }

    /// Names and bytes of the tables that were made.
    pub(crate) fn stored(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
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
    ///
    /// # Errors
    /// A [`Mismatch`] if the clip cannot be coded as a motion stream.
    pub(crate) fn tables(
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
                rig_hash: hashes.rig,
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

/// Sizes of the motion tables stored for one clip, in bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct StoredTables {
    /// Size of the key table.
    pub segs: usize,
    /// Size of the whole-pose keys.
    pub posekeys: usize,
    /// Size of the motion stream.
    pub compact: usize,
}

impl StoredTables {
    /// Returns whether the clip has any table.
    pub fn any(self) -> bool {
        self.segs + self.posekeys + self.compact > 0
    }
}

/// The stored tables of one clip that belong to it, and what is wrong with the others.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MotionTables {
    /// Keys of each joint by tolerance.
    pub joint_keys: Option<KeyTable>,
    /// Keys of the whole pose.
    pub pose_keys: Option<PoseKeys>,
    /// Intervals in which feet stand still.
    pub contacts: Option<ContactTable>,
    /// Error of each joint at each frame, after the thesis, with default options.
    pub error_matrix: Option<ErrorMatrixTable>,
    /// The clip as a motion stream (ABP-2).
    pub compact: Option<Vec<u8>>,
    /// Sizes of tables in bytes; 0 for a table that is not used.
    pub bytes: StoredTables,
    /// Tables that are damaged or were made for another rig, clip or mesh, as text for the user.
    pub warnings: Vec<String>,
}

impl MotionTables {
    /// Reads and checks the tables that the figure's file stores for a clip.
    ///
    /// # Panics
    /// If there is no such clip.
    pub fn stored(figure: &Figure, clip: usize) -> Self {
        let asset = &figure.asset;
        let mut found = Self::default();
        let Some(gltf) = figure.opened.gltf() else {
            return found;
        };
        let hashes = table_hashes(&asset.rig, &asset.clips[clip], &asset.mesh);
        let mut reader = TableReader {
            bytes: &|name| gltf.document.motion_table(clip, name),
            clip,
            warnings: Vec::new(),
        };
        let frames = asset.clips[clip].frames();
        found.joint_keys = reader.read(SEGS, read_key_table, |table| {
            table.check(&hashes)?;
            let last = table.keys.iter().flatten().filter_map(|keys| keys.last());
            within(last.max().copied(), frames)
        });
        found.pose_keys = reader.read(POSE_KEYS, read_pose_keys, |keys| keys.hashes.check(&hashes));
        found.contacts = reader.read(CONTACTS, read_contact_table, |table| {
            table.hashes.check(&hashes)?;
            let last = table.contacts.iter().map(|c| c.frames.end as u32 - 1);
            within(last.max(), frames)
        });
        found.error_matrix = reader.read(ERROR_MATRIX, read_error_matrix, |table| {
            table.hashes.check(&hashes)
        });
        let compact = |bytes: &[u8], limits: &Limits| {
            let (hashes, stream) = read_compact_clip(bytes, limits)?;
            Ok((hashes, stream.to_vec()))
        };
        let compact = reader.read(COMPACT, compact, |(found, stream)| {
            found.check(&hashes)?;
            let limits = StreamLimits::default();
            let received = MotionReceiver::read(stream, &asset.rig, &limits);
            match received {
                Ok(received) if received.is_whole() => Ok(()),
                Ok(_) => Err(Mismatch::new("stream", "it ends early")),
                Err(e) => Err(Mismatch::new("stream", e.to_string())),
            }
        });
        found.compact = compact.map(|(_, stream)| stream);
        found.warnings = reader.warnings;
        let size = |name| {
            gltf.document
                .motion_table(clip, name)
                .map_or(0, <[u8]>::len)
        };
        found.bytes = StoredTables {
            segs: found.joint_keys.as_ref().map_or(0, |_| size(SEGS)),
            posekeys: found.pose_keys.as_ref().map_or(0, |_| size(POSE_KEYS)),
            compact: found.compact.as_ref().map_or(0, |_| size(COMPACT)),
        };
        found
    }
}

struct TableReader<'a> {
    bytes: &'a dyn Fn(&str) -> Option<&'a [u8]>,
    clip: usize,
    warnings: Vec<String>,
}

impl TableReader<'_> {
    fn read<T>(
        &mut self,
        name: &str,
        decode: impl FnOnce(&[u8], &Limits) -> Result<T, ReadError>,
        check: impl FnOnce(&T) -> Result<(), Mismatch>,
    ) -> Option<T> {
        let decoded = decode((self.bytes)(name)?, &Limits::default());
        let checked = decoded.map_err(|e| e.to_string()).and_then(|table| {
            check(&table).map_err(|e| e.to_string())?;
            Ok(table)
        });
        match checked {
            Ok(table) => Some(table),
            Err(what) => {
                let clip = self.clip;
                self.warnings.push(format!(
                    "animations[{clip}].extensions.ARTICULA_articulation.tables.{name}: {what}; it \
                     is not used, and `articula build` renews it"
                ));
                None
            }
        }
    }
}

fn within(last: Option<u32>, frames: usize) -> Result<(), Mismatch> {
    match last {
        Some(last) if last as usize >= frames => Err(Mismatch::new(
            "frames",
            "a key is after the end of the clip",
        )),
        _ => Ok(()),
    }
}
