//! Renders a portrait in a pose as the player does, without a browser.
//!
//! Triangles are painted in order, each with the affine map from each view into the pose; views are
//! blended in sRGB by their weights, as on a canvas. 4 x 4 samples per pixel.

use super::error::{PortraitError, refuse};
use super::flat_mesh::{FlatMesh, corners_of, front_area};
use super::head::HeadPose;
use super::sealing::{OVERLAP_PX, UNDERLAP_PX, sealed};
use super::view_weights::{nearness, view_weights};
use super::{Portrait, views::View};
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use crate::picture::{Picture, Rgba};
use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};

/// Minimum weight of a view that is painted.
pub(super) const MIN_WEIGHT: f32 = 0.03;
/// Twice the area of a triangle in a view below which it is a sliver, square pixels.
const SLIVER: f32 = 0.1;

/// Colour source of one triangle: the views that contribute, each with its weight and the map from
/// the portrait to the view's picture.
#[derive(Debug, Clone, PartialEq, Default)]
struct Paint {
    taken: Vec<(usize, f32, Affine2)>,
}

impl Portrait {
    /// Returns the picture of a head pose and expression weights, with a transparent background.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if an angle or weight is not finite, or there are more weights
    /// than expressions.
    pub fn picture(&self, pose: &HeadPose, weights: &[f32]) -> Result<Picture, PortraitError> {
        self.picture_at(&self.places(pose, weights)?, pose)
    }

    /// Picture for vertex positions that the caller projected (those of
    /// [`super::flat_mesh::FlatMesh::vertices`]); the pose selects order and views.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if the number of positions differs from the number of vertices,
    /// or one is not finite.
    pub(crate) fn picture_at(
        &self,
        places: &[Vec2],
        pose: &HeadPose,
    ) -> Result<Picture, PortraitError> {
        let count = self.mesh.vertices.len();
        if places.len() != count || places.iter().any(|p| !p.is_finite()) || !pose.is_finite() {
            let what = format!(
                "{} positions for {count} vertices; the numbers must match and all values be \
                 finite",
                places.len()
            );
            return Err(refuse("places", what));
        }
        let (paints, buffer) = self.painted(places, pose)?;
        let mut picture = Picture::new(self.size.0, self.size.1, [0; 4])?;
        for y in 0..self.size.1 {
            for x in 0..self.size.0 {
                if !buffer.is_blank(x, y) {
                    picture.set(x, y, self.pixel(&buffer, &paints, x, y));
                }
            }
        }
        Ok(picture)
    }

    /// The triangle of each sample, and the colour source of each triangle.
    fn painted(
        &self,
        places: &[Vec2],
        pose: &HeadPose,
    ) -> Result<(Vec<Paint>, ItemBuffer), PortraitError> {
        let order = self.order(pose.yaw_degrees);
        let mut rank = vec![0; self.mesh.triangles.len()];
        for (i, t) in order.iter().enumerate() {
            rank[*t as usize] = i;
        }
        let corners = |t: usize| corners_of(places, self.mesh.triangles[t]);
        let shown: Vec<bool> = (0..self.mesh.triangles.len())
            .map(|t| FlatMesh::shows(corners(t)))
            .collect();
        let neighbours = self.mesh.neighbours();
        let sources = self.view_places()?;
        let poses: Vec<HeadPose> = self.views.iter().map(|v| v.pose).collect();
        let near = nearness(&poses, pose);
        let mut buffer = ItemBuffer::new(self.size.0, self.size.1, Supersampling::Four)?;
        let mut paints = vec![Paint::default(); self.mesh.triangles.len()];
        for (i, t) in order.iter().map(|t| *t as usize).enumerate() {
            if !shown[t] {
                continue;
            }
            let reach = |n: Option<u32>| match n.map(|n| n as usize).filter(|n| shown[*n]) {
                Some(n) if rank[n] > rank[t] => UNDERLAP_PX,
                Some(_) => OVERLAP_PX,
                None => 0.0,
            };
            paints[t] = self.paint(t, corners(t), &sources, &near);
            // Later triangles are nearer, regardless of depth.
            let grown = sealed(corners(t), neighbours[t].map(reach));
            let flat = grown.map(|p| Vec4::new(p.x, p.y, i as f32, 1.0));
            buffer.draw(t as u32, flat, Faces::Both);
        }
        Ok((paints, buffer))
    }

    /// Screen positions of all vertices in each view.
    pub(crate) fn view_places(&self) -> Result<Vec<Vec<Vec2>>, PortraitError> {
        self.views
            .iter()
            .map(|v| self.places(&v.pose, &[]))
            .collect()
    }

