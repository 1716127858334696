//! Conversion: adds clips from other characters, edits and reduces clips, and writes the character
//! in another format.
//!
//! In the order of the work:
//!
//! - `fit_clips`, `same_joints`, `same_names`, `morphs`: transfer of clips to the joints and morph targets of
//!   another character
//! - `fit_report`, `fit_finding`: quality of the transferred clips, in numbers and in words
//! - `joint_scheme`: the joints of H-Anim or of the thesis
//! - `clip_edits`: trimming, looping, root motion, resampling, key reduction
//! - `reduction`: clips in which only a selection of joints moves
//! - `written`, `body`, `khr_character`, `faps`, `streams`: the bytes of each format
//! - `joint_names`: names for formats without a joint map

mod body;
mod clip_edits;
mod faps;
mod first_frame;
mod fit_clips;
mod fit_finding;
mod fit_report;
mod joint_names;
mod joint_scheme;
mod khr_character;
mod left_out;
mod morphs;
mod pose_kind;
mod reduction;
mod same_joints;
mod same_names;
#[cfg(feature = "streams")]
mod streams;
mod written;

pub use crate::open::{ClipProvenance, FittedClip, NameTransfer};
pub use articula_build::clip_edit::CloseOptions;
pub use articula_build::clip_edit::{ReduceOptions, Timelines};
pub use articula_build::clip_edit::{RootMotionMode, RootMotionOptions};
pub use articula_build::retarget::{ContactPinning, RetargetOptions, RetargetReport};
pub use clip_edits::{
    ClipEdited, ClipEdits, ClipPart, KeysReduced, LoopClosed, LoopPart, Looped, Resampled,
    RootMotionEdited, TrajectoryPlace, Trimmed,
};
pub use fit_clips::{AddClipsOptions, fit_clips};
pub use fit_finding::{FitFinding, FitFindingKind};
pub use fit_report::{
    EndEffectorSummary, FitQuality, FootSlideSummary, JointShare, JointSourceReport,
    TransferReport, TransferredClipReport,
};
pub use joint_scheme::{JointInserted, JointMerged, JointSchemeReport};
pub use left_out::{EncodedFile, LossyPart};
pub use reduction::{
    AnimationSize, JointReduction, JointsHeld, JointsReduced, MovingJoints, hold_joints,
};
#[cfg(feature = "streams")]
pub use streams::{AbpProfile, AfpProfile, write_faps};
pub use written::{write, write_data};

use crate::error::{Context, Error, Result};
use crate::mesh_levels::{self, ShownLevelOptions, ShownLevels};
use crate::open::{CharacterFile, Format, WriteSupport, choose, conversions};
use crate::resampling::ClipResampling;
use crate::work::Executor;
use articula_build::JointScheme;

/// Options of [`convert`]; the default changes nothing.
#[derive(Debug, Clone, Default)]
pub struct ConvertOptions {
    /// Name of the only clip to keep; without a name, the first ones, as many as the format holds.
    pub clip: Option<String>,
    /// Mesh levels that are written in place of the original meshes, if the file has levels;
    /// `None` keeps all levels. For glTF formats.
    pub mesh: Option<ShownLevelOptions>,
    /// Joint scheme to which the character is converted, before its clips are edited; `None` leaves
    /// the joints as they are.
    pub joint_scheme: Option<JointScheme>,
    /// Edits of the clips.
    pub edits: ClipEdits,
    /// Selection of the joints that move, and the poses of the others; `None` keeps all motion.
    pub reduction: Option<JointReduction>,
    /// GLB: whether the draft glTF extensions for characters are written, with a skeleton mapping
    /// and a reference pose.
    pub khr_character: bool,
    /// ABP, MP4: profile and options of the stream; `None` is ABP-2 with its defaults.
    #[cfg(feature = "streams")]
    pub abp: Option<AbpProfile>,
}

/// A converted file with a report.
#[derive(Debug)]
pub struct Converted {
    /// The file, its companion file, and the data that was left out.
    pub written: EncodedFile,
    /// Names of the written clips.
    pub clips: Vec<String>,
    /// The mesh levels that were written, if they were requested.
    pub mesh: Option<ShownLevels>,
    /// Report on the conversion to a joint scheme, if it was requested.
    pub joint_scheme: Option<JointSchemeReport>,
    /// Report on the edits of each clip; empty if no edit was requested.
    pub edits: Vec<ClipEdited>,
    /// Distance of the frames of each written clip from the keys of the file, or of the edited clip
    /// before it was resampled.
    pub resampling: Vec<ClipResampling>,
    /// Report on the joint reduction, if it was requested.
    pub reduction: Option<JointsReduced>,
}

