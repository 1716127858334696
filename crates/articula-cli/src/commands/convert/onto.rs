//! `convert --onto CHARACTER`: retargets motions of other figures onto one character and reports
//! their quality.

use super::plan::{Input, reads_many};
use super::{ConvertArgs, face_level};
use crate::commands::face_shapes::MadeFace;
use crate::fault::{self, clean};
use crate::files::{self, Files};
use crate::open;
use crate::table::Table;
use anyhow::Context;
use articula::convert::{
    AddClipsOptions, ContactPinning, FitFinding, FitFindingKind, FittedClip, FootSlideSummary,
    JointShare, RetargetOptions, TransferReport, TransferredClipReport, fit_clips,
};
use articula::face::{FaceColumns, FaceKind, FaceTransfer, FittedFace, expand_face, fit_motion};
use articula::formats::{Assumption, Limits, Warning};
use articula::stream::StreamLimits;
use articula::stream::abp2::CarriedSkeleton;
use articula::{CharacterFile, Data, DataFormat};
use clap::ValueEnum;
use std::path::Path;

/// The character that receives motions.
#[derive(Debug)]
pub(super) struct Hero {
    pub(super) opened: CharacterFile,
    /// Morph targets that were made for its face.
    pub(super) made: MadeFace,
    options: AddClipsOptions,
}

/// What is kept in place during contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Pin {
    /// Feet, which are also kept above the floor
    Feet,
    /// Feet, and hands that rest on something
    Hands,
    /// Hands that rest on hips, thighs, trunk or head, or meet each other
    SelfContact,
    /// None: joint rotations only
    None,
}

impl Pin {
    /// The pinning of end effectors; feet unless it is told.
    fn pinning(pins: &[Self]) -> ContactPinning {
        if pins.contains(&Self::None) {
            ContactPinning::Nothing
        } else if pins.contains(&Self::Hands) {
            ContactPinning::FeetAndHands
        } else {
            ContactPinning::Feet
        }
    }

    /// Refuses nothing together with something.
    pub(super) fn check(pins: &[Self]) -> anyhow::Result<()> {
        if pins.len() > 1 && pins.contains(&Self::None) {
            return Err(fault::usage("--pin none stands alone"));
        }
        Ok(())
    }
}

/// The motions of one file, retargeted onto the character.
#[derive(Debug)]
pub(super) struct Motions {
    pub(super) fitted: Vec<FittedClip>,
    pub(super) warnings: Vec<String>,
    pub(super) format: &'static str,
    pub(super) bytes: usize,
    pub(super) report: MotionReport,
}

/// How well a character shows the motions of a file.
#[derive(Debug)]
pub(super) enum MotionReport {
    Body(TransferReport),
    Face(FaceTransfer),
}

impl MotionReport {
    /// The names of the clips, in the order of the clips.
    pub(super) fn names(&mut self) -> Vec<&mut String> {
        match self {
            Self::Body(body) => body.clips.iter_mut().map(|c| &mut c.name).collect(),
            Self::Face(face) => vec![&mut face.name],
        }
    }
}

impl Hero {
    /// Reads the character.
    pub(super) fn new(args: &ConvertArgs, files: &Files) -> anyhow::Result<Option<Self>> {
        let Some(path) = &args.onto else {
            return Ok(None);
        };
        let mut opened = open::character(files, path, &args.names)?;
        let made = args.shapes.add(&mut opened)?;
        let options = AddClipsOptions {
            clip: args.clip.clone(),
            file_in_names: reads_many(args),
            // Pinned feet and hands are of the retargeting between different figures.
            by_names: args.pin.is_empty() && args.floor_metres.is_none(),
            retarget: RetargetOptions {
                pinning: Pin::pinning(&args.pin),
                floor_metres: args.floor_metres,
                self_contact: args.pin.contains(&Pin::SelfContact),
                ..RetargetOptions::default()
            },
            ..AddClipsOptions::default()
        };
        Ok(Some(Self {
            opened,
            made,
            options,
        }))
    }

