//! Colours of the triangles in the picture, and of what lies between them.

use super::super::bake::Painter;
use super::charts::ShownTriangle;
use super::packed::Places;
use crate::error::PictureError;
use crate::picture::{Picture, Rgba};
use glam::{Vec2, Vec3, Vec4};

/// Samples along each axis of a pixel.
const SAMPLES: u32 = 2;
/// Distance from a triangle up to which it colours pixels that no triangle covers, pixels.
const MARGIN: f32 = 1.6;

/// The picture: triangles where they lie, then their margins, then smooth colours between, which
/// take few bytes.
///
/// # Errors
/// [`PictureError::LimitExceeded`] for a picture that is too large.
pub(super) fn painted(
    shown: &[ShownTriangle],
    places: &Places,
    of_triangle: &[usize],
    painter: &Painter<'_>,
) -> Result<Picture, PictureError> {
    let (width, height) = places.size;
    let mut canvas = Canvas {
        width,
        height,
        colors: vec![None; width as usize * height as usize],
    };
    for margin in [0.0, MARGIN] {
        for (triangle, chart) in shown.iter().zip(of_triangle) {
            let corners = triangle.texels.map(|at| places.place(*chart, at));
            let texels = places.scale(*chart).powi(-2) / (SAMPLES * SAMPLES) as f32;
            let size = triangle.texels_per_unit;
            let level = painter.level_of(&triangle.corners, texels / (size.x * size.y));
            canvas.add(&corners, margin, |weights| {
                painter.color(&triangle.corners, weights, level).0
            });
        }
    }
    Picture::from_pixels(width, height, canvas.filled())
}

struct Canvas {
    width: u32,
    height: u32,
    colors: Vec<Option<Vec3>>,
}

impl Canvas {
    /// Colours the pixels without a colour whose centres lie in a triangle or up to `margin` pixels
    /// from it.
    fn add(&mut self, corners: &[Vec2; 3], margin: f32, color: impl Fn(Vec3) -> Vec3) {
        let Some(weights_at) = Barycentric::new(corners) else {
            return;
        };
        let [a, b, c] = *corners;
        let least = (a.min(b).min(c) - margin).floor().max(Vec2::ZERO);
        let most = (a.max(b).max(c) + margin).ceil();
        let most = most.min(Vec2::new(self.width as f32, self.height as f32));
        for y in least.y as u32..most.y.max(0.0) as u32 {
            for x in least.x as u32..most.x.max(0.0) as u32 {
                let at = (y * self.width + x) as usize;
                let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let is_near = weights_at.distance(centre) <= margin.max(1e-3);
                if is_near && self.colors[at].is_none() {
                    self.colors[at] = Some(mean(Vec2::new(x as f32, y as f32), |sample| {
                        color(weights_at.weights(sample))
                    }));
                }
            }
        }
    }

    /// All pixels; those without a colour take that of the nearest coarser mean that has one.
    fn filled(self) -> Vec<Rgba> {
        let known = |color: &Option<Vec3>| color.map_or(Vec4::ZERO, |c| c.extend(1.0));
        let level = Level {
            width: self.width as usize,
            height: self.height as usize,
            sums: self.colors.iter().map(known).collect(),
        };
        let round = |c: Vec4| [c.x, c.y, c.z].map(|level| level.round().clamp(0.0, 255.0) as u8);
        let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
        let filled = level.filled();
        filled.into_iter().map(|c| opaque(round(c))).collect()
    }
}

/// The mean over the samples of a pixel, from its upper left corner.
fn mean(corner: Vec2, color: impl Fn(Vec2) -> Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for y in 0..SAMPLES {
        for x in 0..SAMPLES {
            let within = (Vec2::new(x as f32, y as f32) + 0.5) / SAMPLES as f32;
            sum += color(corner + within);
        }
    }
    sum / (SAMPLES * SAMPLES) as f32
}

/// Sums of colours with their weights, for a picture or a coarser version of it.
struct Level {
    width: usize,
    height: usize,
    sums: Vec<Vec4>,
}

