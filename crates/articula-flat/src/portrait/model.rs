//! The portrait itself: a 2D mesh, its view pictures, and where its vertices are.

use super::clip::PortraitClip;
use super::error::{PortraitError, refuse};
use super::flat_mesh::FlatMesh;
use super::head::HeadPose;
use super::paint_order::Sector;
use super::pose_grid::PoseGrid;
use super::views::View;
use super::visibility::Layers;
use glam::Vec2;

/// A talking face in 2D.
#[derive(Debug, Clone, PartialEq)]
pub struct Portrait {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its triangles.
    pub(crate) mesh: FlatMesh,
    /// The view pictures, the front first.
    pub(crate) views: Vec<View>,
    /// Where each triangle lies in them.
    pub(crate) layers: Layers,
    /// Where vertices are.
    pub(crate) grid: PoseGrid,
    /// How much of a tilt each vertex takes part in, 0 to 255.
    pub(crate) tilts: Vec<u8>,
    /// The place that stays when the head tilts, pixels.
    pub(crate) pivot: Vec2,
    /// Painting orders, by rising turn.
    pub(crate) sectors: Vec<Sector>,
    /// Motions.
    pub clips: Vec<PortraitClip>,
}

/// How much a portrait holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortraitCounts {
    /// View pictures.
    pub views: usize,
    /// Triangles of the 2D mesh.
    pub triangles: usize,
    /// Vertices of the 2D mesh.
    pub vertices: usize,
    /// Shapes of the face that can be driven.
    pub expressions: usize,
}

impl Portrait {
    /// How much of everything there is.
    pub fn counts(&self) -> PortraitCounts {
        PortraitCounts {
            views: self.views.len(),
            triangles: self.mesh.triangles.len(),
            vertices: self.mesh.vertices.len(),
            expressions: self.grid.expressions.len(),
        }
    }

    /// Places of all vertices in pixels. One weight for each expression; missing ones are 0.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if an angle or weight is no number, or there are more weights
    /// than expressions.
    pub(crate) fn places(
        &self,
        pose: &HeadPose,
        weights: &[f32],
    ) -> Result<Vec<Vec2>, PortraitError> {
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
    pub(crate) fn order(&self, yaw_degrees: f32) -> &[u32] {
        let after = self
            .sectors
            .partition_point(|s| s.from_yaw_degrees <= yaw_degrees);
        self.sectors
            .get(after.saturating_sub(1))
            .map_or(&[], |s| &s.order)
    }
}
