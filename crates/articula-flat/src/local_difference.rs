//! The largest local difference of two pictures of a character, and where it lies.
//!
//! Source: X. Zhang, B. A. Wandell, "A spatial extension of CIELAB for digital color image
//! reproduction", Journal of the Society for Information Display 5(1), 1997: both pictures are
//! blurred as the eye does, then compared by the colour difference of CIELAB (CIE 1976, D65).
//! Differs: one Gaussian in linear light instead of one filter for each opponent channel, and its
//! width is a fraction of the figure's height, since vector graphics have no viewing distance.
//!
//! A mean over the picture hides what is small: a lost mouth or finger changes few pixels. The
//! largest value of the map does not.

use crate::picture::{Picture, linear_table};
use std::fmt;

/// Standard deviation of the Gaussian as a fraction of the figure's height.
const SIGMA_OF_HEIGHT: f32 = 1.0 / 200.0;
/// Minimum standard deviation, pixels.
const MIN_SIGMA_PX: f32 = 1.0;
/// White point of CIELAB: D65, the white of sRGB.
const WHITE: [f32; 3] = [0.950_47, 1.0, 1.088_83];

/// Region of the character to which a difference is attributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
pub enum JudgedRegion {
    /// Everything but face and hands.
    #[default]
    Body,
    /// Below the wrists.
    Hands,
    /// What the head joint moves, or without one what morph targets move.
    Face,
}

impl fmt::Display for JudgedRegion {
    /// Writes the name in lower case.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Body => "body",
            Self::Hands => "hands",
            Self::Face => "face",
        })
    }
}

/// The largest local difference of a region, and where it lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstDifference {
    /// Region in which it lies.
    pub region: JudgedRegion,
    /// Colour difference of CIELAB: 1 is just visible side by side, 100 is black against white.
    pub delta_e: f64,
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Frame of the clip; fractional between two frames.
    pub frame: f64,
}

/// The largest local differences of all regions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LocalDifferences {
    worst: [Option<WorstDifference>; 3],
}

impl LocalDifferences {
    /// Returns the largest difference of a region; `None` if no picture shows it.
    pub fn of(&self, region: JudgedRegion) -> Option<WorstDifference> {
        self.worst[region as usize]
    }

    /// Returns the largest difference outside of the face.
    pub fn rest(&self) -> Option<WorstDifference> {
        let (body, hands) = (self.of(JudgedRegion::Body), self.of(JudgedRegion::Hands));
        worse(body, hands)
    }

    /// Returns the largest difference of all regions.
    pub fn largest(&self) -> Option<WorstDifference> {
        worse(self.rest(), self.of(JudgedRegion::Face))
    }

    /// Adds the differences of another picture.
    pub(crate) fn add(&mut self, other: &Self) {
        for (held, new) in self.worst.iter_mut().zip(other.worst) {
            *held = worse(*held, new);
        }
    }
}

impl FromIterator<WorstDifference> for LocalDifferences {
    /// The largest of each region.
    fn from_iter<I: IntoIterator<Item = WorstDifference>>(all: I) -> Self {
        let mut out = Self::default();
        for new in all {
            let held = &mut out.worst[new.region as usize];
            *held = worse(*held, Some(new));
        }
        out
    }
}

fn worse(a: Option<WorstDifference>, b: Option<WorstDifference>) -> Option<WorstDifference> {
    match (a, b) {
        (Some(p), Some(q)) => Some(if q.delta_e > p.delta_e { q } else { p }),
        (held, new) => held.or(new),
    }
}

/// Standard deviation of the Gaussian for a figure of this height in pixels.
pub(crate) fn sigma_px(figure_height_px: u32) -> f32 {
    (SIGMA_OF_HEIGHT * figure_height_px as f32).max(MIN_SIGMA_PX)
}

/// Pixels beyond the figure that still count to it.
pub(crate) fn reach_px(sigma_px: f32) -> u32 {
    (3.0 * sigma_px).ceil() as u32
}

