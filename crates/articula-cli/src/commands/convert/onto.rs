//! `convert --onto CHARACTER`: motions of other figures, put onto one character, and how good they
//! are there.

use super::ConvertArgs;
use super::plan::{Input, reads_many};
use crate::fault::clean;
use crate::open;
use crate::table::Table;
use anyhow::Context;
use articula::Opened;
use articula::convert::{
    AddClipsOptions, ClipFit, FittedClip, Pinning, RetargetOptions, RetargetReport, fit_clips,
};
use articula_build::retarget::{self, Origin};
use articula_core::source::Skeleton;
use clap::ValueEnum;
use serde::Serialize;
use std::path::Path;

/// The character that receives motions.
#[derive(Debug)]
pub(super) struct Hero {
    pub(super) opened: Opened,
    options: AddClipsOptions,
}

/// Which ends of limbs stay in place while the source's rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Pin {
    /// The feet, which also stay above the floor
    Feet,
    /// The feet, and hands that rest on something
    Hands,
    /// Neither: turns alone
    None,
}

impl Pin {
    fn pinning(self) -> Pinning {
        match self {
            Self::Feet => Pinning::Feet,
            Self::Hands => Pinning::FeetAndHands,
            Self::None => Pinning::Nothing,
        }
    }
}

/// The motions of one file, on the character.
#[derive(Debug)]
pub(super) struct Motions {
    pub(super) fitted: Vec<FittedClip>,
    pub(super) warnings: Vec<String>,
    pub(super) report: Motion,
}

/// What became of one file of motions.
#[derive(Debug, Serialize)]
pub(super) struct Motion {
    #[serde(rename = "in")]
    input: String,
    pub(super) format: &'static str,
    #[serde(skip)]
    pub(super) bytes: usize,
    /// Size of the character over that of the source, measured by the legs.
    scale: f32,
    joints_mapped: usize,
    joints_shared: usize,
    joints_held: usize,
    pub(super) clips: Vec<OneClip>,
    /// Every joint of the character, in its order.
    pub(super) joints: Vec<Joint>,
    /// Joints of the source that stand for one of a human, and that nothing follows.
    dropped: Vec<String>,
}

/// One clip as it came out.
#[derive(Debug, Serialize)]
pub(super) struct OneClip {
    /// Name in the written file.
    pub(super) name: String,
    /// Name in the file that was read.
    from: String,
    duration_secs: f32,
    /// Morph targets and expressions of the character that follow the source's of their name.
    face: usize,
    /// Fastest turn of a joint against its parent, degrees a second.
    joint_speed_max_deg_per_s: Option<f32>,
    joint_fastest: Option<String>,
    quality: Quality,
}

/// How good a clip is, in the character's own measures.
#[derive(Debug, Serialize)]
pub(super) struct Quality {
    /// How far resting feet move: as the turns alone give it, and in the result.
    foot_slide_before_mm: Slide,
    foot_slide_mm: Slide,
    /// The same of the source's own feet, at the character's size.
    foot_slide_source_mm: Slide,
    /// Deepest that a sole is below the floor.
    below_floor_before_mm: f32,
    below_floor_mm: f32,
    /// How far hands are from where the source has them, seen from the shoulders; in lengths of
    /// the arm. Feet from the hips and the head likewise.
    hands_error: Error,
    feet_error: Error,
    head_error: Error,
    /// Share of frames and sides in which a knee or elbow bends to its wrong side.
    hinge_wrong_share: f32,
}

/// Over the contacts of a clip.
#[derive(Debug, Serialize)]
pub(super) struct Slide {
    contacts: usize,
    mean: f32,
    max: f32,
}

/// Over frames and sides.
#[derive(Debug, Serialize)]
pub(super) struct Error {
    mean: f32,
    max: f32,
}

