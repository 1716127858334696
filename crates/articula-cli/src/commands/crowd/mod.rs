//! `articula crowd FILE`: simulates a crowd; reports its cost, its error and the levels in use.

mod importance;
mod report;

use crate::arguments::{CharacterArgs, field_of_view, not_negative, positive, size};
use crate::console::Console;
use crate::crowd::picture;
use crate::crowd::run::{self, Run};
use crate::crowd::stage::{DISPLAY_HZ, Settings, TimedCrowd};
use crate::files::{self, Files};
use crate::open;
use crate::play::read_camera_path;
use crate::{fault, selection};
use anyhow::Context;
use articula::crowd::{
    Backend, CacheUse, ClipStorage, CrowdAsset, CrowdBuffers, CrowdOptions, DetailGoal,
    ErrorSummary, JointLodMethod, MAX_MEMBERS, MAX_MESH_LEVELS, PaletteForm, PaletteMatrices,
    RootMotionPolicy, read_scene, write_scene,
};
use articula_build::{PLAZA_COUNT, Plaza, Scene, plaza};
use articula_core::Clip;
use articula_flat::impostor::{ImpostorBound, ImpostorOptions};
use articula_report::{Plot, PlotOptions, Series, line_plot, stacked};
use clap::{Args, ValueEnum};
use importance::ImportanceArgs;
use report::CrowdRunReport;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Seconds to play a scene without a camera path.
const USUAL_SECS: f64 = 2.0;

/// Maximum length of a camera path that is played whole by default, seconds.
const LONGEST_LAP_SECS: f64 = 60.0;

/// Maximum number of frames of a run.
const MAX_FRAMES: f64 = 36_000.0;

/// Maximum number of threads.
const MAX_THREADS: usize = 256;

/// Maximum size of a scene file in bytes.
const MAX_SCENE_BYTES: u64 = 512 << 20;

/// Size in pixels of the picture that `--picture` writes.
const PICTURE_PX: (u32, u32) = (1280, 720);

