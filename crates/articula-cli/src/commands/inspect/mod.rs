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

use crate::arguments::{CharacterArgs, file, not_negative, settings};
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use articula::face::rig_face_map;
use articula::formats::Limits;
use articula::inspect::{
    FAR_FROM_METRES, WarningInspection, has_too_many_joints, inspect, inspect_listed, joint_levels,
};
use articula::optimize::{BytesByKind, OptimizeOptions, OptimizeReport, optimize};
use articula::{CharacterFile, DataFormat, Figure, Format, MotionTables, rig_joint_map};
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
    /// Compute and list the joint levels of the character: joints, matrices and errors; from a
    /// tolerance of MM millimetres, a level may drop ancestors of the joints that it keeps (a far
    /// level) [default: 4]
    #[arg(long, value_name = "MM", num_args = 0..=1, require_equals = true,
          value_parser = not_negative)]
    joint_levels: Option<Option<f32>>,
    #[command(flatten)]
    face: face::FaceArgs,
    /// Write what was found, to edit and to give back: joint-map=F.json, the joint map as it was
    /// recognised, face-map=F.json, what morph targets and expressions show, and face-points=F.json, or F.fdp with the zone of each point; and pictures of the
    /// face: face-sheet=F.png with its points, shape-sheet=F.png with each morph target,
    /// clip-sheet=F.png at moments of a clip (--clip, or the first)
    #[arg(long, value_name = "KEY=FILE,…", value_parser = written_files)]
    write: Option<WrittenFiles>,
    /// Make a lighter file at the defaults of `optimize`, and tell what it saves; it is not written
    #[arg(long)]
    savings: bool,
    /// Name of the only clip to report
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
}

/// Files that receive what was found.
#[derive(Debug, Clone, Default)]
struct WrittenFiles {
    joint_map: Option<PathBuf>,
    face_map: Option<PathBuf>,
    face_points: Option<PathBuf>,
    face_sheet: Option<PathBuf>,
    shape_sheet: Option<PathBuf>,
    clip_sheet: Option<PathBuf>,
}

fn written_files(text: &str) -> Result<WrittenFiles, String> {
    let png = |text: &str| match file(text)? {
        path if files::extension(&path) == "png" => Ok(Some(path)),
        _ => Err(format!("{text}: sheets are PNG; name the file .png")),
    };
    settings(text, |to: &mut WrittenFiles, key, value| {
        match key {
            "joint-map" => to.joint_map = Some(file(value)?),
            "face-map" => to.face_map = Some(file(value)?),
            "face-points" => to.face_points = Some(file(value)?),
            "face-sheet" => to.face_sheet = png(value)?,
            "shape-sheet" => to.shape_sheet = png(value)?,
            "clip-sheet" => to.clip_sheet = png(value)?,
            _ => {
                let keys = "joint-map, face-map, face-points, face-sheet, shape-sheet, clip-sheet";
                return Ok(Some(keys));
            }
        }
        Ok(None)
    })
}

impl WrittenFiles {
    fn paths(&self) -> impl Iterator<Item = &Path> {
        let all = [
            &self.joint_map,
            &self.face_map,
            &self.face_sheet,
            &self.shape_sheet,
            &self.clip_sheet,
            &self.face_points,
        ];
        all.into_iter().flatten().map(PathBuf::as_path)
    }

    /// Whether feature points of the face are to be written or drawn.
    fn needs_points(&self) -> bool {
        self.face_points.is_some() || self.face_sheet.is_some()
    }

    /// Whether the face of a mesh is to be written or drawn.
    fn needs_a_mesh(&self) -> bool {
        self.needs_points() || self.shape_sheet.is_some() || self.clip_sheet.is_some()
    }
}

/// Reads the file and prints its contents.
pub(crate) fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<()> {
    let write = args.write.clone().unwrap_or_default();
    let inputs = args.character.inputs().chain(args.face.input());
    console.files.plan(inputs, write.paths())?;
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
    findings.parts = parts(&args.character.file, &figure.opened)?;
    if args.savings {
        findings.optimized = Some(savings(args, &figure.opened, console)?);
    }
    if let Some(far_from_mm) = args.joint_levels {
        let far_from_metres = far_from_mm.map_or(FAR_FROM_METRES, |mm| 1e-3 * mm);
        let found = console.work(|work| joint_levels(&figure, &clips, far_from_metres, work))?;
        findings.joint_levels = Some(found);
    }
    if args.face.asks() || write.needs_points() {
        let (layout, written) = args.face.run(&figure, &write, console)?;
        findings.face_layout = Some(layout);
        findings.written.extend(written);
    }
    let clip = figure.clip(args.clip.as_deref())?;
    let drawn = face::draw_shapes(&figure, clip, &write, console)?;
    findings.written.extend(drawn);
    findings.warnings.extend(unused_map(args, &figure));
    if let Some(path) = &write.joint_map {
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
    if let Some(path) = &write.face_map {
        let bytes = rig_face_map(&figure.opened)?;
        console.files.write(path, &bytes)?;
        findings.written.push(files::shown(path));
    }
    console.result(&findings, |found| text::of(found, args.map))
}

/// What the program `optimize` would save at its defaults.
fn savings(
    args: &InspectArgs,
    opened: &CharacterFile,
    console: &Console,
) -> anyhow::Result<OptimizeReport> {
    let options = OptimizeOptions::default();
    let made = console.work(|work| optimize(opened, &options, work))?;
    if args.character.leaves_out() {
        return Ok(made.report);
    }
    let source = files::read(&args.character.file, Limits::default().bytes)?;
    Ok(made.or_source(&source).report)
}

/// Bytes of the parts of a glTF file, as they are stored if they are all in it.
fn parts(path: &Path, opened: &CharacterFile) -> anyhow::Result<Option<BytesByKind>> {
    match (opened.format(), opened.gltf()) {
        (Format::Gltf, Some(gltf)) => Ok(Some(gltf.document.bytes_by_kind())),
        (Format::Glb | Format::Vrm | Format::Vrma, _) => {
            let bytes = files::read(path, Limits::default().bytes)?;
            Ok(Some(BytesByKind::of_glb(&bytes)))
        }
        _ => Ok(None),
    }
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
    let written = args.write.as_ref();
    let what = if args.joint_levels.is_some() {
        "--joint-levels lists levels of a character; this file has no joints"
    } else if written.is_some_and(|write| write.joint_map.is_some()) {
        "--write joint-map writes the joints of a character; this file has no joints"
    } else if args.savings {
        "--savings makes a lighter file of a character; this file has no joints"
    } else if args.face.asks() || written.is_some_and(WrittenFiles::needs_a_mesh) {
        "flags about the face are for characters; this file has no mesh"
    } else {
        return Ok(());
    };
    Err(fault::usage(what))
}

impl InspectArgs {
    /// Whether a flag asks for what only a rig can tell.
    fn measures(&self) -> bool {
        self.joint_levels.is_some()
            || self.face.asks()
            || self.savings
            || self.clip.is_some()
            || self.write.is_some()
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
