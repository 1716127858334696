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
use contest::Contest;

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
    let shown = |e: &&Entry| match &choice.only {
        Some(only) => e.name.contains(only.as_str()),
        None => !run.small || e.name == SMALL,
    };
    let characters = CHARACTERS.iter().map(|entry| (entry, None));
    let libraries = LIBRARIES.iter().map(|(entry, skin)| (entry, Some(*skin)));
    let mut all = Vec::new();
    for (entry, skin) in characters
        .chain(libraries)
        .filter(|(entry, _)| shown(entry))
    {
        let path = run.data.join(entry.file);
        let skin = skin.map(|skin| run.data.join(skin));
        let contest = Contest::run(entry.name, &path, skin, has_peers);
        all.push(contest.with_context(|| entry.name)?);
    }
    run.save("optimize", &page::page(&all)?, &page::csv(&all)?)
}
