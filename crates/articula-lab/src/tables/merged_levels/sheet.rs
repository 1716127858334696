//! A character in full and at each of its levels, large and at the size for which it is chosen.

use anyhow::{Context, Result};
use articula_build::Asset;
use articula_build::{JointLodOptions, merged_levels};
use articula_core::{Clip, Mesh, PosedMesh, Rig, SkinnedMesh, Wrap};
use articula_flat::{Appearance, Bounds};
use articula_formats::{Limits, gltf};
use articula_report::{ContactSheet, SheetCell, SheetRow, SheetTile, close_up};
use glam::Vec3;
use std::path::Path;

const TILE: (u32, u32) = (220, 300);
const MOMENTS: usize = 6;

/// The character at one level.
struct Variant<'a> {
    label: String,
    rig: &'a Rig,
    clips: &'a [Clip],
    mesh: Mesh,
    error_metres: f32,
}

/// Draws the first clip at several times.
pub(super) fn write(data: &Path, name: &str, asset: &Asset, path: &Path) -> Result<()> {
    let bytes = std::fs::read(data.join(format!("glb/{name}.glb")))?;
    let mut none = |_: &str| Err("no files beside".to_owned());
    let file = gltf::read(&bytes, &Limits::default(), &mut none)?.value;
    let (paint, _) = Appearance::new(&file.character.materials, &file.character.images);
    let opts = JointLodOptions {
        far_from_metres: 4e-3,
        ..JointLodOptions::default()
    };
    let levels = merged_levels(asset, &opts)?;
    let near = levels.joint_lods.levels();
    let error = |level: usize| levels.errors.clips[0].levels_metres[level];
    let mut looks = Vec::new();
    for level in 0..near {
        looks.push(Variant {
            label: format!(
                "{} joints, {:.1} mm",
                levels.joint_lods.joint_count(level),
                1e3 * error(level)
            ),
            rig: &asset.rig,
            clips: &asset.clips,
            mesh: levels.skins.mesh(level, &asset.mesh),
            error_metres: error(level),
        });
    }
    if let Some(far) = &levels.far {
        for level in 0..far.joint_lods.levels() {
            let metres = error(near + level);
            looks.push(Variant {
                label: format!(
                    "far, {} joints, {:.1} mm",
                    far.joint_lods.joint_count(level),
                    1e3 * metres
                ),
                rig: &far.rig,
                clips: &far.clips,
                mesh: far.skins.mesh(level, &asset.mesh),
                error_metres: metres,
            });
        }
    }
    let secs = asset.clips[0].duration_secs();
    let mut rows = Vec::new();
    for look in &looks {
        let mut cells = Vec::new();
        for moment in 0..MOMENTS {
            let at = f64::from(secs) * (moment as f64 + 0.5) / MOMENTS as f64;
            cells.push(cell(&looks[0], look, &paint, at)?);
        }
        rows.push(SheetRow {
            label: look.label.clone(),
            cells,
        });
    }
    let sheet = ContactSheet {
        title: format!("{name}, {}", asset.clips[0].name),
        notes: vec!["Small: at the size where the error of the level is one pixel.".into()],
        rows,
        ..ContactSheet::default()
    };
    let png = sheet.draw()?.to_png()?;
    std::fs::write(path, png).with_context(|| path.display().to_string())
}

fn skinned(look: &Variant<'_>, secs: f64) -> SkinnedMesh {
    let mut posed = PosedMesh::new(look.rig, &look.mesh);
    let posed = posed.pose_at(&look.clips[0], secs, Wrap::Clamp);
    posed.skinned(&look.mesh.morph_weights)
}

/// The character large, and at the size for which the level is made.
fn cell(
    full: &Variant<'_>,
    look: &Variant<'_>,
    paint: &Appearance,
    secs: f64,
) -> Result<SheetCell> {
    let truth = skinned(full, secs).bounds().context("nothing to draw")?;
    let middle = 0.5 * (truth.0 + truth.1);
    let half = Vec3::splat(0.5 * (truth.1 - truth.0).max_element());
    let bounds = Bounds {
        low: middle - half,
        high: middle + half,
    };
    let shown = skinned(look, secs);
    let draw = |size| close_up(&look.mesh, &shown, paint, &bounds, (0.7, 0.12), size);
    let px = 1.0 / look.error_metres.max(1e-3);
    let height = (2.2 * half.y * px).clamp(8.0, TILE.1 as f32);
    let small = (height * TILE.0 as f32 / TILE.1 as f32, height);
    let tile = |picture| SheetTile {
        picture,
        caption: String::new(),
    };
    Ok(SheetCell {
        tiles: vec![
            tile(draw(TILE)?),
            tile(draw((small.0.ceil() as u32, small.1 as u32))?),
        ],
    })
}
