//! Morph target weights of a crowd's characters: the clips' weights laid out for sampling, and the
//! sets of weights of one frame.
//!
//! One frame of a clip is one row: the weights of all targets that move in any clip, so that a
//! character interpolates two rows and never looks a target up. The targets are in the order of the
//! morph levels, so a coarser level reads a prefix of the rows. The other targets keep their default
//! weights.

use super::character_state::{CharacterState, ClipState};
use super::morph_lods::MorphLods;
use crate::Mismatch;
use crate::clip::{Clip, Track, Tracks};
use crate::sample::{FramePosition, Wrap, frame_position_f32, sample_morphs_at};

/// Morph target weights of all clips of a crowd, and the levels that show them.
///
/// A level shows morph targets if its mesh has them and the face is large enough on screen to be
/// worth it, which the caller decides by `levels`: the finest so many levels. The errors of coarser
/// levels must include that their faces rest. How many targets a character of these levels shows is
/// its morph level ([`MorphLods`]).
#[derive(Debug, Clone, PartialEq)]
pub struct MorphClips {
    levels: usize,
    /// Default weights of all targets.
    rest: Vec<f32>,
    /// Morph levels; their order has all targets that leave their default weight in any clip.
    lods: MorphLods,
    /// Rows of all clips, one after the other, with a weight for each target of that order.
    rows: Vec<f32>,
    clips: Vec<MorphClip>,
}

/// One clip within the rows.
#[derive(Debug, Clone, PartialEq)]
struct MorphClip {
    /// The clip without its tracks: rate and number of frames.
    times: Clip,
    first: usize,
    /// Columns whose weights hold until the next frame.
    held: Vec<u16>,
}

impl MorphClips {
    /// Lays out the morph tracks of clips. `rest` are the default weights of all targets of the
    /// mesh, and `levels` is the number of levels, from the finest on, that show them. Tracks of
    /// targets beyond `rest` are left out, as by [`sample_morphs`](crate::sample_morphs).
    ///
    /// # Errors
    /// A [`Mismatch`] if a weight is not finite.
    pub fn new(clips: &[Clip], rest: &[f32], levels: usize) -> Result<Self, Mismatch> {
        let lods = MorphLods::whole(Self::moving(clips, rest)?, clips.len());
        Self::with_lods(clips, rest, levels, lods)
    }

    /// The same with the morph levels of these clips.
    ///
    /// # Errors
    /// A [`Mismatch`] if a weight is not finite, or the levels are not of these clips and of the
    /// targets that [move](Self::moving).
    pub fn with_lods(
        clips: &[Clip],
        rest: &[f32],
        levels: usize,
        lods: MorphLods,
    ) -> Result<Self, Mismatch> {
        let moving = Self::moving(clips, rest)?;
        let mut ordered = lods.order().to_vec();
        ordered.sort_unstable();
        if ordered != moving || lods.clips() != clips.len() {
            let what = format!(
                "{} targets in {} clips, expected the {} that move in {} clips",
                ordered.len(),
                lods.clips(),
                moving.len(),
                clips.len()
            );
            return Err(Mismatch::new("lods", what));
        }
        let mut made = Self {
            levels: if moving.is_empty() { 0 } else { levels },
            rest: rest.to_vec(),
            lods,
            rows: Vec::new(),
            clips: Vec::with_capacity(clips.len()),
        };
        for clip in clips {
            made.append(clip)?;
        }
        Ok(made)
    }

    /// The targets that leave their default weight in any clip, ascending.
    ///
    /// # Errors
    /// A [`Mismatch`] if a weight is not finite.
    pub fn moving(clips: &[Clip], rest: &[f32]) -> Result<Vec<u16>, Mismatch> {
        let tracks = clips.iter().flat_map(|c| &c.tracks().morphs);
        for track in tracks.clone() {
            finite("clips", &track.values)?;
        }
        finite("rest", rest)?;
        let moves = |track: &&Track<f32>| {
            let default = rest.get(usize::from(track.target));
            default.is_some_and(|default| track.values.iter().any(|w| w != default))
        };
        let mut moving: Vec<u16> = tracks.filter(moves).map(|t| t.target).collect();
        moving.sort_unstable();
        moving.dedup();
        Ok(moving)
    }

