//! Who is simplified.

use crate::subdivide::subdivide;
use anyhow::{Context, Result};
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_core::Articulation;
use articula_core::source::Character;
use articula_formats::{Limits, gltf, profile};
use glam::Vec3;
use std::path::Path;

/// A character of the table.
pub(super) struct Entry {
    pub(super) name: &'static str,
    file: &'static str,
    /// Whether every triangle becomes four first.
    subdivided: bool,
    /// How tall it is said to be, metres.
    height_metres: f32,
}

/// A figure.
const BODY_METRES: f32 = 1.8;
/// A head alone.
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

/// The one that a small run takes.
pub(super) const SMALL: &str = "pab_arnaud";

/// The one that the page has a picture of (by Quaternius, CC0).
pub(super) const PICTURED: &str = "Quaternius suit";

/// A character, as the file has it and ready to be played.
pub(super) struct Subject {
    pub(super) name: &'static str,
    pub(super) source: Character,
    pub(super) asset: Asset,
    /// How tall it is said to be.
    pub(super) told_height_metres: f32,
}

impl Subject {
    /// How tall it is in a pose.
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
        let path = data.join(self.file);
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        let mut none = |_: &str| Err("no files beside".to_owned());
        let read = gltf::read(&bytes, &Limits::default(), &mut none);
        let mut source = read
            .with_context(|| path.display().to_string())?
            .value
            .character;
        if self.subdivided {
            source.meshes = source.meshes.iter().map(subdivide).collect();
        }
        let mapped = articula_build::joint_names::map(&source.skeleton, profile::builtin(), None);
        let articulation: Articulation = mapped.articulation;
        let asset = character(&source, Some(articulation), &ClipOptions::default())
            .with_context(|| path.display().to_string())?;
        Ok(Subject {
            name: self.name,
            source,
            asset,
            told_height_metres: self.height_metres,
        })
    }
}
