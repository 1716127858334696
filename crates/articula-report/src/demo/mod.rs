//! The demo: one character through all steps, as numbers, pictures, plots and a page.
//!
//! Every method over distance → costs → mesh levels → 2D → face → crowd → adaptation → page. All numbers
//! on the page are those of the report.

mod adaptation;
mod crowd;
mod face;
mod files;
mod flatten;
mod mesh_levels;
mod page;
mod pictures;
mod report;

pub use files::DemoFile;
pub use report::DemoReport;

use crate::clocks::nanoseconds;
use crate::method_lines::lines_by_method;
use crate::method_plots::{cost_plots, error_plot, gain_plot, updates_plot};
use articula::build::evaluate::{EvaluationSetup, MethodOptions};
use articula::build::moving_joints;
use articula::core::Complexity;
use articula::evaluate::{
    Costs, DISTANCES_M, EvaluatedClip, MethodTable, NamedMethod, ParameterChoice,
};
use articula::{CodedMeshLevels, Error, Executor, Figure, Result};
use files::DemoFiles;
use mesh_levels::MeshLevels;
use report::{Character, ClipRows, Level, MIDDLE, MethodRows};

/// Error to which every method is calibrated, pixels.
const TARGET_PX: f32 = 1.0;
/// The clip that all methods play, where the character has it; else its first.
const CLIP: &str = "walk";

/// Result of the demo.
#[derive(Debug)]
pub struct Demo {
    /// The numbers.
    pub report: DemoReport,
    /// Pictures, plots and other files to which the page refers, besides `asset.glb`.
    pub files: Vec<DemoFile>,
}

impl Demo {
    /// Runs all steps on a character with a clip, and the mesh levels with which its asset was prepared;
    /// `mesh_bytes` is the size of the meshes in the asset. `name` is what reports call the character,
    /// and `page` the path of the page.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a character without a clip or a mesh, and those of the steps.
    pub fn new(
        figure: &Figure,
        (mesh_levels, mesh_bytes): (&CodedMeshLevels, usize),
        name: String,
        page: String,
        work: &Executor<'_>,
    ) -> Result<Self> {
        let mut files = DemoFiles::default();
        let asset = &figure.asset;
        let scene = scene_of(figure, clip_of(figure)?);
        let clip = &asset.clips[scene.clip];
        let chosen = NamedMethod::all(&asset.rig);
        let tuning = ParameterChoice::Calibrated(TARGET_PX);
        let tables = scene.tables(&chosen, &DISTANCES_M, tuning, work)?;
        let clips = over_clips(figure, &chosen[..1], work)?;
        let costs = Costs::new(&scene.stage(), &nanoseconds);
        draw(&mut files, &scene, &tables)?;
        plot(&mut files, &scene, &tables, &costs);
        let levels = MeshLevels::new(mesh_levels, mesh_bytes);
        mesh_levels::draw(&mut files, &scene, &levels)?;
        let flat = flatten::of(&mut files, &scene, work)?;
        let face = face::of(&mut files, figure, work)?;
        let crowd = crowd::of(figure, TARGET_PX, &mut files, work)?;
        let adaptation = adaptation::of(&mut files, &scene, work)?;
        let report = DemoReport {
            version: env!("CARGO_PKG_VERSION"),
            page,
            character: Character::new(name, figure),
            clip: clip.name.clone(),
            target_px: TARGET_PX,
            joints_moving: moving_joints(asset, clip).len(),
            frames: clip.frames(),
            methods: tables.iter().map(MethodRows::new).collect(),
            clips,
            levels: levels_of(figure),
            costs,
            crowd,
            mesh_levels: levels,
            flat,
            face,
            adaptation,
        };
        let files = files.0;
        Ok(Self { report, files })
    }

    /// Returns the page as HTML, which refers to `report.json` and the files.
    pub fn page(&self) -> String {
        page::of(&self.report)
    }
}

/// Index of the clip to play: `walk`, or the first.
fn clip_of(figure: &Figure) -> Result<usize> {
    let clips = &figure.asset.clips;
    if clips.is_empty() {
        let what = "the asset has no clip";
        return Err(Error::Unsupported(what.to_owned()));
    }
    Ok(clips.iter().position(|c| c.name == CLIP).unwrap_or(0))
}

fn scene_of(figure: &Figure, clip: usize) -> EvaluatedClip<'_> {
    EvaluatedClip {
        figure,
        clip,
        setup: EvaluationSetup::default(),
        options: MethodOptions::default(),
    }
}

/// Methods on every clip of the character.
fn over_clips(
    figure: &Figure,
    methods: &[NamedMethod],
    work: &Executor<'_>,
) -> Result<Vec<ClipRows>> {
    let clips = figure.asset.clips.iter().enumerate();
    let rows = clips.map(|(index, clip)| {
        let scene = scene_of(figure, index);
        let tuning = ParameterChoice::Calibrated(TARGET_PX);
        let tables = scene.tables(methods, &DISTANCES_M, tuning, work)?;
        Ok(ClipRows {
            clip: clip.name.clone(),
            rows: tables.into_iter().flat_map(|t| t.rows).collect(),
        })
    });
    rows.collect()
}

/// The stored animation at each level of articulation.
fn levels_of(figure: &Figure) -> Vec<Level> {
    let rig = &figure.asset.rig;
    let clips = &figure.opened.character().clips;
    let levels = Complexity::ALL.into_iter().rev();
    levels.map(|level| Level::new(level, rig, clips)).collect()
}

fn draw(files: &mut DemoFiles, scene: &EvaluatedClip<'_>, tables: &[MethodTable]) -> Result<()> {
    for (name, picture) in [
        ("character.png", pictures::character as pictures::Draw),
        ("distances.png", pictures::distances),
        ("methods.png", pictures::methods),
        ("levels.png", pictures::levels),
    ] {
        files.add_png(name, &picture(scene, tables)?)?;
    }
    Ok(())
}

fn plot(files: &mut DemoFiles, scene: &EvaluatedClip<'_>, tables: &[MethodTable], costs: &Costs) {
    let clip = &scene.figure.asset.clips[scene.clip].name;
    let heading = format!("clip {clip}, calibrated to {TARGET_PX} px");
    let over_the_clip = lines_by_method(tables, MIDDLE);
    let at = format!("clip {clip}, {} m", DISTANCES_M[MIDDLE]);
    let plots = [
        gain_plot(tables, &heading),
        error_plot(tables, &heading, Some(TARGET_PX)),
        updates_plot(&scene.stage(), &over_the_clip, &at),
    ];
    let costs = cost_plots(costs, &format!("clip {clip}"));
    for plot in plots.into_iter().chain(costs) {
        files.add(plot.name, plot.svg);
    }
}
