//! `articula inspect FILE`: prints the contents of a file and warns about irregularities.

mod access_units;
mod data;
mod face;
mod human;
mod item;
mod joint_levels;
mod mesh_levels;
mod motion_stream;
mod mp4;
mod stream;
mod text;

use crate::arguments::{CharacterArgs, not_negative};
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use articula::inspect::{
    FAR_FROM_METRES, WarningInspection, has_too_many_joints, inspect, inspect_listed, joint_levels,
};
use articula::{DataFormat, Figure, Format, MotionTables, rig_joint_map};
use clap::Args;
use std::path::{Path, PathBuf};

/// Arguments of `inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    character: CharacterArgs,
    /// List every joint with its H-Anim name, level and region; of a FAP file every parameter
    #[arg(long)]
    map: bool,
    /// Compute and list the joint levels of the character: joints, matrices and errors
    #[arg(long)]
    joint_levels: bool,
    /// With --joint-levels: tolerance in millimetres from which a level may drop ancestors of the
    /// joints that it keeps (a far level)
    #[arg(long, value_name = "MM", default_value_t = 1e3 * FAR_FROM_METRES,
          value_parser = not_negative, requires = "joint_levels")]
    far_from_mm: f32,
    /// Write the joint map of the character as it was recognised: a file to edit, and to give to
    /// --joint-map
    #[arg(long, value_name = "F.json")]
    write_joint_map: Option<PathBuf>,
    #[command(flatten)]
    face: face::FaceArgs,
    /// Name of the only clip to report
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
}

/// Reads the file and prints its contents.
pub(crate) fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<()> {
    let outputs = args.write_joint_map.iter().map(PathBuf::as_path);
    let outputs = outputs.chain(args.face.outputs());
    let inputs = args.character.inputs().chain(args.face.input());
    console.files.plan(inputs, outputs)?;
    args.face.check()?;
    if let Some(kind) = Jointless::of(&args.character.file)? {
        return kind.run(args, console);
    }
    let opened = open::kept(&console.files, &args.character)?;
    if has_too_many_joints(&opened) && !args.measures() {
        let found = inspect_listed(&opened);
        return console.result(&found, |found| text::of(found, args.map));
    }
    let figure = Figure::new(opened)?;
    let clips: Vec<usize> = match &args.clip {
        Some(name) => figure.clip(Some(name))?.into_iter().collect(),
        None => (0..figure.asset.clips.len()).collect(),
    };
    let mut findings = console.work(|work| inspect(&figure, &clips, work))?;
    for (told, warning) in findings.warnings.iter_mut().zip(figure.opened.warnings()) {
        told.what = open::advised(warning);
    }
    if !args.character.leaves_out() {
        for (clip, found) in clips.iter().zip(&mut findings.clips) {
            let tables = MotionTables::stored(&figure, *clip);
            found.motion_tables = Some(tables.bytes);
            let told = |what| WarningInspection {
                at: "file".to_owned(),
                what,
            };
            findings
                .warnings
                .extend(tables.warnings.into_iter().map(told));
        }
    }
    if matches!(figure.opened.format(), Format::Abp | Format::Mp4) {
        findings.stream = Some(access_units::of(&args.character.file)?);
        findings.tracks = open::tracks(&args.character.file)?;
    }
    if args.joint_levels {
        let far_from_metres = 1e-3 * args.far_from_mm;
        let found = console.work(|work| joint_levels(&figure, &clips, far_from_metres, work))?;
        findings.joint_levels = Some(found);
    }
    if args.face.asks() {
        let (layout, written) = args.face.run(&figure, console)?;
        findings.face_layout = Some(layout);
        findings.written.extend(written);
    }
    findings.written.extend(args.face.draw_shapes(
        &figure,
        figure.clip(args.clip.as_deref())?,
        console,
    )?);
    findings.warnings.extend(unused_map(args, &figure));
    if let Some(path) = &args.write_joint_map {
        let made = rig_joint_map(&figure.opened)?;
        console.files.write(path, &made.bytes)?;
        let shown = files::shown(path);
        if !made.untold.is_empty() {
            let what = format!(
                "{} of the joints share their names with others, or have none, and are not told by \
                 {shown}: {}",
                made.untold.len(),
                made.untold.join(", ")
            );
            let at = "joints".to_owned();
            findings.warnings.push(WarningInspection { at, what });
        }
        findings.written.push(shown);
    }
    console.result(&findings, |found| text::of(found, args.map))
}

/// A file without joints.
enum Jointless {
    Item,
    MeshStream,
    MotionStream(open::Stream),
    Data(DataFormat),
}

impl Jointless {
    /// What a file is, if it has no joints.
    fn of(path: &Path) -> anyhow::Result<Option<Self>> {
        if files::is_item(path) {
            return Ok(Some(Self::Item));
        }
        if let Some(format) = open::data_format(path)? {
            return Ok(Some(Self::Data(format)));
        }
        if stream::is_one(path) {
            return Ok(Some(Self::MeshStream));
        }
        Ok(open::motion_stream(path)?.map(Self::MotionStream))
    }

    /// Prints the contents.
    fn run(&self, args: &InspectArgs, console: &Console) -> anyhow::Result<()> {
        check_without_joints(args)?;
        match self {
            Self::Data(format) => {
                if args.clip.is_some() {
                    return Err(fault::usage(format!(
                        "--clip chooses a motion of joints; a .{} file has none",
                        format.name()
                    )));
                }
                data::run(&args.character, *format, args.map, console)
            }
            Self::Item => item::run(&args.character, console),
            Self::MotionStream(stream) => motion_stream::run(stream, &args.character, console),
            Self::MeshStream => stream::run(&args.character, console),
        }
    }
}

/// Refuses flags that ask for the joints or the face of a character.
fn check_without_joints(args: &InspectArgs) -> anyhow::Result<()> {
    let what = if args.joint_levels {
        "--joint-levels lists levels of a character; this file has no joints"
    } else if args.write_joint_map.is_some() {
        "--write-joint-map writes the joints of a character; this file has no joints"
    } else if args.face.needs_a_mesh() {
        "flags about the face are for characters; this file has no mesh"
    } else {
        return Ok(());
    };
    Err(fault::usage(what))
}

impl InspectArgs {
    /// Whether a flag asks for what only a rig can tell.
    fn measures(&self) -> bool {
        self.joint_levels
            || self.face.asks()
            || self.clip.is_some()
            || self.write_joint_map.is_some()
            || self.face.outputs().next().is_some()
    }
}

/// A warning if joint maps are given and none of them is used.
fn unused_map(args: &InspectArgs, figure: &Figure) -> Option<WarningInspection> {
    let is_given = !args.character.names.joint_map.is_empty();
    let is_stored = figure.opened.character().articulation.is_some();
    if !is_given || !is_stored && figure.opened.mapping().by_user {
        return None;
    }
    let what = if is_stored {
        "the file stores levels and regions of its joints, which are kept; no joint map is used"
    } else {
        "the joint map does not fit and is not used: it must have joints of the file for \
         humanoid_root, l_hip, r_hip, l_shoulder and r_shoulder, or with the scope hand for a wrist \
         and five finger joints"
    };
    Some(WarningInspection {
        at: "--joint-map".to_owned(),
        what: what.to_owned(),
    })
}
