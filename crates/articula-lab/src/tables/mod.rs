//! The published tables, one module each.

pub(crate) mod adaptation;
pub(crate) mod crowd;
pub(crate) mod crowd_characters;
pub(crate) mod crowd_errors;
pub(crate) mod crowd_scene;
pub(crate) mod devices;
pub(crate) mod face_bridges;
pub(crate) mod face_levels;
pub(crate) mod face_mesh_levels;
pub(crate) mod face_points;
pub(crate) mod face_tables;
mod fap_clips;
pub(crate) mod flat;
pub(crate) mod impostors;
mod lids;
pub(crate) mod loa_cost;
pub(crate) mod made_shapes;
pub(crate) mod merged_levels;
pub(crate) mod mesh_levels;
pub(crate) mod motion_lod;
pub(crate) mod optimize;
mod paired_frames;
pub(crate) mod portrait_parameters;
pub(crate) mod portrait_times;
mod pose_keys;
mod random;
pub(crate) mod retargets;
pub(crate) mod round_trips;
mod seen;
mod served;
pub(crate) mod sessions;
pub(crate) mod slider;
pub(crate) mod speech;
pub(crate) mod streams;
mod targets;
pub(crate) mod thesis_grid;

use anyhow::{Context, Result};
use std::path::PathBuf;

/// Input and output folders of a table, and its size.
pub(crate) struct Run {
    /// Folder of the real characters.
    pub(crate) data: PathBuf,
    /// Folder of the results.
    pub(crate) out: PathBuf,
    /// Whether only a small part of the table is run.
    pub(crate) small: bool,
}

impl Run {
    /// Writes a page and its CSV file, and prints their paths.
    fn save(&self, name: &str, page: &str, csv: &str) -> Result<()> {
        self.save_text(name, "md", page)?;
        self.save_csv(name, csv)
    }

    /// Writes a further CSV file of a page.
    fn save_csv(&self, name: &str, csv: &str) -> Result<()> {
        self.save_text(name, "csv", csv)
    }

    fn save_text(&self, name: &str, extension: &str, text: &str) -> Result<()> {
        let folder = &self.out;
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let path = folder.join(name).with_extension(extension);
        std::fs::write(&path, text).with_context(|| path.display().to_string())?;
        println!("{}", path.display());
        Ok(())
    }
}

/// Distances of the thesis, and a fifth by the same factor, metres.
pub(crate) use articula::evaluate::DISTANCES_M;

/// More characters of the tables of motion level of detail: name, file, clips. A dance that moves
/// every finger, and a game character.
pub(crate) const MORE_CHARACTERS: [(&str, &str, &[&str]); 2] = [
    ("dancer", "glb/mh_female_dance.glb", &["dance"]),
    (
        "KayKit Knight",
        "glb/KayKit_Knight.glb",
        &["Walking_A", "Running_A", "1H_Melee_Attack_Chop"],
    ),
];

/// Clips of `pab_arnaud.glb` used for the published numbers.
pub(crate) const CLIPS: [&str; 4] = ["walk", "jog", "run", "atlas"];
