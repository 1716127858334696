//! Impostors that were baked before, as the table beside their atlas tells of them.
//!
//! Format: `docs/formats/impostor.md`. Directions and pictures are the renderer's; a crowd needs the poses
//! and the errors.

use crate::error::{Error, Result};
use articula_core::{Clip, ClipImpostors, Impostors};
use serde::Deserialize;

/// Name and version of the format.
const FORMAT: &str = "articula-impostor";
const VERSION: u32 = 1;

/// Most poses of all clips: more pictures than the largest atlas has pixels in a row.
const MAX_POSES: usize = 1 << 16;

/// Share of a clip's duration by which that of its pictures may differ.
const SAME_DURATION: f32 = 1e-3;

/// Poses and errors of impostors that were baked before.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "TableFile")]
pub struct BakedImpostors {
    clips: Vec<ClipFile>,
}

/// The members of a table that a crowd reads.
#[derive(Debug, Deserialize)]
struct TableFile {
    format: String,
    version: u32,
    clips: Vec<ClipFile>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct ClipFile {
    name: String,
    duration_secs: f32,
    error_m: f32,
    first_pose: usize,
    from_secs: Vec<f32>,
}

impl BakedImpostors {
    /// Reads the table that `articula flatten --profile impostor` writes.
    ///
    /// # Errors
    /// An [`Error`] that names the line or the clip and its fault.
    pub fn read(json: &[u8]) -> Result<Self> {
        serde_json::from_slice(json).map_err(|e| Error::unsuited(format!("impostors: {e}")))
    }

    /// The table of a crowd with these clips, which are on the spot.
    pub(super) fn table(&self, clips: &[Clip]) -> Result<Impostors> {
        let of_clip = |clip: &Clip| self.of(clip, clips.len() == 1);
        let found: Vec<_> = clips.iter().map(of_clip).collect::<Result<_>>()?;
        if found.iter().all(Option::is_none) {
            let known: Vec<&str> = self.clips.iter().map(|clip| clip.name.as_str()).collect();
            let known = known.join(", ");
            return Err(Error::unsuited(format!(
                "impostors: they show none of the clips, but {known}"
            )));
        }
        let durations: Vec<f32> = clips.iter().map(Clip::duration_secs).collect();
        Ok(Impostors::new(found, &durations)?)
    }

    /// The poses of a clip; those without a name are of a character that has no clip.
    fn of(&self, clip: &Clip, is_alone: bool) -> Result<Option<ClipImpostors>> {
        let is_it = |baked: &&ClipFile| {
            baked.name == clip.name || (is_alone && baked.name.is_empty() && clip.frames() == 1)
        };
        let Some(baked) = self.clips.iter().find(is_it) else {
            return Ok(None);
        };
        let (takes, shown) = (clip.duration_secs(), baked.duration_secs);
        if (takes - shown).abs() > SAME_DURATION * takes {
            return Err(Error::unsuited(format!(
                "impostors: those of {} are of {shown} s, the clip takes {takes} s; bake them of this file",
                clip.name
            )));
        }
        let first = baked.first_pose as u32;
        let (secs, error) = (&baked.from_secs, baked.error_m);
        Ok(Some(ClipImpostors::of_stretches(first, secs, shown, error)))
    }
}

impl TryFrom<TableFile> for BakedImpostors {
    type Error = String;

    fn try_from(file: TableFile) -> std::result::Result<Self, String> {
        if file.format != FORMAT || file.version != VERSION {
            let (format, version) = (file.format, file.version);
            return Err(format!(
                "{format} {version} is not {FORMAT} {VERSION}; docs/formats/impostor.md describes it"
            ));
        }
        let mut poses = 0;
        for clip in &file.clips {
            clip.check(poses)
                .map_err(|what| format!("clip {}: {what}", clip.name))?;
            poses += clip.from_secs.len();
        }
        if poses > MAX_POSES {
            return Err(format!("{poses} poses; at most {MAX_POSES} are read"));
        }
        Ok(Self { clips: file.clips })
    }
}

impl ClipFile {
    /// Checks a clip that comes after so many poses.
    fn check(&self, poses: usize) -> std::result::Result<(), &'static str> {
        let is_length = |number: f32| number.is_finite() && number >= 0.0;
        let is_ascending = self.from_secs.is_sorted_by(|a, b| a < b);
        if self.first_pose != poses {
            return Err("first_pose does not follow the clip before");
        }
        if self.from_secs.first() != Some(&0.0) || !is_ascending {
            return Err("from_secs does not ascend from 0");
        }
        if !(is_length(self.duration_secs) && is_length(self.error_m)) {
            return Err("duration_secs and error_m must be finite and not negative");
        }
        Ok(())
    }
}
