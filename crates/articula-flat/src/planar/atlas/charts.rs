//! Connected pieces of texture space and the rectangles around them.

use super::super::clip::PlanarClip;
use super::area;
use glam::Vec2;
use std::collections::BTreeMap;

/// Pixels of the picture per pixel of the screen, along each axis.
const OVERSAMPLING: f32 = 1.25;
/// Least area of a triangle in the picture, pixels; the map from less is unsteady.
const LEAST_PIXELS: f32 = 0.2;

/// A drawn triangle that shows its texture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ShownTriangle {
    /// Index in the clip.
    pub(super) triangle: usize,
    /// Vertices of the mesh.
    pub(super) corners: [u32; 3],
    /// Texture coordinates, in texels of the material's texture.
    pub(super) texels: [Vec2; 3],
    /// Width and height of that texture.
    pub(super) texels_per_unit: Vec2,
    /// Largest area on the screen in a frame in which it is drawn, pixels.
    pub(super) pixels: f32,
    /// Surface of the clip.
    pub(super) surface: u16,
}

impl ShownTriangle {
    /// Area in the texture, texels.
    pub(super) fn texel_area(&self) -> f32 {
        area(&self.texels).abs()
    }

    /// Whether it can be mapped to the screen.
    pub(super) fn is_usable(&self) -> bool {
        let texels = self.texel_area();
        self.texels.iter().all(|at| at.is_finite()) && texels.is_finite() && texels > LEAST_PIXELS
    }
}

/// A rectangle of a texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Chart {
    /// Corners, in texels.
    pub(super) least: Vec2,
    pub(super) most: Vec2,
    /// Pixels of the picture per texel, at most 1.
    pub(super) scale: f32,
    surface: u16,
}

impl Chart {
    /// Width and height in pixels of the picture.
    pub(super) fn size_px(&self) -> Vec2 {
        (self.most - self.least) * self.scale
    }

    fn area_px(&self) -> f32 {
        let size = self.size_px();
        (size.x + 1.0) * (size.y + 1.0)
    }

    fn joined(&self, other: &Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
            scale: self.scale.max(other.scale),
            surface: self.surface,
        }
    }
}

/// Rectangles of textures, and which of them each triangle lies in.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Charts {
    pub(super) charts: Vec<Chart>,
    pub(super) of_triangle: Vec<usize>,
}

impl Charts {
    /// Triangles that share a vertex of the clip lie in one chart; charts of one surface are joined
    /// where one rectangle around both has no more pixels than two.
    pub(super) fn new(clip: &PlanarClip, shown: &[ShownTriangle]) -> Self {
        let groups = connected(clip, shown);
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, group) in groups.iter().enumerate() {
            members.entry(*group).or_default().push(i);
        }
        let mut kept: Vec<(Chart, Vec<usize>)> = Vec::new();
        for of in members.into_values() {
            let Some(mut chart) = around(shown, &of) else {
                continue;
            };
            let mut of = of;
            while let Some(i) = kept.iter().position(|(other, _)| fits(&chart, other)) {
                let (other, more) = kept.swap_remove(i);
                chart = chart.joined(&other);
                of.extend(more);
            }
            kept.push((chart, of));
        }
        let mut of_triangle = vec![0; shown.len()];
        for (number, (_, of)) in kept.iter().enumerate() {
            of.iter().for_each(|i| of_triangle[*i] = number);
        }
        Self {
            charts: kept.into_iter().map(|(chart, _)| chart).collect(),
            of_triangle,
        }
    }
}

fn fits(a: &Chart, b: &Chart) -> bool {
    a.surface == b.surface && a.joined(b).area_px() <= a.area_px() + b.area_px()
}

