//! The portrait: a 2D mesh, its view pictures, and the positions of its vertices.

use super::clip::PortraitClip;
use super::error::{PortraitError, refuse};
use super::flat_mesh::FlatMesh;
use super::head::HeadPose;
use super::paint_order::Sector;
use super::pose_grid::PoseGrid;
use super::roll::Roll;
use super::views::View;
use super::visibility::Layers;
use glam::Vec2;

/// A talking 2D face that turns its head.
#[derive(Debug, Clone, PartialEq)]
pub struct Portrait {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The 2D mesh.
    pub(crate) mesh: FlatMesh,
    /// View pictures, the front first.
    pub(crate) views: Vec<View>,
    /// Layer of each triangle in each view.
    pub(crate) layers: Layers,
    /// Positions of the vertices by head angle and expression.
    pub(crate) grid: PoseGrid,
    /// How the vertices follow a roll.
    pub(crate) roll: Roll,
    /// Painting orders, ascending by yaw.
    pub(crate) sectors: Vec<Sector>,
    /// Motions of the portrait.
    pub clips: Vec<PortraitClip>,
    /// What it can be driven by besides its expressions.
    pub inputs: Vec<PortraitInput>,
    /// What the player leaves out at coarser levels of articulation, the finest first.
    pub levels: Vec<PortraitLevel>,
}

/// What becomes of facial animation parameters and expressions at a level of articulation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortraitLevel {
    /// Name of the level.
    pub name: String,
    /// For each parameter, from the first on, the one whose value it has: itself, another one, or 0 where it is neutral.
    pub faps: Vec<u8>,
    /// The same for each expression, by its index; `None` where it is neutral. Those of a face animation table follow
    /// their parameters.
    pub expressions: Vec<Option<u16>>,
}

/// A name by which a portrait is driven that is not one of its expressions, such as a blend shape or a
/// viseme: it stands for facial animation parameters, which expressions show.
#[derive(Debug, Clone, PartialEq)]
pub struct PortraitInput {
    /// Name of the input.
    pub name: String,
    /// Numbers of the parameters, and their values in their units at weight 1.
    pub faps: Vec<(u8, f32)>,
}

/// Numbers of views, triangles, vertices and expressions of a portrait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortraitCounts {
    /// Number of view pictures.
    pub views: usize,
    /// Number of triangles of the 2D mesh.
    pub triangles: usize,
    /// Number of vertices of the 2D mesh.
    pub vertices: usize,
    /// Number of expressions.
    pub expressions: usize,
}

impl Portrait {
    /// Returns the numbers of views, triangles, vertices and expressions.
    pub fn counts(&self) -> PortraitCounts {
        PortraitCounts {
            views: self.views.len(),
            triangles: self.mesh.triangles.len(),
            vertices: self.mesh.vertices.len(),
            expressions: self.grid.expressions.len(),
        }
    }

    /// Returns the vertex of the figure's mesh that each vertex of the 2D mesh is.
    pub fn vertices(&self) -> &[u32] {
        &self.mesh.vertices
    }

    /// Returns the positions of all vertices in pixels. One weight per expression; missing ones are 0.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if an angle or weight is not finite, or there are more weights
    /// than expressions.
    pub fn places(&self, pose: &HeadPose, weights: &[f32]) -> Result<Vec<Vec2>, PortraitError> {
        if !pose.is_finite() {
            return Err(refuse("pose", "the angles must be finite"));
        }
        if let Some(w) = weights.iter().position(|w| !w.is_finite()) {
            return Err(refuse(format!("weights[{w}]"), "must be finite"));
        }
        if weights.len() > self.grid.expressions.len() {
            let (found, most) = (weights.len(), self.grid.expressions.len());
            return Err(refuse(
                "weights",
                format!("{found} weights for {most} expressions"),
            ));
        }
        let mut places = self.grid.places(pose, weights);
        if pose.roll_degrees != 0.0 {
            let (width, height) = self.size;
            let middle = 0.5 * Vec2::new(width as f32, height as f32);
            self.roll.turn(&mut places, pose.roll_degrees, middle);
        }
        Ok(places)
    }

    /// Painting order for a yaw.
    pub(crate) fn order(&self, yaw_degrees: f32) -> &[u32] {
        let after = self
            .sectors
            .partition_point(|s| s.from_yaw_degrees <= yaw_degrees);
        self.sectors
            .get(after.saturating_sub(1))
            .map_or(&[], |s| &s.order)
    }
}
