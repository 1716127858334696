//! Errors of crowds at a tolerance of one pixel, character by character: what the percentile leaves
//! to a hand or a face.

use super::Run;
use super::targets::{Target, section};
use anyhow::{Context, Result};
use articula::crowd::{
    CacheUse, CrowdAsset, CrowdOptions, DetailGoal, ErrorMeter, ErrorSummary, Hiders, SceneOptions,
    ScenePlayer,
};
use articula::inspect::inspect;
use articula::{CharacterFile, Executor, Figure};
use articula_build::{Plaza, plaza};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Tolerance of the 95th percentile over vertices, pixels.
const TOLERANCE_PX: f32 = 1.0;
/// Limit of the worst vertex relative to the tolerance (docs/metrics.md).
const WORST_VERTEX: f64 = 2.0;
const CHARACTERS: usize = 300;
const DISPLAY_HZ: usize = 60;
/// Three seconds.
const FRAMES: usize = 3 * DISPLAY_HZ;
/// Frames of a small run.
const HALF_A_SECOND: usize = DISPLAY_HZ / 2;
/// Frames between two measurements.
const LOOK_EVERY: usize = 9;
/// Warm-up frames in which levels settle.
const WARM_UP: usize = 30;
const SEED: u64 = 1;
/// Heights of figures that are taken as they are, metres; others are scaled.
const HEIGHTS: std::ops::RangeInclusive<f32> = 0.4..=3.2;
/// Height of a scaled figure, metres.
const SCALED_TO: f32 = 1.8;
/// The character of a small run.
const SMALL: &str = "Quaternius_single_knight_pack__KnightCharacter.glb";

/// Scales of the characters of a crowd of children and giants, in turns.
const SCALES: [f32; 2] = [0.5, 3.0];

/// Ways in which each crowd is played.
const PLAYS: [Play; 4] = [
    Play::new(CacheUse::Never, None),
    Play::new(CacheUse::Cpu, None),
    Play::new(CacheUse::Never, Some(SCALES)),
    Play::new(CacheUse::Cpu, Some(SCALES)),
];

#[derive(Debug, Clone, Copy)]
struct Play {
    cache: CacheUse,
    scales: Option<[f32; 2]>,
}

impl Play {
    const fn new(cache: CacheUse, scales: Option<[f32; 2]>) -> Self {
        Self { cache, scales }
    }
}

/// Result of one character.
struct Found {
    name: String,
    joints: usize,
    clips: usize,
    /// Height in the file, if the figure was scaled.
    scaled_from: Option<f32>,
    /// Matrices written per visible character, relative to the number of joints, in the first play.
    matrices: f64,
    /// Errors in each of [`PLAYS`].
    errors: [ErrorSummary; PLAYS.len()],
}

impl Found {
    /// Maximum over all plays.
    fn most(&self, of: impl Fn(&ErrorSummary) -> f64) -> f64 {
        self.errors.iter().map(of).fold(0.0, f64::max)
    }
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run) -> Result<()> {
    let (mut found, mut unread) = (Vec::new(), Vec::new());
    for path in files(&run.data.join("glb"))? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !run.small || name == SMALL {
            let opened = match articula::fs::open(&path) {
                Ok(opened) => opened,
                Err(why) => {
                    eprintln!("{why}");
                    unread.push(name.into_owned());
                    continue;
                }
            };
            let of = of(
                &path,
                opened,
                if run.small { HALF_A_SECOND } else { FRAMES },
            );
            found.extend(of.with_context(|| path.display().to_string())?);
        }
    }
    run.save("crowd-errors", &page(&found, &unread)?, &csv(&found)?)
}

/// GLB files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "glb") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Plays the crowd of a file; `None` without joints, skin or motion.
fn of(path: &Path, opened: CharacterFile, frames: usize) -> Result<Option<Found>> {
    let mut figure = Figure::new(opened)?;
    let clips = figure.asset.clips.len();
    if figure.asset.mesh.is_empty() || clips == 0 || figure.asset.rig.len() < 2 {
        return Ok(None);
    }
    let height = inspect(&figure, &[], &Executor::default())?.height_m;
    let height = height.context("no height")?;
    let scaled_from = (!HEIGHTS.contains(&height)).then_some(height);
    if scaled_from.is_some() {
        let mut opened = articula::fs::open(path)?;
        opened.edit_character(|character| character.scale_lengths(SCALED_TO / height));
        figure = Figure::new(opened)?;
    }
    let asset = CrowdAsset::new(&figure, &CrowdOptions::default(), &Executor::default())?;
    let joints = figure.asset.rig.len();
    let mut played = Vec::with_capacity(PLAYS.len());
    for play in PLAYS {
        played.push(played_as(&asset, play, frames)?);
    }
    let (matrices, errors): (Vec<f64>, Vec<ErrorSummary>) = played.into_iter().unzip();
    let (&[matrices, ..], Ok(errors)) = (&matrices[..], errors.try_into()) else {
        return Ok(None);
    };
    Ok(Some(Found {
        name: path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        joints,
        clips,
        scaled_from,
        matrices: matrices / joints as f64,
        errors,
    }))
}

