//! A moment of a crowd as its camera sees it, every character in the colour of its level.

use super::cast::Cast;
use super::purse::Decision;
use super::stage::{Settings, Source, Stage, Wanted};
use anyhow::Context;
use articula_build::scene::Scene;
use articula_core::{Camera, Viewport};
use articula_flat::Picture;
use articula_report::CrowdPicture;

/// Most triangles that are drawn; who is farther away than they reach is left out.
const MOST_TRIANGLES: usize = 4_000_000;

/// Draws the scene at its beginning.
pub(crate) fn draw(
    cast: &Cast,
    scene: &Scene,
    settings: Settings,
    size: (u32, u32),
) -> anyhow::Result<Picture> {
    let mut stage = Stage::new(cast, scene, settings)?;
    let decision = match settings.wanted {
        Wanted::Budget { ms, .. } => Some(Decision {
            cost: 1e6 * ms,
            prices: None,
        }),
        _ => None,
    };
    stage.tick(0.0, decision.as_ref())?;
    stage.evaluate();
    let camera = stage.camera()?;
    let crowd = gathered(&stage, &camera);
    let camera = Camera {
        viewport: Viewport {
            width_px: size.0 as f32,
            height_px: size.1 as f32,
            ..camera.viewport
        },
        ..camera
    };
    let legend = legend(&stage, crowd.len());
    crowd.draw(&camera, &legend).context("drawing the crowd")
}

/// The skins of all who are shown, nearest first.
fn gathered(stage: &Stage<'_>, camera: &Camera) -> CrowdPicture {
    let cast = stage.cast;
    let sources = stage.sources();
    let shown = sources.iter().enumerate();
    let mut draws: Vec<(f32, usize, &Source)> = shown
        .filter_map(|(c, source)| Some((c, source.as_ref()?)))
        .map(|(c, source)| (camera.eye.distance(stage.positions[c]), c, source))
        .collect();
    draws.sort_by(|a, b| a.0.total_cmp(&b.0));
    draws.truncate((MOST_TRIANGLES / cast.asset.mesh.triangles.len().max(1)).max(1));
    let mut picture = CrowdPicture::default();
    let mut matrices = Vec::new();
    for (_, character, source) in draws {
        let Some(level) = stage.crowd.level(character) else {
            continue;
        };
        stage.shown_palette(level, source, &mut matrices);
        let world = stage.scene.members[character].world_from_model();
        picture.add(&cast.meshes[level], level, &matrices, &world);
    }
    picture
}

/// Says which colour is which level, how many are shown at it, and how many of all are drawn.
fn legend(stage: &Stage<'_>, drawn: usize) -> Vec<(Option<usize>, String)> {
    let count = stage.scene.members.len();
    let mut levels = vec![0; stage.cast.model.levels()];
    for level in (0..count).filter_map(|c| stage.crowd.level(c)) {
        levels[level] += 1;
    }
    let shown: usize = levels.iter().sum();
    let levels = levels.into_iter().enumerate().filter(|l| l.1 > 0);
    let line_of = |(level, count): (usize, usize)| {
        let joints = stage.cast.ladder().kept(level);
        let text = match &stage.cast.figure {
            Some(figure) => {
                let triangles = figure.levels[level].triangles;
                format!("{joints} joints, {triangles} triangles: {count}")
            }
            None => format!("{joints} joints: {count}"),
        };
        (Some(level), text)
    };
    let mut lines: Vec<_> = levels.map(line_of).collect();
    if drawn < shown {
        lines.push((None, format!("nearest {drawn} drawn")));
    }
    lines
}