impl Quality {
    fn new(quality: &retarget::Quality) -> Self {
        let slide = |s: &retarget::Slide| Slide {
            contacts: s.contacts,
            // Adding zero: an empty sum is -0.
            mean: 1000.0 * s.mean_metres + 0.0,
            max: 1000.0 * s.max_metres + 0.0,
        };
        let error = |e: &retarget::EndError| Error {
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
pub(super) struct Joint {
    pub(super) joint: String,
    /// `mapped`, `shared` or `held`.
    pub(super) origin: &'static str,
    pub(super) from: Vec<Share>,
}

/// The share of a source joint in a joint's turn.
#[derive(Debug, Serialize)]
pub(super) struct Share {
    pub(super) joint: String,
    pub(super) share: f32,
}

impl Hero {
    /// Reads the character; it must be a human figure.
    pub(super) fn new(args: &ConvertArgs) -> anyhow::Result<Option<Self>> {
        let Some(path) = &args.onto else {
            return Ok(None);
        };
        let opened = open::character(path, &args.names)?;
        opened.check_human()?;
        let options = AddClipsOptions {
            clip: args.clip.clone(),
            file_in_names: reads_many(args),
            by_names: false,
            retarget: RetargetOptions {
                pinning: args.pin.unwrap_or(Pin::Feet).pinning(),
                floor_metres: args.floor_metres,
                ..RetargetOptions::default()
            },
            ..AddClipsOptions::default()
        };
        Ok(Some(Self { opened, options }))
    }

    /// Reads a file of motions and makes them the character's; `None` if it has no clip and was
    /// found in a folder among others.
    pub(super) fn motions(
        &self,
        input: &Input,
        args: &ConvertArgs,
    ) -> anyhow::Result<Option<Motions>> {
        let source = open::character(&input.path, &args.names)?;
        if input.found && source.character.clips.is_empty() {
            return Ok(None);
        }
        let fitted = fit_clips(&source, &self.opened, &self.options)?;
        let report = fitted.iter().rev().find_map(|f| f.fit.retargeted.as_ref());
        let report = report.context("no clip was retargeted")?;
        let warnings = open::warnings(&source);
        let warnings = warnings
            .into_iter()
            .map(|w| format!("{}: {w}", source.name));
        let clips = fitted.iter().filter_map(|f| self.one(f)).collect();
        Ok(Some(Motions {
            warnings: warnings.collect(),
            report: self.motion(&source, report, clips),
            fitted,
        }))
    }

    fn one(&self, fitted: &FittedClip) -> Option<OneClip> {
        let names = &self.opened.character.skeleton;
        let ClipFit {
            name: new,
            from,
            morph_channels,
            retargeted,
            ..
        } = &fitted.fit;
        let report = retargeted.as_ref()?;
        Some(OneClip {
            name: new.clone(),
            from: from.clone(),
            duration_secs: fitted.clip.duration_secs,
            face: *morph_channels,
            joint_speed_max_deg_per_s: report.fastest.map(|(_, speed)| speed.to_degrees()),
            joint_fastest: report.fastest.map(|(joint, _)| name(names, joint)),
            quality: Quality::new(&report.quality),
        })
    }

    fn motion(&self, source: &Opened, report: &RetargetReport, clips: Vec<OneClip>) -> Motion {
        let skeleton = &self.opened.character.skeleton;
        let from = &source.character.skeleton;
        let share = |joint: usize, share: f32| Share {
            joint: name(from, joint),
            share,
        };
        let joint = |j: &retarget::JointReport| {
            let (origin, from) = match &j.origin {
                Origin::Mapped { source } => ("mapped", vec![share(*source, 1.0)]),
                Origin::Shared { sources } => (
                    "shared",
                    sources.iter().map(|(s, w)| share(*s, *w)).collect(),
                ),
                Origin::Held => ("held", Vec::new()),
            };
            Joint {
                joint: name(skeleton, j.joint),
                origin,
                from,
            }
        };
        let joints: Vec<Joint> = report.joints.iter().map(joint).collect();
        let count = |origin| joints.iter().filter(|j| j.origin == origin).count();
        Motion {
            input: source.name.clone(),
            format: source.format.name(),
            bytes: source.bytes,
            scale: report.scale,
            joints_mapped: count("mapped"),
            joints_shared: count("shared"),
            joints_held: count("held"),
            clips,
            joints,
            dropped: report.dropped.iter().map(|j| name(from, *j)).collect(),
        }
    }
}

impl Motion {
    /// A line of the table of clips.
    pub(super) fn row(&self, clip: &OneClip) -> [String; 9] {
        let quality = &clip.quality;
        let slide = |s: &Slide| match s.contacts {
            0 => "-".to_owned(),
            _ => format!("{:.0}", s.mean),
        };
        [
            clip.name.clone(),
            self.file_name(),
            format!("{:.2}", clip.duration_secs),
            format!("{:.2}", self.scale),
            slide(&quality.foot_slide_before_mm),
            slide(&quality.foot_slide_mm),
            format!("{:.0}", quality.below_floor_mm),
            format!("{:.0}%", 100.0 * quality.hands_error.mean),
            clip.joint_speed_max_deg_per_s
                .map_or_else(|| "-".to_owned(), |v| format!("{v:.0}")),
        ]
    }

    /// What became of the joints, in one line.
    pub(super) fn joints_line(&self) -> String {
        format!(
            "{}: {} joints mapped, {} shared, {} held; {} dropped\n",
            clean(&self.file_name()),
            self.joints_mapped,
            self.joints_shared,
            self.joints_held,
            self.dropped.len()
        )
    }

    /// Whether its joints went the way of another file's.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let counts = |m: &Self| {
            [
                m.joints_mapped,
                m.joints_shared,
                m.joints_held,
                m.dropped.len(),
            ]
        };
        counts(self) == counts(other)
    }

    fn file_name(&self) -> String {
        let name = Path::new(&self.input).file_name();
        name.map_or_else(|| self.input.clone(), |n| n.to_string_lossy().into_owned())
    }

    /// Where the motion of every joint comes from.
    pub(super) fn map(&self) -> String {
        let mut table = Table::new(&["joint", "is", "from"]);
        for joint in &self.joints {
            let share = |s: &Share| match s.share {
                1.0 => s.joint.clone(),
                share => format!("{:.0}% {}", 100.0 * share, s.joint),
            };
            let from: Vec<String> = joint.from.iter().map(share).collect();
            table.row([&joint.joint, joint.origin, &from.join(" + ")]);
        }
        let mut text = format!("from {}\n{}", clean(&self.input), table.text());
        if !self.dropped.is_empty() {
            text.push_str(&format!("  dropped: {}\n", clean(&self.dropped.join(", "))));
        }
        text
    }
}

fn name(skeleton: &Skeleton, joint: usize) -> String {
    match skeleton.joints[joint].name.as_str() {
        "" => format!("joint {joint}"),
        name => name.to_owned(),
    }
}
