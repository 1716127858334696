//! Builds a portrait from a source.

use super::error::{PortraitError, refuse};
use super::flat_mesh::{FlatMesh, flat_mesh};
use super::head::Head;
use super::head::HeadPose;
use super::model::Portrait;
use super::paint_order::{Probe, Sector, sector};
use super::pose_grid::{PoseGrid, Samples};
use super::posing::{Poser, part_of, places, project};
use super::roll::{Roll, depth_steps};
use super::source::{PortraitOptions, PortraitSource};
use super::views;
use crate::projection::{Projection, Screen};
use articula_core::Progress;
use glam::Vec2;

/// Maximum yaw step between nodes of the pose grid, degrees.
const YAW_STEP: f32 = 7.5;
const PITCH_STEP: f32 = 5.0;
/// Width of a yaw range with one painting order, degrees.
const SECTOR_DEGREES: f32 = 15.0;
/// Maximum number of probe frames of all clips for a painting order.
const CLIP_PROBES: usize = 8;

/// Builds a portrait from a source.
///
/// O(nodes x expressions x vertices of the 2D mesh), plus the rendering of the views.
///
/// # Errors
/// [`PortraitError::Mismatch`] if parts of the source do not match or an option is out of range,
/// [`PortraitError::NotInView`] if a vertex is beside or behind the camera,
/// [`PortraitError::LimitExceeded`] for more than a player can show, [`PortraitError::Picture`] if
/// the viewport is too large, and [`PortraitError::Cancelled`].
pub fn build(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
    progress: &mut Progress<'_>,
) -> Result<Portrait, PortraitError> {
    source.check(options)?;
    let flat = flat_mesh(source, options)?;
    let views = views::views(source, options, &flat, &mut progress.part(0.0, 0.4))?;
    let mesh = part_of(source.mesh, &flat.vertices);
    let poser = Poser::new(&mesh, source.rig, &source.head, source.expressions);
    let samples = samples(source, options, &poser, &mut progress.part(0.4, 0.7))?;
    let grid = PoseGrid::new(&samples, options.tolerance_px);
    progress.step(0.8)?;
    let sectors = sectors(source, options, &flat, &poser)?;
    progress.step(1.0)?;
    let roll = roll(source, &poser)?;
    let viewport = source.camera.viewport;
    Ok(Portrait {
        size: (
            viewport.width_px.round() as u32,
            viewport.height_px.round() as u32,
        ),
        mesh: flat,
        views: views.views,
        layers: views.layers,
        grid,
        roll,
        sectors,
        clips: source.clips.to_vec(),
        inputs: Vec::new(),
        levels: Vec::new(),
    })
}

/// How the vertices follow a roll, from their weights and their depths at rest.
fn roll(source: &PortraitSource<'_>, poser: &Poser<'_>) -> Result<Roll, PortraitError> {
    let screen = Screen::new(&source.camera, Projection::Perspective);
    let pivot = screen.place(poser.pivot()).ok_or_else(|| {
        refuse(
            "head",
            "the pivot of the head is behind the camera; move the camera away",
        )
    })?;
    let depth = source.camera.view(poser.pivot()).z;
    let rest = HeadPose::default();
    let corners = project(&poser.skin(rest, &[]), &source.camera, rest)?;
    let tilt = |share: &f32| (share * 255.0).round() as u8;
    Ok(Roll {
        tilts: poser.shares().iter().map(tilt).collect(),
        depths: corners.iter().map(|c| depth_steps(depth, c.w)).collect(),
        blends: matches!(&source.head, Head::Joints(joints) if joints.len() == 1),
        pivot,
    })
}

/// Grid nodes from `-limit` to `limit`, including the angles of all views.
fn nodes(limit: f32, step: f32, views: impl Iterator<Item = f32>) -> Vec<f32> {
    let count = (limit / step).floor() as i32;
    let mut nodes: Vec<f32> = (-count..=count).map(|i| i as f32 * step).collect();
    nodes.extend([-limit, limit]);
    nodes.extend(views);
    nodes.sort_by(f32::total_cmp);
    nodes.dedup_by(|a, b| (*a - *b).abs() < 0.01);
    nodes
}

/// Projects all vertices at all nodes, at rest and with each expression.
fn samples(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
    poser: &Poser<'_>,
    progress: &mut Progress<'_>,
) -> Result<Samples, PortraitError> {
    let views = options.view_poses();
    let yaw_degrees = nodes(
        options.yaw_limit_degrees,
        YAW_STEP,
        views.iter().map(|v| v.yaw_degrees),
    );
    let pitch_degrees = nodes(
        options.pitch_limit_degrees,
        PITCH_STEP,
        views.iter().map(|v| v.pitch_degrees),
    );
    let mut rest = Vec::new();
    let named = source
        .expressions
        .iter()
        .map(|e| (e.name.clone(), Vec::new()));
    let mut expressions: Vec<(String, Vec<Vec<Vec2>>)> = named.collect();
    for (p, &pitch) in pitch_degrees.iter().enumerate() {
        progress.step(p as f32 / pitch_degrees.len() as f32)?;
        for &yaw in &yaw_degrees {
            let pose = HeadPose {
                yaw_degrees: yaw,
                pitch_degrees: pitch,
                roll_degrees: 0.0,
            };
            let at = |weights: &[(usize, f32)]| {
                let corners = project(&poser.skin(pose, weights), &source.camera, pose)?;
                Ok::<_, PortraitError>(places(&corners))
            };
            rest.push(at(&[])?);
            for (e, (_, places)) in expressions.iter_mut().enumerate() {
                places.push(at(&[(e, 1.0)])?);
            }
        }
    }
    Ok(Samples {
        yaw_degrees,
        pitch_degrees,
        rest,
        expressions,
    })
}

/// Computes a painting order for each yaw range.
fn sectors(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
    flat: &FlatMesh,
    poser: &Poser<'_>,
) -> Result<Vec<Sector>, PortraitError> {
    let half = (options.yaw_limit_degrees / SECTOR_DEGREES).round() as i32;
    let faces = faces(source);
    let mut sectors = Vec::new();
    for i in -half..=half {
        let middle = i as f32 * SECTOR_DEGREES;
        let mut probes: Vec<Probe> = Vec::new();
        for (yaw, pitch) in [
            (0.0, 0.0),
            (-0.45, 0.0),
            (0.45, 0.0),
            (0.0, -0.5),
            (0.0, 0.5),
        ] {
            let pose = HeadPose {
                yaw_degrees: middle + yaw * SECTOR_DEGREES,
                pitch_degrees: pitch * options.pitch_limit_degrees,
                roll_degrees: 0.0,
            };
            probes.push((pose, Vec::new()));
            if pitch == 0.0 && yaw == 0.0 {
                probes.extend(faces.iter().map(|f| (pose, f.clone())));
            }
        }
        let from = middle - 0.5 * SECTOR_DEGREES;
        sectors.push(sector(flat, poser, &source.camera, from, &probes)?);
    }
    Ok(sectors)
}

/// Expression weights of the probe poses: each expression alone, and frames of the clips.
fn faces(source: &PortraitSource<'_>) -> Vec<Vec<(usize, f32)>> {
    let mut faces: Vec<Vec<(usize, f32)>> = (0..source.expressions.len())
        .map(|e| vec![(e, 1.0)])
        .collect();
    for clip in source.clips {
        let step = clip.weights.len().div_ceil(CLIP_PROBES).max(1);
        faces.extend(clip.weights.iter().step_by(step).map(|weights| {
            let driven = weights.iter().copied().enumerate();
            driven.filter(|(_, w)| *w != 0.0).collect()
        }));
    }
    faces
}
