//! The characters that are simplified.

use crate::subdivide::subdivide;
use anyhow::Result;
use articula::Figure;
use articula_build::Asset;
use articula_core::source::Character;
use glam::Vec3;
use std::path::Path;

/// A character of the table.
pub(super) struct Entry {
    pub(super) name: &'static str,
    file: &'static str,
    /// Whether it is subdivided once before simplification.
    subdivided: bool,
    /// Nominal height, metres.
    height_metres: f32,
}

/// Height of a figure.
const BODY_METRES: f32 = 1.8;
/// Height of a head.
const HEAD_METRES: f32 = 0.25;

const fn entry(name: &'static str, file: &'static str) -> Entry {
    Entry {
        name,
        file,
        subdivided: false,
        height_metres: BODY_METRES,
    }
}

const fn head(name: &'static str, file: &'static str) -> Entry {
    Entry {
        height_metres: HEAD_METRES,
        ..entry(name, file)
    }
}

/// The characters; a small run takes [`SMALL`].
pub(super) const CHARACTERS: [Entry; 12] = [
    entry("pab_arnaud", "glb/pab_arnaud.glb"),
    entry("MakeHuman, 31 joints", "glb/mh_male_cmu31.glb"),
    entry("MakeHuman", "glb/mh_female_dance.glb"),
    Entry {
        subdivided: true,
        ..entry("MakeHuman 107k", "glb/mh_female_dance.glb")
    },
    entry("mannequiny", "glb/mannequiny.glb"),
    entry("KayKit Knight", "glb/KayKit_Knight.glb"),
    entry(
        "Quaternius fighter",
        "glb/Quaternius_cyberpunk_pack__Character.glb",
    ),
    entry("Quaternius suit", "glb/Quaternius_modular_men__Suit.glb"),
    entry(
        "Quaternius casual",
        "glb/Quaternius_modular_men__Casual2.glb",
    ),
    entry("RobotExpressive", "glb/RobotExpressive.glb"),
    head("ICT head", "glb/ict_head_talk_1095.glb"),
    head("ICT face 52k", "face/ict_facekit_expressions.glb"),
];

/// The character of a small run.
pub(super) const SMALL: &str = "pab_arnaud";

/// The character in the picture of the page (by Quaternius, CC0).
pub(super) const PICTURED: &str = "Quaternius suit";

/// A character as read from the file, and as an asset.
pub(super) struct Subject {
    pub(super) name: &'static str,
    pub(super) source: Character,
    pub(super) asset: Asset,
    /// Nominal height, metres.
    pub(super) told_height_metres: f32,
}

impl Subject {
    /// Height in a pose, metres.
    pub(super) fn height_metres(&self, pose: &[Vec3]) -> f32 {
        let ys = || {
            self.asset
                .mesh
                .triangles
                .iter()
                .flatten()
                .map(|v| pose[*v as usize].y)
        };
        ys().fold(f32::MIN, f32::max) - ys().fold(f32::MAX, f32::min)
    }
}

impl Entry {
    pub(super) fn open(&self, data: &Path) -> Result<Subject> {
        let mut opened = articula::fs::open(data.join(self.file))?;
        if self.subdivided {
            opened.edit_character(|character| {
                character.meshes = character.meshes.iter().map(subdivide).collect();
            });
        }
        let figure = Figure::new(opened)?;
        Ok(Subject {
            name: self.name,
            source: figure.opened.into_character(),
            asset: figure.asset,
            told_height_metres: self.height_metres,
        })
    }
}
