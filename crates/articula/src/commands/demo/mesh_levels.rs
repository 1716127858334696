//! The mesh levels of the demo: what they weigh, and how they look in motion.

use super::Folder;
use crate::mesh_levels::{Levels, report};
use crate::play::Scene;
use crate::play::artist::artist;
use crate::prepared::Prepared;
use anyhow::Context;
use articula_core::source;
use articula_core::{Region, Wrap, sample};
use articula_flat::{Picture, codec};
use articula_report::{Cell, ContactSheet, Row};
use serde::Serialize;

/// What the levels of the asset show, lose and weigh.
#[derive(Debug, Serialize)]
pub(super) struct MeshLevels {
    /// The finest first.
    pub(super) levels: Vec<report::Level>,
    pub(super) bytes: report::Bytes,
    pub(super) poses_measured: usize,
}

impl MeshLevels {
    /// Of an asset whose meshes take so many bytes.
    pub(super) fn new(levels: &Levels, mesh_bytes: usize) -> Self {
        Self {
            levels: report::levels(levels),
            bytes: report::bytes(levels, mesh_bytes),
            poses_measured: levels.made.measured.poses(),
        }
    }
}

/// Draws every level in a moment of the clip: the whole figure, its face and a hand.
pub(super) fn draw(folder: &Folder, scene: &Scene<'_>) -> anyhow::Result<()> {
    let meshes = &scene.prepared.loaded.character.meshes;
    let count = meshes.iter().flat_map(|m| m.clustered.first());
    let count = count.map(|c| c.clusters.levels()).max().unwrap_or(0);
    let mut rows = Vec::with_capacity(count);
    for level in (0..count).rev() {
        rows.push(row(scene, level)?);
    }
    let sheet = ContactSheet {
        title: "Mesh levels in motion".into(),
        rows,
        ..ContactSheet::default()
    };
    let picture = sheet.draw().context("the picture of mesh levels")?;
    folder.write("mesh-levels.png", &codec::png(&picture)?)
}

fn row(scene: &Scene<'_>, level: usize) -> anyhow::Result<Row> {
    let prepared = at_level(scene.prepared, level)?;
    let clip = &prepared.asset.clips[scene.clip];
    let mut pose = prepared.asset.rig.rest_pose().clone();
    let secs = f64::from(clip.duration_secs()) / 4.0;
    let all = prepared.asset.rig.all();
    sample(clip, secs, Wrap::Clamp, &all, &mut pose);
    let morphs = prepared.asset.mesh.morph_weights.clone();
    let mut artist = artist(&prepared, (230, 300));
    artist.frame_pose(&pose, &morphs);
    let mut pictures = vec![("in motion", artist.figure(&pose, morphs.clone())?)];
    for (caption, region, azimuth) in [("face", Region::Face, 0.4), ("hand", Region::Hands, 1.2)] {
        artist.azimuth = azimuth;
        artist.frame_region(&pose, region);
        pictures.push((caption, artist.figure(&pose, morphs.clone())?));
    }
    let triangles = prepared.asset.mesh.triangles.len();
    let cell = |(caption, picture): (&str, Picture)| Cell::of(picture, caption);
    Ok(Row {
        label: format!("{triangles} triangles"),
        cells: pictures.into_iter().map(cell).collect(),
    })
}

/// A character that was read, showing one of its mesh levels.
fn at_level(prepared: &Prepared, level: usize) -> anyhow::Result<Prepared> {
    let mut loaded = prepared.loaded.clone();
    for mesh in &mut loaded.character.meshes {
        show(mesh, level);
    }
    Prepared::from_loaded(loaded)
}

fn show(mesh: &mut source::Mesh, level: usize) {
    for (primitive, levels) in mesh.primitives.iter_mut().zip(&mesh.clustered) {
        primitive.triangles = levels.level(level).collect();
    }
    mesh.clustered.clear();
}
