//! Error of merged levels by joints kept, also on clips not used for the joint order.
//!
//! Source: `docs/methods/motion-lod.md` part 8, `docs/methods/runtime.md` 4.1.

mod sheet;

use super::Run;
use super::targets::{self, Target};
use crate::data;
use anyhow::{Context, Result};
use articula_build::Asset;
use articula_build::{
    JointLodOptions, far_levels, far_order, joint_lods, levels_of, mean_pose, merged_levels,
    named_joint_lods,
};
use articula_core::loa::LoaExpression;
use articula_core::{JointLods, LodErrors};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Characters of the table; a small run has only the first.
const CHARACTERS: [&str; 7] = [
    "pab_arnaud",
    "KayKit_Knight",
    "Quaternius_cyberpunk_pack__Character",
    "RobotExpressive",
    "mannequiny",
    "mh_female_dance",
    "CesiumMan",
];

/// Clips of the character of a small run.
const FEW_CLIPS: usize = 3;

/// Numbers of joints kept, as far as a character has more.
const COUNTS: [u16; 7] = [96, 64, 48, 32, 24, 16, 10];

/// Joints kept and errors in millimetres of an independent prototype on the first character
/// (`docs/methods/motion-lod.md`, part 8).
const PROTOTYPE_MM: [(usize, f64); 3] = [(48, 0.8), (24, 73.0), (16, 86.0)];

const TARGETS: &str = "Of docs/methods/motion-lod.md, part 8, for near and far levels alike: errors not larger
than those of an independent prototype with 48, 24 and 16 joints of `pab_arnaud`, learned levels not worse
than named ones of the same size, and the rules for default levels.";

/// Levels of articulation that a user would name.
const NAMED: [&str; 4] = ["loa(High)", "loa(Medium)", "loa(Low)", "loa(VeryLow)"];

/// Maximum number of parts into which the clips are divided for holding out.
const MAX_PARTS: usize = 8;

/// Pictures in addition to the table.
#[derive(clap::Args, Default)]
pub(crate) struct Sheets {
    /// Folder for a sheet of each character: full, and at each level.
    #[arg(long)]
    sheets: Option<PathBuf>,
}

/// Errors with a number of joints kept, millimetres.
struct Row {
    character: &'static str,
    kind: &'static str,
    kept: usize,
    influences: usize,
    /// 95th percentile over vertices, maximum over frames and clips.
    error_mm: f32,
    /// Maximum over vertices, frames and clips.
    worst_mm: f32,
    /// As `error_mm`, with order and mean pose computed without the measured clip.
    held_out_mm: Option<f32>,
}

/// Runs the table and writes it, and the pictures that are asked for.
pub(crate) fn write(run: &Run, sheets: &Sheets) -> Result<()> {
    let shown = if run.small { 1 } else { CHARACTERS.len() };
    let mut rows = Vec::new();
    let mut chosen = String::new();
    let mut defaults = Vec::new();
    for name in &CHARACTERS[..shown] {
        let mut asset = data::asset(&run.data, &format!("glb/{name}.glb"))?;
        if run.small {
            asset.clips.truncate(FEW_CLIPS);
        }
        let named = match *name == CHARACTERS[0] {
            true => named_rows(name, &asset)?,
            false => Vec::new(),
        };
        let counts = counts(&asset, &named);
        rows.extend(near_rows(name, &asset, &counts)?);
        rows.extend(far_rows(name, &asset, &counts)?);
        rows.extend(named);
        let (line, kept) = default_levels(name, &asset)?;
        writeln!(chosen, "{line}")?;
        defaults.extend(default_targets(name, &kept));
        if let Some(folder) = &sheets.sheets {
            std::fs::create_dir_all(folder)?;
            sheet::write(
                &run.data,
                name,
                &asset,
                &folder.join(name).with_extension("png"),
            )?;
        }
    }
    let mut targets = row_targets(&rows);
    targets.extend(defaults);
    run.save(
        "merged-levels",
        &page(&rows, &chosen, &targets)?,
        &csv(&rows)?,
    )
}

/// The number of all joints, then the smaller counts, those of named levels among them.
fn counts(asset: &Asset, named: &[Row]) -> Vec<u16> {
    let all = asset.rig.len() as u16;
    let named = named.iter().map(|row| row.kept as u16);
    let fewer = COUNTS.into_iter().chain(named);
    let mut counts: Vec<u16> = fewer.filter(|n| *n < all).chain([all]).collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    counts.dedup();
    counts
}

