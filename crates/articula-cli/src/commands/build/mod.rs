//! `articula build IN [MOTION...] OUT.glb`: writes an asset with articulation, motion tables and
//! mesh levels, and adds clips of other files.

mod arguments;
mod check;
mod compact;
pub(crate) mod levels;
mod optimized;

use super::optimize::{Given, error};
use crate::arguments::{ReadArgs, skin_millimetres};
use crate::console::Console;
use crate::fault::clean;
use crate::open;
use crate::table::{Table, counted, warnings};
use crate::{fault, files};
use anyhow::Context;
use arguments::MeshLevelArgs;
use articula::convert::ClipProvenance;
use articula::stream::abp2::MotionOptions;
use articula::{
    AddClipsOptions, CharacterFile, ClipResampling, ClipTables, CodedMeshLevels, Format,
    MeshLevelBytes, MeshLevelRow, PartBytes, PrepareOptions, PreparedAsset, PreparedPart, prepare,
};
use clap::Args;
use compact::CompactClip;
use optimized::{OptimizedFirst, optimized};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Arguments of `build`.
#[derive(Debug, Args)]
pub(crate) struct BuildArgs {
    /// Character file (.glb, .gltf, .vrm, .vrma, .fbx, .bvh), files whose clips are added (any format with
    /// clips), and the asset to write (.glb); with --check, the asset to check
    #[arg(value_name = "IN [MOTION]… OUT.glb", required = true)]
    paths: Vec<PathBuf>,
    /// Only check that an asset has every part, and that each belongs to the character beside it
    #[arg(long)]
    check: bool,
    /// Parts of the preparation to leave out
    #[arg(long, value_name = "PART,…", value_delimiter = ',', value_parser = part, conflicts_with = "check")]
    without: Vec<PreparedPart>,
    /// Store every clip also as a motion stream (ABP-2), within a tolerance in millimetres of skin
    /// [default without a value: 0.1]
    #[arg(long, value_name = "MM", num_args = 0..=1, require_equals = true,
          default_missing_value = "0.1", value_parser = skin_millimetres, conflicts_with = "check")]
    compact_clips: Option<f64>,
    #[command(flatten)]
    names: ReadArgs,
    /// Seed for choosing the vertices and frames that errors are measured on
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Feature points of the face that are known, as JSON or in an FDP file for this mesh; the others
    /// are found (see inspect --face)
    #[arg(long, value_name = "F.json|F.fdp", conflicts_with = "check")]
    face_points: Option<PathBuf>,
    /// Leave out keys, triangles and bytes of pictures first, as optimize does it, at a greatest error in motion: pixels of
    /// a picture of 720 lines that the figure at rest fills, or a length; arrays are not compressed [default without a
    /// value: 1px]
    #[arg(long, value_name = "1px|0.5mm", num_args = 0..=1, require_equals = true,
          default_missing_value = "1px", value_parser = error,
          conflicts_with_all = ["check", "face_points", "lock"])]
    optimize: Option<Given>,
    #[command(flatten)]
    mesh_levels: MeshLevelArgs,
}

/// Lines of the picture that an error in pixels is meant of.
const OPTIMIZE_PX: f32 = 720.0;

