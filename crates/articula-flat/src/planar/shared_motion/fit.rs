//! The affine motion that moves some triangles best.

use super::item::Item;
use super::placed::Placed;
use crate::planar::keyed_motion::{ANGLE, KeyedMotion, SCALE, TRANSLATION, parts};
use crate::planar::tunnel::{Windows, fewest_keys};
use glam::{DAffine2, DMat2, DVec2};

/// Rounds of fitting maps to places and places to maps.
const ROUNDS: usize = 6;
/// Weight of corners in frames in which they are not shown.
const HIDDEN: f64 = 0.02;
/// Second moment of places that is added as if the motion kept shape there, square grid steps: small
/// groups move rigidly.
const RIGID: f64 = 400.0;
/// Tolerance of a motion's keys, grid steps at the distance of its triangles.
const TOLERANCE: f64 = 0.4;
/// Least area factor of a map; below it the motion keeps shape instead.
pub(super) const LEAST_AREA: f64 = 0.05;

/// Motion of some items. Origin of the shapes' coordinates is their centre.
pub(super) fn fitted(items: &[&Item], frames: usize) -> KeyedMotion {
    let mut weights = vec![1.0; items.len()];
    let mut fit = Fit::new(items, frames);
    for _ in 0..ROUNDS {
        fit.maps(&weights);
        fit.places(&weights);
        weights = items.iter().map(|item| fit.trust(item)).collect();
    }
    fit.maps(&weights);
    fit.keyed()
}

struct Fit<'a> {
    items: &'a [&'a Item],
    /// Corners of the items in the coordinates of shapes.
    points: Vec<[DVec2; 3]>,
    maps: Vec<DAffine2>,
}

impl<'a> Fit<'a> {
    fn new(items: &'a [&'a Item], frames: usize) -> Self {
        let maps = vec![DAffine2::IDENTITY; frames];
        let points = Vec::new();
        let mut fit = Self {
            items,
            points,
            maps,
        };
        fit.places(&vec![1.0; items.len()]);
        fit
    }

    /// Mean place of each corner, by the inverse maps.
    fn places(&mut self, weights: &[f64]) {
        let inverse: Vec<DAffine2> = self.maps.iter().map(DAffine2::inverse).collect();
        let place = |item: &&Item| {
            let (mut sum, mut total) = ([DVec2::ZERO; 3], 0.0);
            for (f, corners) in item.corners.iter().enumerate() {
                let weight = if item.is_shown[f] { 1.0 } else { HIDDEN };
                total += weight;
                for (sum, corner) in sum.iter_mut().zip(corners) {
                    *sum += weight * inverse[f].transform_point2(*corner);
                }
            }
            sum.map(|sum| sum / total)
        };
        self.points = self.items.iter().map(place).collect();
        let of = |(points, weight): (&[DVec2; 3], &f64)| points.iter().sum::<DVec2>() * *weight;
        let sum: DVec2 = self.points.iter().zip(weights).map(of).sum();
        let centre = sum / (3.0 * weights.iter().sum::<f64>()).max(1e-9);
        for point in self.points.as_flattened_mut() {
            *point -= centre;
        }
    }

    /// Map of each frame, by least squares.
    fn maps(&mut self, weights: &[f64]) {
        self.maps = (0..self.maps.len()).map(|f| self.map(f, weights)).collect();
    }

    fn map(&self, frame: usize, weights: &[f64]) -> DAffine2 {
        let rows = || {
            let all = self.items.iter().zip(&self.points).zip(weights);
            all.flat_map(|((item, points), weight)| {
                let shown = if item.is_shown[frame] { 1.0 } else { HIDDEN };
                let pairs = points.iter().zip(&item.corners[frame]);
                pairs.map(move |(from, to)| (*from, *to, weight * shown))
            })
        };
        let zero = (DVec2::ZERO, DVec2::ZERO, 0.0);
        let (from, to, total) = rows().fold(zero, |(a, b, w), (from, to, weight)| {
            (a + weight * from, b + weight * to, w + weight)
        });
        let (from_mean, to_mean) = (from / total.max(1e-9), to / total.max(1e-9));
        let rigid = DMat2::from_diagonal(DVec2::splat(RIGID));
        let (mut moments, mut products) = (rigid, rigid);
        for (from, to, weight) in rows() {
            let (a, b) = (from - from_mean, to - to_mean);
            moments += weight * outer(a, a);
            products += weight * outer(b, a);
        }
        let mut linear = products * moments.inverse();
        if linear.determinant() < LEAST_AREA {
            linear = DMat2::IDENTITY;
        }
        DAffine2::from_mat2_translation(linear, to_mean - linear * from_mean)
    }

    /// Weight of an item: less, the further it is off its motion.
    fn trust(&self, item: &Item) -> f64 {
        let shown = (0..self.maps.len()).filter(|f| item.is_shown[*f]);
        let (mut low, mut high) = ([DVec2::INFINITY; 3], [DVec2::NEG_INFINITY; 3]);
        for f in shown {
            let placed = Placed::new(self.maps[f]);
            for (c, corner) in item.corners[f].iter().enumerate() {
                let point = placed.to_shape(*corner);
                low[c] = low[c].min(point);
                high[c] = high[c].max(point);
            }
        }
        let widest = |(low, high): (&DVec2, &DVec2)| (*high - *low).max_element() / 2.0;
        let off = low.iter().zip(&high).map(widest).fold(0.0, f64::max) / (2.0 * item.tolerance);
        1.0 / (1.0 + off * off)
    }

    fn keyed(&self) -> KeyedMotion {
        let lengths = self
            .points
            .as_flattened()
            .iter()
            .map(|p| p.length_squared());
        let mean = lengths.sum::<f64>() / (3 * self.points.len()).max(1) as f64;
        // Twice the root mean square: the distance of most corners from the centre.
        let radius = (2.0 * mean.sqrt()).max(1.0);
        let mut turned = 0.0;
        let mut rows = [const { Vec::new() }; 4];
        for map in &self.maps {
            let (angle, skew, scale) = parts(map.matrix2);
            let turns = ((turned - angle) / std::f64::consts::TAU).round();
            turned = angle + turns * std::f64::consts::TAU;
            rows[0].extend((map.translation * TRANSLATION).to_array());
            rows[1].push(turned.to_degrees() * ANGLE);
            rows[2].push(skew.to_degrees() * ANGLE);
            rows[3].extend((scale * SCALE).to_array());
        }
        let angle = (TOLERANCE / radius).to_degrees() * ANGLE;
        let frames = self.maps.len();
        let track = |targets: &[f64], reach: f64| {
            let (width, reach) = (targets.len() / frames, vec![reach; frames]);
            fewest_keys(&Windows {
                targets,
                width,
                reach: &reach,
            })
        };
        let scale = TOLERANCE / radius * SCALE;
        KeyedMotion {
            translation: track(&rows[0], TOLERANCE * TRANSLATION),
            rotation: track(&rows[1], angle),
            skew: track(&rows[2], angle),
            scale: track(&rows[3], scale),
        }
    }
}

/// `a` times the transpose of `b`.
fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}
