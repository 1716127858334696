//! Conversion: clips come from other characters, are edited and reduced, and the character is
//! written in a format.
//!
//! In the order of the work:
//!
//! - `fit_clips`, `same_joints`, `morphs`: clips of one file on the joints and morph targets of
//!   another's character
//! - `fit_report`: how good they are there
//! - `clip_edits`: clips trimmed, looped, kept in place, keyed at a rate, with fewer keys
//! - `reduction`: clips in which a selection of joints moves
//! - `written`, `body`, `khr_character`: the bytes of each format

mod body;
mod clip_edits;
mod fit_clips;
mod fit_report;
mod khr_character;
mod left_out;
mod morphs;
mod pose_kind;
mod reduction;
mod same_joints;
mod written;

pub use articula_build::clip_edit::CloseOptions;
pub use articula_build::clip_edit::ReduceOptions;
pub use articula_build::clip_edit::{RootMotionMode, RootMotionOptions};
pub use articula_build::retarget::{ContactPinning, RetargetOptions, RetargetReport};
pub use clip_edits::{
    ClipEdited, ClipEdits, ClipPart, KeysReduced, LoopClosed, LoopPart, Looped, Resampled,
    RootMotionEdited, TrajectoryPlace, Trimmed,
};
pub use fit_clips::{AddClipsOptions, ClipFit, FittedClip, fit_clips};
pub use fit_report::{
    EndEffectorSummary, FitClip, FitJoint, FitQuality, FitReport, FootSlideSummary, JointShare,
};
pub use left_out::{EncodedFile, LossyPart};
pub use reduction::{
    AnimationSize, JointReduction, JointsHeld, JointsReduced, MovingJoints, hold_joints,
};
pub use written::{write, write_data};

use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, Format, WriteSupport, choose, conversions};
use crate::work::Executor;

/// What is done with a character before it is written; the default is nothing.
#[derive(Debug, Clone, Default)]
pub struct ConvertOptions {
    /// The clip that is kept alone; without a name all that the format holds, the first ones.
    pub clip: Option<String>,
    /// How the clips are edited.
    pub edits: ClipEdits,
    /// Which joints move and what the others show, if not every joint moves.
    pub reduction: Option<JointReduction>,
    /// GLB: whether the draft glTF extensions for characters are written, with a skeleton mapping
    /// and a reference pose.
    pub khr_character: bool,
}

/// A converted file, and what was done on the way.
#[derive(Debug)]
pub struct Converted {
    /// The file, and what must lie beside it.
    pub written: EncodedFile,
    /// Names of the clips that were written.
    pub clips: Vec<String>,
    /// What was done with each clip; empty if no edit was asked for.
    pub edits: Vec<ClipEdited>,
    /// What holding joints saved, if that was asked for.
    pub reduction: Option<JointsReduced>,
}

/// Changes a character as asked for and writes it: clip, edits, reduction, then fewer keys.
///
/// What stands behind a glTF file passes through, if the format is a glTF one. Jobs are the
/// clips.
///
/// ```
/// use articula::convert::{ClipEdits, ConvertOptions};
/// use articula::{Format, OpenOptions, Executor, convert, open};
///
/// # fn main() -> articula::Result<()> {
/// let bvh = "HIERARCHY
/// ROOT Hips
/// {
///   OFFSET 0 90 0
///   CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
///   JOINT Spine
///   {
///     OFFSET 0 30 0
///     CHANNELS 3 Zrotation Xrotation Yrotation
///     End Site
///     {
///       OFFSET 0 20 0
///     }
///   }
/// }
/// MOTION
/// Frames: 2
/// Frame Time: 0.0333333
/// 0 90 0 0 0 0 0 0 0
/// 0 90 1 0 0 0 0 5 0";
/// let nothing = &mut |_: &str| Err("nothing lies beside it".into());
/// let nod = open(bvh.as_bytes(), "nod.bvh", &OpenOptions::default(), nothing)?;
/// let options = ConvertOptions {
///     edits: ClipEdits { rate_hz: Some(60.0), ..ClipEdits::default() },
///     ..ConvertOptions::default()
/// };
/// let converted = convert(nod, Format::Glb, &options, &Executor::default())?;
/// assert!(converted.written.bytes.starts_with(b"glTF"));
/// assert_eq!(converted.clips.len(), 1);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`Error::Argument`] if the format cannot hold what is asked for or no clip has the name; else
/// an [`Error`] that names the file and what of it does not fit.
pub fn convert(
    mut opened: CharacterFile,
    format: Format,
    options: &ConvertOptions,
    work: &Executor<'_>,
) -> Result<Converted> {
    options.check(opened.format, format)?;
    let place = opened.name.clone();
    let dropped = choose_clips(options.clip.as_deref(), &mut opened, format);
    let dropped = dropped.with_context(|| &place)?;
    let mut edits = options.edits.apply(&mut opened, work)?;
    let reduction = options.reduction.as_ref();
    let reduction = reduction.map(|r| r.apply(&mut opened)).transpose()?;
    options.edits.reduce_keys(&mut opened, &mut edits, work)?;
    opened.clips_changed |= dropped > 0;
    let made = written::written(&opened, format, options.khr_character);
    let mut written = made.with_context(|| &place)?;
    if dropped > 0 && options.clip.is_none() {
        written.left_out.push(LossyPart::Clips(dropped));
    }
    let clips = opened.character.clips.iter();
    Ok(Converted {
        written,
        clips: clips.map(|c| c.name.clone()).collect(),
        edits,
        reduction,
    })
}

impl ConvertOptions {
    /// Whether a file of one format can be written in another with these options.
    ///
    /// # Errors
    /// [`Error::Argument`] that says what is not possible, and what is.
    pub fn check(&self, from: Format, to: Format) -> Result<()> {
        self.edits.check(to)?;
        if self.khr_character && to != Format::Glb {
            return Err(Error::argument(format!(
                "the draft extensions for characters are written into a .glb file, not into a .{}",
                to.name()
            )));
        }
        let fits = match to.writes() {
            WriteSupport::Any => true,
            WriteSupport::Back => from == to,
            WriteSupport::Never => false,
        };
        if fits {
            return Ok(());
        }
        Err(Error::argument(format!(
            "{} to {} is not converted; converted are {}",
            from.name(),
            to.name(),
            conversions()
        )))
    }
}

/// Keeps the clips that go into the output; says how many were dropped.
fn choose_clips(wanted: Option<&str>, opened: &mut CharacterFile, to: Format) -> Result<usize> {
    let clips = &mut opened.character.clips;
    let index = match wanted {
        Some(name) => choose("clip", name, clips.iter().map(|c| c.name.as_str()))?,
        None if to.holds_one_clip() && !clips.is_empty() => 0,
        None if to.needs_a_clip() => {
            let what = "clips: there is none to write; give a file that has one";
            return Err(Error::unsuited(what));
        }
        None => return Ok(0),
    };
    let dropped = clips.len() - 1;
    *clips = vec![clips.swap_remove(index)];
    Ok(dropped)
}