#[derive(Debug, Serialize)]
struct BuildReport {
    #[serde(rename = "in")]
    input: String,
    out: String,
    bytes_in: usize,
    bytes_out: usize,
    joints: usize,
    mapped: usize,
    profile: String,
    clips: Vec<ClipTableSizes>,
    /// Bytes of each part of the preparation; 0 for what was left out or is not needed.
    parts: Vec<PartBytes>,
    /// Bytes of the palettes that the keys of the pose cache become when the asset is opened.
    pose_cache_bytes: usize,
    /// Number of feature points of the face; 0 if the figure shows too little of one.
    face_points: usize,
    /// Number of those that every mesh level keeps; null without levels, with --free-face and for a
    /// face whose points may be wrong.
    face_points_kept: Option<usize>,
    /// Files whose clips were added.
    added: Vec<Added>,
    /// What was left out before; null without --optimize.
    optimized: Option<OptimizedFirst>,
    /// Mesh levels, finest first; empty unless asked for.
    levels: Vec<MeshLevelRow>,
    /// Sizes of the mesh levels.
    bytes: Option<MeshLevelBytes>,
    /// Number of poses on which errors in motion were measured.
    poses_measured: Option<usize>,
    #[serde(skip)]
    measured: String,
    mesh_stream: Option<String>,
    /// Distance of the frames of each clip from the keys of its file.
    resampling: Vec<ClipResampling>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ClipTableSizes {
    name: String,
    frames: usize,
    segs_bytes: usize,
    posekeys_bytes: usize,
    contacts_bytes: usize,
    /// The clip as a motion stream, if it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    compact: Option<CompactClip>,
    /// Keys of all joints at each tolerance, from 0.5 mm, doubling.
    keys: Vec<usize>,
}

/// The clips added from one file.
#[derive(Debug, Serialize)]
struct Added {
    #[serde(rename = "in")]
    input: String,
    /// Names of the clips on the character.
    clips: Vec<String>,
    /// Whether they were retargeted by the H-Anim map.
    retargeted: bool,
    /// Whether they were retargeted by the names of the joints.
    by_name: bool,
}

/// Reads a character, computes its tables and writes the asset.
pub(crate) fn run(args: &BuildArgs, console: &Console) -> anyhow::Result<()> {
    let mesh_levels = args.mesh_levels.wanted()?;
    if args.check {
        return check::run(args, console);
    }
    let Some((out, inputs)) = args.paths.split_last().filter(|(_, i)| !i.is_empty()) else {
        return Err(fault::usage(
            "name the character, then the asset to write: IN OUT.glb",
        ));
    };
    if files::format(out) != Some(Format::Glb) {
        let what = "an asset is a GLB; name the file .glb";
        return Err(fault::usage(format!("{}: {what}", files::shown(out))));
    }
    let mut options = PrepareOptions {
        seed: args.seed,
        mesh_levels,
        compact_clips: args.compact_clips.map(|mm| MotionOptions {
            tolerance_metres: 1e-3 * mm,
            ..MotionOptions::default()
        }),
        without: args.without.clone(),
        face_points: Vec::new(),
    };
    console.files.plan(args.inputs(inputs), args.outputs(out))?;
    let (character, motions) = inputs.split_first().context("no character was named")?;
    // With motions, the clips of the character itself stay as they are.
    let mut opened = match motions.is_empty() {
        true => open::motion(&console.files, character, &args.names)?,
        false => open::character(&console.files, character, &args.names)?,
    };
    let files = motions
        .iter()
        .map(|p| open::motion(&console.files, p, &args.names));
    let motions: Vec<CharacterFile> = files.collect::<Result<_, _>>()?;
    if let Some(path) = &args.face_points {
        options.face_points = open::face_points(&opened, path)?;
    }
    let added = added(&mut opened, &motions, console)?;
    let bytes_in = opened.bytes();
    let optimized = match args.optimize {
        Some(given) => {
            let (error, how) = (given.bound(OPTIMIZE_PX), (args.seed, &args.names));
            let (lighter, first) = optimized(&opened, error, how, console)?;
            opened = lighter;
            Some(first)
        }
        None => None,
    };
    let built = console.work(|work| prepare(opened, &options, work));
    let built = built.map_err(|error| match (error.cause(), &args.mesh_levels.lock) {
        (articula::Error::LockedVertices(what), Some(list)) => {
            anyhow::anyhow!("{}: {what}", files::shown(list))
        }
        _ => error.into(),
    })?;
    let mut written = vec![(out.as_path(), built.glb.as_slice())];
    if let (Some(path), Some(levels)) = (&args.mesh_levels.mesh_stream, &built.mesh_levels) {
        written.push((path, &levels.stream.bytes));
    }
    console.files.write_all(&written)?;
    let mut report = BuildReport::new(args, out, &built)?;
    report.added = added;
    report.bytes_in = bytes_in;
    report.optimized = optimized;
    for motion in &motions {
        let warnings = open::warnings(motion.warnings()).into_iter();
        let warnings = warnings.map(|w| format!("{}: {w}", motion.name()));
        report.warnings.extend(warnings);
    }
    console.result(&report, BuildReport::text)
}

impl BuildArgs {
    /// The files that are read.
    fn inputs<'a>(&'a self, characters: &'a [PathBuf]) -> impl Iterator<Item = &'a Path> {
        let points = self.face_points.iter();
        let named = characters
            .iter()
            .chain(&self.mesh_levels.lock)
            .chain(points);
        named.map(PathBuf::as_path).chain(self.names.inputs())
    }

