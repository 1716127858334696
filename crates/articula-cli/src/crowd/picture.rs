//! A picture of the first frame of a crowd, each character in the colour of its level.

use super::stage::{Settings, TimedCrowd};
use anyhow::Context;
use articula::crowd::{CrowdAsset, CrowdPlayer, ImpostorDraw, PoseSource};
use articula_build::Scene;
use articula_core::{Camera, Viewport};
use articula_flat::Picture;
use articula_report::CrowdPicture;
use glam::Vec3;

/// Maximum number of triangles of skins; the farthest characters beyond it are slivers.
const MAX_TRIANGLES: usize = 8_000_000;

/// Draws the scene at time 0.
pub(crate) fn draw(
    asset: &CrowdAsset,
    scene: &Scene,
    settings: Settings,
    size: (u32, u32),
) -> anyhow::Result<Picture> {
    let stage = TimedCrowd::first_frame(asset, scene, settings)?;
    let (player, camera) = (stage.scene.player(), stage.scene.camera()?);
    let (mut crowd, drawn) = gathered(player, &camera);
    for wall in &scene.walls {
        crowd.add_wall(wall.centre, 0.5 * wall.size, wall.yaw_radians);
    }
    let camera = Camera {
        viewport: Viewport {
            width_px: size.0 as f32,
            height_px: size.1 as f32,
            ..camera.viewport
        },
        ..camera
    };
    let legend = legend(player, drawn);
    crowd.draw(&camera, &legend).context("drawing the crowd")
}

/// How a character is shown.
enum Shown<'a> {
    Posed(&'a PoseSource),
    Impostor(ImpostorDraw),
}

/// The skins of the nearest visible characters, the others as slivers, and the number of those with
/// skins.
fn gathered(player: &CrowdPlayer, camera: &Camera) -> (CrowdPicture, usize) {
    let asset = player.asset();
    let sources = player.sources();
    let shown = sources.iter().enumerate();
    let mut draws: Vec<(f32, usize, Shown<'_>)> = shown
        .filter_map(|(c, source)| Some((c, source.as_ref()?)))
        .map(|(c, source)| {
            (
                camera.eye.distance(player.positions()[c]),
                c,
                Shown::Posed(source),
            )
        })
        .collect();
    let impostors = player.impostors().iter().map(|draw| {
        let character = draw.character as usize;
        let distance = camera.eye.distance(player.positions()[character]);
        (distance, character, Shown::Impostor(*draw))
    });
    draws.extend(impostors);
    draws.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut picture, mut drawn, mut triangles) = (CrowdPicture::default(), 0, 0);
    let mut matrices = Vec::new();
    let across = camera.orientation * Vec3::X;
    for (_, character, shown) in draws {
        let Some(level) = player.crowd().level(character) else {
            continue;
        };
        let world = player.world_from_model(character);
        let (mesh, level) = match shown {
            Shown::Posed(_) => (asset.mesh(level), level),
            // The whole mesh, flat: what the pictures show, without their pixels.
            Shown::Impostor(_) => (&asset.full().mesh, asset.levels()),
        };
        triangles += mesh.triangles.len();
        if triangles > MAX_TRIANGLES && drawn > 0 {
            let clip = player.crowd().state(character).clip_state().clip();
            let bound = asset.model().parts().bounds.clips[clip].whole().sphere;
            let centre = world.transform_point3(bound.centre);
            let radius = bound.radius * player.scale(character);
            picture.add_far(level, centre, radius, across);
            continue;
        }
        match shown {
            Shown::Posed(source) => player.skin_matrices(level, source, &mut matrices),
            Shown::Impostor(draw) => player.impostor_matrices(draw, camera.eye, &mut matrices),
        }
        picture.add(mesh, level, &matrices, &world);
        drawn += 1;
    }
    (picture, drawn)
}

/// The legend: the colour and number of characters of each level, and the number drawn.
fn legend(player: &CrowdPlayer, drawn: usize) -> Vec<(Option<usize>, String)> {
    let asset = player.asset();
    let count = player.positions().len();
    let mut levels = vec![0; asset.levels()];
    let far = player.impostors().len();
    for level in (0..count).filter_map(|c| player.crowd().level(c)) {
        levels[level] += 1;
    }
    let shown: usize = levels.iter().sum();
    // Impostors count as of the coarsest level, whose colour is not theirs.
    if let Some(coarsest) = levels.last_mut() {
        *coarsest -= far.min(*coarsest);
    }
    let levels = levels.into_iter().enumerate().filter(|l| l.1 > 0);
    let line_of = |(level, count): (usize, usize)| {
        let made = asset.level(level);
        let joints = made.joints;
        let text = if asset.has_mesh_lods() {
            format!("{joints} joints, {} triangles: {count}", made.triangles)
        } else {
            format!("{joints} joints: {count}")
        };
        (Some(level), text)
    };
    let mut lines: Vec<_> = levels.map(line_of).collect();
    if far > 0 {
        lines.push((
            Some(asset.levels()),
            format!("impostors, 2 triangles: {far}"),
        ));
    }
    if drawn < shown {
        lines.push((None, format!("nearest {drawn} with their skins")));
    }
    lines
}
