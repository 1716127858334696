//! Properties of levels of joints and mesh that are shown together.

use crate::reference_human::asset_of_4000;
use articula_build::{Asset, Borders, attach};
use articula_build::{FigureLevels, figure_levels};
use articula_build::{JointLodOptions, MergedLevels, merged_levels};
use articula_build::{PoseOptions, poses, positions};
use articula_core::{Mesh, PosedMesh, Wrap};
use glam::Vec3;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

type Triangles = Vec<[u32; 3]>;

struct Figure {
    asset: Asset,
    merged: MergedLevels,
    /// Mesh levels, finest first.
    mesh_levels: Vec<Triangles>,
    poses: Vec<Vec<Vec3>>,
}

fn options() -> JointLodOptions {
    JointLodOptions {
        frames: 40,
        max_levels: 12,
        ..JointLodOptions::default()
    }
}

/// The reference human with mesh levels made by grid cells.
fn someone() -> &'static Figure {
    static HUMAN: OnceLock<Figure> = OnceLock::new();
    HUMAN.get_or_init(|| {
        let asset = asset_of_4000().clone();
        let opts = PoseOptions {
            shaping: 3,
            ..PoseOptions::default()
        };
        let shaping = poses(&asset, &opts).unwrap().shaping;
        Figure {
            merged: merged_levels(&asset, &options()).unwrap(),
            mesh_levels: vec![
                asset.mesh.triangles.clone(),
                clustered(&asset, 0.03),
                clustered(&asset, 0.06),
                clustered(&asset, 0.12),
            ],
            poses: positions(&asset, &shaping),
            asset,
        }
    })
}

/// Each vertex becomes the first one of its cell and part.
fn clustered(asset: &Asset, cell_metres: f32) -> Triangles {
    let mesh = &asset.mesh;
    let mut first = BTreeMap::new();
    let mut representative = vec![0; mesh.len()];
    for (p, part) in mesh.parts.iter().enumerate() {
        for v in part.vertices.clone() {
            let cell = (mesh.positions[v] / cell_metres).floor().to_array();
            representative[v] = *first.entry((p, cell.map(|x| x as i32))).or_insert(v as u32);
        }
    }
    let snapped = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| representative[v as usize]));
    snapped
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect()
}

fn slices(levels: &[Triangles]) -> Vec<&[[u32; 3]]> {
    levels.iter().map(Vec::as_slice).collect()
}

fn found(figure: &Figure) -> FigureLevels {
    let levels = slices(&figure.mesh_levels);
    figure_levels(
        &figure.asset,
        &figure.merged,
        &levels,
        &figure.poses,
        &options(),
    )
    .unwrap()
}

fn posed(asset: &Asset, mesh: &Mesh, frame: usize) -> Vec<Vec3> {
    let clip = &asset.clips[0];
    let secs = frame as f64 / f64::from(clip.rate_hz());
    let mut posed = PosedMesh::new(&asset.rig, mesh);
    let posed = posed.pose_at(clip, secs, Wrap::Clamp);
    posed.skinned(&mesh.morph_weights).positions
}

#[test]
fn nothing_grows_but_the_error_and_every_step_is_worth_it() {
    let figure = someone();
    let found = found(figure);
    let full = found.levels[0];
    assert_eq!((full.joint_level, full.mesh_level), (0, 0));
    assert_eq!((full.joints, full.cost), (figure.asset.rig.len(), 3.0));
    assert!(found.levels.len() > 5, "{:?}", found.levels);
    for pair in found.levels.windows(2) {
        let [a, b] = [&pair[0], &pair[1]];
        assert!(b.joints <= a.joints && b.triangles <= a.triangles);
        assert!(b.influences <= a.influences && b.vertices <= a.vertices);
        assert!(b.cost < a.cost);
    }
    let last = found.levels[found.levels.len() - 1];
    assert_eq!(last.mesh_level, 3, "the coarsest mesh is used");
    let clips = figure.asset.clips.len();
    found
        .merged
        .errors
        .check(clips, found.levels.len())
        .unwrap();
    assert_eq!(found.merged.joint_lods.levels(), found.levels.len());
    // Both joint and mesh levels change, and not always together.
    let changes = |of: fn(&articula_core::FigureLevel) -> usize| {
        found
            .levels
            .windows(2)
            .filter(|p| of(&p[0]) != of(&p[1]))
            .count()
    };
    assert!(changes(|l| l.joints) >= 2 && changes(|l| l.triangles) >= 2);
}