    fn append(&mut self, clip: &Clip) -> Result<(), Mismatch> {
        let (rate_hz, frames) = (clip.rate_hz(), clip.frames());
        let times = Clip::new("", rate_hz, frames, clip.joints(), Tracks::default())?;
        let morphs = &clip.tracks().morphs;
        let is_held = |target: &u16| {
            let last = morphs.iter().rev().find(|t| t.target == *target);
            last.is_some_and(|t| t.step)
        };
        let columns = self.lods.order().iter().enumerate();
        self.clips.push(MorphClip {
            times,
            first: self.rows.len(),
            held: columns
                .filter(|(_, target)| is_held(target))
                .map(|(column, _)| column as u16)
                .collect(),
        });
        let mut weights = self.rest.clone();
        for frame in 0..frames {
            let at = FramePosition {
                before: frame,
                after: frame,
                blend: 0.0,
            };
            sample_morphs_at(clip, at, &mut weights);
            let row = self.lods.order().iter().map(|t| weights[usize::from(*t)]);
            self.rows.extend(row);
        }
        Ok(())
    }

    /// Number of levels that show morph targets, from the finest on; 0 if no clip moves any.
    pub fn levels(&self) -> usize {
        self.levels
    }

    /// Number of weights of one character: one for each morph target of the mesh.
    pub fn targets(&self) -> usize {
        self.rest.len()
    }

    /// The morph levels of the characters that show morph targets.
    pub fn lods(&self) -> &MorphLods {
        &self.lods
    }

    /// Number of clips.
    pub(crate) fn clips(&self) -> usize {
        self.clips.len()
    }

    /// Size of the weights of all clips in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.rows.as_slice())
    }

    /// Writes all weights of a character at the times of its clips, blended as they are: those of the
    /// targets that a morph level shows, the default weights of the others. O(targets); does not
    /// allocate.
    pub(crate) fn sample(&self, state: &CharacterState, level: usize, out: &mut [f32]) {
        out.copy_from_slice(&self.rest);
        let shown = &self.lods.order()[..self.lods.count(level)];
        if shown.is_empty() {
            return;
        }
        self.one(&state.from, shown, |out, weight| *out = weight, out);
        if state.fade > 0.0 {
            let fade = state.fade;
            self.one(&state.to, shown, |out, to| *out += (to - *out) * fade, out);
        }
    }

    /// Joins the weights of one clip with those of the first targets of the order.
    fn one(&self, state: &ClipState, shown: &[u16], join: impl Fn(&mut f32, f32), out: &mut [f32]) {
        let clip = &self.clips[usize::from(state.clip)];
        // The time is already wrapped; as for the body, the end of a clip is its last frame.
        let at = frame_position_f32(&clip.times, state.secs, Wrap::Clamp);
        let count = self.lods.order().len();
        let row = |frame: usize| &self.rows[clip.first + frame * count..][..shown.len()];
        let before = row(at.before);
        // At a frame itself its weights are taken as they are stored.
        let after = row(if at.blend == 0.0 { at.before } else { at.after });
        let mut held = clip.held.iter().peekable();
        for (column, target) in shown.iter().enumerate() {
            let (a, b) = (before[column], after[column]);
            let is_held = held.next_if(|h| usize::from(**h) == column).is_some();
            let weight = if is_held { a } else { a + (b - a) * at.blend };
            join(&mut out[usize::from(*target)], weight);
        }
    }
}

fn finite(at: &str, weights: &[f32]) -> Result<(), Mismatch> {
    match weights.iter().all(|w| w.is_finite()) {
        true => Ok(()),
        false => Err(Mismatch::new(at, "every morph weight must be finite")),
    }
}
