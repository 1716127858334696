//! Tables of key frames for a series of tolerances, such that the keys of the levels nest.
//!
//! Source: `docs/methods/motion-lod.md` parts 4.5, 6 and 9. Level 0 is the finest; level `k`
//! tolerates `base * 2^k` metres of skin displacement. The keys of a coarser level are among those
//! of every finer one, so that levels can be stored and streamed as increments.

use crate::Mismatch;

/// Interpolation of a joint's rotation between two keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyMode {
    /// The rotation of the previous key.
    Hold,
    /// The normalised linear blend of the previous and the next key.
    Linear,
}

/// Hashes of the inputs of a table, which is invalid for any other rig, clip or mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TableHashes {
    /// Hash of joint names, parents and rest pose.
    pub rig: u64,
    /// Hash of the clip's frames.
    pub clip: u64,
    /// Hash of the skin.
    pub mesh: u64,
}

impl TableHashes {
    /// Checks the hashes of a table against those of a rig, clip and mesh.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the part whose hash differs.
    pub fn check(&self, hashes: &Self) -> Result<(), Mismatch> {
        let pairs = [
            ("rig", self.rig, hashes.rig),
            ("clip", self.clip, hashes.clip),
            ("mesh", self.mesh, hashes.mesh),
        ];
        for (name, stored, found) in pairs {
            if stored != found {
                let what = format!(
                    "the table was built for another {name} (hash {stored:016x}, expected \
                     {found:016x}); rebuild the asset"
                );
                return Err(Mismatch::new(format!("hashes.{name}"), what));
            }
        }
        Ok(())
    }
}

/// Key frames of every joint at every tolerance level.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyTable {
    /// Hashes of the rig, clip and mesh for which the table was made.
    pub hashes: TableHashes,
    /// Frames per second of the clip.
    pub rate_hz: f32,
    /// Number of frames of the clip.
    pub frames: u32,
    /// Tolerance of level 0 in metres.
    pub base_metres: f32,
    /// Interpolation between keys.
    pub mode: KeyMode,
    /// `keys[joint][level]`: ascending frame numbers, the first 0; empty for a joint that does not
    /// move.
    pub keys: Vec<Vec<Vec<u32>>>,
}

impl KeyTable {
    /// Returns the number of levels.
    pub fn levels(&self) -> usize {
        self.keys.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Returns the coarsest level whose tolerance does not exceed `tolerance_metres`; `None` if
    /// even the finest is too coarse and the joint must be evaluated.
    pub fn level_for(&self, tolerance_metres: f32) -> Option<usize> {
        let highest = self.levels().checked_sub(1)?;
        // Doubling is exact, so the level is the same on every platform.
        let mut next = self.base_metres;
        let mut fitting = 0;
        while fitting <= highest && next <= tolerance_metres {
            fitting += 1;
            next *= 2.0;
        }
        fitting.checked_sub(1)
    }

    /// Returns the key at or before a frame, and the next key if there is one.
    pub fn span(&self, joint: usize, level: usize, frame: u32) -> Option<(u32, Option<u32>)> {
        let keys = self.keys.get(joint)?.get(level)?;
        let after = keys.partition_point(|k| *k <= frame);
        Some((*keys.get(after.checked_sub(1)?)?, keys.get(after).copied()))
    }

    /// Checks the hashes of the table and the nesting of its levels.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the part whose hash differs, or the level that does not nest.
    pub fn check(&self, hashes: &TableHashes) -> Result<(), Mismatch> {
        self.hashes.check(hashes)?;
        for (j, levels) in self.keys.iter().enumerate() {
            for (k, pair) in levels.windows(2).enumerate() {
                if !pair[1].iter().all(|f| pair[0].binary_search(f).is_ok()) {
                    let what = "every key of a coarser level must also be a key of the finer level";
                    return Err(Mismatch::new(format!("keys[{j}][{}]", k + 1), what));
                }
            }
        }
        Ok(())
    }
}

/// Times of whole-pose keys, such that every vertex stays within the tolerance of a straight line
/// between two keys.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseKeys {
    /// Hashes of the rig, clip and mesh for which the keys were made.
    pub hashes: TableHashes,
    /// Ticks per second of the key times; denser than the clip's frames.
    pub tick_hz: f32,
    /// Last tick, the end of the clip.
    pub ticks: u32,
    /// Tolerance of level 0 in metres.
    pub base_metres: f32,
    /// `levels[k]`: ascending ticks from 0 to the last, or `None` if the keys would hardly be more
    /// than two display frames apart and every frame is to be evaluated.
    pub levels: Vec<Option<Vec<u32>>>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> KeyTable {
        KeyTable {
            hashes: TableHashes {
                rig: 1,
                clip: 2,
                mesh: 3,
            },
            rate_hz: 30.0,
            frames: 10,
            base_metres: 0.001,
            mode: KeyMode::Hold,
            keys: vec![vec![vec![0, 3, 6], vec![0, 6]], vec![vec![], vec![]]],
        }
    }

    #[test]
    fn levels_and_spans_by_hand() {
        let t = table();
        assert_eq!(t.level_for(0.0005), None);
        assert_eq!(t.level_for(0.001), Some(0));
        assert_eq!(t.level_for(0.0039), Some(1));
        assert_eq!(t.level_for(9.0), Some(1));
        assert_eq!(t.span(0, 0, 4), Some((3, Some(6))));
        assert_eq!(t.span(0, 1, 9), Some((6, None)));
        assert_eq!(
            t.span(1, 0, 4),
            None,
            "a joint that does not move has no key"
        );
    }

    #[test]
    fn another_clip_or_a_table_that_is_not_nested_is_refused() {
        let t = table();
        assert!(t.check(&t.hashes).is_ok());
        let other = TableHashes {
            clip: 9,
            ..t.hashes
        };
        assert_eq!(t.check(&other).unwrap_err().at, "hashes.clip");
        let mut bad = table();
        bad.keys[0][1] = vec![0, 5];
        assert_eq!(bad.check(&t.hashes).unwrap_err().at, "keys[0][1]");
    }
}
