//! How clips of a file came out on the character of another.
//!
//! The field names are a promise to scripts that read them as JSON (`docs/commands.md`).

use super::fit_clips::FittedClip;
use crate::open::CharacterFile;
use articula_build::retarget::{self, RetargetReport, RotationOrigin};
use articula_core::source::Skeleton;
use serde::Serialize;

/// What became of one file of motions.
#[derive(Debug, Serialize)]
pub struct FitReport {
    /// The file, as errors call it.
    #[serde(rename = "in")]
    pub input: String,
    /// Name of its format.
    pub format: &'static str,
    /// Length of the file.
    #[serde(skip)]
    pub bytes: usize,
    /// Size of the character over that of the source, measured by the legs.
    pub scale: f32,
    /// Joints of the character that follow one of the source.
    pub joints_mapped: usize,
    /// Joints that share in the turn of several.
    pub joints_shared: usize,
    /// Joints that nothing moves.
    pub joints_held: usize,
    /// The clips.
    pub clips: Vec<FitClip>,
    /// Every joint of the character, in its order.
    pub joints: Vec<FitJoint>,
    /// Joints of the source that stand for one of a human, and that nothing follows.
    pub dropped: Vec<String>,
}

/// One clip as it came out.
#[derive(Debug, Serialize)]
pub struct FitClip {
    /// Name in the written file.
    pub name: String,
    /// Name in the file that was read.
    pub from: String,
    /// Length, seconds.
    pub duration_secs: f32,
    /// Morph targets and expressions of the character that follow the source's of their name.
    pub face: usize,
    /// Fastest turn of a joint against its parent, degrees a second.
    pub joint_speed_max_deg_per_s: Option<f32>,
    /// The joint that turns so fast.
    pub joint_fastest: Option<String>,
    /// How good it is.
    pub quality: FitQuality,
}

/// How good a clip is, in the character's own measures.
#[derive(Debug, Serialize)]
pub struct FitQuality {
    /// How far resting feet move as the turns alone give it.
    pub foot_slide_before_mm: FootSlideSummary,
    /// The same in the result.
    pub foot_slide_mm: FootSlideSummary,
    /// The same of the source's own feet, at the character's size.
    pub foot_slide_source_mm: FootSlideSummary,
    /// Deepest that a sole is below the floor as the turns alone give it.
    pub below_floor_before_mm: f32,
    /// The same in the result.
    pub below_floor_mm: f32,
    /// How far hands are from where the source has them, seen from the shoulders; in lengths of
    /// the arm.
    pub hands_error: EndEffectorSummary,
    /// Feet likewise, from the hips.
    pub feet_error: EndEffectorSummary,
    /// The head likewise.
    pub head_error: EndEffectorSummary,
    /// Share of frames and sides in which a knee or elbow bends to its wrong side.
    pub hinge_wrong_share: f32,
}

/// Over the contacts of a clip.
#[derive(Debug, Serialize)]
pub struct FootSlideSummary {
    /// Number of contacts.
    pub contacts: usize,
    /// Mean.
    pub mean: f32,
    /// Greatest.
    pub max: f32,
}

/// Over frames and sides.
#[derive(Debug, Serialize)]
pub struct EndEffectorSummary {
    /// Mean.
    pub mean: f32,
    /// Greatest.
    pub max: f32,
}

impl FitQuality {
    fn new(quality: &retarget::RetargetQuality) -> Self {
        let slide = |s: &retarget::FootSlide| FootSlideSummary {
            contacts: s.contacts,
            // Adding zero: an empty sum is -0.
            mean: 1000.0 * s.mean_metres + 0.0,
            max: 1000.0 * s.max_metres + 0.0,
        };
        let error = |e: &retarget::EndEffectorError| EndEffectorSummary {
            mean: e.mean,
            max: e.max,
        };
        Self {
            foot_slide_before_mm: slide(&quality.slide_before),
            foot_slide_mm: slide(&quality.slide),
            foot_slide_source_mm: slide(&quality.slide_source),
            below_floor_before_mm: 1000.0 * quality.below_floor_before_metres,
            below_floor_mm: 1000.0 * quality.below_floor_metres,
            hands_error: error(&quality.hands),
            feet_error: error(&quality.feet),
            head_error: error(&quality.head),
            hinge_wrong_share: quality.hinge_wrong_share,
        }
    }
}

/// Where a joint's motion comes from.
#[derive(Debug, Serialize)]
pub struct FitJoint {
    /// The joint.
    pub joint: String,
    /// `mapped`, `shared` or `held`.
    pub origin: &'static str,
    /// Joints of the source.
    pub from: Vec<JointShare>,
}

/// The share of a source joint in a joint's turn.
#[derive(Debug, Serialize)]
pub struct JointShare {
    /// The joint of the source.
    pub joint: String,
    /// Its share.
    pub share: f32,
}

impl FitReport {
    /// How the clips of a file came out on a character; `None` if none of them was retargeted.
    pub fn new(
        file: &CharacterFile,
        character: &CharacterFile,
        fitted: &[FittedClip],
    ) -> Option<Self> {
        let (skeleton, from) = (&character.character.skeleton, &file.character.skeleton);
        let report = fitted
            .iter()
            .rev()
            .find_map(|f| f.fit.retargeted.as_ref())?;
        let joints = joints(skeleton, from, report);
        let count = |origin| joints.iter().filter(|j| j.origin == origin).count();
        Some(Self {
            input: file.name.clone(),
            format: file.format.name(),
            bytes: file.bytes,
            scale: report.scale,
            joints_mapped: count("mapped"),
            joints_shared: count("shared"),
            joints_held: count("held"),
            clips: fitted.iter().filter_map(|f| clip(skeleton, f)).collect(),
            joints,
            dropped: report.dropped.iter().map(|j| name(from, *j)).collect(),
        })
    }
}

fn clip(skeleton: &Skeleton, fitted: &FittedClip) -> Option<FitClip> {
    let fit = &fitted.fit;
    let report = fit.retargeted.as_ref()?;
    Some(FitClip {
        name: fit.name.clone(),
        from: fit.from.clone(),
        duration_secs: fitted.clip.duration_secs,
        face: fit.morph_channels,
        joint_speed_max_deg_per_s: report.fastest.map(|(_, speed)| speed.to_degrees()),
        joint_fastest: report.fastest.map(|(joint, _)| name(skeleton, joint)),
        quality: FitQuality::new(&report.quality),
    })
}

fn joints(skeleton: &Skeleton, from: &Skeleton, report: &RetargetReport) -> Vec<FitJoint> {
    let share = |joint: usize, share: f32| JointShare {
        joint: name(from, joint),
        share,
    };
    let joint = |j: &retarget::JointReport| {
        let (origin, from) = match &j.origin {
            RotationOrigin::Mapped { source } => ("mapped", vec![share(*source, 1.0)]),
            RotationOrigin::Shared { sources } => (
                "shared",
                sources.iter().map(|(s, w)| share(*s, *w)).collect(),
            ),
            RotationOrigin::Held => ("held", Vec::new()),
        };
        FitJoint {
            joint: name(skeleton, j.joint),
            origin,
            from,
        }
    };
    report.joints.iter().map(joint).collect()
}

fn name(skeleton: &Skeleton, joint: usize) -> String {
    match skeleton.joints[joint].name.as_str() {
        "" => format!("joint {joint}"),
        name => name.to_owned(),
    }
}
