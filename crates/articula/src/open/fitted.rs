//! Clips that were made for a character from those of another file.

use super::CharacterFile;
use crate::resampling::ClipResampling;
use articula_build::retarget::RetargetReport;
use articula_core::source::RawClip;
use std::collections::HashSet;

/// A clip of one file, transferred to the character of another.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedClip {
    /// The clip; its channels drive joints and meshes of the character.
    pub clip: RawClip,
    /// Provenance of the clip.
    pub fit: ClipProvenance,
}

/// Provenance of a transferred clip: source file and clip, matched channels and retargeting.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipProvenance {
    /// Name of the clip on the character.
    pub name: String,
    /// Name of the source file, as in errors and reports.
    pub file: String,
    /// Name of the clip in the source file.
    pub from: String,
    /// Number of channels of morph targets and expressions that were matched by name.
    pub morph_channels: usize,
    /// Greatest displacement of the source's skin between the frames that were retargeted and its keys
    /// in millimetres, and their rate per second; `None` if the keys were copied.
    pub resampling: Option<ClipResampling>,
    /// Report of the retargeting by the H-Anim mapping.
    pub retargeted: Option<RetargetReport>,
    /// Report of the retargeting by joint names, between rigs that are not both human. If this and
    /// `retargeted` are `None`, the skeleton is the same and the motion was copied.
    pub by_name: Option<NameTransfer>,
}

/// Report on a motion that was transferred by the names of the joints.
#[derive(Debug, Clone, PartialEq)]
pub struct NameTransfer {
    /// Number of moving joints of the source that a joint of the same name follows.
    pub followed: usize,
    /// Number of moving joints of the source.
    pub moving: usize,
    /// Factor of translations: length of the character's skeleton relative to that of the source.
    pub scale: f32,
    /// For each joint of the character the joint of the source that it follows.
    pub sources: Vec<Option<usize>>,
    /// Moving joints of the source that no joint of the character follows.
    pub dropped: Vec<usize>,
}

impl CharacterFile {
    /// Adds clips that [`fit_clips`](crate::convert::fit_clips) made for this character. A number is
    /// appended to names already in use; the returned reports have the final names.
    pub fn put_clips(&mut self, fitted: Vec<FittedClip>, keep_own: bool) -> Vec<ClipProvenance> {
        let clips = self.clips_mut();
        if !keep_own {
            clips.clear();
        }
        let mut taken: HashSet<String> = clips.iter().map(|c| c.name.clone()).collect();
        let mut fits = Vec::with_capacity(fitted.len());
        for FittedClip { mut clip, mut fit } in fitted {
            let wanted = clip.name.clone();
            let mut count = 1;
            while !taken.insert(clip.name.clone()) {
                count += 1;
                clip.name = format!("{wanted} {count}");
            }
            fit.name.clone_from(&clip.name);
            clips.push(clip);
            fits.push(fit);
        }
        fits
    }
}