    /// Reads a file of motions and retargets them; `None` if it has no clip and was found in a
    /// folder rather than named.
    pub(super) fn motions(
        &self,
        input: &Input,
        args: &ConvertArgs,
        files: &Files,
    ) -> anyhow::Result<Option<Motions>> {
        let format = open::data_format(&input.path)?.filter(|f| f.animates_a_face());
        if let Some(format) = format {
            return self.face(input, format, args).map(Some);
        }
        let stream = open::motion_stream(&input.path)?;
        let mut source = match stream.filter(|stream| self.decodes(&stream.bytes)) {
            Some(stream) => {
                let name = files::shown(&input.path);
                let read = self
                    .opened
                    .decode_motion(&stream.bytes, &name, &Limits::default())?;
                let format = files::format(&input.path).unwrap_or(read.format());
                read.found_in(format, stream.file_bytes, stream.warnings)
            }
            None => open::character(files, &input.path, &args.names)?,
        };
        if args.names.settings().skip_first_frame {
            source.skip_first_frames()?;
        }
        if input.found && source.character().clips.is_empty() {
            return Ok(None);
        }
        let fitted = fit_clips(&source, &self.opened, &self.options)?;
        let report = TransferReport::new(&source, &self.opened, &fitted);
        // The findings of a transfer tell of a first frame too.
        let is_judged = fitted.iter().any(|f| f.fit.retargeted.is_some());
        let is_new = |w: &&Warning| !is_judged || w.guess != Some(Assumption::FirstFrame);
        let told: Vec<Warning> = source.warnings().iter().filter(is_new).cloned().collect();
        let warnings = open::warnings(&told);
        let warnings = warnings
            .into_iter()
            .map(|w| format!("{}: {w}", source.name()));
        let report = report.context("no clip was retargeted")?;
        Ok(Some(Motions {
            warnings: warnings.collect(),
            format: report.format,
            bytes: report.bytes,
            report: MotionReport::Body(report),
            fitted,
        }))
    }

    /// Whether a motion stream is decoded onto the character: a stream of another one that carries its
    /// own skeleton is opened like any other motion.
    fn decodes(&self, stream: &[u8]) -> bool {
        let limits = StreamLimits::default();
        let is_alone = matches!(CarriedSkeleton::open(stream, &limits), Ok(Some(_)));
        !is_alone || self.opened.is_of_motion(stream, &limits)
    }

    /// Reads a FAP file or a capture and transfers it to the character's face.
    fn face(
        &self,
        input: &Input,
        format: DataFormat,
        args: &ConvertArgs,
    ) -> anyhow::Result<Motions> {
        let read = open::face_motion(&input.path, format, &args.names)?;
        let name = files::shown(&input.path);
        let (data, level) = match read.data {
            Data::Fap(clip) => {
                let (clip, level) = face_level::applied(clip, args, expand_face);
                (Data::Fap(clip), level)
            }
            other => (other, None),
        };
        let FittedFace { fitted, mut report } = fit_motion(&data, &name, &self.opened)?;
        report.level = level;
        let warnings = open::warnings(&read.warnings).into_iter();
        Ok(Motions {
            fitted: vec![fitted],
            warnings: warnings.map(|w| format!("{name}: {w}")).collect(),
            format: format.name(),
            bytes: read.bytes,
            report: MotionReport::Face(report),
        })
    }
}

/// Columns of the table of clips.
pub(super) const COLUMNS: [&str; 12] = [
    "clip",
    "from",
    "seconds",
    "scale",
    "raw slide mm",
    "foot slide mm",
    "below floor mm",
    "wrong hinges",
    "hand error",
    "head error",
    "max deg/s (source)",
    "verdict",
];

/// One row of the table of clips.
pub(super) fn row(motion: &TransferReport, clip: &TransferredClipReport) -> [String; 12] {
    let [name, file] = [clip.name.clone(), file_name(&motion.input)];
    let seconds = format!("{:.2}", clip.duration_secs);
    let scale = format!("{:.2}", motion.scale);
    let Some(quality) = &clip.quality else {
        let mut row = [const { String::new() }; 12].map(|_| "-".to_owned());
        row[..4].clone_from_slice(&[name, file, seconds, scale]);
        return row;
    };
    let slide = |s: &FootSlideSummary| match s.contacts {
        0 => "-".to_owned(),
        _ => format!("{:.0}", s.mean),
    };
    let speed = |v: Option<f32>| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.0}"));
    let percent = |share: f32| format!("{:.0}%", 100.0 * share);
    let [fastest, source] = [
        clip.joint_speed_max_deg_per_s,
        clip.source_speed_max_deg_per_s,
    ]
    .map(speed);
    [
        name,
        file,
        seconds,
        scale,
        slide(&quality.foot_slide_before_mm),
        slide(&quality.foot_slide_mm),
        format!("{:.0}", quality.below_floor_mm),
        percent(quality.hinge_wrong_share),
        percent(quality.hands_error.mean),
        percent(quality.head_error.mean),
        format!("{fastest} ({source})"),
        match clip.good {
            Some(true) => "good",
            Some(false) => "look at it",
            None => "-",
        }
        .to_owned(),
    ]
}

/// What was found in a clip, each with what helps, on lines of their own.
pub(super) fn findings(clip: &TransferredClipReport) -> String {
    let name = clean(&clip.name);
    let line = |finding: &FitFinding| {
        let mend = mend(finding.kind).map_or_else(String::new, |mend| format!("; {mend}"));
        format!("{name}: {}{mend}\n", clean(&finding.what))
    };
    clip.findings.iter().map(line).collect()
}

