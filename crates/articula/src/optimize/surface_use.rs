//! How large pictures are on screen: the texels that the surface they lie on can show.
//!
//! A triangle is largest on screen where it faces the viewer; then a texel has as many pixels as the greatest
//! stretch of the map from the picture to the surface. Source: the principal stretches of that map,
//! P. V. Sander, J. Snyder, S. J. Gortler, H. Hoppe, Texture Mapping Progressive Meshes, SIGGRAPH 2001.

use articula_build::PosedVertices;
use articula_formats::gltf::Document;
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

/// Share of the surface on whose texels a picture is not made larger than a pixel.
const SURFACE_SHARE: f64 = 0.99;
/// Least longest side that is written.
const LEAST_PX: u32 = 16;

/// The surfaces of all materials, as large as a figure of a height in pixels shows them.
pub(super) struct SurfaceUse {
    /// For each material its triangles.
    materials: Vec<Vec<Stretch>>,
    /// For each picture the materials that show it, if they are known.
    pictures: Vec<Option<BTreeSet<usize>>>,
}

/// The map from a picture to a triangle.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    /// Area in square pixels.
    area: f64,
    /// Pixels that one unit of each texture coordinate spans; `None` if they do not span the triangle.
    along: Option<[Vec3; 2]>,
}

impl Stretch {
    fn of(corners: [Vec3; 3], places: [Vec2; 3]) -> Self {
        let [a, b] = [corners[1] - corners[0], corners[2] - corners[0]];
        let [s, t] = [places[1] - places[0], places[2] - places[0]];
        let determinant = s.perp_dot(t);
        let along = [
            (a * t.y - b * s.y) / determinant,
            (b * s.x - a * t.x) / determinant,
        ];
        Self {
            area: 0.5 * f64::from(a.cross(b).length()),
            along: along.iter().all(|v| v.is_finite()).then_some(along),
        }
    }

    /// Pixels along the longest axis of a texel of a picture of a size.
    fn pixels_of_texel(&self, [width, height]: [u32; 2]) -> f64 {
        let Some([u, v]) = self.along else {
            return f64::INFINITY;
        };
        let (u, v) = (
            u.as_dvec3() / f64::from(width),
            v.as_dvec3() / f64::from(height),
        );
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let greatest = 0.5 * (uu + vv) + (0.25 * (uu - vv).powi(2) + uv * uv).sqrt();
        greatest.sqrt()
    }
}

impl SurfaceUse {
    /// The surfaces of a character at rest, of whose metres each has a number of pixels.
    pub(super) fn of(
        posed: &mut PosedVertices<'_>,
        document: &Document,
        px_per_metre: f32,
    ) -> Self {
        let points = posed.at(None, 0.0).iter();
        let points: Vec<Vec3> = points.map(|p| *p * px_per_metre).collect();
        let mesh = posed.mesh();
        let last = mesh.parts.iter().filter_map(|part| part.material).max();
        let mut materials = vec![Vec::new(); last.map_or(0, |last| last + 1)];
        for part in &mesh.parts {
            let Some(triangles) = part.material.and_then(|m| materials.get_mut(m)) else {
                continue;
            };
            let of_part = mesh.triangles[part.triangles.clone()].iter();
            triangles.extend(of_part.map(|triangle| {
                let corners = triangle.map(|v| points[v as usize]);
                Stretch::of(corners, triangle.map(|v| mesh.texcoords[v as usize]))
            }));
        }
        Self {
            materials,
            pictures: document.picture_materials(),
        }
    }

    /// The longest side that a picture of a size needs, so that on 99 % of the surface no texel is larger
    /// than a pixel: a power of two; `None` if it needs its own size, or its surface is not known.
    pub(super) fn longest_px(&self, picture: usize, size: [u32; 2]) -> Option<u32> {
        let materials = self.pictures.get(picture)?.as_ref()?;
        let all = materials.iter().filter_map(|m| self.materials.get(*m));
        let mut texels: Vec<(f64, f64)> = all
            .flatten()
            .map(|triangle| (triangle.pixels_of_texel(size), triangle.area))
            .filter(|(_, area)| *area > 0.0)
            .collect();
        texels.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = texels.iter().map(|(_, area)| area).sum();
        let mut below = 0.0;
        let pixels = texels.iter().find_map(|(pixels, area)| {
            below += area;
            (below >= SURFACE_SHARE * whole).then_some(*pixels)
        })?;
        let own = size[0].max(size[1]);
        let needed = (f64::from(own) * pixels).ceil();
        let is_less = needed < f64::from(own);
        let needed = is_less.then(|| (needed as u32).next_power_of_two().max(LEAST_PX))?;
        (needed < own).then_some(needed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 100 pixels that shows the whole picture, and a sliver that shows all of it too.
    fn surface(sliver: f32) -> SurfaceUse {
        let square = [Vec3::ZERO, 100.0 * Vec3::X, 100.0 * Vec3::ONE];
        let places = [Vec2::ZERO, Vec2::X, Vec2::ONE];
        let square = square.map(|p| p.with_z(0.0));
        let long = [Vec3::ZERO, 1000.0 * Vec3::X, Vec3::new(1000.0, sliver, 0.0)];
        SurfaceUse {
            materials: vec![vec![Stretch::of(square, places), Stretch::of(long, places)]],
            pictures: vec![Some([0].into()), None],
        }
    }

    #[test]
    fn a_texel_is_a_pixel_on_all_but_a_hundredth_of_the_surface() {
        // One pixel a texel at 100 texels.
        let few = surface(0.09);
        assert_eq!(few.longest_px(0, [1024, 1024]), Some(128));
        assert_eq!(few.longest_px(0, [64, 64]), None);
        // The sliver is 1000 pixels long and more than a hundredth.
        let many = surface(10.0);
        assert_eq!(many.longest_px(0, [4096, 4096]), Some(1024));
        assert_eq!(many.longest_px(0, [512, 512]), None);
        // The texels of a picture that is half as high are twice as long.
        assert_eq!(few.longest_px(0, [1024, 512]), Some(256));
        // A picture whose coordinates are not known keeps its size.
        assert_eq!(many.longest_px(1, [4096, 4096]), None);
    }

    #[test]
    fn a_surface_of_one_texel_keeps_the_picture() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let point = Stretch::of(corners, [Vec2::splat(0.5); 3]);
        let surface = SurfaceUse {
            materials: vec![vec![point]],
            pictures: vec![Some([0].into())],
        };
        assert_eq!(surface.longest_px(0, [1024, 1024]), None);
    }
}
