//! Painting orders of triangles, back to front, for ranges of yaw.
//!
//! Source: `docs/methods/vector.md` parts 4 and 10. Some poses of the range are taken as the frames
//! of one clip, which [`crate::planar::order`] orders.

use super::error::PortraitError;
use super::flat_mesh::{FlatMesh, corners_of};
use super::head::HeadPose;
use super::posing::{Poser, places, project};
use crate::planar::clip::{PlanarClip, PlanarFrame, PlanarMaterial};
use crate::planar::drawn::Drawn;
use crate::planar::order::Painting;
use articula_core::Camera;

/// A painting order from one yaw on.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Sector {
    /// Minimum yaw of the range, degrees; the first sector also applies below it.
    pub from_yaw_degrees: f32,
    /// Triangles, back to front.
    pub order: Vec<u32>,
}

/// A pose and the weights that are not zero.
pub(crate) type Probe = (HeadPose, Vec<(usize, f32)>);

/// Computes the order of one range of yaw from probe poses in it.
pub(crate) fn sector(
    flat: &FlatMesh,
    poser: &Poser<'_>,
    camera: &Camera,
    from_yaw_degrees: f32,
    probes: &[Probe],
) -> Result<Sector, PortraitError> {
    let count = flat.triangles.len();
    let mut frames = Vec::with_capacity(probes.len());
    let mut drawn = Drawn::none(probes.len(), count);
    for (f, (pose, weights)) in probes.iter().enumerate() {
        let corners = project(&poser.skin(*pose, weights), camera, *pose)?;
        let xy = places(&corners);
        for (t, triangle) in flat.triangles.iter().enumerate() {
            drawn.set(f, t, FlatMesh::shows(corners_of(&xy, *triangle)));
        }
        frames.push(PlanarFrame {
            nearness: corners.iter().map(|c| c.z / c.w).collect(),
            light: vec![1.0; xy.len()],
            xy,
        });
    }
    let clip = PlanarClip {
        width: camera.viewport.width_px.round() as u32,
        height: camera.viewport.height_px.round() as u32,
        fps: 1.0,
        frames,
        triangles: flat.triangles.clone(),
        surface: vec![0; count],
        part: vec![0; count],
        surfaces: vec![PlanarMaterial {
            name: String::new(),
            albedo: None,
        }],
        albedo: vec![[255.0; 3]; flat.vertices.len()],
        texture: None,
    };
    let painting = Painting::single(&clip, &drawn)?;
    let painted = painting.order_at(0);
    let mut is_painted = vec![false; count];
    painted.iter().for_each(|t| is_painted[*t as usize] = true);
    // What no probe shows lies at the edge of what is visible: behind all others.
    let mut order: Vec<u32> = (0..count as u32)
        .filter(|t| !is_painted[*t as usize])
        .collect();
    order.extend(painted);
    Ok(Sector {
        from_yaw_degrees,
        order,
    })
}
