//! The mesh levels of the demo: sizes, errors and pictures in motion.

use super::files::DemoFiles;
use crate::artist::Artist;
use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use articula::core::source;
use articula::core::{Region, Wrap, sample};
use articula::evaluate::EvaluatedClip;
use articula::flat::Picture;
use articula::{CodedMeshLevels, Figure, MeshLevelBytes, MeshLevelRow, Result};
use serde::Serialize;

/// Triangles, errors and sizes of the asset's mesh levels.
#[derive(Debug, Serialize)]
pub(super) struct MeshLevels {
    /// The levels, finest first.
    pub(super) levels: Vec<MeshLevelRow>,
    pub(super) bytes: MeshLevelBytes,
    pub(super) poses_measured: usize,
}

impl MeshLevels {
    /// Of an asset whose meshes take `mesh_bytes` bytes.
    pub(super) fn new(levels: &CodedMeshLevels, mesh_bytes: usize) -> Self {
        Self {
            levels: levels.rows(),
            bytes: levels.sizes(mesh_bytes),
            poses_measured: levels.poses_measured(),
        }
    }
}

/// Draws every level at one time of the clip: the whole figure, its face and a hand, and the figure as
/// large as it is where the error of the level is a pixel.
pub(super) fn draw(
    files: &mut DemoFiles,
    scene: &EvaluatedClip<'_>,
    levels: &MeshLevels,
) -> Result<()> {
    let meshes = &scene.figure.opened.character().meshes;
    let count = meshes.iter().flat_map(|m| m.clustered.first());
    let count = count.map(|c| c.clusters.levels()).max().unwrap_or(0);
    let mut rows = Vec::with_capacity(count);
    for level in 0..count {
        let error_m = levels.levels.get(level).and_then(|row| row.error_motion_m);
        rows.push(row(scene, level, error_m.unwrap_or(0.0))?);
    }
    let sheet = ContactSheet {
        title: "Mesh levels in motion".into(),
        rows,
        ..ContactSheet::default()
    };
    files.add_png("mesh-levels.png", &sheet.draw()?)
}

fn row(scene: &EvaluatedClip<'_>, level: usize, error_m: f32) -> Result<SheetRow> {
    let figure = at_level(scene.figure, level)?;
    let clip = &figure.asset.clips[scene.clip];
    let mut pose = figure.asset.rig.rest_pose().clone();
    let secs = f64::from(clip.duration_secs()) / 4.0;
    let all = figure.asset.rig.all();
    sample(clip, secs, Wrap::Clamp, &all, &mut pose);
    let morphs = figure.asset.mesh.morph_weights.clone();
    let mut artist = Artist::of_figure(&figure, (230, 300));
    artist.frame_pose(&pose, &morphs);
    let mut pictures = vec![(
        "in motion".to_owned(),
        artist.figure(&pose, morphs.clone())?,
    )];
    // One pixel is the error, whatever the picture.
    let used = (error_m > 0.0).then(|| artist.at_scale(&pose, &morphs, 1.0 / error_m));
    let used = used.transpose()?;
    for (caption, region, azimuth) in [("face", Region::Face, 0.4), ("hand", Region::Hands, 1.2)] {
        artist.azimuth = azimuth;
        artist.frame_region(&pose, region);
        pictures.push((caption.to_owned(), artist.figure(&pose, morphs.clone())?));
    }
    let viewport = scene.setup.viewport;
    let distance_m = error_m * viewport.pixels_per_metre(1.0);
    pictures.extend(used.map(|picture| (format!("1 px, at {distance_m:.1} m"), picture)));
    let triangles = figure.asset.mesh.triangles.len();
    let cell = |(caption, picture): (String, Picture)| SheetCell::of(picture, caption);
    Ok(SheetRow {
        label: format!("{triangles} triangles"),
        cells: pictures.into_iter().map(cell).collect(),
    })
}

/// The figure of a character file with only one of its mesh levels.
fn at_level(figure: &Figure, level: usize) -> Result<Figure> {
    let mut opened = figure.opened.clone();
    opened.edit_character(|character| {
        character.meshes.iter_mut().for_each(|m| show(m, level));
    });
    Figure::new(opened)
}

fn show(mesh: &mut source::RawMesh, level: usize) {
    for (primitive, levels) in mesh.primitives.iter_mut().zip(&mesh.clustered) {
        primitive.triangles = levels.level(level).collect();
    }
    mesh.clustered.clear();
}
