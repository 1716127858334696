//! `articula crowd FILE…`: simulates a crowd; reports its cost, its error and the levels in use.

mod cast;
mod importance;
mod outputs;
mod report;

use crate::arguments::{field_of_view, not_negative, positive, size};
use crate::console::Console;
use crate::files;
use crate::play::read_camera_path;
use crate::{fault, selection};
use anyhow::Context;
use articula::build::{PLAZA_COUNT, Plaza, Scene, SceneView, plaza};
use articula::core::Clip;
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdOptions, DISPLAY_HZ, DetailGoal, JointLodMethod, MAX_MEMBERS,
    MAX_MESH_LEVELS, MAX_VIEWS, MeasureOptions, PaletteMatrices, RootMotionPolicy,
    SceneMeasurement, SceneOptions, measure_scene,
};
use articula::flat::impostor::{ImpostorBound, ImpostorOptions};
use articula_report::{FRAME_CLOCKS, crowd_for_sizes};
use cast::{CastArgs, CastAsset, NamedScene};
use clap::{Args, ValueEnum};
use importance::ImportanceArgs;
use report::CrowdRunReport;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Seconds to play a scene without a camera path.
const USUAL_SECS: f64 = 2.0;

/// Maximum length of a camera path that is played whole by default, seconds.
const LONGEST_LAP_SECS: f64 = 60.0;

/// Maximum number of frames of a run.
const MAX_FRAMES: f64 = 36_000.0;

/// Maximum number of threads.
const MAX_THREADS: usize = 256;

/// Size in pixels of the picture that `--picture` writes.
const PICTURE_PX: (u32, u32) = (1280, 720);

/// Arguments of `crowd`.
#[derive(Debug, Args)]
pub(crate) struct CrowdArgs {
    #[command(flatten)]
    cast: CastArgs,
    /// Number of characters [default: 10000, or all of a scene file]
    #[arg(long, value_name = "N", value_parser = count)]
    count: Option<usize>,
    /// Joint levels of detail. full: every joint of every character in every frame; auto: merged
    /// levels within the tolerance or budget; an expression such as "loa(Low) + zone(hands)":
    /// these joints of all characters in view
    #[arg(long, value_name = "full|auto|EXPR", default_value = "auto")]
    level: String,
    /// Maximum number of mesh levels, chosen together with the joint levels: those of the file, or,
    /// if it has none or more, new ones as by build --levels; 1: the original mesh only [default:
    /// those of the file, or up to 6 down to 120 triangles if it is no asset]
    #[arg(long, value_name = "N", value_parser = mesh_levels)]
    mesh_levels: Option<usize>,
    /// Maximum size of the cached poses of a character in bytes
    #[arg(long, value_name = "BYTES", default_value_t = CrowdOptions::default().cache_bytes)]
    cache_bytes: usize,
    /// Show who is far away by impostors, pictures of at most so many bytes of pixels, where their error
    /// is within the tolerance [default of BYTES: 4194304]
    #[arg(long, value_name = "BYTES", num_args = 0..=1, default_missing_value = "4194304")]
    impostors: Option<usize>,
    /// Scene to play, with travelling clips kept in place: plaza, plaza-2 (moving camera, a fifth
    /// of the characters in cross-fades), plaza-2-in-step (as plaza-2, all phases equal), or a
    /// scene file
    #[arg(long, value_name = "NAME|F.json", default_value = "plaza")]
    scene: String,
    /// Processor time per frame in milliseconds; where it does not suffice, triangles are given up, then
    /// the error of far characters
    #[arg(long, value_name = "MS", value_parser = positive)]
    budget_ms: Option<f32>,
    /// Maximum visible error in pixels; with a budget, as long as the time suffices
    #[arg(long, value_name = "PX", default_value = "1", value_parser = not_negative)]
    epsilon_px: f32,
    /// Number of threads
    #[arg(long, value_name = "T", default_value = "1", value_parser = threads)]
    threads: usize,
    /// Duration in seconds at 60 frames per second [default: one lap of the scene's camera, or 2]
    #[arg(long, value_name = "S", value_parser = positive)]
    seconds: Option<f32>,
    /// JSON file with a camera path to use instead: a list of key frames with t, eye and target
    /// (repeatable: every further one is another view)
    #[arg(long, value_name = "F.json")]
    camera_path: Vec<PathBuf>,
    /// Also compute the root motion of travelling clips; characters do not move by it here
    #[arg(long)]
    root_motion: bool,
    /// Name of a clip to play (repeatable), by every character that has it [default: all]
    #[arg(long, value_name = "NAME|all")]
    clip: Vec<String>,
    #[command(flatten)]
    importance: ImportanceArgs,
    /// Source of poses. auto: evaluated, or blended from cached ones where that is cheaper within
    /// the tolerance; records: the same, with cached poses blended by the GPU from records of 16
    /// bytes
    #[arg(long, value_enum, default_value = "auto")]
    source: SourceName,
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
    /// Write a picture of the first frame: the characters as they look, and below in the colours of their
    /// levels; the views below each other
    #[arg(long, value_name = "F.png")]
    picture: Option<PathBuf>,
    /// Write what a GPU reads in the first frame into a folder: palettes of the skin, draws, records,
    /// transforms, meshes and their description, crowd.json; of several characters, each in a folder with
    /// its name
    #[arg(long, value_name = "DIR")]
    buffers: Option<PathBuf>,
}

