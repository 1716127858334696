//! The floor below a character: a grid of half metres and a soft contact shadow.
//!
//! The shadow shows contact and is independent of the light: a point of the floor is the darker,
//! the lower the body above it is, so a floating foot differs from one that stands.

use crate::error::PictureError;
use crate::frame::Bounds;
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use glam::{Vec2, Vec3, Vec4};

/// Height at which a body part's shadow has faded to about a third, metres.
const FADE_M: f32 = 0.12;
/// Cells along the longer side of the shadow map.
const CELLS: f32 = 192.0;
/// Distance between grid lines, metres.
const GRID_M: f32 = 0.5;
/// Width of a grid line, metres.
const LINE_M: f32 = 0.012;

/// A floor with grid lines and a contact shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Height of the floor, metres.
    pub height_m: f32,
    /// Centre of the disc that is drawn (x and z), metres.
    pub middle: Vec2,
    /// Radius at which the floor has faded into the background, metres.
    pub radius_m: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            height_m: 0.0,
            middle: Vec2::ZERO,
            radius_m: 2.5,
        }
    }
}

impl Ground {
    /// Returns a floor at a height, centred under the bounds, with a radius of 1.5 times their
    /// longest side.
    pub fn below(bounds: &Bounds, height_m: f32) -> Self {
        let (middle, size) = (bounds.middle(), bounds.high - bounds.low);
        Self {
            height_m,
            middle: Vec2::new(middle.x, middle.z),
            radius_m: 1.5 * size.max_element(),
        }
    }
}

/// Map of the shadow that a body casts straight down on the floor.
pub(crate) struct ContactShadow {
    origin: Vec2,
    cells_per_metre: f32,
    width: usize,
    darkness: Vec<f32>,
}

impl ContactShadow {
    /// Rasterises the triangles seen from below the floor, straight up.
    pub(crate) fn new(
        positions: &[Vec3],
        triangles: impl Iterator<Item = [u32; 3]>,
        height_m: f32,
    ) -> Result<Self, PictureError> {
        let finite = positions.iter().filter(|p| p.is_finite());
        let flat = |p: &Vec3| Vec2::new(p.x, p.z);
        let low = finite.clone().map(flat).fold(Vec2::MAX, Vec2::min);
        let high = finite.map(flat).fold(Vec2::MIN, Vec2::max);
        let size = (high - low).max(Vec2::splat(0.1)) + 4.0 * FADE_M;
        if low.cmpgt(high).any() || !size.is_finite() {
            return Ok(Self::none());
        }
        let cells_per_metre = CELLS / size.max_element();
        let origin = low - 2.0 * FADE_M;
        let cells = (size * cells_per_metre).ceil();
        let (width, height) = (cells.x as u32, cells.y as u32);
        let mut buffer = ItemBuffer::new(width, height, Supersampling::One)?;
        for corners in triangles {
            let corners = corners.map(|v| {
                let p = positions[v as usize];
                let cell = (flat(&p) - origin) * cells_per_metre;
                // Whatever reaches below the floor touches it.
                Vec4::new(cell.x, cell.y, -(p.y - height_m).max(0.0), 1.0)
            });
            buffer.draw(0, corners, Faces::Both);
        }
        let of = |nearness: f32| (nearness / FADE_M).exp();
        let darkness = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| of(buffer.nearness(x, y)))
            .collect();
        let width = width as usize;
        let mut shadow = Self {
            origin,
            cells_per_metre,
            width,
            darkness,
        };
        shadow.soften(0.02);
        Ok(shadow)
    }

    /// Darkness, 0 to 1, at a position (x and z) on the floor.
    pub(crate) fn at(&self, place: Vec2) -> f32 {
        let cell = (place - self.origin) * self.cells_per_metre - 0.5;
        if cell.min_element() < -1.0 || cell.x > self.width as f32 {
            return 0.0;
        }
        let corner = cell.floor();
        let blend = cell - corner;
        let (x, y) = (corner.x as i64, corner.y as i64);
        let upper = lerp(self.cell(x, y), self.cell(x + 1, y), blend.x);
        let lower = lerp(self.cell(x, y + 1), self.cell(x + 1, y + 1), blend.x);
        lerp(upper, lower, blend.y)
    }

    fn none() -> Self {
        Self {
            origin: Vec2::ZERO,
            cells_per_metre: 1.0,
            width: 0,
            darkness: Vec::new(),
        }
    }

    fn cell(&self, x: i64, y: i64) -> f32 {
        if x < 0 || x >= self.width as i64 || y < 0 {
            return 0.0;
        }
        let index = y as usize * self.width + x as usize;
        self.darkness.get(index).copied().unwrap_or(0.0)
    }

    /// Blurs by two box passes of this radius along each axis, which approximates a Gaussian.
    fn soften(&mut self, radius_m: f32) {
        let radius = (radius_m * self.cells_per_metre).round().max(1.0) as usize;
        let height = self.darkness.len() / self.width.max(1);
        for _ in 0..2 {
            for y in 0..height {
                box_blur(&mut self.darkness, y * self.width, 1, self.width, radius);
            }
            for x in 0..self.width {
                box_blur(&mut self.darkness, x, self.width, height, radius);
            }
        }
    }
}

