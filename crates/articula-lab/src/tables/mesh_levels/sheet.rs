//! A character in motion at every level, whole and in close-ups of hands, face and armpits.

use super::QUARTER;
use super::SHARES;
use super::characters::Subject;
use super::contestants::{Contestant, Posed, levels};
use anyhow::{Context, Result};
use articula_build::LevelTriangles;
use articula_build::SkinPose;
use articula_core::{Mesh, SkinnedMesh};
use articula_flat::{Appearance, Bounds};
use articula_report::{ContactSheet, SheetCell, SheetRow, SheetTile, close_up};
use glam::Vec3;
use std::path::Path;

const TILE_PX: (u32, u32) = (230, 250);
/// Elevation of the camera, radians.
const ELEVATION: f32 = 0.1;
/// Number of poses shown.
const MOMENTS: usize = 3;
/// Size of the visible part of a shoulder, as a fraction of the height.
const ARMPIT: f32 = 0.09;

/// Part of the character in a picture.
#[derive(Clone, Copy)]
enum View {
    Body,
    /// The skin of a joint and its descendants, from an azimuth in radians.
    Below(&'static str, f32),
    /// The surroundings of a joint, from an azimuth in radians.
    Near(&'static str, f32),
}

const VIEWS: [View; 4] = [
    View::Body,
    View::Below("l_wrist", 1.2),
    View::Below("skullbase", 0.5),
    View::Near("l_shoulder", 0.7),
];

/// Contents of a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// All levels in several poses.
    Full,
    /// One pose, the levels down to 10 %: for a page.
    Page,
}

/// Draws some of the poses for measuring.
pub(super) fn write(
    subject: &Subject,
    posed: &Posed,
    ours: &[LevelTriangles],
    extent: Extent,
    path: &Path,
) -> Result<()> {
    let source = &subject.source;
    let (paint, _) = Appearance::new(&source.materials, &source.images);
    let (count, lowest) = match extent {
        Extent::Full => (MOMENTS, 0),
        Extent::Page => (1, 1),
    };
    let poses = &posed.measuring_poses;
    let at = |m: usize| (2 * m + 1) * poses.len() / (2 * count);
    let moments: Vec<SkinnedMesh> = (0..count.min(poses.len()))
        .map(|m| skinned(subject, &poses[at(m)]))
        .collect();
    let peer = levels(Contestant::Meshopt, subject, posed, ours)?;
    let mut rows = Vec::new();
    for (l, level) in ours.iter().enumerate().skip(lowest).rev() {
        rows.push(row(subject, &moments, level, &paint, SHARES[l])?);
    }
    for l in (lowest..=QUARTER).rev() {
        let label = format!("meshopt {}", SHARES[l]);
        rows.push(row(subject, &moments, &peer.levels[l], &paint, &label)?);
    }
    let sheet = ContactSheet {
        title: format!("{}: levels in motion", subject.name),
        rows,
        ..ContactSheet::default()
    };
    let png = sheet.draw()?.to_png()?;
    std::fs::write(path, png).with_context(|| path.display().to_string())
}

fn skinned(subject: &Subject, pose: &SkinPose) -> SkinnedMesh {
    pose.skinned(&subject.asset, &subject.asset.mesh)
}

fn row(
    subject: &Subject,
    moments: &[SkinnedMesh],
    level: &LevelTriangles,
    paint: &Appearance,
    label: &str,
) -> Result<SheetRow> {
    let mut mesh = Mesh::clone(&subject.asset.mesh);
    mesh.triangles.clone_from(&level.triangles);
    for (part, triangles) in mesh.parts.iter_mut().zip(&level.parts) {
        part.triangles = triangles.clone();
    }
    let mut tiles = Vec::new();
    for moment in moments {
        for view in VIEWS {
            let Some((bounds, azimuth)) = seen(subject, moment, view) else {
                continue;
            };
            let from = (azimuth, ELEVATION);
            tiles.push(SheetTile {
                picture: close_up(&mesh, moment, paint, &bounds, from, TILE_PX)?,
                caption: String::new(),
            });
        }
    }
    Ok(SheetRow {
        label: format!("{label}: {} triangles", level.triangles.len()),
        cells: vec![SheetCell { tiles }],
    })
}

/// The box in the picture and the azimuth; `None` if the character lacks the joint.
fn seen(subject: &Subject, moment: &SkinnedMesh, view: View) -> Option<(Bounds, f32)> {
    let mesh = &subject.asset.mesh;
    let rig = &subject.asset.rig;
    let positions = &moment.positions;
    let of = |vertices: &mut dyn Iterator<Item = usize>| {
        Bounds::around(vertices.map(|v| (positions[v], positions[v])))
    };
    let joint = |name: &str| rig.articulation().find(name);
    let follows = |v: usize, joint: usize| {
        let below = mesh
            .influences_of(v)
            .filter(|(j, _)| rig.is_at_or_below(*j, joint));
        below.map(|(_, w)| w).sum::<f32>() > 0.5
    };
    match view {
        View::Body => Some((of(&mut (0..mesh.len()))?, 0.6)),
        View::Below(name, azimuth) => {
            let joint = joint(name)?;
            Some((
                of(&mut (0..mesh.len()).filter(|v| follows(*v, joint)))?,
                azimuth,
            ))
        }
        View::Near(name, azimuth) => {
            let joint = joint(name)?;
            let whole = of(&mut (0..mesh.len()))?;
            let near = of(&mut (0..mesh.len()).filter(|v| {
                let direct = mesh.influences_of(*v).find(|(j, _)| *j == joint);
                direct.is_some_and(|(_, w)| w > 0.3 && w < 0.7)
            }))?;
            let half = Vec3::splat(ARMPIT * (whole.high - whole.low).max_element());
            let middle = near.middle();
            Some((
                Bounds {
                    low: middle - half,
                    high: middle + half,
                },
                azimuth,
            ))
        }
    }
}