/// What blends cached poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SourceName {
    Auto,
    Records,
}

/// The parsed and checked inputs of a run.
struct Piece {
    cast: Vec<CastAsset>,
    scene: Arc<Scene>,
    options: MeasureOptions,
}

/// Plays the crowd and prints the report.
pub(crate) fn run(args: &CrowdArgs, console: &Console) -> anyhow::Result<()> {
    let detail = args.detail()?;
    args.check_outputs()?;
    args.check_records()?;
    args.check_mesh_levels()?;
    args.check_buffers()?;
    let scene_file = args.scene_file()?;
    let files = args.cast.of(scene_file.as_ref())?;
    let buffers = args.buffer_files(&files);
    let outputs = args.outputs().chain(buffers.iter().map(PathBuf::as_path));
    let inputs = args.inputs().chain(files.iter().map(|f| f.path.as_path()));
    console.files.plan(inputs, outputs)?;
    let start = Instant::now();
    let several = files.len() > 1;
    let options = |clips: &[Clip]| args.options(clips, several);
    let cast = files.into_iter();
    let cast = cast.map(|file| args.cast.open(file, &options, console));
    let cast = cast.collect::<anyhow::Result<Vec<CastAsset>>>()?;
    let ready_ms = start.elapsed().as_secs_f64() * 1e3;
    if let (Some(_), Some(bare)) = (&args.picture, cast.iter().find(|c| !c.asset.has_mesh())) {
        let place = files::shown(&bare.file.path);
        anyhow::bail!("{place}: no mesh, so there is nothing to draw; leave --picture out");
    }
    let scene = args.scene(&cast, scene_file)?;
    let options = MeasureOptions {
        scene: args.scene_options(detail),
        threads: args.threads,
        frames: args.frames(&scene)?,
        seed: args.seed,
    };
    let piece = Piece {
        cast,
        scene: scene.into(),
        options,
    };
    let measured = piece.measure(console)?;
    let mut report = CrowdRunReport::new(args, &piece, ready_ms, measured);
    args.write(&piece, &mut report, &console.files)?;
    console.result(&report, CrowdRunReport::text)
}

impl Piece {
    /// The assets of the cast, which share their data with it.
    fn assets(&self) -> Vec<CrowdAsset> {
        self.cast.iter().map(|c| c.asset.clone()).collect()
    }