/// Arguments of `crowd`.
#[derive(Debug, Args)]
pub(crate) struct CrowdArgs {
    #[command(flatten)]
    character: CharacterArgs,
    /// Number of characters [default: 10000, or all of a scene file]
    #[arg(long, value_name = "N", value_parser = count)]
    count: Option<usize>,
    /// Joint levels of detail. full: every joint of every character in every frame; auto: merged
    /// levels within the tolerance or budget; an expression such as "loa(Low) + zone(hands)":
    /// these joints of all characters in view
    #[arg(long, value_name = "full|auto|EXPR", default_value = "auto")]
    level: String,
    /// Maximum number of mesh levels, chosen together with the joint levels: those of the file, or,
    /// if it has none or more, new ones as by build --levels; 1: the original mesh only
    #[arg(long, value_name = "N", default_value = "1", value_parser = mesh_levels)]
    mesh_levels: usize,
    /// Show who is far away by impostors, pictures of at most so many bytes of pixels, where their error
    /// is within the tolerance [default of BYTES: 4194304]
    #[arg(long, value_name = "BYTES", num_args = 0..=1, default_missing_value = "4194304")]
    impostors: Option<usize>,
    /// Lowest and highest pitch of the eyes that impostors are made for, in degrees above the
    /// horizon of a character
    #[arg(long, value_name = "LOW..HIGH", default_value = "-90..90", value_parser = pitches,
          allow_hyphen_values = true)]
    impostor_pitches: [f32; 2],
    /// Scene to play, with travelling clips kept in place: plaza, plaza-2 (moving camera, a fifth
    /// of the characters in cross-fades), plaza-2-in-step (as plaza-2, all phases equal), or a
    /// scene file
    #[arg(long, value_name = "NAME|F.json", default_value = "plaza")]
    scene: String,
    /// Processor time per frame in milliseconds; levels are chosen for the least visible error
    /// within it
    #[arg(long, value_name = "MS", value_parser = positive)]
    budget_ms: Option<f32>,
    /// Maximum visible error in pixels; with a budget, errors above it are reduced first
    #[arg(long, value_name = "PX", default_value = "1", value_parser = not_negative)]
    epsilon_px: f32,
    /// Number of threads
    #[arg(long, value_name = "T", default_value = "1", value_parser = threads)]
    threads: usize,
    /// Duration in seconds at 60 frames per second [default: one lap of the scene's camera, or 2]
    #[arg(long, value_name = "S", value_parser = positive)]
    seconds: Option<f32>,
    /// JSON file with a camera path to use instead: a list of key frames with t, eye and target
    #[arg(long, value_name = "F.json")]
    camera_path: Option<PathBuf>,
    /// Also compute the root motion of travelling clips; characters do not move by it here
    #[arg(long)]
    root_motion: bool,
    /// Name of a clip to play (repeatable) [default: all]
    #[arg(long, value_name = "NAME|all")]
    clip: Vec<String>,
    #[command(flatten)]
    importance: ImportanceArgs,
    #[command(flatten)]
    storage: StorageArgs,
    /// Size of the picture in whose pixels errors are measured [default: the scene's, 1920x1080]
    #[arg(long, value_name = "WxH", value_parser = size)]
    viewport: Option<(u32, u32)>,
    /// Vertical field of view in degrees [default: the scene's, 45]
    #[arg(long, value_name = "DEG", value_parser = field_of_view)]
    fov_deg: Option<f32>,
    /// Seed of the scene and of all random choices
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the scene to a JSON file, to edit and pass to --scene
    #[arg(long, value_name = "F.json")]
    save_scene: Option<PathBuf>,
    /// Write a plot of frame time and error over time
    #[arg(long, value_name = "F.svg")]
    plot: Option<PathBuf>,
    /// Write a picture of the first frame, each character in the colour of its level
    #[arg(long, value_name = "F.png")]
    picture: Option<PathBuf>,
    /// Write what a GPU reads in the first frame into a folder: palettes of the skin, draws, records,
    /// transforms, meshes and their description, crowd.json
    #[arg(long, value_name = "DIR")]
    buffers: Option<PathBuf>,
}