/// Blurs `count` cells with the given `stride`.
fn box_blur(cells: &mut [f32], first: usize, stride: usize, count: usize, radius: usize) {
    let line: Vec<f32> = (0..count).map(|i| cells[first + i * stride]).collect();
    for i in 0..count {
        let window = &line[i.saturating_sub(radius)..(i + radius + 1).min(count)];
        let mean = window.iter().sum::<f32>() / (2 * radius + 1) as f32;
        cells[first + i * stride] = mean;
    }
}

/// Coverage of the grid lines at a position (x and z), filtered over `footprint` metres (the size
/// of a pixel on the floor along each axis).
pub(crate) fn grid_coverage(place: Vec2, footprint: Vec2) -> f32 {
    let along = |at: f32, footprint: f32| {
        let distance = (at / GRID_M - (at / GRID_M).round()).abs() * GRID_M;
        let width = footprint.max(1e-4);
        // Fraction of the pixel's width that the line covers.
        let reach = 0.5 * (width + LINE_M) - distance;
        let share = (reach / width).clamp(0.0, (LINE_M / width).min(1.0));
        // Far away the lines would merge into an even grey; they fade out instead.
        share * (1.0 - width / (0.5 * GRID_M)).clamp(0.0, 1.0)
    };
    along(place.x, footprint.x).max(along(place.y, footprint.y))
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate(height: f32) -> Vec<Vec3> {
        [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)]
            .map(|(x, z)| Vec3::new(x, height, z))
            .to_vec()
    }

    fn shadow(height: f32) -> ContactShadow {
        let triangles = [[0, 1, 2], [0, 2, 3]].into_iter();
        ContactShadow::new(&plate(height), triangles, 0.0).unwrap()
    }

    #[test]
    fn contact_is_dark_and_height_fades_it() {
        let touching = shadow(0.0);
        assert!((touching.at(Vec2::ZERO) - 1.0).abs() < 1e-3);
        assert!(touching.at(Vec2::new(0.3, 0.0)) < 0.01);
        let one_fade_up = shadow(FADE_M).at(Vec2::ZERO);
        assert!((one_fade_up - (-1.0f32).exp()).abs() < 1e-3);
        assert!((shadow(-0.3).at(Vec2::ZERO) - 1.0).abs() < 1e-3, "sunk in");
    }

    #[test]
    fn nothing_to_shade_is_no_shadow() {
        let none = ContactShadow::new(&[], std::iter::empty(), 0.0).unwrap();
        assert_eq!(none.at(Vec2::ZERO), 0.0);
        let odd = ContactShadow::new(&[Vec3::NAN], std::iter::once([0, 0, 0]), 0.0).unwrap();
        assert_eq!(odd.at(Vec2::ZERO), 0.0);
    }

    #[test]
    fn grid_lines_lie_at_half_metres() {
        let sharp = Vec2::splat(0.001);
        assert!(grid_coverage(Vec2::new(1.5, 0.2), sharp) > 0.99);
        assert_eq!(grid_coverage(Vec2::new(1.25, 0.2), sharp), 0.0);
        let blurred = grid_coverage(Vec2::new(0.5, 0.2), Vec2::splat(0.12));
        assert!(blurred > 0.0 && blurred < 0.11);
    }
}