    /// The files that are written.
    fn outputs<'a>(&'a self, asset: &'a Path) -> impl Iterator<Item = &'a Path> {
        [asset]
            .into_iter()
            .chain(self.mesh_levels.mesh_stream.as_deref())
    }
}

/// Adds the clips of other files to the character.
fn added(
    opened: &mut CharacterFile,
    motions: &[CharacterFile],
    console: &Console,
) -> anyhow::Result<Vec<Added>> {
    if motions.is_empty() {
        return Ok(Vec::new());
    }
    let options = AddClipsOptions::default();
    let fits = console.work(|work| opened.add_clips(motions, &options, work))?;
    let of_one = |fits: &[ClipProvenance]| Added {
        input: fits[0].file.clone(),
        clips: fits.iter().map(|fit| fit.name.clone()).collect(),
        retargeted: fits[0].retargeted.is_some(),
        by_name: fits[0].by_name.is_some(),
    };
    Ok(fits.chunk_by(|a, b| a.file == b.file).map(of_one).collect())
}

impl BuildReport {
    fn new(args: &BuildArgs, out: &Path, built: &PreparedAsset) -> anyhow::Result<Self> {
        let (figure, made) = (&built.figure, built.mesh_levels.as_ref());
        let asset = &figure.asset;
        let articulation = asset.rig.articulation();
        let clip = |(index, tables): (usize, &ClipTables)| {
            let clip = &asset.clips[index];
            let compact = (!tables.compact.is_empty()).then(|| {
                CompactClip::measure(figure, index, &tables.compact, tables.compact_error_metres)
            });
            Ok(ClipTableSizes {
                name: clip.name.clone(),
                frames: clip.frames(),
                segs_bytes: tables.segs.len(),
                posekeys_bytes: tables.pose_keys.len(),
                contacts_bytes: tables.contacts.len(),
                compact: compact.transpose()?,
                keys: tables.keys.clone(),
            })
        };
        let clips = built.tables.iter().enumerate().map(clip);
        let resampling = figure.resampling();
        Ok(Self {
            input: figure.opened.name().to_owned(),
            out: files::shown(out),
            bytes_in: figure.opened.bytes(),
            bytes_out: built.glb.len(),
            joints: asset.rig.skin_joints().len(),
            mapped: articulation.mapped(),
            profile: articulation.profile.clone(),
            clips: clips.collect::<anyhow::Result<_>>()?,
            parts: built.parts.clone(),
            pose_cache_bytes: built.pose_cache_bytes,
            face_points: built.face_points,
            face_points_kept: made.and_then(|l| Some(l.face.as_ref()?.points)),
            added: Vec::new(),
            optimized: None,
            levels: made.map(CodedMeshLevels::rows).unwrap_or_default(),
            bytes: made.map(|l| l.sizes(built.mesh_bytes)),
            poses_measured: made.map(CodedMeshLevels::poses_measured),
            measured: made.map(levels::measured).unwrap_or_default(),
            mesh_stream: args.mesh_levels.mesh_stream.as_deref().map(files::shown),
            warnings: {
                let of_levels = made.map(|l| l.warnings.clone()).unwrap_or_default();
                let mut warnings = open::warnings(figure.opened.warnings());
                warnings.extend(resampling.iter().filter_map(ClipResampling::warning));
                warnings.extend(of_levels);
                warnings
            },
            resampling,
        })
    }

    fn text(&self) -> String {
        let profile = match self.profile.as_str() {
            "" => "no joint map matches".to_owned(),
            name => format!("joint map {}", clean(name)),
        };
        let mut text = format!(
            "{} ({} bytes) -> {} ({} bytes)\n{}, {} mapped to H-Anim ({})\n",
            clean(&self.input),
            self.bytes_in,
            clean(&self.out),
            self.bytes_out,
            counted(self.joints, "joint", "joints"),
            self.mapped,
            profile
        );
        text.extend(self.optimized.as_ref().map(OptimizedFirst::text));
        for added in &self.added {
            let how = if added.retargeted {
                "retargeted by the H-Anim map"
            } else if added.by_name {
                "retargeted by joint names"
            } else {
                "same joints"
            };
            let clips = counted(added.clips.len(), "clip", "clips");
            text.push_str(&format!("{clips} from {} ({how})\n", clean(&added.input)));
        }
        let mut table = Table::new(&[
            "clip",
            "frames",
            "segs bytes",
            "posekeys bytes",
            "keys at 0.5 mm",
            "at 8 mm",
            "at 128 mm",
        ]);
        for clip in &self.clips {
            let keys = |level: usize| clip.keys.get(level).map_or("-".into(), usize::to_string);
            table.row([
                clip.name.clone(),
                clip.frames.to_string(),
                clip.segs_bytes.to_string(),
                clip.posekeys_bytes.to_string(),
                keys(0),
                keys(4),
                keys(8),
            ]);
        }
        if table.is_empty() {
            text.push_str("no clip: only levels and regions of joints were stored\n");
        } else {
            text.push_str(&table.text());
        }
        let compact = self.clips.iter();
        let compact = compact.filter_map(|c| Some((c.name.as_str(), c.compact.as_ref()?)));
        text.push_str(&compact::text(compact));
        text.push('\n');
        text.push_str(&parts_text(&self.parts, self.pose_cache_bytes));
        if self.face_points > 0 {
            let points = self.face_points;
            text.push_str(&format!("face: {points} feature points"));
            if let Some(kept) = self.face_points_kept {
                text.push_str(&format!(", {kept} of them in every mesh level"));
            }
            text.push('\n');
        }
        if let Some(bytes) = &self.bytes {
            text.push('\n');
            text.push_str(&levels::text(&self.levels, bytes, &self.measured));
        }
        if let Some(stream) = &self.mesh_stream {
            text.push_str(&format!("mesh level stream: {}\n", clean(stream)));
        }
        text.push_str(&warnings(&self.warnings));
        text
    }
}

/// The stored parts as a table.
fn parts_text(parts: &[PartBytes], pose_cache_bytes: usize) -> String {
    let mut table = Table::new(&["part", "bytes"]);
    for part in parts {
        let bytes = match part.bytes {
            0 => "-".to_owned(),
            bytes => bytes.to_string(),
        };
        table.row([part.part.to_owned(), bytes]);
    }
    let mut text = table.text();
    if pose_cache_bytes > 0 {
        text.push_str(&format!(
            "pose cache: its keys become palettes of {pose_cache_bytes} bytes when the asset is opened\n"
        ));
    }
    text
}

fn part(text: &str) -> Result<PreparedPart, String> {
    text.trim().parse()
}
