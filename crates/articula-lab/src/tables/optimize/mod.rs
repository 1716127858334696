//! Lighter files: bytes at equal error in motion, beside other optimisers.
//!
//! Source: `docs/methods/optimize.md`.
//!
//! - `contest`: the files of one character, and the fair ones among those of the peers
//! - `page`: the page and its CSV file

mod contest;
mod page;

use super::Run;
use crate::peers::optimisers::{self, MISSING};
use anyhow::{Context, Result};
use contest::{Contest, Kind};
use std::path::Path;

/// A character of the table.
struct Entry {
    name: &'static str,
    file: &'static str,
}

const fn entry(name: &'static str, file: &'static str) -> Entry {
    Entry { name, file }
}

/// Game characters, captured motion, faces, and an animal.
const CHARACTERS: [Entry; 16] = [
    entry("KayKit Knight", "glb/KayKit_Knight.glb"),
    entry("KayKit Mage", "glb/KayKit_Mage.glb"),
    entry("RobotExpressive", "glb/RobotExpressive.glb"),
    entry(
        "Quaternius fighter",
        "glb/Quaternius_cyberpunk_pack__Character.glb",
    ),
    entry(
        "Quaternius knight",
        "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
    ),
    entry(
        "Quaternius figure",
        "glb/Quaternius_platformer_game_pack__Character.glb",
    ),
    entry("mannequiny", "glb/mannequiny.glb"),
    entry("pab", "glb/pab_arnaud.glb"),
    entry("dancer, 52 morphs", "glb/mh_female_dance.glb"),
    entry(
        "woman, 52 morphs, still",
        "glb/mh_female_default163_arkit52.glb",
    ),
    entry("man, still", "glb/mh_male_cmu31.glb"),
    entry("CesiumMan", "glb/CesiumMan.glb"),
    entry("Fox", "glb/Fox.glb"),
    entry("Godette (VRM)", "vrm/Godette_vrm_v4.vrm"),
    entry("head, 17 morphs", "glb/ict_head_talk_1095.glb"),
    entry("face, 57 morphs", "face/ict_facekit_expressions.glb"),
];

/// Libraries of clips without meshes, and the characters that play them.
const LIBRARIES: [(Entry, &str); 9] = [
    (
        entry(
            "KayKit melee, 22 clips",
            "glb/kaykit_mannequin/Med_CombatMelee.glb",
        ),
        KAYKIT,
    ),
    (
        entry(
            "KayKit ranged, 20 clips",
            "glb/kaykit_mannequin/Med_CombatRanged.glb",
        ),
        KAYKIT,
    ),
    (
        entry(
            "KayKit general, 15 clips",
            "glb/kaykit_mannequin/Med_General.glb",
        ),
        KAYKIT,
    ),
    (
        entry(
            "KayKit movement, 13 clips",
            "glb/kaykit_mannequin/Med_MovementAdvanced.glb",
        ),
        KAYKIT,
    ),
    (
        entry(
            "KayKit walking, 11 clips",
            "glb/kaykit_mannequin/Med_MovementBasic.glb",
        ),
        KAYKIT,
    ),
    (
        entry(
            "KayKit work, 14 clips",
            "glb/kaykit_mannequin/Med_Simulation.glb",
        ),
        KAYKIT,
    ),
    (
        entry(
            "KayKit special, 15 clips",
            "glb/kaykit_mannequin/Med_Special.glb",
        ),
        KAYKIT,
    ),
    (
        entry("viverse walk, 1 clip", "glb/viverse/walk.glb"),
        VIVERSE,
    ),
    (entry("viverse run, 1 clip", "glb/viverse/run.glb"), VIVERSE),
];
const KAYKIT: &str = "glb/kaykit_mannequin/manny_med_mod.gltf";
const VIVERSE: &str = "glb/viverse/mannequin.glb";

/// Characters with triangles to spare, and the parts of their triangles that peers are asked for.
const WITH_FEWER: [&str; 9] = [
    "Quaternius figure",
    "mannequiny",
    "pab",
    "dancer, 52 morphs",
    "man, still",
    "CesiumMan",
    "Fox",
    "Godette (VRM)",
    "head, 17 morphs",
];
const PARTS: [&str; 2] = ["0.7", "0.35"];

/// The character of a small run, which is without peers.
const SMALL: &str = "head, 17 morphs";

/// The part of the table to run.
#[derive(clap::Args, Default)]
pub(crate) struct Choice {
    /// Run only characters and libraries whose names contain this text.
    #[arg(long)]
    only: Option<String>,
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    let has_peers = !run.small && optimisers::are_there()?;
    if !has_peers && !run.small {
        println!("skipped: {MISSING}");
    }
    let is_shown = |name: &str| match &choice.only {
        Some(only) => name.contains(only.as_str()),
        None => !run.small || name == SMALL,
    };
    let mut all = Vec::new();
    for (entry, kind) in everything(&run.data) {
        if is_shown(entry.name) && (has_peers || !matches!(kind, Kind::Fewer(_))) {
            let contest = Contest::run(entry.name, &run.data.join(entry.file), kind, has_peers);
            all.push(contest.with_context(|| entry.name)?);
        }
    }
    run.save("optimize", &page::page(&all)?, &page::csv(&all)?)
}

/// All rows of the page.
fn everything(data: &Path) -> Vec<(&'static Entry, Kind)> {
    let whole = CHARACTERS.iter().map(|entry| (entry, Kind::Whole));
    let clips = LIBRARIES
        .iter()
        .map(|(entry, skin)| (entry, Kind::Clips(data.join(skin))));
    let has_fewer = |entry: &&Entry| WITH_FEWER.contains(&entry.name);
    let fewer = CHARACTERS.iter().filter(has_fewer);
    let fewer = fewer.flat_map(|entry| PARTS.map(|part| (entry, Kind::Fewer(part))));
    whole.chain(clips).chain(fewer).collect()
}