impl Level {
    /// Colours everywhere, by the pull-push algorithm (Gortler, Grzeszczuk, Szeliski and Cohen, *The
    /// Lumigraph*, SIGGRAPH 1996, 3.4) with the nearest coarser pixel.
    fn filled(self) -> Vec<Vec4> {
        let missing = self.sums.iter().any(|sum| sum.w == 0.0);
        if !missing || (self.width <= 1 && self.height <= 1) {
            return self.sums.iter().map(|sum| means(*sum)).collect();
        }
        let coarse = self.halved();
        let width = coarse.width;
        let coarse = coarse.filled();
        let pixel = |(i, sum): (usize, &Vec4)| {
            let (x, y) = (i % self.width, i / self.width);
            match sum.w > 0.0 {
                true => means(*sum),
                false => coarse[y / 2 * width + x / 2],
            }
        };
        self.sums.iter().enumerate().map(pixel).collect()
    }

    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut sums = vec![Vec4::ZERO; width * height];
        for (i, sum) in self.sums.iter().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            sums[y / 2 * width + x / 2] += *sum;
        }
        Self {
            width,
            height,
            sums,
        }
    }
}

fn means(sum: Vec4) -> Vec4 {
    sum / sum.w.max(1e-6)
}

/// Barycentric weights and distances of a triangle in the plane.
struct Barycentric {
    corners: [Vec2; 3],
    area: f32,
}

impl Barycentric {
    fn new(corners: &[Vec2; 3]) -> Option<Self> {
        let area = super::area(corners);
        (area.abs() > 1e-6).then_some(Self {
            corners: *corners,
            area,
        })
    }

    fn weights(&self, at: Vec2) -> Vec3 {
        let [a, b, c] = self.corners;
        let part = |p, q| super::area(&[at, p, q]) / self.area;
        Vec3::new(part(b, c), part(c, a), part(a, b))
    }

    /// Distance from a point to the triangle, 0 inside.
    fn distance(&self, at: Vec2) -> f32 {
        if self.weights(at).min_element() >= 0.0 {
            return 0.0;
        }
        let side = |i: usize| {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
            let along = to - from;
            let share = (at - from).dot(along) / along.length_squared().max(1e-12);
            at.distance(from + along * share.clamp(0.0, 1.0))
        };
        side(0).min(side(1)).min(side(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_spread_to_where_no_triangle_is() {
        let mut canvas = Canvas {
            width: 8,
            height: 8,
            colors: vec![None; 64],
        };
        let corners = [Vec2::ZERO, Vec2::new(4.0, 0.0), Vec2::new(0.0, 4.0)];
        canvas.add(&corners, 0.0, |weights| weights * 200.0);
        let covered = canvas.colors.iter().filter(|c| c.is_some()).count();
        // Centres with x + y at most 4.
        assert_eq!(covered, 10);
        let at = canvas.colors[8 + 1].unwrap();
        assert!((at - Vec3::new(50.0, 75.0, 75.0)).length() < 1e-3, "{at}");
        canvas.add(&corners, 1.0, |_| Vec3::splat(7.0));
        assert_eq!(canvas.colors[4], Some(Vec3::splat(7.0)));
        assert_eq!(canvas.colors[63], None);
        assert!(
            canvas
                .filled()
                .iter()
                .all(|p| p[3] == 255 && *p != [0, 0, 0, 255])
        );
    }

    #[test]
    fn missing_colours_are_means_of_what_is_near() {
        let mut sums = vec![Vec4::ZERO; 16];
        sums[0] = Vec4::new(10.0, 0.0, 0.0, 1.0);
        sums[15] = Vec4::new(30.0, 0.0, 0.0, 1.0);
        let level = Level {
            width: 4,
            height: 4,
            sums,
        };
        let red: Vec<f32> = level.filled().iter().map(|c| c.x).collect();
        assert_eq!((red[1], red[14], red[3]), (10.0, 30.0, 20.0));
    }
}
