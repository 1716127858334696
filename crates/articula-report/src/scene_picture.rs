//! A picture of a scene that is played: its characters as they look, and in the colours of their levels.

use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use crate::crowd::{CrowdColors, CrowdLook, CrowdPicture};
use articula::core::source::Character;
use articula::core::{Camera, Viewport};
use articula::crowd::{CrowdPlayer, ImpostorDraw, PoseSource, ScenePlayer};
use articula::flat::Picture;
use glam::Vec3;

/// Number of triangles of skins, farther than which figures are thinned to a fraction of their size.
const MANY_TRIANGLES: usize = 8_000_000;
/// This fraction of the radius of a figure.
const COARSE: f32 = 0.25;
/// Width of the cells to which figures are thinned, pixels.
const CELL_PX: f32 = 0.5;
/// Radius in pixels below which a figure is thinned.
const SMALL_PX: f32 = 100.0;

/// Draws the evaluated frame of a scene under a title and notes: each view in the colours of the
/// characters, and below in those of their levels, with the number of characters of each. Pictures are of
/// a size in pixels. `characters` are those of the scene's crowds.
///
/// # Errors
/// [`Error::Unsupported`](articula::Error::Unsupported) if a view has no camera, or a picture error if
/// the size is too large.
///
/// # Panics
/// If there are fewer characters than crowds, or one belongs to another crowd.
pub fn scene_picture(
    scene: &ScenePlayer,
    characters: &[&Character],
    (width, height): (u32, u32),
    (title, notes): (&str, Vec<String>),
) -> articula::Result<Picture> {
    let look = CrowdLook::new(characters);
    let legend = legend(scene);
    let mut sheet = ContactSheet {
        title: title.to_owned(),
        notes,
        ..ContactSheet::default()
    };
    for camera in scene.cameras()? {
        let camera = Camera {
            viewport: Viewport {
                width_px: width as f32,
                height_px: height as f32,
                ..camera.viewport
            },
            ..camera
        };
        let mut crowd = gathered(scene, &look, &camera);
        for wall in &scene.scene().walls {
            crowd.add_wall(wall.centre, 0.5 * wall.size, wall.yaw_radians);
        }
        // The colours mean the same in all views.
        let legend = if sheet.rows.is_empty() {
            &legend[..]
        } else {
            &[]
        };
        for colors in [CrowdColors::Own(&look), CrowdColors::Levels(legend)] {
            sheet.rows.push(SheetRow {
                label: String::new(),
                cells: vec![SheetCell::of(crowd.draw(&camera, colors)?, "")],
            });
        }
    }
    Ok(sheet.draw()?)
}

/// How a character is shown.
enum Shown<'a> {
    Posed(&'a PoseSource),
    Impostor(ImpostorDraw),
}

/// The skins of all visible characters, of the distant ones as far as pixels tell.
fn gathered(scene: &ScenePlayer, look: &CrowdLook, camera: &Camera) -> CrowdPicture {
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
    let (mut picture, mut triangles) = (CrowdPicture::default(), 0);
    let mut matrices = Vec::new();
    let across = camera.orientation * Vec3::X;
    for (distance_m, crowd, character, shown) in draws {
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
        let clip = player.crowd().state(character).clip_state().clip();
        let bound = asset.model().parts().bounds.clips[clip].whole().sphere;
        let centre = world.transform_point3(bound.centre);
        let radius = bound.radius * player.scale(character);
        let pixel_m = 1.0 / camera.viewport.pixels_per_metre(distance_m);
        let cell_m = match triangles > MANY_TRIANGLES {
            true => COARSE * radius,
            false if radius < SMALL_PX * pixel_m => CELL_PX * pixel_m,
            false => 0.0,
        };
        match shown {
            Shown::Posed(source) => player.skin_matrices(level, source, &mut matrices),
            Shown::Impostor(draw) => player.impostor_matrices(draw, camera.eye, &mut matrices),
        }
        let pose = (&matrices[..], &world);
        let added = picture.add((mesh, crowd), level, pose, (look, cell_m));
        if added == 0 {
            picture.add_far(level, centre, radius, across);
        }
        triangles += added;
    }
    picture
}

/// The legend: the colour and number of characters of each level. Where the levels belong to several
/// characters, what they keep is left out.
fn legend(scene: &ScenePlayer) -> Vec<(usize, String)> {
    let mut levels = vec![0; beyond_levels(scene)];
    let mut far = 0;
    for player in scene.crowds() {
        for level in (0..player.positions().len()).filter_map(|c| player.crowd().level(c)) {
            levels[level] += 1;
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
        (level, text)
    };
    let mut lines: Vec<_> = levels.map(line_of).collect();
    if far > 0 {
        lines.push((
            beyond_levels(scene),
            format!("impostors, 2 triangles: {far}"),
        ));
    }
    lines
}

/// The colour of impostors: that of a level which no character has.
fn beyond_levels(scene: &ScenePlayer) -> usize {
    let levels = scene.crowds().iter().map(|crowd| crowd.asset().levels());
    levels.max().unwrap_or(0)
}
