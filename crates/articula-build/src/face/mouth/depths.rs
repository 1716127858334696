//! How far vertices are behind the foremost skin, seen from the front.

use super::super::points::FaceSurface;
use glam::{Vec2, Vec3};

/// Most cells along one side.
const MOST: f32 = 1024.0;

/// The foremost skin in each cell of the front view.
pub(super) struct Depths {
    corner: Vec2,
    cell: f32,
    width: usize,
    foremost: Vec<f32>,
}

impl Depths {
    /// Those of triangles, in cells of a width, or larger ones if these are too many.
    pub(super) fn of(surface: &FaceSurface, triangles: &[[u32; 3]], cell: f32) -> Self {
        let at = |v: u32| surface.positions[v as usize];
        let all = || triangles.iter().flatten().map(|v| at(*v).truncate());
        let corner = all().fold(Vec2::INFINITY, Vec2::min);
        let size = (all().fold(Vec2::NEG_INFINITY, Vec2::max) - corner).max(Vec2::ZERO);
        let cell = cell.max(size.max_element() / MOST).max(1e-6);
        let [width, height] = cell_at(size / cell).map(|count| count + 1);
        let mut depths = Self {
            corner,
            cell,
            width,
            foremost: vec![f32::NEG_INFINITY; width * height],
        };
        for triangle in triangles {
            depths.draw(triangle.map(at));
        }
        depths
    }

    /// Distance behind the foremost skin, 0 or more.
    pub(super) fn behind(&self, place: Vec3) -> f32 {
        let at = self.index(cell_at((place.truncate() - self.corner) / self.cell));
        let foremost = at.and_then(|at| self.foremost.get(at));
        foremost.map_or(0.0, |front| (front - place.z).max(0.0))
    }

    fn index(&self, [x, y]: [usize; 2]) -> Option<usize> {
        (x < self.width).then_some(y * self.width + x)
    }

    /// Draws a triangle: at the middles of its cells, and its corners.
    fn draw(&mut self, corners: [Vec3; 3]) {
        let flat = corners.map(|p| (p.truncate() - self.corner) / self.cell);
        for (cell, corner) in flat.iter().zip(corners) {
            self.set(cell_at(*cell), corner.z);
        }
        let [a, b, c] = flat;
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            return;
        }
        let [low, high] = [a.min(b).min(c), a.max(b).max(c)].map(cell_at);
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let p = Vec2::new(x as f32, y as f32) + 0.5 - a;
                let (of_b, of_c) = (p.perp_dot(c - a) / area, (b - a).perp_dot(p) / area);
                if of_b >= 0.0 && of_c >= 0.0 && of_b + of_c <= 1.0 {
                    let [za, zb, zc] = corners.map(|p| p.z);
                    self.set([x, y], za + of_b * (zb - za) + of_c * (zc - za));
                }
            }
        }
    }

    fn set(&mut self, cell: [usize; 2], depth: f32) {
        if let Some(known) = self.index(cell).and_then(|at| self.foremost.get_mut(at)) {
            *known = known.max(depth);
        }
    }
}

/// Column and row of a place in units of cells; the first one before all.
fn cell_at(place: Vec2) -> [usize; 2] {
    place.to_array().map(|c| c as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_behind_a_wall_is_behind_it() {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.3);
        let surface = FaceSurface {
            positions: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)],
            triangles: vec![[0, 1, 2]],
            ..FaceSurface::default()
        };
        let depths = Depths::of(&surface, &surface.triangles, 0.01);
        assert!((depths.behind(Vec3::new(0.2, 0.3, 0.1)) - 0.2).abs() < 1e-6);
        assert_eq!(depths.behind(Vec3::new(0.2, 0.3, 0.4)), 0.0);
        // Beside the triangle, and beside all.
        assert_eq!(depths.behind(Vec3::new(0.9, 0.9, 0.0)), 0.0);
        assert_eq!(depths.behind(Vec3::new(5.0, -7.0, 0.0)), 0.0);
        let none = Depths::of(&surface, &[], 0.01);
        assert_eq!(none.behind(Vec3::ZERO), 0.0);
    }
}
