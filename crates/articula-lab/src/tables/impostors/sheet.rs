//! A character at its true sizes, magnified: as it is, at the coarsest near level, at a far level and as
//! an impostor.

use super::far::FarLevel;
use super::impostor::Baked;
use super::{HEIGHTS_PX, Subject};
use anyhow::{Context, Result};
use articula_core::{Camera, Mesh, PosedMesh, SkinnedMesh, Viewport, Wrap};
use articula_flat::impostor::ImpostorPainter;
use articula_flat::{
    Appearance, Picture, Projection, RenderOptions, Screen, Supersampling, render,
};
use articula_report::{ContactSheet, SheetCell, SheetRow, SheetTile};
use glam::{Affine3A, Vec3};
use std::path::Path;

/// Magnified height of a tile, pixels.
const TILE_PX: u32 = 240;

/// Directions of the eyes: yaw and pitch, degrees.
const EYES_DEG: [(f32, f32); 2] = [(25.0, 5.0), (130.0, 16.0)];

const PAPER: [u8; 4] = [225, 230, 225, 255];

const WAYS: [&str; 4] = ["as it is", "near level", "far level", "impostor"];

/// Pictures at one height, for each of [`WAYS`].
pub(super) type Tiles = [Vec<Picture>; 4];

/// Draws all ways at one height, in the middle of the first clip.
pub(super) fn tiles(
    subject: &Subject,
    height_px: f32,
    (near, shown_far, baked): (usize, Option<&FarLevel>, Option<&Baked>),
) -> Result<Tiles> {
    let full = subject.crowd.full();
    let character = subject.figure.opened.character();
    let (paint, _) = Appearance::new(&character.materials, &character.images);
    let secs = 0.4 * full.clips[0].duration_secs();
    let posed = |asset: &articula_build::Asset, mesh: &Mesh| {
        let mut posed = PosedMesh::new(&asset.rig, mesh);
        let posed = posed.pose_at(&asset.clips[0], f64::from(secs), Wrap::Clamp);
        posed.skinned(&mesh.morph_weights)
    };
    let truth = posed(full, &full.mesh);
    let (low, high) = truth.bounds().context("nothing to draw")?;
    let middle = 0.5 * (low + high);
    let side = (1.6 * height_px).ceil();
    let projection = Projection::Parallel {
        pixels_per_metre: height_px / subject.height_m,
    };
    let mut tiles = Tiles::default();
    for (yaw, pitch) in EYES_DEG {
        let turn = glam::Quat::from_rotation_y(yaw.to_radians())
            * glam::Quat::from_rotation_x(-pitch.to_radians());
        let viewport = Viewport {
            width_px: side,
            height_px: side,
            ..Viewport::default()
        };
        let camera = Camera::looking_at(middle + turn * Vec3::Z * 9.0, middle, viewport);
        let options = RenderOptions {
            background: PAPER,
            samples: Supersampling::Eight,
            projection,
            ..RenderOptions::default()
        };
        let draw = |mesh: &Mesh, skinned: &SkinnedMesh| -> Result<Picture> {
            magnified(&render(mesh, skinned, &paint, &camera, &options)?)
        };
        tiles[0].push(draw(&full.mesh, &truth)?);
        let mesh = subject.crowd.mesh(near);
        tiles[1].push(draw(mesh, &near_skin(subject, near, secs))?);
        if let Some(level) = shown_far {
            let asset = level.crowd.full();
            tiles[2].push(draw(&asset.mesh, &posed(asset, &asset.mesh))?);
        }
        if let Some(baked) = baked {
            let pose = baked.plan.clips[0].first_pose + baked.plan.clips[0].pose_at(secs);
            let atlas = baked.atlas(subject, pose)?;
            let mut picture = Picture::new(side as u32, side as u32, PAPER)?;
            let screen = Screen::new(&camera, projection);
            let painter = ImpostorPainter::new(&baked.plan, &atlas);
            painter.paint(&mut picture, &screen, &Affine3A::IDENTITY, pose);
            tiles[3].push(magnified(&picture)?);
        }
    }
    Ok(tiles)
}

/// A level as a crowd shows it: its own mesh, posed by the whole rig with the joints that it keeps.
fn near_skin(subject: &Subject, level: usize, secs: f32) -> SkinnedMesh {
    use articula::crowd::{CacheUse, CrowdPlayer, Culling, Detail};
    let mesh = subject.crowd.mesh(level);
    let fallback = || SkinnedMesh::new(mesh);
    let Ok(mut player) = CrowdPlayer::new(&subject.crowd, 1) else {
        return fallback();
    };
    player.cache = CacheUse::Never;
    player.detail = Detail::Level(level);
    player.play(0, 0, secs);
    player.plan(0.0, Culling::Off, &mut |_| ());
    player.evaluate();
    player
        .skinned(0)
        .map_or_else(fallback, |(_, skinned)| skinned)
}

/// Enlarges a picture to the height of a tile without smoothing.
fn magnified(picture: &Picture) -> Result<Picture> {
    let factor = (TILE_PX / picture.height().max(1)).max(1);
    let (width, height) = (picture.width() * factor, picture.height() * factor);
    let at = |i: u32| picture.get(i % width / factor, i / width / factor);
    let pixels = (0..width * height).filter_map(at).collect();
    Ok(Picture::from_pixels(width, height, pixels)?)
}

/// Writes the sheet: a row for each way, a column for each height.
pub(super) fn write(name: &str, heights: Vec<Tiles>, path: &Path) -> Result<()> {
    let row = |(way, label): (usize, &&str)| SheetRow {
        label: (*label).to_owned(),
        cells: heights
            .iter()
            .map(|tiles| SheetCell {
                tiles: tiles[way]
                    .iter()
                    .map(|picture| SheetTile {
                        picture: picture.clone(),
                        caption: String::new(),
                    })
                    .collect(),
            })
            .collect(),
    };
    let sheet = ContactSheet {
        title: name.to_owned(),
        notes: vec!["Each within one pixel at its height; pixels magnified.".to_owned()],
        columns: HEIGHTS_PX.iter().map(|px| format!("{px} px")).collect(),
        rows: WAYS.iter().enumerate().map(row).collect(),
        ..ContactSheet::default()
    };
    let png = sheet.draw()?.to_png()?;
    std::fs::write(path, png).with_context(|| path.display().to_string())
}