    /// Plays the scene on the threads asked for, the others of which are a step away from the first.
    fn measure(&self, console: &Console) -> anyhow::Result<SceneMeasurement> {
        let (assets, options) = (self.assets(), &self.options);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads);
        let pool = (options.threads > 1).then(|| pool.build().context("threads"));
        let pool = pool.transpose()?;
        Ok(console.work(|work| {
            let measure = || measure_scene(&assets, &self.scene, options, FRAME_CLOCKS, work);
            match &pool {
                Some(pool) => pool.install(measure),
                None => measure(),
            }
        })?)
    }
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
        let paths = self.camera_path.iter().map(PathBuf::as_path);
        self.cast.inputs().chain(scene).chain(paths)
    }

    /// Names of the clips to play; empty for all. Where there are several characters, each plays those
    /// that it has.
    fn clips(&self, clips: &[Clip], several: bool) -> Vec<String> {
        let has = |name: &String| clips.iter().any(|c| c.name == *name);
        if self.clip.iter().any(|name| name == "all" && !has(name)) {
            return Vec::new();
        }
        let own = || self.clip.iter().filter(|name| has(name)).cloned();
        match several && own().next().is_some() {
            true => own().collect(),
            false => self.clip.clone(),
        }
    }

    fn options(&self, clips: &[Clip], several: bool) -> anyhow::Result<CrowdOptions> {
        let joints = match self.level.as_str() {
            "full" => JointLodMethod::Whole,
            "auto" => JointLodMethod::Merged,
            text => JointLodMethod::Named(selection::expression("--level", text)?),
        };
        Ok(CrowdOptions {
            clips: self.clips(clips, several),
            root_motion: if self.root_motion {
                RootMotionPolicy::Extracted
            } else {
                RootMotionPolicy::OnTheSpot
            },
            joints,
            matrices: self.matrices(),
            seed: self.seed,
            pose_cache: self.level == "auto",
            cache_bytes: self.cache_bytes,
            impostors: self.impostors.map(|bytes| ImpostorOptions {
                bound: ImpostorBound::Bytes(bytes),
                ..ImpostorOptions::default()
            }),
            mesh_levels: self.mesh_levels,
            ..CrowdOptions::default()
        })
    }

    /// Coarser meshes and impostors are chosen by their error, which only `--level auto` does.
    fn check_mesh_levels(&self) -> anyhow::Result<()> {
        if self.impostors.is_some() && self.level != "auto" {
            let what = format!("--impostors requires --level auto, not {}", self.level);
            return Err(fault::usage(what));
        }
        if self.mesh_levels.is_some_and(|n| n > 1) && self.level != "auto" {
            let what = format!("--mesh-levels requires --level auto, not {}", self.level);
            return Err(fault::usage(what));
        }
        Ok(())
    }

    /// Kind of palette matrices; a cache and written buffers require those of the skin.
    fn matrices(&self) -> PaletteMatrices {
        match self.level == "auto" || self.buffers.is_some() {
            true => PaletteMatrices::Skin,
            false => PaletteMatrices::Joints,
        }
    }

    fn scene_options(&self, detail: DetailGoal) -> SceneOptions {
        SceneOptions {
            detail,
            cache: match self.source {
                SourceName::Auto => CacheUse::Cpu,
                SourceName::Records => CacheUse::Gpu,
            },
            hiders: self.importance.hiders(),
        }
    }

    /// Records are of cached poses, which are chosen by their error.
    fn check_records(&self) -> anyhow::Result<()> {
        match self.source == SourceName::Records && self.level != "auto" {
            true => Err(fault::usage("--source records requires --level auto")),
            false => Ok(()),
        }
    }

    /// The scene file, unless the scene is a built-in one.
    fn scene_file(&self) -> anyhow::Result<Option<NamedScene>> {
        if self.plaza().is_some() {
            return Ok(None);
        }
        let path = Path::new(&self.scene);
        if path.extension().is_none() && !path.exists() {
            let known = "give plaza, plaza-2, plaza-2-in-step or a .json file";
            return Err(fault::usage(format!("--scene {}: {known}", self.scene)));
        }
        NamedScene::read(path).map(Some)
    }

    /// The built-in scene, if it is one.
    fn plaza(&self) -> Option<Plaza> {
        match self.scene.as_str() {
            "plaza" => Some(Plaza::Still),
            "plaza-2" => Some(Plaza::Moving),
            "plaza-2-in-step" => Some(Plaza::InPhase),
            _ => None,
        }
    }

    fn scene(&self, cast: &[CastAsset], file: Option<NamedScene>) -> anyhow::Result<Scene> {
        let mut scene = match file {
            Some(file) => self.scene_of(file, cast)?,
            None => {
                let count = self.count.unwrap_or(PLAZA_COUNT);
                let clips: Vec<usize> = cast.iter().map(|c| c.asset.clips().len()).collect();
                let scene = plaza(count, &clips, self.seed, self.plaza().unwrap_or_default());
                crowd_for_sizes(scene, cast.iter().map(|c| c.asset.full()))
            }
        };
        self.apply_views(&mut scene)?;
        self.importance.apply(&mut scene)?;
        Ok(scene)
    }

    /// Replaces the camera paths, and the pictures of all views.
    fn apply_views(&self, scene: &mut Scene) -> anyhow::Result<()> {
        if self.camera_path.len() > MAX_VIEWS {
            let count = self.camera_path.len();
            let what = format!("--camera-path: {count} views, at most {MAX_VIEWS}");
            return Err(fault::usage(what));
        }
        for (i, path) in self.camera_path.iter().enumerate() {
            let viewport = scene.views[i.min(scene.views.len() - 1)].viewport;
            let view = SceneView {
                viewport,
                camera: read_camera_path(path, DISPLAY_HZ)?,
                camera_loops: false,
            };
            match scene.views.get_mut(i) {
                Some(there) => *there = view,
                None => scene.views.push(view),
            }
        }
        for view in &mut scene.views {
            if let Some((width, height)) = self.viewport {
                view.viewport.width_px = width as f32;
                view.viewport.height_px = height as f32;
            }
            if let Some(fov_deg) = self.fov_deg {
                view.viewport.fov_y_radians = fov_deg.to_radians();
            }
        }
        Ok(())
    }

    fn scene_of(&self, file: NamedScene, cast: &[CastAsset]) -> anyhow::Result<Scene> {
        let nowhere = vec![None; cast.len()];
        let members = cast::members(cast, &nowhere);
        let scene = file.parsed.resolve(&members, DISPLAY_HZ);
        let mut scene = scene.with_context(|| files::shown(Path::new(&self.scene)))?;
        let there = scene.members.len();
        match self.count {
            Some(count) if count > there => Err(fault::usage(format!(
                "--count {count}: {} has {there} characters",
                files::shown(Path::new(&self.scene))
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

fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok();
    let number = number.filter(|n| (1..=MAX_THREADS).contains(n));
    number.ok_or_else(|| format!("expected a whole number of 1 to {MAX_THREADS}"))
}