/// What a user can do about a finding.
fn mend(kind: FitFindingKind) -> Option<&'static str> {
    Some(match kind {
        FitFindingKind::NotDriven => {
            "if the motion has them, map their names with --joint-map F.json"
        }
        FitFindingKind::FirstFrame => "--read first-frame=skip leaves it out",
        FitFindingKind::Hinges | FitFindingKind::Speed => {
            "check the joint map of both files (inspect, --map, --joint-map F.json)"
        }
        FitFindingKind::Ends => "check with --map which joint follows which",
        FitFindingKind::Slide => "--pin feet keeps them in place, --floor-metres M sets the floor",
        FitFindingKind::Floor => "--pin feet keeps them above, --floor-metres M sets the floor",
        FitFindingKind::SourceRest | FitFindingKind::TargetRest | FitFindingKind::Contacts => {
            return None;
        }
    })
}

/// The number of joints of each origin, on one line.
pub(super) fn joints_line(motion: &TransferReport) -> String {
    if motion.by_name {
        let (followed, dropped) = (motion.joints_mapped, motion.dropped.len());
        return format!(
            "{}: retargeted by joint names: {followed} of {} moving joints are followed, scale {:.2}\n",
            clean(&file_name(&motion.input)),
            followed + dropped,
            motion.scale
        );
    }
    format!(
        "{}: {} joints mapped, {} shared, {} held; {} dropped\n",
        clean(&file_name(&motion.input)),
        motion.joints_mapped,
        motion.joints_shared,
        motion.joints_held,
        motion.dropped.len()
    )
}

/// Whether the joints of both have the same origins.
pub(super) fn is_like(motion: &TransferReport, other: &TransferReport) -> bool {
    let counts = |m: &TransferReport| {
        [
            usize::from(m.by_name),
            m.joints_mapped,
            m.joints_shared,
            m.joints_held,
            m.dropped.len(),
        ]
    };
    counts(motion) == counts(other)
}

fn file_name(path: &str) -> String {
    let name = Path::new(path).file_name();
    name.map_or_else(|| path.to_owned(), |n| n.to_string_lossy().into_owned())
}

/// Table of the source of every joint's motion.
pub(super) fn map(motion: &TransferReport) -> String {
    let mut table = Table::new(&["joint", "origin", "from"]);
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

/// Columns of the table of face clips.
pub(super) const FACE_COLUMNS: [&str; 10] = [
    "face clip",
    "from",
    "seconds",
    "driven by",
    "columns",
    "joints",
    "FAPs",
    "not driven",
    "mean error mm",
    "max error mm",
];

/// One row of the table of face clips.
pub(super) fn face_row(face: &FaceTransfer) -> [String; 10] {
    let controls = match face.kind {
        FaceKind::MorphTargets => "morph targets",
        FaceKind::Expressions => "expressions",
        FaceKind::Joints => "parts of joints",
    };
    let most = match face.error_fap {
        None => "-".to_owned(),
        Some(fap) => format!(
            "{:.1} (FAP {fap}, {:.2} s)",
            face.error_mm_max, face.error_at_secs
        ),
    };
    [
        face.name.clone(),
        file_name(&face.file),
        format!("{:.2}", face.duration_secs),
        format!("{} of {} {controls}", face.controls_moved, face.controls),
        match face.columns {
            FaceColumns::Generic => "generic",
            FaceColumns::Measured => "of this face",
            FaceColumns::Table => "table",
        }
        .to_owned(),
        face.joints.len().to_string(),
        face.faps_moving.to_string(),
        face.not_driven.len().to_string(),
        format!("{:.2}", face.error_mm_mean),
        most,
    ]
}

/// The parameters that joints show least, and those that nothing of the face shows, on one line each.
pub(super) fn not_driven(face: &FaceTransfer) -> String {
    let mut text = String::new();
    let mut shown: Vec<_> = face.shown.iter().collect();
    shown.sort_by(|a, b| a.percent.total_cmp(&b.percent));
    if let Some(least) = shown.first() {
        let mean = shown.iter().map(|s| s.percent).sum::<f32>() / shown.len() as f32;
        text.push_str(&format!(
            "{}: joints show {mean:.0} % of the displacements of the face animation table, least of FAP {} ({:.0} %)\n",
            clean(&face.name),
            least.fap,
            least.percent
        ));
    }
    if face.not_driven.is_empty() {
        return text;
    }
    let faps = face.not_driven.iter();
    let faps: Vec<String> = faps.map(|n| format!("{} {}", n.fap, n.name)).collect();
    text.push_str(&format!(
        "{}: not driven: FAP {}\n",
        clean(&face.name),
        faps.join(", ")
    ));
    text
}