/// The errors of the prototype on the first character, and named levels beside learned ones of the
/// same size.
fn row_targets(rows: &[Row]) -> Vec<Target> {
    let mut targets = Vec::new();
    let learned = |row: &&Row| row.character == CHARACTERS[0] && row.kind != "named";
    for row in rows.iter().filter(learned) {
        let what = format!("{} {} joints: error, mm", row.kind, row.kept);
        let found = f64::from(row.error_mm);
        if let Some((_, most)) = PROTOTYPE_MM.iter().find(|(kept, _)| *kept == row.kept) {
            targets.push(Target::at_most([row.character, &what], *most, found));
        }
        let named = rows
            .iter()
            .find(|n| n.kind == "named" && n.kept == row.kept);
        if let Some(named) = named {
            let what = format!("{what} / that of the named level");
            let ratio = found / f64::from(named.error_mm);
            targets.push(Target::at_most([row.character, &what], 1.0, ratio));
        }
    }
    targets
}

/// The rules of docs/methods/motion-lod.md, part 8, on the levels that are chosen by default; `kept`
/// are the joints of the near and of the far levels.
fn default_targets(character: &str, kept: &[Vec<usize>; 2]) -> Vec<Target> {
    let all = || kept.iter().flatten();
    let drop = |pair: &[usize]| 100.0 * (1.0 - pair[1] as f64 / pair[0] as f64);
    let drops = kept.iter().flat_map(|levels| levels.windows(2)).map(drop);
    let least = drops.fold(f64::INFINITY, f64::min);
    let fewest = all().copied().min().unwrap_or(0) as f64;
    let count = all().count() as f64;
    let mut targets = vec![
        Target::at_least([character, "default levels: fewest joints"], 8.0, fewest),
        Target::at_most([character, "default levels: number"], 8.0, count),
    ];
    if least.is_finite() {
        let what = "default levels: least drop of joints within near or far, %";
        targets.push(Target::at_least([character, what], 12.0, least));
    }
    targets
}

fn near_rows(character: &'static str, asset: &Asset, counts: &[u16]) -> Result<Vec<Row>> {
    let opts = JointLodOptions::default();
    let judged = |learned: &Asset, judged: &Asset| {
        let mean = mean_pose(learned);
        let order = joint_lods(learned, &mean, &opts)?;
        let joint_lods =
            JointLods::new(&asset.rig, order.joints().to_vec(), counts.to_vec(), &mean)?;
        levels_of(judged, joint_lods, &opts)
    };
    let all = judged(asset, asset)?;
    let mut held = vec![0.0f32; counts.len()];
    let parts = parts(asset);
    for (rest, part) in &parts {
        let levels = judged(rest, part)?;
        for (l, held) in held.iter_mut().enumerate() {
            *held = held.max(worst(&levels.errors, l).0);
        }
    }
    let row = |l: usize| {
        let (error_mm, worst_mm) = worst(&all.errors, l);
        Row {
            character,
            kind: "near",
            kept: usize::from(counts[l]),
            influences: all.skins.levels[l].influences,
            error_mm,
            worst_mm,
            held_out_mm: (!parts.is_empty()).then_some(held[l]),
        }
    };
    Ok((1..counts.len()).map(row).collect())
}

fn far_rows(character: &'static str, asset: &Asset, counts: &[u16]) -> Result<Vec<Row>> {
    let opts = JointLodOptions::default();
    let counts = &counts[1..];
    let judged = |learned: &Asset, judged: &Asset| {
        let mean = mean_pose(learned);
        let order = far_order(learned, &mean, &opts)?;
        far_levels(judged, &order, counts, &mean, &opts)
    };
    let Some((levels, errors)) = judged(asset, asset)? else {
        return Ok(Vec::new());
    };
    let mut held = vec![0.0f32; counts.len()];
    let parts = parts(asset);
    for (rest, part) in &parts {
        let (_, errors) = judged(rest, part)?.context("a chain of the clips shears")?;
        for (l, held) in held.iter_mut().enumerate() {
            *held = held.max(worst(&errors, l + 1).0);
        }
    }
    let row = |l: usize| {
        let (error_mm, worst_mm) = worst(&errors, l + 1);
        Row {
            character,
            kind: "far",
            kept: usize::from(counts[l]),
            influences: levels.skins.levels[l].influences,
            error_mm,
            worst_mm,
            held_out_mm: (!parts.is_empty()).then_some(held[l]),
        }
    };
    Ok((0..counts.len()).map(row).collect())
}

fn named_rows(character: &'static str, asset: &Asset) -> Result<Vec<Row>> {
    let expressions: Result<Vec<LoaExpression>, _> = NAMED
        .iter()
        .map(|text| text.parse::<LoaExpression>())
        .collect();
    let joint_lods = named_joint_lods(asset, &mean_pose(asset), &expressions?)?;
    let levels = levels_of(asset, joint_lods, &JointLodOptions::default())?;
    let row = |l: usize| {
        let (error_mm, worst_mm) = worst(&levels.errors, l);
        Row {
            character,
            kind: "named",
            kept: levels.joint_lods.joint_count(l),
            influences: levels.skins.levels[l].influences,
            error_mm,
            worst_mm,
            held_out_mm: None,
        }
    };
    Ok((1..levels.joint_lods.levels()).map(row).collect())
}

