//! Motion tables that a GLB stores, checked whenever they are played.
//!
//! Source: `docs/methods/motion-lod.md` part 9. A table that was made for another rig, clip or mesh
//! is not used.

#[cfg(feature = "streams")]
mod compact;

use crate::figure::Figure;
use crate::old_hashes;
use crate::prepared::part::{COMPACT, CONTACTS, ERROR_MATRIX, POSE_KEYS, SEGS};
use articula_build::table_hashes;
use articula_core::playback::ErrorMatrixTable;
use articula_core::{ContactTable, KeyTable, Mismatch, PoseKeys, TableHashes};
use articula_formats::{Limits, ReadError};
use articula_formats::{read_contact_table, read_error_matrix, read_key_table, read_pose_keys};
use serde::Serialize;

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
    /// The clip as a motion stream (ABP-2); without the feature `streams` it is not read.
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
        let (rig, of_clip, mesh) = (&asset.rig, &asset.clips[clip], &asset.mesh);
        let current = table_hashes(rig, of_clip, mesh);
        // Older files have other hashes of the same data.
        let hashes = |stored: &TableHashes| {
            let is_old = || *stored == old_hashes::table_hashes(rig, of_clip, mesh);
            if *stored != current && is_old() {
                *stored
            } else {
                current
            }
        };
        let mut reader = TableReader {
            bytes: &|name| gltf.document.motion_table(clip, name),
            clip,
            warnings: Vec::new(),
        };
        let frames = asset.clips[clip].frames();
        found.joint_keys = reader.read(SEGS, read_key_table, |table| {
            table.check(&hashes(&table.hashes))?;
            let last = table.keys.iter().flatten().filter_map(|keys| keys.last());
            within(last.max().copied(), frames)
        });
        found.pose_keys = reader.read(POSE_KEYS, read_pose_keys, |keys| {
            keys.hashes.check(&hashes(&keys.hashes))
        });
        found.contacts = reader.read(CONTACTS, read_contact_table, |table| {
            table.hashes.check(&hashes(&table.hashes))?;
            let last = table.contacts.iter().map(|c| c.frames.end as u32 - 1);
            within(last.max(), frames)
        });
        found.error_matrix = reader.read(ERROR_MATRIX, read_error_matrix, |table| {
            table.hashes.check(&hashes(&table.hashes))
        });
        #[cfg(feature = "streams")]
        compact::read(&mut found, &mut reader, hashes, rig);
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