/// Plays a crowd. Returns the matrices written per visible character, and the errors.
fn played_as(asset: &CrowdAsset, play: Play, frames: usize) -> Result<(f64, ErrorSummary)> {
    let scene = plaza(CHARACTERS, &[asset.clips().len()], SEED, Plaza::Still);
    let options = SceneOptions {
        detail: DetailGoal::Tolerance(TOLERANCE_PX),
        cache: play.cache,
        hiders: Hiders::Nothing,
    };
    let mut player = ScenePlayer::new(std::slice::from_ref(asset), scene, options)?;
    if let Some(scales) = play.scales {
        for character in 0..CHARACTERS {
            let scale = scales[character % scales.len()];
            player.crowds_mut()[0].set_scale(character, scale);
        }
    }
    let mut meter = ErrorMeter::new(asset, SEED);
    let mut samples = Vec::new();
    let (mut used, mut shown) = (0, 0);
    for frame in 0..WARM_UP + frames {
        let is_counted = frame >= WARM_UP;
        let step = if is_counted {
            1.0 / DISPLAY_HZ as f64
        } else {
            0.0
        };
        player.plan(step)?;
        player.crowds_mut()[0].evaluate();
        if is_counted && (frame - WARM_UP).is_multiple_of(LOOK_EVERY) {
            let error_views = player.error_views(0)?;
            samples.push(meter.measure(&player.crowds()[0], player.secs(), &error_views));
            for draw in player.crowds()[0].draws() {
                used += draw.matrices * draw.instances.len();
                shown += draw.instances.len();
            }
        }
    }
    let matrices = used as f64 / shown.max(1) as f64;
    Ok((matrices, ErrorSummary::of(&samples)))
}

fn page(all: &[Found], unread: &[String]) -> Result<String> {
    let mut page = HEAD.to_owned();
    let limit = WORST_VERTEX * f64::from(TOLERANCE_PX);
    let mut targets = Vec::new();
    for found in all {
        let of = |what, most, px| Target::at_most([found.name.as_str(), what], most, px);
        let (p95, worst) = (found.most(|e| e.p95), found.most(|e| e.worst_vertex));
        targets.extend([
            of("p95 over characters, px", f64::from(TOLERANCE_PX), p95),
            of("worst vertex, px", limit, worst),
        ]);
    }
    page.push_str(&section(TARGETS, &["character", "quantity"], &targets));
    page.push_str(TABLE);
    let px = |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{v:.2}"));
    for found in all {
        let [error, cached, scaled, scaled_cached] = &found.errors;
        let height = found
            .scaled_from
            .map_or(String::new(), |h| format!(" ({h:.3} m)"));
        writeln!(
            page,
            "| {}{height} | {} | {} | {:.0} % | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {} | {} | {} |",
            found.name,
            found.joints,
            found.clips,
            100.0 * found.matrices,
            error.p95,
            error.near_max,
            error.worst_vertex,
            cached.worst_vertex,
            scaled.worst_vertex,
            scaled_cached.worst_vertex,
            px(error.parts.hands),
            px(error.parts.face),
            px(error.parts.feet),
        )?;
    }
    if !unread.is_empty() {
        writeln!(page, "\nNot read: {}.", unread.join(", "))?;
    }
    Ok(page)
}

const HEAD: &str = "# Errors of crowds, by character

Made by `cargo run --release -p articula-lab -- crowd-errors`: every GLB file of the data with a skin and
a clip, as 300 characters on the plaza for three seconds, within 1 px: with poses of their own
(`CacheUse::Never`), and with cached poses, as by `articula crowd FILE --count 300`; then with every other
character at half of its size and the rest at three times it. The camera stands 1 m in front of the first
row, so it is inside of giants. Errors are pixels on a screen of 720 lines, against all joints, in the
picture.
";

const TARGETS: &str = "The tolerance applies to the 95th percentile over the vertices of a character; the
worst vertex of all, in all frames, is expected within twice the tolerance (docs/metrics.md). Each number is
the greatest of the four ways.";

const TABLE: &str = "
## Errors

*Matrices*: those written per visible character, one for each joint or binding of its level, relative to
the number of joints. *Near*: maximum over characters within 20 m
of their 95th percentile. *Cached*: the worst vertex with cached poses; *scaled*: of children and giants.
*Hands*, *face* and *feet*: the worst vertex of that part, with poses of their own at their size. In brackets
the height of a file whose unit is not the metre; it was scaled to 1.8 m.

| character | joints | clips | matrices | p95, px | near, px | worst vertex, px | cached | scaled | scaled, cached | hands | face | feet |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

fn csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from(
        "character,joints,clips,scaled_from_m,matrices,poses,scales,p95_px,max_px,near_max_px,worst_vertex_px,hands_px,face_px,feet_px\n",
    );
    let cell = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.4}"));
    for found in all {
        for (play, error) in PLAYS.iter().zip(&found.errors) {
            writeln!(
                csv,
                "{},{},{},{},{:.4},{},{},{:.4},{:.4},{:.4},{:.4},{},{},{}",
                found.name.replace(',', ";"),
                found.joints,
                found.clips,
                cell(found.scaled_from.map(f64::from)),
                found.matrices,
                match play.cache {
                    CacheUse::Never => "own",
                    _ => "cached",
                },
                play.scales
                    .map_or("1".to_owned(), |s| s.map(|s| s.to_string()).join(" ")),
                error.p95,
                error.max,
                error.near_max,
                error.worst_vertex,
                cell(error.parts.hands),
                cell(error.parts.face),
                cell(error.parts.feet),
            )?;
        }
    }
    Ok(csv)
}