/// Compares two pictures of equal size over white, by the region of each pixel (`None`: not
/// compared).
///
/// O(pixels x width of the Gaussian).
pub(crate) fn local_differences(
    a: &Picture,
    b: &Picture,
    regions: &[Option<JudgedRegion>],
    sigma_px: f32,
    frame: f64,
) -> LocalDifferences {
    let width = a.width() as usize;
    let mut all = LocalDifferences::default();
    let Some(rows) = rows_of(regions, width) else {
        return all;
    };
    let (p, q) = (
        Blurred::of(a, &rows, sigma_px),
        Blurred::of(b, &rows, sigma_px),
    );
    for y in rows.clone() {
        for x in 0..width {
            let Some(region) = regions[y * width + x] else {
                continue;
            };
            let at = (y - rows.start) * width + x;
            let delta_e = f64::from(delta_e(p.0[at], q.0[at]));
            let held = &mut all.worst[region as usize];
            if held.is_none_or(|held| delta_e > held.delta_e) {
                *held = Some(WorstDifference {
                    region,
                    delta_e,
                    x: x as u32,
                    y: y as u32,
                    frame,
                });
            }
        }
    }
    all
}

/// The colour difference at each pixel of two pictures of equal size over white.
///
/// O(pixels x width of the Gaussian).
pub(crate) fn difference_map(a: &Picture, b: &Picture, sigma_px: f32) -> Vec<f32> {
    let rows = 0..a.height() as usize;
    let (p, q) = (
        Blurred::of(a, &rows, sigma_px),
        Blurred::of(b, &rows, sigma_px),
    );
    let pairs = p.0.iter().zip(&q.0);
    pairs.map(|(p, q)| delta_e(*p, *q)).collect()
}

/// Rows that have a region.
fn rows_of(regions: &[Option<JudgedRegion>], width: usize) -> Option<std::ops::Range<usize>> {
    let first = regions.iter().position(Option::is_some)?;
    let last = regions.iter().rposition(Option::is_some)?;
    Some(first / width..last / width + 1)
}

/// Linear red, green and blue of some rows of a picture, blurred.
struct Blurred(Vec<[f32; 3]>);

impl Blurred {
    fn of(picture: &Picture, rows: &std::ops::Range<usize>, sigma_px: f32) -> Self {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let radius = reach_px(sigma_px) as usize;
        let weights = gaussian(sigma_px, radius);
        // Columns first, over the rows that are needed only; beyond the border its pixels go on.
        let table = linear_table();
        let lit = |at: usize| {
            let [r, g, b, a] = picture.pixels()[at];
            let alpha = f32::from(a) / 255.0;
            [r, g, b].map(|c| 1.0 + (table[usize::from(c)] - 1.0) * alpha)
        };
        let low = rows.start.saturating_sub(radius);
        let high = (rows.end + radius).min(height);
        let source: Vec<[f32; 3]> = (low * width..high * width).map(lit).collect();
        let mut down = vec![[0.0; 3]; rows.len() * width];
        for (row, out) in rows.clone().zip(down.chunks_exact_mut(width)) {
            for (k, weight) in weights.iter().enumerate() {
                let from = (row + k).saturating_sub(radius).min(height - 1);
                let line = &source[(from - low) * width..][..width];
                add_weighted(out, line.iter(), *weight);
            }
        }
        let mut across = vec![[0.0; 3]; down.len()];
        let mut padded = vec![[0.0; 3]; width + 2 * radius];
        for (line, out) in down.chunks_exact(width).zip(across.chunks_exact_mut(width)) {
            padded[..radius].fill(line[0]);
            padded[radius..radius + width].copy_from_slice(line);
            padded[radius + width..].fill(line[width - 1]);
            for (k, weight) in weights.iter().enumerate() {
                add_weighted(out, padded[k..k + width].iter(), *weight);
            }
        }
        Self(across)
    }
}

fn add_weighted<'a>(out: &mut [[f32; 3]], line: impl Iterator<Item = &'a [f32; 3]>, weight: f32) {
    for (sum, value) in out.iter_mut().zip(line) {
        for k in 0..3 {
            sum[k] += weight * value[k];
        }
    }
}

fn gaussian(sigma_px: f32, radius: usize) -> Vec<f32> {
    let of = |k: usize| {
        let away = k as f32 - radius as f32;
        (-away * away / (2.0 * sigma_px * sigma_px)).exp()
    };
    let weights: Vec<f32> = (0..=2 * radius).map(of).collect();
    let sum: f32 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

/// Distance of two linear sRGB colours in CIELAB.
fn delta_e(a: [f32; 3], b: [f32; 3]) -> f32 {
    if a == b {
        return 0.0;
    }
    let (p, q) = (lab(a), lab(b));
    let squares = (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k]));
    squares.sum::<f32>().sqrt()
}

