//! A talking face in 2D that can turn its head: warped view pictures of a 3D figure.
//!
//! Source: `spec/vector.md` part 10; thesis 4.1 (a 2D mesh over a portrait, driven by face
//! parameters) and annex C (which of them it supports). What differs: the head turns, what is
//! behind (teeth, tongue, eyes under lids) is found rather than drawn by hand, and every shape
//! of the face moves in all views.
//!
//! - [`source`]: figure, head, expressions, options; [`clip`]: motions to carry along
//! - [`flat_mesh`]: the 2D mesh; [`visibility`]: its layers in each view
//! - [`views`]: the view pictures; [`view_weights`]: how much each counts for a triangle
//! - [`pose_grid`]: where vertices are for any turn, nod and expression
//! - [`paint_order`]: back to front for a range of turns; [`sealing`]: no gap between neighbours
//! - [`raster`]: the picture of a pose, without a browser; [`evaluate`]: how far it is from a
//!   render of the 3D figure
//! - [`document`]: JSON and pictures; [`page`]: one HTML page with its player

pub mod clip;
pub mod document;
pub mod error;
pub mod evaluate;
pub mod flat_mesh;
mod low_rank;
pub mod page;
pub mod paint_order;
pub mod pose_grid;
mod posing;
pub mod raster;
pub mod sealing;
pub mod source;
pub mod view_weights;
pub mod views;
pub mod visibility;

#[cfg(test)]
mod tests;

pub use clip::PortraitClip;
pub use error::PortraitError;
pub use source::{
    Head, HeadPose, JointTurn, LightFollows, PortraitExpression, PortraitOptions, PortraitSource,
};

use crate::projection::{Projection, Screen};
use error::refuse;
use flat_mesh::{FlatMesh, flat_mesh};
use glam::Vec2;
use paint_order::{Probe, Sector, sector};
use pose_grid::{PoseGrid, Samples};
use posing::{Poser, part_of, places, project};
use views::View;
use visibility::Layers;

/// Step between nodes of the pose grid, degrees.
const YAW_STEP: f32 = 7.5;
const PITCH_STEP: f32 = 10.0;
/// Width of a range of turns with one painting order, degrees.
const SECTOR_DEGREES: f32 = 15.0;
/// Most moments of its clips that a painting order looks at.
const CLIP_PROBES: usize = 8;

/// A talking face in 2D.
#[derive(Debug, Clone, PartialEq)]
pub struct Portrait {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its triangles.
    pub mesh: FlatMesh,
    /// The view pictures, the front first.
    pub views: Vec<View>,
    /// Where each triangle lies in them.
    pub layers: Layers,
    /// Where vertices are.
    pub grid: PoseGrid,
    /// How much of a tilt each vertex takes part in, 0 to 255.
    pub tilts: Vec<u8>,
    /// The place that stays when the head tilts, pixels.
    pub pivot: Vec2,
    /// Painting orders, by rising turn.
    pub sectors: Vec<Sector>,
    /// Motions.
    pub clips: Vec<PortraitClip>,
}

/// Makes a portrait.
///
/// O(nodes x expressions x vertices of the 2D mesh), plus the rendering of the views.
///
/// # Errors
/// [`PortraitError::Mismatch`] if parts of the source do not fit each other or an option is out
/// of range, [`PortraitError::NotInView`] if a vertex is beside or behind the camera,
/// [`PortraitError::LimitExceeded`] for more than a player can show, and
/// [`PortraitError::Picture`] if the viewport is too large.
pub fn build(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
) -> Result<Portrait, PortraitError> {
    source.check(options)?;
    let flat = flat_mesh(source, options)?;
    let views = views::views(source, options, &flat)?;
    let mesh = part_of(source.mesh, &flat.vertices);
    let poser = Poser::new(&mesh, source.rig, &source.head, source.expressions);
    let samples = samples(source, options, &poser)?;
    let grid = PoseGrid::new(&samples, options.tolerance_px);
    let sectors = sectors(source, options, &flat, &poser)?;
    let screen = Screen::new(&source.camera, Projection::Perspective);
    let pivot = screen.place(poser.pivot()).ok_or_else(|| {
        refuse(
            "head",
            "the point about which the head turns is behind the camera",
        )
    })?;
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
        tilts: poser
            .shares()
            .iter()
            .map(|s| (s * 255.0).round() as u8)
            .collect(),
        pivot,
        sectors,
        clips: source.clips.to_vec(),
    })
}

impl Portrait {
    /// Places of all vertices in pixels. One weight for each expression; missing ones are 0.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if an angle or weight is no number, or there are more weights
    /// than expressions.
    pub fn places(&self, pose: &HeadPose, weights: &[f32]) -> Result<Vec<Vec2>, PortraitError> {
        if !pose.is_finite() {
            return Err(refuse("pose", "an angle is no number"));
        }
        if let Some(w) = weights.iter().position(|w| !w.is_finite()) {
            return Err(refuse(format!("weights[{w}]"), "is no number"));
        }
        if weights.len() > self.grid.expressions.len() {
            let (found, most) = (weights.len(), self.grid.expressions.len());
            return Err(refuse("weights", format!("{found} for {most} expressions")));
        }
        let mut places = self.grid.places(pose, weights);
        if pose.roll_degrees != 0.0 {
            for (place, tilt) in places.iter_mut().zip(&self.tilts) {
                // The picture's y points down, so counter-clockwise is a negative angle.
                let angle = -pose.roll_degrees.to_radians() * f32::from(*tilt) / 255.0;
                *place = self.pivot + Vec2::from_angle(angle).rotate(*place - self.pivot);
            }
        }
        Ok(places)
    }

    /// The painting order for a turn.
    pub fn order(&self, yaw_degrees: f32) -> &[u32] {
        let after = self
            .sectors
            .partition_point(|s| s.from_yaw_degrees <= yaw_degrees);
        self.sectors
            .get(after.saturating_sub(1))
            .map_or(&[], |s| &s.order)
    }
}

/// Nodes from `-limit` to `limit`, through all views.
fn nodes(limit: f32, step: f32, views: impl Iterator<Item = f32>) -> Vec<f32> {
    let count = (limit / step).floor() as i32;
    let mut nodes: Vec<f32> = (-count..=count).map(|i| i as f32 * step).collect();
    nodes.extend([-limit, limit]);
    nodes.extend(views);
    nodes.sort_by(f32::total_cmp);
    nodes.dedup_by(|a, b| (*a - *b).abs() < 0.01);
    nodes
}

/// Projects all vertices at all nodes, at rest and under each expression.
fn samples(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
    poser: &Poser<'_>,
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
    for &pitch in &pitch_degrees {
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

/// A painting order for each range of turns.
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

/// Faces that an order is told by: each expression, and moments of the clips.
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
