//! Report on clips transferred to another character.
//!
//! Field names are stable, since scripts read them as JSON (`docs/commands.md`).

use super::fit_finding::{FitFinding, in_words};
use crate::open::{CharacterFile, ClipProvenance, FittedClip, NameTransfer};
use crate::resampling::ClipResampling;
use articula_build::retarget::{self, RetargetReport, RotationOrigin};
use articula_core::source::Skeleton;
use serde::Serialize;
use std::collections::BTreeSet;

/// JSON report on the clips transferred from one file.
#[derive(Debug, Serialize)]
pub struct TransferReport {
    /// Name of the file, as in errors.
    #[serde(rename = "in")]
    pub input: String,
    /// Name of its format.
    pub format: &'static str,
    /// Size of the file in bytes.
    #[serde(skip)]
    pub bytes: usize,
    /// Scale from the source to the character, by the length of the legs; by that of the skeletons
    /// if joints were matched by their names.
    pub scale: f32,
    /// Whether the joints were matched by their names rather than by the H-Anim mapping.
    pub by_name: bool,
    /// Number of joints of the character that follow one source joint.
    pub joints_mapped: usize,
    /// Number of joints that share the rotation of several source joints.
    pub joints_shared: usize,
    /// Number of joints that are not animated.
    pub joints_held: usize,
    /// Reports on the clips.
    pub clips: Vec<TransferredClipReport>,
    /// Origin of the motion of every joint, in the order of the character's joints.
    pub joints: Vec<JointSourceReport>,
    /// Source joints with an H-Anim mapping that no joint of the character follows; by name, those
    /// that move.
    pub dropped: Vec<String>,
}

/// JSON report on one transferred clip.
#[derive(Debug, Serialize)]
pub struct TransferredClipReport {
    /// Name in the output file.
    pub name: String,
    /// Name in the source file.
    pub from: String,
    /// Duration, in seconds.
    pub duration_secs: f32,
    /// Distance of the frames that were retargeted from the keys of the source; null if the keys were
    /// copied.
    pub resampling: Option<ClipResampling>,
    /// Number of morph targets and expressions that follow the source's of the same name.
    pub face: usize,
    /// Maximum angular speed of a joint relative to its parent, in degrees per second.
    pub joint_speed_max_deg_per_s: Option<f32>,
    /// The joint with this speed.
    pub joint_fastest: Option<String>,
    /// Maximum angular speed of a joint of the source relative to its parent, in degrees per second.
    pub source_speed_max_deg_per_s: Option<f32>,
    /// Whether nothing was found that a viewer would notice; null if joints were matched by their
    /// names.
    pub good: Option<bool>,
    /// What was found; some of it, such as a rest pose that was found from the motion, explains the
    /// numbers and is no fault.
    pub findings: Vec<FitFinding>,
    /// Quality measures; null if joints were matched by their names.
    pub quality: Option<FitQuality>,
}

/// Quality of a transferred clip, measured at the character's size.
#[derive(Debug, Serialize)]
pub struct FitQuality {
    /// Distance that feet in contact slide before correction, in millimetres.
    pub foot_slide_before_mm: FootSlideSummary,
    /// The same in the result.
    pub foot_slide_mm: FootSlideSummary,
    /// The same of the source's own feet, scaled to the character.
    pub foot_slide_source_mm: FootSlideSummary,
    /// Greatest depth of a sole below the floor before correction, in millimetres.
    pub below_floor_before_mm: f32,
    /// The same in the result.
    pub below_floor_mm: f32,
    /// Distance of the hands from their source positions relative to the shoulders, in arm lengths.
    pub hands_error: EndEffectorSummary,
    /// Distance of the feet from their source positions relative to the hips, in leg lengths.
    pub feet_error: EndEffectorSummary,
    /// Distance of the head from its source position relative to the hips, as a fraction of the
    /// distance between hips and head.
    pub head_error: EndEffectorSummary,
    /// Fraction of frames and sides in which a knee or elbow bends the wrong way.
    pub hinge_wrong_share: f32,
}

/// Foot slide over the contacts of a clip.
#[derive(Debug, Serialize)]
pub struct FootSlideSummary {
    /// Number of contacts.
    pub contacts: usize,
    /// Mean.
    pub mean: f32,
    /// Maximum.
    pub max: f32,
}