/// CIELAB of a linear sRGB colour (IEC 61966-2-1, CIE 15).
pub(crate) fn lab([r, g, b]: [f32; 3]) -> [f32; 3] {
    let xyz = [
        0.412_456 * r + 0.357_576 * g + 0.180_437 * b,
        0.212_673 * r + 0.715_152 * g + 0.072_175 * b,
        0.019_334 * r + 0.119_192 * g + 0.950_304 * b,
    ];
    let curve = |t: f32| {
        if t > 216.0 / 24_389.0 {
            t.cbrt()
        } else {
            (24_389.0 / 27.0 * t + 16.0) / 116.0
        }
    };
    let [x, y, z] = [0, 1, 2].map(|k| curve(xyz[k] / WHITE[k]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Extends the regions of a picture to the pixels within `reach` of them.
pub(crate) fn extended(
    mut regions: Vec<Option<JudgedRegion>>,
    width: usize,
    reach: u32,
) -> Vec<Option<JudgedRegion>> {
    for _ in 0..reach {
        let held = regions.clone();
        for (at, region) in regions.iter_mut().enumerate() {
            if region.is_some() {
                continue;
            }
            let x = at % width;
            let left = (x > 0).then(|| held[at - 1]).flatten();
            let right = (x + 1 < width).then(|| held[at + 1]).flatten();
            let above = at.checked_sub(width).and_then(|at| held[at]);
            let below = held.get(at + width).copied().flatten();
            *region = left.max(right).max(above).max(below);
        }
    }
    regions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cielab_of_known_colours() {
        // White, black, and the primary red of sRGB: L* 53.24, a* 80.09, b* 67.20 (Lindbloom).
        let near = |found: [f32; 3], expected: [f32; 3]| {
            (0..3).all(|k| (found[k] - expected[k]).abs() < 0.05)
        };
        assert!(near(lab([1.0; 3]), [100.0, 0.0, 0.0]));
        assert!(near(lab([0.0; 3]), [0.0; 3]));
        assert!(near(lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20]));
        assert!((delta_e([0.0; 3], [1.0; 3]) - 100.0).abs() < 0.05);
    }

    #[test]
    fn a_lost_spot_is_found_where_it_was_and_in_its_region() {
        let plain = Picture::new(60, 50, [200, 160, 130, 255]).unwrap();
        let mut spot = plain.clone();
        for (x, y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
            spot.set(40 + x, 20 + y, [20, 10, 10, 255]);
        }
        let mut regions = vec![Some(JudgedRegion::Body); 60 * 50];
        for y in 10..30 {
            regions[y * 60 + 30..y * 60 + 55].fill(Some(JudgedRegion::Face));
        }
        let found = local_differences(&spot, &plain, &regions, 1.0, 3.5);
        let face = found.of(JudgedRegion::Face).unwrap();
        assert!((41..=42).contains(&face.x) && (21..=22).contains(&face.y));
        assert!(face.frame == 3.5 && face.delta_e > 30.0, "{face:?}");
        let rest = found.rest().unwrap();
        assert!(rest.region == JudgedRegion::Body && rest.delta_e < 1e-3);
        assert_eq!(found.largest(), Some(face));
        assert_eq!(found.of(JudgedRegion::Hands), None);
        let same = local_differences(&spot, &spot, &regions, 1.0, 0.0);
        assert_eq!(same.largest().map(|w| w.delta_e), Some(0.0));
    }

    #[test]
    fn a_uniform_picture_stays_what_it_is_up_to_the_border() {
        let a = Picture::new(9, 7, [255; 4]).unwrap();
        let b = Picture::new(9, 7, [0, 0, 0, 255]).unwrap();
        let regions = vec![Some(JudgedRegion::Body); 63];
        let found = local_differences(&a, &b, &regions, 2.0, 0.0);
        assert!((found.largest().unwrap().delta_e - 100.0).abs() < 0.05);
        let none = local_differences(&a, &b, &[None; 63], 2.0, 0.0);
        assert_eq!(none.largest(), None);
    }

    #[test]
    fn regions_grow_by_their_reach_and_the_face_wins() {
        let mut regions = vec![None; 49];
        regions[3 * 7 + 1] = Some(JudgedRegion::Body);
        regions[3 * 7 + 5] = Some(JudgedRegion::Face);
        let grown = extended(regions, 7, 2);
        assert_eq!(grown[3 * 7 + 3], Some(JudgedRegion::Face));
        assert_eq!(grown[3 * 7 + 2], Some(JudgedRegion::Body));
        // A diamond of radius 2 has 13 pixels; the left one is cut by one, and they share one.
        assert_eq!(grown.iter().flatten().count(), 12 + 12 - 1);
    }
}
