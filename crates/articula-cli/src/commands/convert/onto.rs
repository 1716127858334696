//! `convert --onto CHARACTER`: motions of other figures, put onto one character, and how good they
//! are there.

use super::ConvertArgs;
use super::plan::{Input, reads_many};
use crate::fault::clean;
use crate::open;
use crate::table::Table;
use anyhow::Context;
use articula::CharacterFile;
use articula::convert::{
    AddClipsOptions, ContactPinning, FitClip, FitReport, FittedClip, FootSlideSummary, JointShare,
    RetargetOptions, fit_clips,
};
use clap::ValueEnum;
use std::path::Path;

/// The character that receives motions.
#[derive(Debug)]
pub(super) struct Hero {
    pub(super) opened: CharacterFile,
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
    fn pinning(self) -> ContactPinning {
        match self {
            Self::Feet => ContactPinning::Feet,
            Self::Hands => ContactPinning::FeetAndHands,
            Self::None => ContactPinning::Nothing,
        }
    }
}

/// The motions of one file, on the character.
#[derive(Debug)]
pub(super) struct Motions {
    pub(super) fitted: Vec<FittedClip>,
    pub(super) warnings: Vec<String>,
    pub(super) report: FitReport,
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
        let report = FitReport::new(&source, &self.opened, &fitted);
        let warnings = open::warnings(&source);
        let warnings = warnings
            .into_iter()
            .map(|w| format!("{}: {w}", source.name));
        Ok(Some(Motions {
            warnings: warnings.collect(),
            report: report.context("no clip was retargeted")?,
            fitted,
        }))
    }
}

/// A line of the table of clips.
pub(super) fn row(motion: &FitReport, clip: &FitClip) -> [String; 9] {
    let quality = &clip.quality;
    let slide = |s: &FootSlideSummary| match s.contacts {
        0 => "-".to_owned(),
        _ => format!("{:.0}", s.mean),
    };
    [
        clip.name.clone(),
        file_name(motion),
        format!("{:.2}", clip.duration_secs),
        format!("{:.2}", motion.scale),
        slide(&quality.foot_slide_before_mm),
        slide(&quality.foot_slide_mm),
        format!("{:.0}", quality.below_floor_mm),
        format!("{:.0}%", 100.0 * quality.hands_error.mean),
        clip.joint_speed_max_deg_per_s
            .map_or_else(|| "-".to_owned(), |v| format!("{v:.0}")),
    ]
}

/// What became of the joints, in one line.
pub(super) fn joints_line(motion: &FitReport) -> String {
    format!(
        "{}: {} joints mapped, {} shared, {} held; {} dropped\n",
        clean(&file_name(motion)),
        motion.joints_mapped,
        motion.joints_shared,
        motion.joints_held,
        motion.dropped.len()
    )
}

/// Whether its joints went the way of another file's.
pub(super) fn is_like(motion: &FitReport, other: &FitReport) -> bool {
    let counts = |m: &FitReport| {
        [
            m.joints_mapped,
            m.joints_shared,
            m.joints_held,
            m.dropped.len(),
        ]
    };
    counts(motion) == counts(other)
}

fn file_name(motion: &FitReport) -> String {
    let name = Path::new(&motion.input).file_name();
    name.map_or_else(
        || motion.input.clone(),
        |n| n.to_string_lossy().into_owned(),
    )
}

/// Where the motion of every joint comes from.
pub(super) fn map(motion: &FitReport) -> String {
    let mut table = Table::new(&["joint", "is", "from"]);
    for joint in &motion.joints {
        let share = |s: &JointShare| match s.share {
            1.0 => s.joint.clone(),
            share => format!("{:.0}% {}", 100.0 * share, s.joint),
        };
        let from: Vec<String> = joint.from.iter().map(share).collect();
        table.row([&joint.joint, joint.origin, &from.join(" + ")]);
    }
    let mut text = format!("from {}\n{}", clean(&motion.input), table.text());
    if !motion.dropped.is_empty() {
        text.push_str(&format!(
            "  dropped: {}\n",
            clean(&motion.dropped.join(", "))
        ));
    }
    text
}