    fn paint(
        &self,
        triangle: usize,
        corners: [Vec2; 3],
        sources: &[Vec<Vec2>],
        near: &[f32],
    ) -> Paint {
        let of = |places: &Vec<Vec2>| corners_of(places, self.mesh.triangles[triangle]);
        let areas: Vec<f32> = sources.iter().map(|s| front_area(of(s))).collect();
        let seen = self.layers.seen(triangle);
        let weights = view_weights(&areas, &seen, near, front_area(corners));
        let mut taken = Vec::new();
        for (view, weight) in weights
            .iter()
            .enumerate()
            .filter(|(_, w)| **w >= MIN_WEIGHT)
        {
            let layer = usize::from(self.layers.of_view[view][triangle]);
            let Some([x, y]) = self.views[view].shifts.get(layer) else {
                continue;
            };
            let shift = Vec2::new(*x as f32, *y as f32);
            let there = of(&sources[view]).map(|p| p + shift);
            if let Some(map) = affine(corners, there) {
                taken.push((view, *weight, map));
            }
        }
        Paint { taken }
    }

    fn pixel(&self, buffer: &ItemBuffer, paints: &[Paint], x: u32, y: u32) -> Rgba {
        let n = buffer.samples().per_side();
        let mut sum = Vec4::ZERO;
        for sample_y in y * n..(y + 1) * n {
            for sample_x in x * n..(x + 1) * n {
                let Some(t) = buffer.item(sample_x, sample_y) else {
                    continue;
                };
                let at = buffer.position(sample_x, sample_y);
                sum += self.color(&paints[t as usize], at);
            }
        }
        if sum.w <= 0.0 {
            return [0; 4];
        }
        let color = (sum.truncate() / sum.w).to_array();
        let [r, g, b] = color.map(|v| v.round().clamp(0.0, 255.0) as u8);
        let alpha = sum.w / (n * n) as f32 * 255.0;
        [r, g, b, alpha.round().clamp(0.0, 255.0) as u8]
    }

    /// Colour of a triangle at a position, multiplied by its coverage.
    fn color(&self, paint: &Paint, at: Vec2) -> Vec4 {
        let mut sum = Vec4::ZERO;
        for (view, weight, map) in &paint.taken {
            sum += texel(&self.views[*view], map.transform_point2(at)) * *weight;
        }
        if sum.w > 0.0 { sum / sum.w } else { Vec4::ZERO }
    }
}

/// Map from a triangle of the portrait to the one in a view's picture. A sliver in the view has no
/// direction across: it gives the colours around its centre. `None` if the portrait's triangle is a
/// sliver.
fn affine(from: [Vec2; 3], to: [Vec2; 3]) -> Option<Affine2> {
    let edges = |p: [Vec2; 3]| Mat2::from_cols(p[1] - p[0], p[2] - p[0]);
    let before = edges(from);
    if before.determinant().abs() < 1e-6 {
        return None;
    }
    let after = edges(to);
    if after.determinant().abs() < SLIVER {
        let middle = |p: [Vec2; 3]| (p[0] + p[1] + p[2]) / 3.0;
        let matrix = Mat2::from_diagonal(Vec2::splat(0.125));
        return Some(Affine2 {
            matrix2: matrix,
            translation: middle(to) - matrix * middle(from),
        });
    }
    let matrix = after * before.inverse();
    Some(Affine2 {
        matrix2: matrix,
        translation: to[0] - matrix * from[0],
    })
}

/// Colour at a position in a view's picture, bilinear over the pixels that show anything.
fn texel(view: &View, at: Vec2) -> Vec4 {
    let picture = &view.picture;
    let most = Vec2::new(picture.width() as f32, picture.height() as f32) - 1.0;
    let place = (at - 0.5).clamp(Vec2::ZERO, most.max(Vec2::ZERO));
    let corner = place.floor();
    let blend = place - corner;
    let (x, y) = (corner.x as u32, corner.y as u32);
    let mut sum = Vec4::ZERO;
    for (dx, dy, share) in [
        (0, 0, (1.0 - blend.x) * (1.0 - blend.y)),
        (1, 0, blend.x * (1.0 - blend.y)),
        (0, 1, (1.0 - blend.x) * blend.y),
        (1, 1, blend.x * blend.y),
    ] {
        if let Some([r, g, b, a]) = picture.get(x + dx, y + dy) {
            let color = Vec3::new(f32::from(r), f32::from(g), f32::from(b));
            sum += color.extend(1.0) * (share * f32::from(a) / 255.0);
        }
    }
    if sum.w > 0.0 { sum / sum.w } else { Vec4::ZERO }
}
