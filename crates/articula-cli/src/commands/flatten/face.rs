//! `flatten --motion FILE`: a motion of the face as a clip of the character.

use super::arguments::ConvertArgs;
use crate::commands::face_shapes::{self, MadeFace};
use crate::commands::speak;
use crate::console::Console;
use crate::{fault, files, open};
use articula::CharacterFile;
use articula::build::face::FapInterval;
use articula::face::{FaceTransfer, FittedFace, add_face_table, fit_motion};
use articula::speech::{SpeechOptions, fit_speech};
use serde::Serialize;
use std::path::Path;

/// What the face of a character was given.
#[derive(Debug, Default)]
pub(super) struct Given {
    /// Name of the new clip, and how well the face shows the motion.
    pub(super) motion: Option<FaceTransfer>,
    made: MadeFace,
    pub(super) warnings: Vec<String>,
}

/// A report with what the face shows of a motion.
#[derive(Debug, Serialize)]
pub(super) struct WithFace<R> {
    #[serde(flatten)]
    pub(super) report: R,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) motion: Option<FaceTransfer>,
}

/// Gives the face its morph targets and the motion that were asked for, which is then the only clip.
pub(super) fn give(
    args: &ConvertArgs,
    opened: &mut CharacterFile,
    console: &Console,
) -> anyhow::Result<Given> {
    let mut given = Given {
        made: args.shapes.add(opened)?,
        ..Given::default()
    };
    if let Some(path) = &args.motion.motion {
        move_face(args, path, opened, &mut given, console)?;
    }
    Ok(given)
}

/// Gives a face the table by which parameters drive it, beside the shapes that a motion drives; without one
/// it has to be found.
pub(super) fn give_table(opened: &mut CharacterFile, given: &mut Given) -> anyhow::Result<()> {
    let mut names = opened
        .character()
        .meshes
        .iter()
        .flat_map(|m| &m.morph_names);
    if !names.any(|name| FapInterval::parse(name).is_some()) {
        given.made.table = Some(add_face_table(opened, &[])?);
    }
    Ok(())
}

fn move_face(
    args: &ConvertArgs,
    path: &Path,
    opened: &mut CharacterFile,
    given: &mut Given,
    console: &Console,
) -> anyhow::Result<()> {
    let (FittedFace { fitted, report }, mut warnings) = if is_voice(path) {
        (spoken(path, opened, console)?, told(args, path))
    } else {
        shown(args, path, opened)?
    };
    opened.put_clips(vec![fitted], false);
    if !report.not_driven.is_empty() {
        let faps = report.not_driven.iter();
        let faps: Vec<String> = faps.map(|n| format!("{} {}", n.fap, n.name)).collect();
        let what = format!("not shown by this face: FAP {}", faps.join(", "));
        warnings.push(format!("{}: {what}", report.file));
    }
    given.motion = Some(report);
    given.warnings = warnings;
    Ok(())
}

fn is_voice(path: &Path) -> bool {
    files::extension(path) == "wav"
}

/// What a face does while it speaks a recording.
fn spoken(path: &Path, opened: &CharacterFile, console: &Console) -> anyhow::Result<FittedFace> {
    let track = speak::recognised(&speak::recording(path)?, console);
    let options = SpeechOptions::default();
    Ok(fit_speech(&track, &files::shown(path), opened, &options)?)
}

/// Where the recording is heard, if the result does not hold it.
fn told(args: &ConvertArgs, path: &Path) -> Vec<String> {
    if args.special.audio.is_some() {
        return Vec::new();
    }
    let file = files::shown(path);
    let how = if files::extension(args.out()) == "html" {
        format!("--audio {file} puts it into the page, which then plays in time with it")
    } else {
        "play it beside the result, from the start of the clip".to_owned()
    };
    vec![format!("{file}: the result has no sound; {how}")]
}

/// Parameters or a capture, with warnings about their file.
fn shown(
    args: &ConvertArgs,
    path: &Path,
    opened: &CharacterFile,
) -> anyhow::Result<(FittedFace, Vec<String>)> {
    let place = files::shown(path);
    let Some(format) = open::data_format(path)?.filter(|f| f.animates_a_face()) else {
        let what = "no motion of a face; give a .fap, .afp, .fba, .csv or .wav file";
        return Err(fault::usage(format!("--motion {place}: {what}")));
    };
    let read = open::face_motion(path, format, &args.names)?;
    let warnings = open::warnings(&read.warnings);
    let warnings = warnings.into_iter().map(|w| format!("{place}: {w}"));
    let fitted = fit_motion(&read.data, &place, opened)?;
    Ok((fitted, warnings.collect()))
}

impl Given {
    /// Name of the clip to show: of the motion, else that which was asked for.
    pub(super) fn clip<'a>(&'a self, args: &'a ConvertArgs) -> Option<&'a str> {
        let motion = self.motion.as_ref().map(|m| m.name.as_str());
        motion.or(args.motion.clip.as_deref())
    }

    /// The report of a conversion with that of the face.
    pub(super) fn with<R: Serialize>(self, report: R) -> WithFace<R> {
        WithFace {
            report,
            motion: self.motion,
        }
    }

    /// What was made and what the face shows, for people.
    pub(super) fn text(&self) -> String {
        let mut text: String = self
            .made
            .table
            .iter()
            .map(face_shapes::table_text)
            .collect();
        text.extend(self.made.shapes.iter().map(face_shapes::text));
        if let Some(motion) = &self.motion {
            text.push_str(&format!(
                "face: {} of {} controls move, {} joints turn; {} of {} moving parameters are shown, {:.2} mm \
                 off in the mean and {:.1} at most\n",
                motion.controls_moved,
                motion.controls,
                motion.joints.len(),
                motion.faps_moving - motion.not_driven.len(),
                motion.faps_moving,
                motion.error_mm_mean,
                motion.error_mm_max,
            ));
        }
        text
    }
}
