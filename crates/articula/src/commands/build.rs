//! `articula build IN OUT.glb`: what is prepared once goes into the file.

use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::fault::clean;
use crate::load::{self, Behind, Format, Loaded};
use crate::mesh_levels::{self, Levels, MeshLevelArgs, report};
use crate::motion_tables::{self, ClipTables, POSE_KEYS, SEGS};
use crate::prepared::{Prepared, articulation_of};
use crate::table::{Table, counted};
use crate::{fault, files};
use anyhow::Context;
use articula_formats::gltf::{self, Document};
use articula_formats::{Limits, Resolver};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `build`.
#[derive(Debug, Args)]
pub(crate) struct BuildArgs {
    /// Character file (.glb, .gltf, .vrm, .vrma, .bvh)
    input: PathBuf,
    /// Asset to write (.glb)
    out: PathBuf,
    #[command(flatten)]
    names: ReadArgs,
    /// Seed of the choice of vertices that whole-pose keys watch
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    mesh_levels: MeshLevelArgs,
}

#[derive(Debug, Serialize)]
struct Report {
    #[serde(rename = "in")]
    input: String,
    out: String,
    bytes_in: usize,
    bytes_out: usize,
    joints: usize,
    mapped: usize,
    profile: String,
    clips: Vec<Clip>,
    /// Mesh levels, the finest first; none unless they are asked for.
    levels: Vec<report::Level>,
    /// What they weigh.
    bytes: Option<report::Bytes>,
    /// Poses that their errors in motion were measured on.
    poses_measured: Option<usize>,
    #[serde(skip)]
    measured: String,
    mesh_stream: Option<String>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Clip {
    name: String,
    frames: usize,
    segs_bytes: usize,
    posekeys_bytes: usize,
    /// Keys of all joints at each tolerance, from 0.5 mm, doubling.
    keys: Vec<usize>,
}

/// Reads a character, works out its tables, writes the asset.
pub(crate) fn run(args: &BuildArgs, console: &Console) -> anyhow::Result<()> {
    if Format::of_name(&args.out) != Some(Format::Glb) {
        let what = "an asset is a GLB; name the file .glb";
        return Err(fault::usage(format!("{}: {what}", files::shown(&args.out))));
    }
    let targets = args.mesh_levels.wanted()?;
    let wanted = targets.map(|targets| (&args.mesh_levels, targets));
    let loaded = load::character(&args.input, &args.names)?;
    let built = asset(loaded, wanted, args.seed, console)?;
    files::write(&args.out, &built.bytes)?;
    if let (Some(path), Some(levels)) = (&args.mesh_levels.mesh_stream, &built.levels) {
        files::write(path, &levels.transport.stream)?;
    }
    let report = Report::new(args, &built);
    console.result(&report, Report::text)
}

/// An asset, and what went into it.
#[derive(Debug)]
pub(crate) struct Built {
    pub(crate) bytes: Vec<u8>,
    prepared: Prepared,
    tables: Vec<ClipTables>,
    pub(crate) levels: Option<Levels>,
    /// Bytes that its meshes take.
    pub(crate) mesh_bytes: usize,
}

/// The asset of a character, with mesh levels at some shares of its triangles if wanted.
pub(crate) fn asset(
    loaded: Loaded,
    wanted: Option<(&MeshLevelArgs, Vec<f64>)>,
    seed: u64,
    console: &Console,
) -> anyhow::Result<Built> {
    let mut loaded = with_document(loaded)?;
    let place = loaded.place();
    let mut levels = None;
    if let Some((args, targets)) = wanted {
        let prepared = Prepared::from_loaded(loaded)?;
        let behind = prepared.loaded.behind.as_ref();
        let mut document = behind
            .context("the character has no document")?
            .document
            .clone();
        let made = mesh_levels::add(&prepared, &mut document, args, targets, console)
            .with_context(|| place.clone())?;
        // Tables are bound to the order of the vertices, which is new.
        loaded = reread(prepared.loaded, &document).with_context(|| place.clone())?;
        levels = Some(made);
    }
    let prepared = Prepared::from_loaded(loaded)?;
    let tables = motion_tables::made(&prepared.asset, seed, console);
    let (bytes, mesh_bytes) = written(&prepared, &tables).context(place)?;
    Ok(Built {
        bytes,
        prepared,
        tables,
        levels,
        mesh_bytes,
    })
}

/// A character of another format as the document that it will be.
fn with_document(loaded: Loaded) -> anyhow::Result<Loaded> {
    if loaded.behind.is_some() {
        return Ok(loaded);
    }
    let place = loaded.place();
    let document = Document::from_character(&loaded.character).context(place.clone())?;
    reread(loaded, &document).context(place)
}

/// A character as a document shows it.
fn reread(mut loaded: Loaded, document: &Document) -> anyhow::Result<Loaded> {
    let nothing: &mut Resolver<'_> = &mut |_: &str| Err("a GLB has nothing beside it".into());
    let file = gltf::read(&document.write_glb()?, &Limits::default(), nothing)?.value;
    let (character, behind) = Behind::split(file);
    loaded.character = character;
    loaded.behind = Some(behind);
    Ok(loaded)
}

/// The bytes of the asset, and how many of them are its meshes.
fn written(prepared: &Prepared, tables: &[ClipTables]) -> anyhow::Result<(Vec<u8>, usize)> {
    let behind = prepared.loaded.behind.as_ref();
    let behind = behind.context("the character has no document")?;
    let mut document = behind.document.clone();
    document.set_articulation(&articulation_of(&prepared.loaded), &behind.node_of_joint)?;
    for (clip, tables) in tables.iter().enumerate() {
        document.set_motion_table(clip, SEGS, &tables.segs)?;
        document.set_motion_table(clip, POSE_KEYS, &tables.pose_keys)?;
    }
    Ok((document.write_glb()?, document.mesh_bytes()))
}

impl Report {
    fn new(args: &BuildArgs, built: &Built) -> Self {
        let (prepared, levels) = (&built.prepared, built.levels.as_ref());
        let asset = &prepared.asset;
        let articulation = asset.rig.articulation();
        let clip = |(clip, tables): (&articula_core::Clip, &ClipTables)| Clip {
            name: clip.name.clone(),
            frames: clip.frames(),
            segs_bytes: tables.segs.len(),
            posekeys_bytes: tables.pose_keys.len(),
            keys: tables.keys.clone(),
        };
        Self {
            input: prepared.loaded.place(),
            out: files::shown(&args.out),
            bytes_in: prepared.loaded.bytes,
            bytes_out: built.bytes.len(),
            joints: asset.rig.skin_joints().len(),
            mapped: articulation.mapped(),
            profile: articulation.profile.clone(),
            clips: asset.clips.iter().zip(&built.tables).map(clip).collect(),
            levels: levels.map(report::levels).unwrap_or_default(),
            bytes: levels.map(|l| report::bytes(l, built.mesh_bytes)),
            poses_measured: levels.map(|l| l.made.measured.poses()),
            measured: levels.map(report::measured).unwrap_or_default(),
            mesh_stream: args.mesh_levels.mesh_stream.as_deref().map(files::shown),
            warnings: {
                let of_levels = levels.map(|l| l.warnings.clone()).unwrap_or_default();
                let mut warnings = prepared.loaded.warnings();
                warnings.extend(of_levels);
                warnings
            },
        }
    }

    fn text(&self) -> String {
        let profile = match self.profile.as_str() {
            "" => "no profile fits".to_owned(),
            name => format!("profile {}", clean(name)),
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
        let mut table = Table::new(&[
            "clip",
            "frames",
            "segs bytes",
            "posekeys bytes",
            "keys at 0.5 mm",
            "8 mm",
            "128 mm",
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
            text.push_str("no clip: levels and regions only\n");
        } else {
            text.push_str(&table.text());
        }
        if let Some(bytes) = &self.bytes {
            text.push('\n');
            text.push_str(&report::text(&self.levels, bytes, &self.measured));
        }
        if let Some(stream) = &self.mesh_stream {
            text.push_str(&format!("mesh levels as a stream: {}\n", clean(stream)));
        }
        for warning in &self.warnings {
            text.push_str(&format!("warning: {}\n", clean(warning)));
        }
        text
    }
}