#[test]
fn what_is_stated_is_what_the_slow_way_sees() {
    let figure = someone();
    let found = found(figure);
    let (asset, levels) = (&figure.asset, slices(&figure.mesh_levels));
    let all: Vec<u32> = (0..asset.mesh.len() as u32).collect();
    let borders = Borders::of(&asset.mesh, &figure.poses[0]);
    for (l, level) in found.levels.iter().enumerate().skip(1) {
        let mesh = found.mesh(l, &asset.mesh, &levels);
        assert_eq!(mesh.triangles.len(), level.triangles);
        let parts: usize = mesh.parts.iter().map(|p| p.triangles.len()).sum();
        assert_eq!(
            (parts, mesh.influences),
            (level.triangles, level.influences)
        );
        let points = attach(&mesh.triangles, &all, &figure.poses, &mesh.parts, &borders);
        let mut worst = 0.0f32;
        for frame in (0..asset.clips[0].frames()).step_by(7) {
            let truth = posed(asset, &asset.mesh, frame);
            let shown = posed(asset, &mesh, frame);
            let apart = points
                .iter()
                .zip(&truth)
                .map(|(p, t)| p.posed(&shown).distance(*t));
            worst = worst.max(apart.fold(0.0, f32::max));
        }
        // The slow method uses a sample of the frames.
        let stated = found.merged.errors.clips[0].worst_metres[l];
        assert!(worst <= stated + 1e-5, "level {l}: {worst} of {stated}");
        let first = found.merged.errors.clips[0].worst_metres[1];
        assert!(
            l > 1 || (worst > 0.2 * stated || first < 1e-3),
            "{worst} of {stated}"
        );
    }
}

#[test]
fn without_coarser_meshes_errors_are_those_of_the_joints() {
    let figure = someone();
    let whole = slices(&figure.mesh_levels[..1]);
    let found = figure_levels(
        &figure.asset,
        &figure.merged,
        &whole,
        &figure.poses,
        &options(),
    )
    .unwrap();
    let own = &figure.merged;
    let mut compared = 0;
    for (l, level) in found.levels.iter().enumerate() {
        let skin = &own.skins.levels[level.joint_level];
        if level.influences != skin.influences {
            continue;
        }
        compared += 1;
        for (stated, joints) in found.merged.errors.clips.iter().zip(&own.errors.clips) {
            let (a, b) = (
                stated.worst_metres[l],
                joints.worst_metres[level.joint_level],
            );
            // Both are running maxima over other levels.
            assert!(a <= b + 1e-6, "level {l}: {a} m, joints alone {b} m");
        }
    }
    assert!(compared >= 2);
}

#[test]
fn one_joint_is_enough_for_levels_and_what_does_not_fit_is_refused() {
    let figure = someone();
    let asset = &figure.asset;
    let levels = slices(&figure.mesh_levels);
    let at = |mesh: &[&[[u32; 3]]], poses: &[Vec<Vec3>]| {
        figure_levels(asset, &figure.merged, mesh, poses, &options())
            .unwrap_err()
            .at
    };
    assert_eq!(at(&[], &figure.poses), "mesh_levels");
    assert_eq!(at(&levels, &[]), "poses");
    assert_eq!(at(&levels, &[vec![]]), "poses[0]");
    assert_eq!(at(&[&[], levels[0]], &figure.poses), "mesh_levels[0]");
    assert_eq!(
        at(&[&[[0, 1, u32::MAX]], levels[0]], &figure.poses),
        "mesh_levels[0]"
    );

    // All skin on the root: only the mesh can become coarser.
    let mut still = asset.clone();
    let mesh = Arc::make_mut(&mut still.mesh);
    let root = mesh.bindings.len() as u16;
    mesh.bindings.push(mesh.bindings[0]);
    mesh.binding_indices.fill(root);
    let merged = merged_levels(
        &still,
        &JointLodOptions {
            max_levels: 1,
            ..options()
        },
    )
    .unwrap();
    assert_eq!(merged.joint_lods.levels(), 1);
    let rest = vec![figure.poses[0].clone()];
    let found = figure_levels(&still, &merged, &levels, &rest, &options()).unwrap();
    assert!(found.levels.len() >= 3, "{:?}", found.levels);
    assert!(found.levels.iter().all(|l| l.joints == still.rig.len()));
}
