//! A picture of a scene that is played, each character in the colour of its level.

use crate::crowd::CrowdPicture;
use articula::core::{Camera, Viewport};
use articula::crowd::{CrowdPlayer, ImpostorDraw, PoseSource, ScenePlayer};
use articula::flat::Picture;
use glam::Vec3;

/// Maximum number of triangles of skins; the farthest characters beyond it are slivers.
const MAX_TRIANGLES: usize = 8_000_000;

/// Draws the evaluated frame of a scene, its views below each other, each of a size in pixels.
///
/// # Errors
/// [`Error::Unsupported`](articula::Error::Unsupported) if a view has no camera, or a picture error if
/// the size is too large.
pub fn scene_picture(
    scene: &ScenePlayer,
    (width, height): (u32, u32),
) -> articula::Result<Picture> {
    let mut pictures = Vec::new();
    for camera in scene.cameras()? {
        let (mut crowd, drawn) = gathered(scene, &camera);
        for wall in &scene.scene().walls {
            crowd.add_wall(wall.centre, 0.5 * wall.size, wall.yaw_radians);
        }
        let camera = Camera {
            viewport: Viewport {
                width_px: width as f32,
                height_px: height as f32,
                ..camera.viewport
            },
            ..camera
        };
        // The colours mean the same in all views.
        let legend = match pictures.is_empty() {
            true => legend(scene, drawn),
            false => Vec::new(),
        };
        pictures.push(crowd.draw(&camera, &legend)?);
    }
    let all = height * pictures.len() as u32;
    let mut sheet = Picture::new(width, all, [255; 4])?;
    for (i, picture) in pictures.iter().enumerate() {
        sheet.blit(picture, 0, (i as u32 * height) as i32);
    }
    Ok(sheet)
}

/// How a character is shown.
enum Shown<'a> {
    Posed(&'a PoseSource),
    Impostor(ImpostorDraw),
}

/// The skins of the nearest visible characters, the others as slivers, and the number of those with
/// skins.
fn gathered(scene: &ScenePlayer, camera: &Camera) -> (CrowdPicture, usize) {
    let sources = scene.crowds().iter().map(CrowdPlayer::sources);
    let sources: Vec<_> = sources.collect();
    let mut draws: Vec<(f32, usize, usize, Shown<'_>)> = Vec::new();
    for (crowd, (player, sources)) in scene.crowds().iter().zip(&sources).enumerate() {
        let distance = |c: usize| camera.eye.distance(player.positions()[c]);
        let shown = sources.iter().enumerate();
        draws.extend(shown.filter_map(|(c, source)| {
            let shown = Shown::Posed(source.as_ref()?);
            Some((distance(c), crowd, c, shown))
        }));
        draws.extend(player.impostors().iter().map(|draw| {
            let character = draw.character as usize;
            (
                distance(character),
                crowd,
                character,
                Shown::Impostor(*draw),
            )
        }));
    }
    draws.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut picture, mut drawn, mut triangles) = (CrowdPicture::default(), 0, 0);
    let mut matrices = Vec::new();
    let across = camera.orientation * Vec3::X;
    for (_, crowd, character, shown) in draws {
        let player = &scene.crowds()[crowd];
        let asset = player.asset();
        let Some(level) = player.crowd().level(character) else {
            continue;
        };
        let world = player.world_from_model(character);
        let (mesh, level) = match shown {
            Shown::Posed(_) => (asset.mesh(level), level),
            // The whole mesh, flat: what the pictures show, without their pixels.
            Shown::Impostor(_) => (&*asset.full().mesh, beyond_levels(scene)),
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

/// The legend: the colour and number of characters of each level, and the number drawn. Where the levels
/// belong to several characters, what they keep is left out.
fn legend(scene: &ScenePlayer, drawn: usize) -> Vec<(Option<usize>, String)> {
    let mut levels = vec![0; beyond_levels(scene)];
    let mut far = 0;
    let mut shown = 0;
    for player in scene.crowds() {
        for level in (0..player.positions().len()).filter_map(|c| player.crowd().level(c)) {
            levels[level] += 1;
            shown += 1;
        }
        // Impostors count as of the coarsest level, whose colour is not theirs.
        let impostors = player.impostors().len();
        levels[player.asset().levels() - 1] -= impostors;
        far += impostors;
    }
    let levels = levels.into_iter().enumerate().filter(|l| l.1 > 0);
    let line_of = |(level, count): (usize, usize)| {
        let text = match scene.crowds() {
            [player] => {
                let made = player.asset().level(level);
                let joints = made.joints;
                if player.asset().has_mesh_lods() {
                    format!("{joints} joints, {} triangles: {count}", made.triangles)
                } else {
                    format!("{joints} joints: {count}")
                }
            }
            _ => format!("level {level}: {count}"),
        };
        (Some(level), text)
    };
    let mut lines: Vec<_> = levels.map(line_of).collect();
    if far > 0 {
        lines.push((
            Some(beyond_levels(scene)),
            format!("impostors, 2 triangles: {far}"),
        ));
    }
    if drawn < shown {
        lines.push((None, format!("nearest {drawn} with their skins")));
    }
    lines
}

/// The colour of impostors: that of a level which no character has.
fn beyond_levels(scene: &ScenePlayer) -> usize {
    let levels = scene.crowds().iter().map(|crowd| crowd.asset().levels());
    levels.max().unwrap_or(0)
}