/// Converts a character: selects clips, changes the joint scheme, edits the clips, reduces them to a selection of joints, drops
/// keys, and writes the file.
///
/// Other contents of a glTF document are preserved if the output is a glTF format. There is one job
/// per clip.
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
/// [`Error::Argument`] if the format cannot hold the requested data or no clip has the name;
/// otherwise an [`Error`] that names the file and the cause.
pub fn convert(
    mut opened: CharacterFile,
    format: Format,
    options: &ConvertOptions,
    work: &Executor<'_>,
) -> Result<Converted> {
    options.check(opened.format(), format)?;
    let place = opened.name().to_owned();
    let mesh = options.mesh.as_ref();
    let mesh = mesh.map(|wanted| mesh_levels::show(&mut opened, wanted, work));
    let mesh = mesh.transpose().with_context(|| &place)?;
    let dropped = choose_clips(options.clip.as_deref(), &mut opened, format);
    let dropped = dropped.with_context(|| &place)?;
    let joint_scheme = options.joint_scheme;
    let joint_scheme = joint_scheme.map(|scheme| opened.set_joint_scheme(scheme));
    let joint_scheme = joint_scheme.transpose()?;
    let mut edits = options.edits.apply(&mut opened, work)?;
    let reduction = options.reduction.as_ref();
    let reduction = reduction.map(|r| r.apply(&mut opened)).transpose()?;
    options.edits.reduce_keys(&mut opened, &mut edits, work)?;
    let made = written::written(&opened, format, options);
    let mut written = made.with_context(|| &place)?;
    if dropped > 0 && options.clip.is_none() {
        written.left_out.push(LossyPart::Clips(dropped));
    }
    let resampling = written::resampling(&opened, format, options, &edits);
    let resampling = resampling.with_context(|| &place)?;
    let clips = opened.character().clips.iter();
    Ok(Converted {
        written,
        clips: clips.map(|c| c.name.clone()).collect(),
        mesh,
        joint_scheme,
        edits,
        resampling,
        reduction,
    })
}

impl ConvertOptions {
    #[cfg(not(feature = "streams"))]
    fn writes_motion_stream(&self, _: Format) -> bool {
        false
    }

    /// Checks that a file of one format can be written in another with these options.
    ///
    /// # Errors
    /// [`Error::Argument`] that names the obstacle and an alternative.
    pub fn check(&self, from: Format, to: Format) -> Result<()> {
        self.edits.check(to)?;
        if self.khr_character && to != Format::Glb {
            return Err(Error::argument(format!(
                "the draft extensions for characters need a .glb file, not .{}",
                to.name()
            )));
        }
        #[cfg(feature = "streams")]
        self.check_profile(to)?;
        if self.mesh.is_some() && !to.is_gltf() {
            return Err(Error::argument(format!(
                "a choice of mesh levels needs a .glb or .vrm file, not .{}",
                to.name()
            )));
        }
        let fits = match to.writes() {
            WriteSupport::Any => true,
            WriteSupport::SameFormat => from == to,
            WriteSupport::Never => false,
        };
        if fits {
            return Ok(());
        }
        Err(Error::argument(format!(
            "conversion from {} to {} is not supported; supported are {}",
            from.name(),
            to.name(),
            conversions()
        )))
    }
}

/// Keeps the clips that are written; returns the number of dropped ones.
fn choose_clips(wanted: Option<&str>, opened: &mut CharacterFile, to: Format) -> Result<usize> {
    let clips = &opened.character().clips;
    let index = match wanted {
        Some(name) => choose("clip", name, clips.iter().map(|c| c.name.as_str()))?,
        None if to.holds_one_clip() && !clips.is_empty() => 0,
        None if to.needs_a_clip() => {
            let what = "clips: the file has no clip to write; give a file that has one";
            return Err(Error::unsuited(what));
        }
        None => return Ok(0),
    };
    let dropped = clips.len() - 1;
    opened.select_clips(&[index]);
    Ok(dropped)
}