/// Storage of clips and format of palettes.
#[derive(Debug, Clone, Args)]
struct StorageArgs {
    /// Storage of clips: 32-bit floats or 16-bit integers
    #[arg(long, value_enum, default_value = "float")]
    storage: StorageName,
    /// Format of a palette matrix: 48, 24, 32 or 16 bytes
    #[arg(long, value_enum, default_value = "matrix")]
    form: FormName,
    /// Palette matrices: one per joint, or one per skin binding including the inverse bind matrix
    /// [default: skin where poses may be cached, else joints]
    #[arg(long, value_enum)]
    palette: Option<MatricesName>,
    /// Source of poses. auto: evaluated, or blended from cached ones where that is cheaper within
    /// the tolerance; records: the same, with cached poses blended by the GPU from records of 16
    /// bytes; own: evaluated for each character; shared: evaluated, and shared by characters whose
    /// poses agree within the tolerance
    #[arg(long, value_enum, default_value = "auto")]
    source: SourceName,
    /// Instruction set; all give the same bits [default: the fastest]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    backend: Option<Backend>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StorageName {
    Float,
    Short,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormName {
    Matrix,
    Half,
    Rigid,
    HalfRigid,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatricesName {
    Joints,
    Skin,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SourceName {
    Auto,
    Records,
    Own,
    Shared,
}

impl StorageArgs {
    /// Whether the form of palettes can be cached.
    fn is_cacheable(&self) -> bool {
        matches!(self.form, FormName::Matrix | FormName::Half)
    }

    /// Use of the pose cache that the source asks for.
    fn cache(&self) -> CacheUse {
        match self.source {
            SourceName::Auto => CacheUse::Cpu,
            SourceName::Records => CacheUse::Gpu,
            SourceName::Own | SourceName::Shared => CacheUse::Never,
        }
    }
}

/// The parsed and checked inputs of a run.
struct Piece {
    asset: CrowdAsset,
    scene: Scene,
    scene_name: String,
    in_place: Vec<String>,
    settings: Settings,
}

/// Plays the crowd and prints the report.
pub(crate) fn run(args: &CrowdArgs, console: &Console) -> anyhow::Result<()> {
    let detail = args.detail()?;
    args.check_outputs()?;
    args.check_records()?;
    args.check_mesh_levels()?;
    args.check_buffers()?;
    let buffers = args.buffer_files();
    let outputs = args.outputs().chain(buffers.iter().map(PathBuf::as_path));
    console.files.plan(args.inputs(), outputs)?;
    let start = Instant::now();
    let figure = open::figure(&console.files, &args.character)?;
    let place = figure.opened.name.clone();
    let mut warnings = open::warnings(&figure.opened.warnings);
    let options = args.options(&figure.asset.clips)?;
    let asset = console.work(|work| CrowdAsset::new(&figure, &options, work))?;
    let ready_ms = start.elapsed().as_secs_f64() * 1e3;
    warnings.extend_from_slice(asset.warnings());
    if args.picture.is_some() && !asset.has_mesh() {
        anyhow::bail!("{place}: no mesh, so there is nothing to draw; leave --picture out");
    }
    let scene = args.scene(&asset)?;
    let settings = Settings {
        detail,
        share: args.storage.source == SourceName::Shared,
        cache: args.storage.cache(),
        hiders: args.importance.hiders(),
        threads: args.threads,
        frames: args.frames(&scene)?,
    };
    let clips = asset.clips().iter().enumerate();
    let in_place = clips.filter(|(c, _)| asset.travels(*c));
    let piece = Piece {
        in_place: in_place.map(|(_, clip)| clip.name.clone()).collect(),
        asset,
        scene,
        scene_name: args.scene.clone(),
        settings,
    };
    let found = run::run(&piece.asset, &piece.scene, settings, args.seed, console)?;
    let mut report = CrowdRunReport::new(args, &piece, &found, place);
    report.ready_ms = ready_ms;
    report.warnings.extend(warnings);
    args.write(&piece, &found, &mut report, &console.files)?;
    console.result(&report, CrowdRunReport::text)
}

impl CrowdArgs {
    /// Detail goal that the flags ask for.
    fn detail(&self) -> anyhow::Result<DetailGoal> {
        match (self.level.as_str(), self.budget_ms) {
            ("auto", None) => Ok(DetailGoal::Tolerance(self.epsilon_px)),
            ("auto", Some(ms)) => Ok(DetailGoal::Budget {
                ms,
                cap_px: self.epsilon_px,
            }),
            (level, Some(_)) => Err(fault::usage(format!(
                "--budget-ms chooses levels itself; leave --level {level} out"
            ))),
            ("full", None) => Ok(DetailGoal::Full),
            // Level 0 keeps every joint; the named level comes after it.
            (_, None) => Ok(DetailGoal::Level(1)),
        }
    }

    /// The files that are read.
    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let scene = [Path::new(&self.scene)].into_iter();
        let path = self.camera_path.as_deref();
        self.character.inputs().chain(scene).chain(path)
    }

    /// The files that are written.
    fn outputs(&self) -> impl Iterator<Item = &Path> {
        let all = [&self.save_scene, &self.plot, &self.picture];
        all.into_iter().flatten().map(PathBuf::as_path)
    }

    /// The files of `--buffers` that may exist already; a missing folder has none.
    fn buffer_files(&self) -> Vec<PathBuf> {
        let folder = self.buffers.iter().filter(|folder| folder.is_dir());
        let names = CrowdBuffers::FILES.into_iter();
        let names = names.chain([CrowdBuffers::MANIFEST]);
        folder
            .flat_map(|folder| names.clone().map(|name| folder.join(name)))
            .collect()
    }

    fn check_buffers(&self) -> anyhow::Result<()> {
        let Some(folder) = &self.buffers else {
            return Ok(());
        };
        if self.storage.palette == Some(MatricesName::Joints) {
            let what = "--buffers requires palettes of the skin; leave --palette out";
            return Err(fault::usage(what));
        }
        if files::is_no_folder(folder) {
            let folder = files::shown(folder);
            let what = format!("--buffers {folder}: this is no folder; name a folder");
            return Err(fault::usage(what));
        }
        Ok(())
    }

    fn check_outputs(&self) -> anyhow::Result<()> {
        let wanted = [
            ("--plot", &self.plot, "svg", "plots are SVG"),
            ("--picture", &self.picture, "png", "pictures are PNG"),
            ("--save-scene", &self.save_scene, "json", "scenes are JSON"),
        ];
        for (flag, path, ending, what) in wanted {
            let Some(path) = path else { continue };
            let found = path.extension().unwrap_or_default();
            if !found.eq_ignore_ascii_case(ending) {
                let path = files::shown(path);
                let mend = format!("name a .{ending} file");
                return Err(fault::usage(format!("{flag} {path}: {what}; {mend}")));
            }
        }
        Ok(())
    }

    /// Names of the clips to play; empty for all.
    fn clips(&self, clips: &[Clip]) -> Vec<String> {
        let is_all = |name: &String| name == "all" && !clips.iter().any(|c| c.name == "all");
        if self.clip.iter().any(is_all) {
            Vec::new()
        } else {
            self.clip.clone()
        }
    }

    fn options(&self, clips: &[Clip]) -> anyhow::Result<CrowdOptions> {
        let joints = match self.level.as_str() {
            "full" => JointLodMethod::Whole,
            "auto" => JointLodMethod::Merged,
            text => JointLodMethod::Named(selection::expression("--level", text)?),
        };
        Ok(CrowdOptions {
            clips: self.clips(clips),
            root_motion: if self.root_motion {
                RootMotionPolicy::Extracted
            } else {
                RootMotionPolicy::OnTheSpot
            },
            joints,
            matrices: match self.palette() {
                MatricesName::Joints => PaletteMatrices::Joints,
                MatricesName::Skin => PaletteMatrices::Skin,
            },
            form: match self.storage.form {
                FormName::Matrix => PaletteForm::Matrix,
                FormName::Half => PaletteForm::HalfMatrix,
                FormName::Rigid => PaletteForm::Rigid,
                FormName::HalfRigid => PaletteForm::HalfRigid,
            },
            storage: match self.storage.storage {
                StorageName::Float => ClipStorage::Float,
                StorageName::Short => ClipStorage::Short,
            },
            backend: self.storage.backend.unwrap_or_else(Backend::best),
            seed: self.seed,
            pose_cache: self.is_cached(),
            impostors: self.impostors.map(|bytes| ImpostorOptions {
                bound: ImpostorBound::Bytes(bytes),
                pitches_radians: self.impostor_pitches.map(f32::to_radians),
                ..ImpostorOptions::default()
            }),
            mesh_levels: self.mesh_levels,
        })
    }

    /// Coarser meshes and impostors are chosen by their error, which only `--level auto` does.
    fn check_mesh_levels(&self) -> anyhow::Result<()> {
        if self.impostors.is_some() && self.level != "auto" {
            let what = format!("--impostors requires --level auto, not {}", self.level);
            return Err(fault::usage(what));
        }
        if self.mesh_levels > 1 && self.level != "auto" {
            let what = format!("--mesh-levels requires --level auto, not {}", self.level);
            return Err(fault::usage(what));
        }
        Ok(())
    }

    /// Kind of palette matrices; a cache and written buffers require those of the skin.
    fn palette(&self) -> MatricesName {
        let may_cache = self.level == "auto"
            && self.storage.cache() != CacheUse::Never
            && self.storage.is_cacheable();
        let usual = match may_cache || self.buffers.is_some() {
            true => MatricesName::Skin,
            false => MatricesName::Joints,
        };
        self.storage.palette.unwrap_or(usual)
    }

    /// Whether poses are cached.
    fn is_cached(&self) -> bool {
        self.level == "auto"
            && self.storage.cache() != CacheUse::Never
            && self.storage.is_cacheable()
            && self.palette() == MatricesName::Skin
    }

    /// Records are of cached poses, which are matrices of the skin chosen by their error.
    fn check_records(&self) -> anyhow::Result<()> {
        if self.storage.source != SourceName::Records || self.is_cached() {
            return Ok(());
        }
        let mend = if self.level != "auto" {
            "requires --level auto"
        } else if self.storage.is_cacheable() {
            "requires palettes of the skin; leave --palette out"
        } else {
            "requires --form matrix or half"
        };
        Err(fault::usage(format!("--source records {mend}")))
    }

    fn scene(&self, asset: &CrowdAsset) -> anyhow::Result<Scene> {
        let clips = asset.clips();
        let count = self.count.unwrap_or(PLAZA_COUNT);
        let made = |kind| plaza(count, clips.len(), self.seed, kind);
        let mut scene = match self.scene.as_str() {
            "plaza" => made(Plaza::Still),
            "plaza-2" => made(Plaza::Moving),
            "plaza-2-in-step" => made(Plaza::InPhase),
            path => self.scene_file(Path::new(path), clips)?,
        };
        if let Some((width, height)) = self.viewport {
            scene.viewport.width_px = width as f32;
            scene.viewport.height_px = height as f32;
        }
        if let Some(fov_deg) = self.fov_deg {
            scene.viewport.fov_y_radians = fov_deg.to_radians();
        }
        if let Some(path) = &self.camera_path {
            scene.camera = read_camera_path(path, DISPLAY_HZ)?;
            scene.camera_loops = false;
        }
        self.importance.apply(&mut scene, clips)?;
        Ok(scene)
    }

    fn scene_file(&self, path: &Path, clips: &[Clip]) -> anyhow::Result<Scene> {
        if path.extension().is_none() && !path.exists() {
            let known = "give plaza, plaza-2, plaza-2-in-step or a .json file";
            return Err(fault::usage(format!("--scene {}: {known}", self.scene)));
        }
        let bytes = files::read(path, MAX_SCENE_BYTES)?;
        let mut scene = read_scene(&bytes, clips, DISPLAY_HZ)
            .map_err(|e| match e {
                // Not JSON, or not a scene; an error inside a scene is reported as it is.
                articula::Error::Read(e) => {
                    anyhow::anyhow!("{e}; --save-scene writes an example")
                }
                other => other.into(),
            })
            .with_context(|| files::shown(path))?;
        let there = scene.members.len();
        match self.count {
            Some(count) if count > there => Err(fault::usage(format!(
                "--count {count}: {} has {there} characters",
                files::shown(path)
            ))),
            count => {
                scene.truncate(count.unwrap_or(there));
                Ok(scene)
            }
        }
    }

    /// Number of frames that count.
    fn frames(&self, scene: &Scene) -> anyhow::Result<usize> {
        let lap = scene.loop_secs();
        let usual = if lap > 0.0 {
            lap.min(LONGEST_LAP_SECS)
        } else {
            USUAL_SECS
        };
        let secs = self.seconds.map_or(usual, f64::from);
        let frames = (secs * DISPLAY_HZ).round().max(1.0);
        if frames > MAX_FRAMES {
            let most = MAX_FRAMES / DISPLAY_HZ;
            let what = format!("--seconds {secs}: at most {most} seconds");
            return Err(fault::usage(what));
        }
        Ok(frames as usize)
    }

    /// Writes the scene, plot, picture and buffers that were asked for.
    fn write(
        &self,
        piece: &Piece,
        found: &Run,
        report: &mut CrowdRunReport,
        files: &Files,
    ) -> anyhow::Result<()> {
        if let Some(path) = &self.save_scene {
            files.write(path, &write_scene(&piece.scene, piece.asset.clips()))?;
            report.written.push(files::shown(path));
        }
        if let Some(path) = &self.plot {
            let svg = stacked(&plots(found, self.budget_ms));
            files.write(path, svg.as_bytes())?;
            report.written.push(files::shown(path));
        }
        if let Some(path) = &self.picture {
            let picture = picture::draw(&piece.asset, &piece.scene, piece.settings, PICTURE_PX)?;
            let png = picture.to_png().with_context(|| files::shown(path))?;
            files.write(path, &png)?;
            report.written.push(files::shown(path));
        }
        if let Some(folder) = &self.buffers {
            let stage = TimedCrowd::first_frame(&piece.asset, &piece.scene, piece.settings)?;
            let buffers = CrowdBuffers::new(stage.scene.player())?
                .files()?
                .into_iter();
            let buffers = buffers.map(|(name, bytes)| (folder.join(name), bytes));
            let buffers: Vec<(PathBuf, Vec<u8>)> = buffers.collect();
            files.make_folder(folder)?;
            files.write_all(&buffers)?;
            let written = buffers.iter().map(|(path, _)| files::shown(path));
            report.written.extend(written);
        }
        Ok(())
    }
}

/// Plots of frame time and error over the time of the scene.
pub(crate) fn plots(found: &Run, budget_ms: Option<f32>) -> Vec<Plot> {
    let options = |title: &str, y: &str, target| PlotOptions {
        title: title.into(),
        x_label: "time (s)".into(),
        y_label: y.into(),
        target,
        ..PlotOptions::default()
    };
    let target = budget_ms.map(|ms| (f64::from(ms), format!("budget {ms} ms")));
    let time = Series {
        points: found.over_time.clone(),
        ..Series::default()
    };
    let line = |name: &str, of: &dyn Fn(&ErrorSummary) -> f64| Series {
        name: name.into(),
        points: found
            .looks
            .iter()
            .map(|l| {
                let one = std::slice::from_ref(l);
                (l.secs, of(&ErrorSummary::of(one)))
            })
            .collect(),
        dashed: name != "p95 of visible characters",
    };
    let errors = [
        line("p95 of visible characters", &|s| s.p95),
        line("max", &|s| s.max),
        line("max within 20 m", &|s| s.near_max),
    ];
    vec![
        Plot {
            name: "frame-time.svg",
            svg: line_plot(
                &options("Processor time of a frame", "time (ms)", target),
                &[time],
            ),
        },
        Plot {
            name: "crowd-error.svg",
            svg: line_plot(&options("Error of the crowd", "error (px)", None), &errors),
        },
    ]
}

fn count(text: &str) -> Result<usize, String> {
    let most = MAX_MEMBERS;
    let number = text.parse::<usize>().ok();
    let number = number.filter(|n| (1..=most).contains(n));
    number.ok_or_else(|| format!("expected a whole number of 1 to {most}"))
}

fn mesh_levels(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok();
    let number = number.filter(|n| (1..=MAX_MESH_LEVELS).contains(n));
    number.ok_or_else(|| format!("expected a whole number of 1 to {MAX_MESH_LEVELS}"))
}

fn pitches(text: &str) -> Result<[f32; 2], String> {
    let pair = text.split_once("..");
    let pair = pair.and_then(|(low, high)| Some([low.parse().ok()?, high.parse().ok()?]));
    let pair = pair.filter(|[low, high]: &[f32; 2]| low < high && *low >= -90.0 && *high <= 90.0);
    pair.ok_or_else(|| "expected two rising angles of -90 to 90 degrees, such as -10..30".into())
}

fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok();
    let number = number.filter(|n| (1..=MAX_THREADS).contains(n));
    number.ok_or_else(|| format!("expected a whole number of 1 to {MAX_THREADS}"))
}

fn backend(text: &str) -> Result<Backend, String> {
    let here = Backend::ALL.into_iter().filter(|b| b.is_available());
    let found = text.parse().ok().filter(|b: &Backend| b.is_available());
    found.ok_or_else(|| {
        let here: Vec<String> = here.map(|b| b.to_string()).collect();
        format!("this machine has {}", here.join(", "))
    })
}
