//! Ways to show a far character at the same projected error: levels on the character's own rig, far
//! levels on a rig of their own, and impostors.
//!
//! Source: `docs/methods/impostors.md`.

mod far;
mod impostor;
mod page;
mod played;
mod sheet;

use super::Run;
use anyhow::{Context, Result};
use articula::crowd::{CacheUse, CrowdAsset, CrowdOptions};
use articula::inspect::inspect;
use articula::{Executor, Figure};
use std::path::PathBuf;

/// File, and meshes left out: of a pack's character with all its weapons in the file, those that it
/// does not hold.
const CHARACTERS: [(&str, &[&str]); 4] = [
    (
        "KayKit_Knight",
        &[
            "1H_Sword_Offhand",
            "2H_Sword",
            "Badge_Shield",
            "Rectangle_Shield",
            "Spike_Shield",
        ],
    ),
    ("Quaternius_single_knight_pack__KnightCharacter", &[]),
    ("Quaternius_cyberpunk_pack__Character", &[]),
    ("pab_arnaud", &[]),
];

/// Clips of a crowd, by the names in the files; those that a character does not have are left out. All
/// clips if it has none of them.
const CLIPS: [&str; 12] = [
    "Walking_A",
    "Running_A",
    "Idle",
    "Walk",
    "Run",
    "Wave",
    "walk",
    "jog",
    "run",
    "Cheer",
    "HumanArmature|Man_Walk",
    "HumanArmature|Man_Idle",
];

/// Heights on the screen, pixels; the tolerance is one pixel.
pub(super) const HEIGHTS_PX: [f32; 4] = [40.0, 20.0, 10.0, 5.0];

/// Pictures in addition to the table.
#[derive(clap::Args, Default)]
pub(crate) struct Sheet {
    /// Folder for a sheet of each character.
    #[arg(long)]
    sheets: Option<PathBuf>,
}

/// One way to show a character at one height.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub(super) character: String,
    pub(super) height_px: f32,
    pub(super) way: &'static str,
    /// Error in pixels at this height, the maximum over clips.
    pub(super) error_px: f32,
    pub(super) joints: usize,
    /// Nanoseconds of a frame for each character.
    pub(super) ns: f64,
    /// Bytes written for each character in a frame.
    pub(super) bytes: f64,
    /// Bytes that all characters share: cached palettes, pixels.
    pub(super) resident: usize,
    pub(super) vertices: f64,
    pub(super) triangles: f64,
}

/// A character with what its rows need.
pub(super) struct Subject {
    pub(super) name: String,
    pub(super) figure: Figure,
    /// Clips in place, levels with their meshes, cached poses.
    pub(super) crowd: CrowdAsset,
    /// Height at rest, metres.
    pub(super) height_m: f32,
}

impl Subject {
    fn open(run: &Run, name: &str, hidden: &[&str]) -> Result<Self> {
        let mut opened = articula::fs::open(run.data.join(format!("glb/{name}.glb")))?;
        let meshes = opened.character().meshes.iter().map(|m| m.name.clone());
        let hidden: Vec<String> = meshes.filter(|m| hidden.contains(&m.as_str())).collect();
        if !hidden.is_empty() {
            opened.keep_meshes(&[], &hidden)?;
            opened.detach_document();
        }
        let known = |name: &str| CLIPS.contains(&name);
        let clips = opened.character().clips.iter().enumerate();
        let kept = clips.filter(|(_, c)| known(&c.name)).map(|(i, _)| i);
        let kept: Vec<usize> = kept.collect();
        if !kept.is_empty() {
            opened.select_clips(&kept);
        }
        let figure = Figure::new(opened)?;
        let options = CrowdOptions {
            mesh_levels: Some(5),
            pose_cache: true,
            ..CrowdOptions::default()
        };
        let crowd = CrowdAsset::new(&figure, &options, &Executor::default())?;
        let height_m = inspect(&figure, &[], &Executor::default())?.height_m;
        Ok(Self {
            name: name.to_owned(),
            figure,
            crowd,
            height_m: height_m.context("no height")?,
        })
    }
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run, sheets: &Sheet) -> Result<()> {
    let characters = if run.small {
        &CHARACTERS[1..2]
    } else {
        &CHARACTERS[..]
    };
    let (mut rows, mut trials) = (Vec::new(), Vec::new());
    for (name, hidden) in characters {
        let subject = Subject::open(run, name, hidden).with_context(|| (*name).to_owned())?;
        let far = far::FarSubject::new(&subject)?;
        let mut tiles = Vec::new();
        for height_px in HEIGHTS_PX {
            let tolerance_m = subject.height_m / height_px;
            let near = |cache| played::played(&subject.crowd, tolerance_m, cache);
            let evaluated = near(CacheUse::Never)?;
            rows.push(evaluated.row(&subject, height_px, "near, evaluated"));
            let cached = near(CacheUse::Cpu)?;
            rows.push(cached.row(&subject, height_px, "near, cached"));
            let shown_far = far.level(tolerance_m);
            if let Some(level) = &shown_far {
                for (cache, way) in [
                    (CacheUse::Never, "far, evaluated"),
                    (CacheUse::Cpu, "far, cached"),
                ] {
                    let slack = tolerance_m - level.error_m;
                    let played = played::played(&level.crowd, slack, cache)?;
                    rows.push(level.row(&played, &subject, height_px, way));
                }
            }
            let level = impostor::Baked::within(&subject, tolerance_m, impostor::LEVEL_DEG)?;
            let all = impostor::Baked::within(&subject, tolerance_m, impostor::ALL_DEG)?;
            for (baked, way) in [
                (&level, "impostor, level eyes"),
                (&all, "impostor, all eyes"),
            ] {
                let row = |b: &impostor::Baked| b.row(&subject, height_px, way, cached.ns);
                rows.extend(baked.as_ref().map(row));
            }
            let baked = level;
            if sheets.sheets.is_some() {
                let shown = (cached.coarsest, shown_far.as_ref(), baked.as_ref());
                tiles.push(sheet::tiles(&subject, height_px, shown)?);
            }
        }
        trials.extend(impostor::trials(&subject)?);
        if let Some(folder) = &sheets.sheets {
            std::fs::create_dir_all(folder)?;
            sheet::write(name, tiles, &folder.join(name).with_extension("png"))?;
        }
    }
    run.save(
        "impostors",
        &page::page(&rows, &trials)?,
        &page::csv(&rows)?,
    )
}