/// The chart around triangles, at the resolution of those with most pixels per texel, weighted by
/// their pixels.
fn around(shown: &[ShownTriangle], of: &[usize]) -> Option<Chart> {
    let first = &shown[*of.first()?];
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let (mut sum, mut weights) = (0.0, 0.0);
    for triangle in of.iter().map(|i| &shown[*i]) {
        for at in triangle.texels {
            (least, most) = (least.min(at), most.max(at));
        }
        let ratio = (triangle.pixels / triangle.texel_area()).sqrt();
        sum += ratio * triangle.pixels;
        weights += triangle.pixels;
    }
    let scale = sum / weights.max(f32::MIN_POSITIVE) * OVERSAMPLING;
    Some(Chart {
        least,
        most,
        scale: scale.clamp(1e-3, 1.0),
        surface: first.surface,
    })
}

/// A number for each triangle, equal for those that are connected by vertices.
fn connected(clip: &PlanarClip, shown: &[ShownTriangle]) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..shown.len()).collect();
    let mut of_vertex: BTreeMap<u32, usize> = BTreeMap::new();
    for (i, triangle) in shown.iter().enumerate() {
        for vertex in clip.triangles[triangle.triangle] {
            let other = *of_vertex.entry(vertex).or_insert(i);
            let (a, b) = (root(&mut parents, i), root(&mut parents, other));
            parents[a.max(b)] = a.min(b);
        }
    }
    (0..shown.len()).map(|i| root(&mut parents, i)).collect()
}

fn root(parents: &mut [usize], mut at: usize) -> usize {
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture::loose;

    fn shown(triangle: usize, texels: [[f32; 2]; 3], pixels: f32) -> ShownTriangle {
        ShownTriangle {
            triangle,
            corners: [0; 3],
            texels: texels.map(Vec2::from_array),
            texels_per_unit: Vec2::splat(256.0),
            pixels,
            surface: 0,
        }
    }

    /// Three separate triangles of the screen.
    fn clip() -> PlanarClip {
        let at = |x: f32| [[x, 1.0, 0.5], [x, 9.0, 0.5], [x + 8.0, 1.0, 0.5]];
        loose(&[1.0, 11.0, 21.0].map(|x| (at(x), [9; 3])), 1)
    }

    #[test]
    fn pieces_that_overlap_share_a_rectangle() {
        let all = [
            shown(0, [[0.0, 0.0], [40.0, 0.0], [0.0, 40.0]], 50.0),
            shown(1, [[100.0, 100.0], [140.0, 100.0], [100.0, 140.0]], 50.0),
            shown(2, [[2.0, 2.0], [40.0, 4.0], [2.0, 40.0]], 50.0),
        ];
        let charts = Charts::new(&clip(), &all);
        assert_eq!(charts.charts.len(), 2);
        assert_eq!(charts.of_triangle[0], charts.of_triangle[2]);
        assert_ne!(charts.of_triangle[0], charts.of_triangle[1]);
        let joined = charts.charts[charts.of_triangle[0]];
        assert_eq!((joined.least, joined.most), (Vec2::ZERO, Vec2::splat(40.0)));
    }

    #[test]
    fn vertices_connect_and_the_scale_follows_the_screen() {
        let mut clip = clip();
        clip.triangles[1][0] = clip.triangles[0][2];
        let all = [
            shown(0, [[0.0, 0.0], [40.0, 0.0], [0.0, 40.0]], 50.0),
            shown(1, [[40.0, 0.0], [90.0, 0.0], [40.0, 90.0]], 50.0),
        ];
        let charts = Charts::new(&clip, &all);
        assert_eq!(charts.of_triangle, [0, 0]);
        // 800 texels on 50 pixels: four texels a pixel along each axis.
        let one = Charts::new(&clip, &all[..1]).charts[0];
        assert!((one.scale - OVERSAMPLING / 4.0).abs() < 1e-5);
        // A texture is never enlarged.
        let near = shown(0, [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]], 500.0);
        assert_eq!(Charts::new(&clip, &[near]).charts[0].scale, 1.0);
    }
}
