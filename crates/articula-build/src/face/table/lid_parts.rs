//! Lids that are parts of their own, beside the skin: sheets on the eyeball.

use super::super::points::{FacePoints, FaceSurface, FrontGrid, FrontView};
use super::eye_shape::EyeShape;
use glam::Vec3;
use std::collections::BTreeMap;

/// Distances of such a part from the centre of the eye, by the radius of the eye: lashes reach farther.
const NEAR: std::ops::Range<f32> = 0.95..1.4;
/// Shares of the opening of the skin that it covers: a shell or a film of tears covers all or a little of it.
const COVERS: std::ops::Range<f32> = 0.12..0.9;
/// Least height of it, and least distance of its outer side, by that radius: a film of tears is lower, or lies on the eye.
const TALL: f32 = 0.5;
const THICK: f32 = 1.07;

/// The triangles of the lids of an eye that are parts of their own: `grid` are the cells of a view, `ball` the depths of
/// the eyeball in them, if there is one, and `region` those of the opening of the skin.
pub(super) fn lid_parts(
    surface: &FaceSurface,
    points: &FacePoints,
    shape: &EyeShape,
    (grid, ball): (FrontGrid, Option<&[f32]>),
    region: &[usize],
) -> Vec<[u32; 3]> {
    let Some(ball) = ball else {
        return Vec::new();
    };
    let at = |v: u32| surface.positions[v as usize];
    let radius = shape.radius(Vec3::Y);
    let is_near = |v: &u32| NEAR.contains(&(at(*v).distance(shape.centre) / radius));
    let is_lid = |part: &Vec<[u32; 3]>| {
        let vertices = || part.iter().flatten();
        let heights = vertices().map(|v| at(*v).y);
        let [low, high] = heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], y| {
            [low.min(y), high.max(y)]
        });
        let reaches = |v: &u32| at(*v).distance(shape.centre) > THICK * radius;
        let is_sheet = high - low > TALL * radius && vertices().any(reaches);
        if !is_sheet || !vertices().all(is_near) {
            return false;
        }
        let corners = part.iter().map(|t| t.map(at));
        let view = FrontView::of(grid, corners, shape.centre.z);
        let covered = region
            .iter()
            .filter(|c| view.depths[**c] > ball[**c])
            .count();
        COVERS.contains(&(covered as f32 / region.len().max(1) as f32))
    };
    let parts = components(surface, points).into_iter().filter(is_lid);
    parts.flatten().collect()
}

/// The connected parts beside the skin and the eyeballs.
fn components(surface: &FaceSurface, points: &FacePoints) -> Vec<Vec<[u32; 3]>> {
    let joined = &points.parts.joined;
    let triangles = surface.triangles_among(&points.parts.others);
    let mut root: BTreeMap<u32, u32> = BTreeMap::new();
    fn top(root: &mut BTreeMap<u32, u32>, mut at: u32) -> u32 {
        while let Some(above) = root.get(&at).copied().filter(|above| *above != at) {
            at = above;
        }
        at
    }
    for triangle in &triangles {
        let tops = triangle.map(|v| top(&mut root, joined[v as usize]));
        let least = tops.into_iter().min().unwrap_or_default();
        tops.iter().for_each(|t| {
            root.insert(*t, least);
        });
    }
    let mut parts: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for triangle in triangles {
        let part = top(&mut root, joined[triangle[0] as usize]);
        parts.entry(part).or_default().push(triangle);
    }
    parts.into_values().collect()
}