/// Position error of an end effector over frames and sides.
#[derive(Debug, Serialize)]
pub struct EndEffectorSummary {
    /// Mean.
    pub mean: f32,
    /// Maximum.
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

/// JSON report on the source joints that one joint of the character follows.
#[derive(Debug, Serialize)]
pub struct JointSourceReport {
    /// The joint.
    pub joint: String,
    /// `mapped`, `shared` or `held`.
    pub origin: &'static str,
    /// Source joints and their shares.
    pub from: Vec<JointShare>,
}

/// Share of a source joint in a joint's rotation.
#[derive(Debug, Serialize)]
pub struct JointShare {
    /// Name of the source joint.
    pub joint: String,
    /// Its share, 0 to 1.
    pub share: f32,
}

impl TransferReport {
    /// Creates the report on the clips of a file; `None` if there is none.
    pub fn new(
        file: &CharacterFile,
        character: &CharacterFile,
        fitted: &[FittedClip],
    ) -> Option<Self> {
        let (skeleton, from) = (&character.character().skeleton, &file.character().skeleton);
        let report = fitted.last().map(|f| Transfer::of(&f.fit))?;
        let (joints, scale, dropped) = match report {
            Transfer::ByMap(report) => (
                joints(skeleton, from, report),
                report.scale,
                report.dropped.clone(),
            ),
            Transfer::ByName(report) => {
                let all = fitted.iter().filter_map(|f| f.fit.by_name.as_ref());
                let all: Vec<&NameTransfer> = all.collect();
                let dropped: BTreeSet<usize> =
                    all.iter().flat_map(|r| &r.dropped).copied().collect();
                let joints = joints_by_name(skeleton, from, &all);
                (joints, report.scale, dropped.into_iter().collect())
            }
            Transfer::Copied => (copied_joints(skeleton, fitted), 1.0, Vec::new()),
        };
        let count = |origin| joints.iter().filter(|j| j.origin == origin).count();
        Some(Self {
            input: file.name().to_owned(),
            format: file.format().name(),
            bytes: file.bytes(),
            scale,
            by_name: !matches!(report, Transfer::ByMap(_)),
            joints_mapped: count("mapped"),
            joints_shared: count("shared"),
            joints_held: count("held"),
            clips: fitted.iter().map(|f| clip(skeleton, from, f)).collect(),
            joints,
            dropped: dropped.iter().map(|j| name(from, *j)).collect(),
        })
    }
}

/// How a clip came to the character.
#[derive(Clone, Copy)]
enum Transfer<'a> {
    ByMap(&'a RetargetReport),
    ByName(&'a NameTransfer),
    /// Unchanged, as both have the same skeleton.
    Copied,
}

impl<'a> Transfer<'a> {
    fn of(fit: &'a ClipProvenance) -> Self {
        match (&fit.retargeted, &fit.by_name) {
            (Some(report), _) => Self::ByMap(report),
            (None, Some(report)) => Self::ByName(report),
            (None, None) => Self::Copied,
        }
    }
}

/// The joints that copied clips move, each from the joint of its own name.
fn copied_joints(skeleton: &Skeleton, fitted: &[FittedClip]) -> Vec<JointSourceReport> {
    let channels = fitted.iter().flat_map(|f| &f.clip.channels);
    let of_joints = channels.filter(|c| c.property.is_of_joint());
    let moved: BTreeSet<usize> = of_joints.map(|c| c.target).collect();
    let joint = |joint: usize| {
        let is_moved = moved.contains(&joint);
        let own = JointShare {
            joint: name(skeleton, joint),
            share: 1.0,
        };
        JointSourceReport {
            joint: name(skeleton, joint),
            origin: if is_moved { "mapped" } else { "held" },
            from: is_moved.then_some(own).into_iter().collect(),
        }
    };
    (0..skeleton.joints.len()).map(joint).collect()
}

/// The source of every joint that follows one of the same name in any clip.
fn joints_by_name(
    skeleton: &Skeleton,
    from: &Skeleton,
    reports: &[&NameTransfer],
) -> Vec<JointSourceReport> {
    let source = |joint: usize| reports.iter().find_map(|r| r.sources[joint]);
    let joint = |joint: usize| {
        let source = source(joint);
        let share = |source| JointShare {
            joint: name(from, source),
            share: 1.0,
        };
        JointSourceReport {
            joint: name(skeleton, joint),
            origin: if source.is_some() { "mapped" } else { "held" },
            from: source.map(share).into_iter().collect(),
        }
    };
    (0..skeleton.joints.len()).map(joint).collect()
}

fn clip(skeleton: &Skeleton, from: &Skeleton, fitted: &FittedClip) -> TransferredClipReport {
    let fit = &fitted.fit;
    let report = fit.retargeted.as_ref();
    let fastest = report.and_then(|report| report.fastest);
    let findings = report.map(|report| in_words(&report.findings, from, skeleton));
    let source = report.and_then(|report| report.fastest_source);
    let is_good = |found: &Vec<FitFinding>| found.iter().all(|finding| finding.kind.is_note());
    TransferredClipReport {
        name: fit.name.clone(),
        from: fit.from.clone(),
        duration_secs: fitted.clip.duration_secs,
        resampling: fit.resampling.clone(),
        face: fit.morph_channels,
        joint_speed_max_deg_per_s: fastest.map(|(_, speed)| speed.to_degrees()),
        joint_fastest: fastest.map(|(joint, _)| name(skeleton, joint)),
        source_speed_max_deg_per_s: source.map(|(_, speed)| speed.to_degrees()),
        good: findings.as_ref().map(is_good),
        findings: findings.unwrap_or_default(),
        quality: report.map(|report| FitQuality::new(&report.quality)),
    }
}

fn joints(skeleton: &Skeleton, from: &Skeleton, report: &RetargetReport) -> Vec<JointSourceReport> {
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
        JointSourceReport {
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
