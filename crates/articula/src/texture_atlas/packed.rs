//! Rectangles of an atlas.

use crate::error::{Error, Result};
use etagere::{AtlasAllocator, Rectangle, size2};
use glam::Vec2;

/// Pixels around each rectangle that repeat its border, so that filters see nothing of its neighbours.
pub(super) const GUTTER: u32 = 2;
/// Least and greatest side of an atlas in pixels.
const LEAST_PX: u32 = 64;
const MOST_PX: u32 = 16_384;
/// Halvings of the interval in which the scale is searched.
const HALVINGS: u32 = 10;

/// The rectangles of an atlas, without their gutters.
#[derive(Debug, Clone)]
pub(super) struct Places {
    /// Width and height of the atlas.
    pub(super) side_px: u32,
    /// Left, top, width and height of each.
    pub(super) rectangles: Vec<[u32; 4]>,
}

impl Places {
    /// Finds places for rectangles of these sizes: in the least atlas in which they have room, or in one of the
    /// most allowed size at the largest scale at which they do.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a size that is not 64 to 16,384, and if rectangles of a single pixel have no room.
    pub(super) fn new(sizes: &[[u32; 2]], longest_px: u32) -> Result<Self> {
        if !(LEAST_PX..=MOST_PX).contains(&longest_px) {
            let what =
                format!("an atlas has sides of {LEAST_PX} to {MOST_PX} pixels, not {longest_px}");
            return Err(Error::unsuited(what));
        }
        let sides = std::iter::successors(Some(LEAST_PX), |side| Some(2 * side))
            .take_while(|side| *side <= longest_px);
        if let Some(places) = sides.clone().find_map(|side| Self::at(sizes, side, 1.0)) {
            return Ok(places);
        }
        let side_px = sides.last().unwrap_or(longest_px);
        let (mut low, mut high) = (0.0, 1.0);
        let mut best = Self::at(sizes, side_px, low).ok_or_else(|| {
            let count = sizes.len();
            Error::unsuited(format!(
                "{count} textures have no room in one of {longest_px} x {longest_px} pixels; allow a larger one"
            ))
        })?;
        for _ in 0..HALVINGS {
            let scale = 0.5 * (low + high);
            match Self::at(sizes, side_px, scale) {
                Some(places) => (best, low) = (places, scale),
                None => high = scale,
            }
        }
        Ok(best)
    }

    /// Places at a scale, the highest rectangle first.
    fn at(sizes: &[[u32; 2]], side_px: u32, scale: f64) -> Option<Self> {
        let scaled = |of: u32| ((f64::from(of) * scale).round() as u32).clamp(1, side_px);
        let sizes: Vec<[u32; 2]> = sizes.iter().map(|size| size.map(scaled)).collect();
        let mut order: Vec<usize> = (0..sizes.len()).collect();
        order.sort_by_key(|i| sizes[*i].map(std::cmp::Reverse)[1]);
        let side = i32::try_from(side_px).ok()?;
        let mut free = AtlasAllocator::new(size2(side, side));
        let mut rectangles = vec![[0; 4]; sizes.len()];
        for i in order {
            let [width, height] = sizes[i].map(|of| of + 2 * GUTTER);
            let size = size2(i32::try_from(width).ok()?, i32::try_from(height).ok()?);
            rectangles[i] = inner(free.allocate(size)?.rectangle, sizes[i])?;
        }
        Some(Self {
            side_px,
            rectangles,
        })
    }

    /// Texture coordinates of an atlas for those of a texture, 0 to 1.
    pub(super) fn moved(&self, place: usize, uv: Vec2) -> Vec2 {
        let [left, top, width, height] = self.rectangles[place].map(|x| x as f32);
        let within = uv.clamp(Vec2::ZERO, Vec2::ONE) * Vec2::new(width, height);
        (Vec2::new(left, top) + within) / self.side_px as f32
    }
}

/// A rectangle of a size in one with a gutter, which may be larger than was asked for.
fn inner(outer: Rectangle, [width, height]: [u32; 2]) -> Option<[u32; 4]> {
    let [left, top] = [outer.min.x, outer.min.y].map(|x| u32::try_from(x).ok());
    Some([left? + GUTTER, top? + GUTTER, width, height])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether all rectangles with their gutters are apart and inside.
    fn is_sound(places: &Places) -> bool {
        let outer = |[left, top, width, height]: [u32; 4]| {
            let [width, height] = [width, height].map(|of| of + 2 * GUTTER);
            [
                left - GUTTER,
                top - GUTTER,
                left - GUTTER + width,
                top - GUTTER + height,
            ]
        };
        let all: Vec<[u32; 4]> = places.rectangles.iter().map(|of| outer(*of)).collect();
        let is_inside = all.iter().all(|of| of[2].max(of[3]) <= places.side_px);
        let is_apart = |a: &[u32; 4], b: &[u32; 4]| {
            a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1]
        };
        let pairs = |i: usize| all[..i].iter().all(|other| is_apart(other, &all[i]));
        is_inside && (0..all.len()).all(pairs)
    }

    #[test]
    fn small_rectangles_keep_their_size_in_the_least_atlas() {
        let sizes = [[60, 20], [30, 50], [1, 1]];
        let places = Places::new(&sizes, 1024).unwrap();
        assert!(is_sound(&places), "{places:?}");
        assert_eq!(places.side_px, 128);
        let kept: Vec<[u32; 2]> = places.rectangles.iter().map(|of| [of[2], of[3]]).collect();
        assert_eq!(kept, sizes);
    }

    #[test]
    fn large_rectangles_are_scaled_alike() {
        let sizes = [
            [1024, 1024],
            [1024, 512],
            [512, 512],
            [256, 256],
            [2048, 2048],
        ];
        let places = Places::new(&sizes, 1000).unwrap();
        assert!(is_sound(&places), "{places:?}");
        assert_eq!(places.side_px, 512);
        let scales = sizes
            .iter()
            .zip(&places.rectangles)
            .map(|(size, of)| f64::from(of[2]) / f64::from(size[0]));
        let scales: Vec<f64> = scales.collect();
        assert!(
            scales.iter().all(|s| (0.15..0.25).contains(s)),
            "{scales:?}"
        );
        assert!(Places::new(&[[9, 9]; 2000], 128).is_err());
        for side in [0, 63, 16_385, u32::MAX] {
            assert!(Places::new(&sizes, side).is_err());
        }
    }

    #[test]
    fn coordinates_stay_within_their_rectangle() {
        let places = Places {
            side_px: 100,
            rectangles: vec![[10, 20, 40, 50]],
        };
        assert_eq!(places.moved(0, Vec2::ZERO), Vec2::new(0.1, 0.2));
        assert_eq!(places.moved(0, Vec2::ONE), Vec2::new(0.5, 0.7));
        assert_eq!(places.moved(0, Vec2::splat(1.00005)), Vec2::new(0.5, 0.7));
    }
}
