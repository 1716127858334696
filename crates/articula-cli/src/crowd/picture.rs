//! A moment of a crowd as its camera sees it, every character in the colour of its level.

use super::stage::{Settings, Stage};
use anyhow::Context;
use articula::crowd::{Allowance, CrowdAsset, CrowdPlayer, DetailGoal, PoseSource};
use articula_build::scene::Scene;
use articula_core::source::Material;
use articula_core::{Camera, Mesh, Part, SkinnedMesh, Viewport, skin};
use articula_flat::Appearance;
use articula_flat::{Ground, Picture};
use articula_flat::{RenderOptions, render};
use articula_flat::{Rgba, linear_table};
use articula_report::TextStyle;
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// Most triangles that are drawn; who is farther away than they reach is left out.
const MOST_TRIANGLES: usize = 4_000_000;

/// Colours of the levels, from every joint to the fewest: dark blue over green to yellow and red.
const COLORS: [Rgba; 8] = [
    [58, 76, 160, 255],
    [52, 120, 190, 255],
    [42, 160, 170, 255],
    [70, 175, 110, 255],
    [150, 190, 70, 255],
    [225, 190, 60, 255],
    [235, 140, 60, 255],
    [215, 85, 75, 255],
];

/// Colour of a level.
pub(crate) fn color(level: usize) -> Rgba {
    COLORS[level.min(COLORS.len() - 1)]
}

/// Draws the scene at its beginning.
pub(crate) fn draw(
    asset: &CrowdAsset,
    scene: &Scene,
    settings: Settings,
    size: (u32, u32),
) -> anyhow::Result<Picture> {
    let mut stage = Stage::new(asset, scene, settings)?;
    let allowance = match settings.detail {
        DetailGoal::Budget { ms, .. } => Some(Allowance::of_ns(1e6 * ms)),
        _ => None,
    };
    stage.plan(0.0, allowance.as_ref())?;
    stage.evaluate();
    let (player, camera) = (stage.scene.player(), stage.scene.camera()?);
    let (mesh, skinned) = gathered(player, &camera);
    let camera = Camera {
        viewport: Viewport {
            width_px: size.0 as f32,
            height_px: size.1 as f32,
            ..camera.viewport
        },
        ..camera
    };
    let (look, _) = Appearance::new(&materials(asset.levels()), &[]);
    let middle = camera.eye + camera.forward() * 30.0;
    let options = RenderOptions {
        ground: Some(Ground {
            height_m: 0.0,
            middle: Vec2::new(middle.x, middle.z),
            radius_m: 80.0,
        }),
        ..RenderOptions::default()
    };
    let picture = render(&mesh, &skinned, &look, &camera, &options);
    let mut picture = picture.context("drawing the crowd")?;
    write_legend(&mut picture, player, mesh.parts.len());
    Ok(picture)
}

fn materials(levels: usize) -> Vec<Material> {
    let table = linear_table();
    let linear = |c: Rgba| Vec4::from([0, 1, 2, 3].map(|i| table[usize::from(c[i])]));
    let of_level = |level| Material {
        base_color: linear(color(level)),
        ..Material::default()
    };
    (0..levels).map(of_level).collect()
}

/// The skins of all who are shown, nearest first, as one mesh in the world.
fn gathered(player: &CrowdPlayer, camera: &Camera) -> (Mesh, SkinnedMesh) {
    let asset = player.asset();
    let sources = player.sources();
    let shown = sources.iter().enumerate();
    let mut draws: Vec<(f32, usize, &PoseSource)> = shown
        .filter_map(|(c, source)| Some((c, source.as_ref()?)))
        .map(|(c, source)| (camera.eye.distance(player.positions()[c]), c, source))
        .collect();
    draws.sort_by(|a, b| a.0.total_cmp(&b.0));
    draws.truncate((MOST_TRIANGLES / asset.full().mesh.triangles.len().max(1)).max(1));
    let mut mesh = Mesh {
        influences: 1,
        ..Mesh::default()
    };
    let mut all = SkinnedMesh::default();
    let mut matrices = Vec::new();
    for (_, character, source) in draws {
        let Some(level) = player.crowd().level(character) else {
            continue;
        };
        player.skin_matrices(level, source, &mut matrices);
        let world = player.world_from_model(character);
        append(
            (&mut mesh, &mut all),
            asset.mesh(level),
            level,
            &matrices,
            &world,
        );
    }
    (mesh, all)
}

/// Adds one character.
fn append(
    (mesh, all): (&mut Mesh, &mut SkinnedMesh),
    own: &Mesh,
    level: usize,
    matrices: &[Affine3A],
    world: &Affine3A,
) {
    let mut skinned = SkinnedMesh::new(own);
    skin(own, matrices, &own.morph_weights, &mut skinned);
    let (first, triangle) = (all.positions.len(), mesh.triangles.len());
    let place = |p: &Vec3| world.transform_point3(*p);
    let turn = |n: &Vec3| world.transform_vector3(*n);
    all.positions.extend(skinned.positions.iter().map(place));
    all.normals.extend(skinned.normals.iter().map(turn));
    mesh.positions.extend_from_slice(&own.positions);
    mesh.normals.extend_from_slice(&own.normals);
    mesh.texcoords.extend_from_slice(&own.texcoords);
    mesh.colors.resize(mesh.positions.len(), Vec4::ONE);
    let moved = |t: &[u32; 3]| t.map(|v| v + first as u32);
    mesh.triangles.extend(own.triangles.iter().map(moved));
    mesh.parts.push(Part {
        name: String::new(),
        mesh: 0,
        material: Some(level),
        vertices: first..mesh.positions.len(),
        triangles: triangle..mesh.triangles.len(),
    });
}

/// Says which colour is which level, how many are shown at it, and how many of all are drawn.
fn write_legend(picture: &mut Picture, player: &CrowdPlayer, drawn: usize) {
    let style = TextStyle::default();
    let line = style.height() as i32 + 6;
    let asset = player.asset();
    let count = player.positions().len();
    let mut levels = vec![0; asset.levels()];
    for level in (0..count).filter_map(|c| player.crowd().level(c)) {
        levels[level] += 1;
    }
    let shown: usize = levels.iter().sum();
    let levels: Vec<(usize, usize)> = levels.into_iter().enumerate().filter(|l| l.1 > 0).collect();
    let mut y = 8;
    let paper = [255, 255, 255, 255];
    let line_of = |(level, count): &(usize, usize)| {
        let made = asset.level(*level);
        let joints = made.joints;
        if asset.has_mesh_lods() {
            format!("{joints} joints, {} triangles: {count}", made.triangles)
        } else {
            format!("{joints} joints: {count}")
        }
    };
    let mut lines: Vec<String> = levels.iter().map(line_of).collect();
    if drawn < shown {
        lines.push(format!("nearest {drawn} drawn"));
    }
    let width = lines.iter().map(|l| style.width(l)).max().unwrap_or(0) + 40;
    let height = (lines.len() as i32 * line + 10).unsigned_abs();
    picture.draw_box(4, 4, width, height, paper);
    for (i, text) in lines.iter().enumerate() {
        if let Some((level, _)) = levels.get(i) {
            picture.draw_box(12, y + 3, 14, 14, color(*level));
        }
        picture.draw_text(34, y, text, style, [30, 34, 44, 255]);
        y += line;
    }
}