/// Pairs of the character without some clips and with only those, for each part of the clips.
fn parts(asset: &Asset) -> Vec<(Asset, Asset)> {
    let clips = asset.clips.len();
    if clips < 2 {
        return Vec::new();
    }
    let count = clips.min(MAX_PARTS);
    let with = |keep: &dyn Fn(usize) -> bool| Asset {
        clips: (0..clips)
            .filter(|c| keep(*c))
            .map(|c| asset.clips[c].clone())
            .collect(),
        ..asset.clone()
    };
    (0..count)
        .map(|p| (with(&|c| c % count != p), with(&|c| c % count == p)))
        .collect()
}

/// Maximum errors of a level over clips, millimetres.
fn worst(errors: &LodErrors, level: usize) -> (f32, f32) {
    let greatest = |of: &dyn Fn(usize) -> f32| {
        let all = (0..errors.clips.len()).map(of);
        1e3 * all.fold(0.0, f32::max)
    };
    (
        greatest(&|c| errors.clips[c].levels_metres[level]),
        greatest(&|c| errors.clips[c].worst_metres[level]),
    )
}

/// A line about the levels that are chosen by default, and the joints that the near and the far ones
/// keep.
fn default_levels(name: &str, asset: &Asset) -> Result<(String, [Vec<usize>; 2])> {
    let opts = JointLodOptions {
        far_from_metres: 4e-3,
        ..JointLodOptions::default()
    };
    let levels = merged_levels(asset, &opts)?;
    let near = levels.joint_lods.levels();
    let at = |l: usize, kept: usize| format!("{kept} ({:.1})", worst(&levels.errors, l).0);
    let kept = |of: &JointLods| (0..of.levels()).map(|l| of.joint_count(l)).collect();
    let near_kept: Vec<usize> = kept(&levels.joint_lods);
    let mut far_kept: Vec<usize> = Vec::new();
    let mut all: Vec<String> = (0..near).map(|l| at(l, near_kept[l])).collect();
    if let Some(far) = &levels.far {
        all.push("far:".into());
        far_kept = kept(&far.joint_lods);
        let far = far_kept.iter().enumerate();
        all.extend(far.map(|(l, joints)| at(near + l, *joints)));
    }
    let line = format!("| {name} | {} |", all.join(" "));
    Ok((line, [near_kept, far_kept]))
}

fn page(rows: &[Row], chosen: &str, targets: &[Target]) -> Result<String> {
    let mut page = String::from(
        "# Merged levels

Made by `cargo run --release -p articula-lab -- merged-levels`. Distance in millimetres
between the full character and one with the other joints merged: the 95th percentile over 700 vertices,
the maximum over the frames of a clip and over the clips; *worst*: the maximum over all measured
vertices. *Near* levels keep the ancestors of every kept joint; *far* levels may drop any joint and have
a separate rig. *Held out*: joint order and mean pose were computed without the measured clips (one clip
at a time, an eighth of them where there are more than eight). *Named*: levels of articulation from the
name map, with the ancestors of their joints.
",
    );
    page.push_str(&targets::section(
        TARGETS,
        &["character", "quantity"],
        targets,
    ));
    page.push_str(
        "
## Every level

| character | levels | joints | influences | error | worst | held out |
| --- | --- | --- | --- | --- | --- | --- |
",
    );
    for row in rows {
        let held = row.held_out_mm.map_or("–".into(), |mm| format!("{mm:.1}"));
        writeln!(
            page,
            "| {} | {} | {} | {} | {:.1} | {:.0} | {held} |",
            row.character, row.kind, row.kept, row.influences, row.error_mm, row.worst_mm
        )?;
    }
    write!(
        page,
        "
## Levels by default

The levels that are chosen automatically, far ones from 4 mm on: joints kept, and in brackets the
error in millimetres.

| character | levels |
| --- | --- |
{chosen}"
    )?;
    Ok(page)
}

fn csv(rows: &[Row]) -> Result<String> {
    let mut csv =
        String::from("character,levels,joints,influences,error_mm,worst_mm,held_out_mm\n");
    for row in rows {
        let held = row
            .held_out_mm
            .map_or(String::new(), |mm| format!("{mm:.3}"));
        writeln!(
            csv,
            "{},{},{},{},{:.3},{:.3},{held}",
            row.character, row.kind, row.kept, row.influences, row.error_mm, row.worst_mm
        )?;
    }
    Ok(csv)
}
