//! Profile of a face: the front-most depth for each height in a vertical plane, and the features
//! along it.

use super::surface::{FaceSurface, SurfacePart};
use articula_core::Libm;
use glam::Vec3;
use std::ops::Range;

/// Standard deviation of the smoothing, in steps.
const SMOOTHING: f32 = 1.6;

/// Depths of a cut, evenly spaced by height.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    /// Height of the first sample.
    low: f32,
    step: f32,
    /// Sideways place of the plane.
    x: f32,
    /// Depths from the lowest sample up.
    pub(super) z: Vec<f32>,
}

impl Profile {
    /// Cuts a part with the plane of constant `x`, between two heights. Gaps between known depths
    /// are bridged by straight lines. `None` if the plane cuts nothing.
    pub(super) fn cut(
        surface: &FaceSurface,
        part: &SurfacePart,
        x: f32,
        heights: Range<f32>,
        step: f32,
    ) -> Option<Self> {
        let count = ((heights.end - heights.start) / step).ceil() as usize + 1;
        let mut found: Vec<Option<f32>> = vec![None; count];
        for triangle in &part.triangles {
            let corners = surface.corners(triangle);
            let Some([a, b]) = crossing(corners, x) else {
                continue;
            };
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            let place = |y: f32| (y - heights.start) / step;
            let first = place(a.y).ceil().max(0.0) as usize;
            let last = place(b.y).floor();
            if last < 0.0 {
                continue;
            }
            let crossed = found
                .iter_mut()
                .enumerate()
                .take(last as usize + 1)
                .skip(first);
            for (index, known) in crossed {
                let along = (heights.start + index as f32 * step - a.y) / (b.y - a.y).max(1e-12);
                let z = a.z + (b.z - a.z) * along.clamp(0.0, 1.0);
                *known = Some(known.map_or(z, |known: f32| known.max(z)));
            }
        }
        Some(Self {
            low: heights.start,
            step,
            x,
            z: smoothed(&bridged(&found)?),
        })
    }

    /// Height of a sample.
    pub(super) fn height(&self, index: usize) -> f32 {
        self.low + index as f32 * self.step
    }

    /// Sample nearest to a height.
    pub(super) fn index(&self, height: f32) -> usize {
        let index = ((height - self.low) / self.step).round().max(0.0) as usize;
        index.min(self.z.len() - 1)
    }

    /// Place of a sample.
    pub(super) fn place(&self, index: usize) -> Vec3 {
        Vec3::new(self.x, self.height(index), self.z[index])
    }

    /// Samples with the largest value of `of`, among `range`.
    pub(super) fn most(&self, range: Range<usize>, of: impl Fn(usize) -> f32) -> Option<usize> {
        range.max_by(|a, b| of(*a).total_cmp(&of(*b)))
    }

    /// Second difference of the depth over `reach` samples, negative where the profile bulges.
    pub(super) fn bend(&self, index: usize, reach: usize) -> f32 {
        let low = self.z[index.saturating_sub(reach)];
        let high = self.z[(index + reach).min(self.z.len() - 1)];
        low + high - 2.0 * self.z[index]
    }

    /// How far a sample lies behind the fullest places within `reach` samples above and below it, in
    /// the tilt that shows it best.
    pub(super) fn groove(&self, index: usize, reach: usize, tilts: &[f32]) -> f32 {
        let above = index..(index + reach).min(self.z.len());
        let below = index.saturating_sub(reach)..index + 1;
        let depth = |tilt: &f32| {
            let of = |i: usize| self.z[i] + tilt * self.height(i);
            let most = |range: &Range<usize>| range.clone().map(of).fold(f32::MIN, f32::max);
            most(&above).min(most(&below)) - of(index)
        };
        tilts.iter().map(depth).fold(0.0, f32::max)
    }

    /// The first `count` extrema below a sample that bulges, hollow and bulge in turn, of depths
    /// tilted by `tilt` per height. Those that stand out by less than `prominence` are left out, the
    /// least first. `None` if there are fewer.
    pub(super) fn extrema_below(
        &self,
        from: usize,
        count: usize,
        prominence: f32,
        tilt: f32,
    ) -> Option<Vec<usize>> {
        let depth = |index: usize| self.z[index] + tilt * self.height(index);
        // The sample itself, the turns below it, and the end.
        let mut turns = vec![from];
        let mut falls = true;
        for index in (0..from).rev() {
            let last = turns[turns.len() - 1];
            let ahead = if index == 0 {
                None
            } else {
                Some(depth(index - 1))
            };
            let is_turn = match ahead {
                None => true,
                Some(ahead) if falls => ahead > depth(index),
                Some(ahead) => ahead < depth(index),
            };
            if is_turn && index < last {
                turns.push(index);
                falls = !falls;
            }
        }
        loop {
            let gap = |i: usize| (depth(turns[i + 1]) - depth(turns[i])).abs();
            let pairs = 0..turns.len().saturating_sub(1);
            let Some(least) = pairs.min_by(|a, b| gap(*a).total_cmp(&gap(*b))) else {
                break;
            };
            if gap(least) >= prominence {
                break;
            }
            // The first sample stays, so that the next turn after it goes alone with its successor.
            let first = least.max(1);
            turns.drain(first..(first + 2).min(turns.len()));
        }
        (turns.len() > count).then(|| turns[1..=count].to_vec())
    }
}

/// The line in which a triangle crosses a plane of constant x.
fn crossing(corners: [Vec3; 3], x: f32) -> Option<[Vec3; 2]> {
    let mut ends = Vec::with_capacity(3);
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if (a.x - x) * (b.x - x) <= 0.0 && a.x != b.x {
            ends.push(a.lerp(b, (x - a.x) / (b.x - a.x)));
        }
    }
    match ends[..] {
        [a, b] => Some([a, b]),
        // Through a corner: two of the three are the same.
        [a, b, c] => Some(if a.distance(b) >= a.distance(c) {
            [a, b]
        } else {
            [a, c]
        }),
        _ => None,
    }
}

/// Fills gaps between known values by straight lines, and repeats the first and last beyond them.
fn bridged(found: &[Option<f32>]) -> Option<Vec<f32>> {
    let known: Vec<(usize, f32)> = found
        .iter()
        .enumerate()
        .filter_map(|(i, z)| Some((i, (*z)?)))
        .collect();
    let (first, last) = (known.first()?, known.last()?);
    let mut filled = vec![first.1; found.len()];
    for pair in known.windows(2) {
        let [(i, a), (j, b)] = [pair[0], pair[1]];
        for (step, value) in filled[i..=j].iter_mut().enumerate() {
            *value = a + (b - a) * step as f32 / (j - i) as f32;
        }
    }
    filled[last.0..].fill(last.1);
    Some(filled)
}

/// Gaussian smoothing; values beyond the ends are those of the ends.
fn smoothed(z: &[f32]) -> Vec<f32> {
    const REACH: isize = 5;
    let weight = |k: isize| (-0.5 * (k as f32 / SMOOTHING).powi(2)).libm_exp();
    let total: f32 = (-REACH..=REACH).map(weight).sum();
    (0..z.len())
        .map(|index| {
            let near = |k: isize| {
                let at = index.saturating_add_signed(k).min(z.len() - 1);
                weight(k) * z[at]
            };
            (-REACH..=REACH).map(near).sum::<f32>() / total
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A profile without smoothing or a surface.
    fn of(z: &[f32]) -> Profile {
        Profile {
            low: 0.0,
            step: 1.0,
            x: 0.0,
            z: z.to_vec(),
        }
    }

    #[test]
    fn a_cut_takes_the_front_of_a_slanted_wall() {
        // The wall z = y / 2 for y from 0 to 4, and another one behind it.
        let wall = |z: f32| {
            [
                Vec3::new(-1.0, 0.0, z),
                Vec3::new(1.0, 0.0, z),
                Vec3::new(0.0, 4.0, z + 2.0),
            ]
        };
        let surface = FaceSurface {
            positions: [wall(0.0), wall(-1.0)].concat(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            ..FaceSurface::default()
        };
        let part = SurfacePart {
            triangles: surface.triangles.clone(),
            ..SurfacePart::default()
        };
        let cut = Profile::cut(&surface, &part, 0.25, 0.0..3.0, 0.01).unwrap();
        // At x = 0.25 the wall ends at y = 3. Smoothing keeps straight lines, but for the ends.
        let at = cut.index(1.5);
        let place = cut.place(at);
        assert!(
            (place.y - 1.5).abs() < 1e-5 && (place.z - 0.75).abs() < 1e-3,
            "{place}"
        );
        assert!(Profile::cut(&surface, &part, 1.5, 0.0..3.0, 0.1).is_none());
    }

    #[test]
    fn extrema_in_turn_without_those_that_hardly_stand_out() {
        // From the top (index 12): a bulge of 9, a hollow of 4, a ripple of 0.1, a bulge of 7, a
        // hollow of 2, and the end.
        let profile = of(&[
            3.0, 2.5, 2.0, 4.0, 7.0, 6.0, 5.0, 4.5, 4.6, 4.0, 5.0, 8.0, 9.0,
        ]);
        let turns = profile.extrema_below(12, 3, 0.2, 0.0).unwrap();
        assert_eq!(turns, [9, 4, 2]);
        let fine = profile.extrema_below(12, 5, 0.05, 0.0).unwrap();
        assert_eq!(fine, [9, 8, 7, 4, 2]);
        assert_eq!(profile.extrema_below(12, 5, 0.2, 0.0), None);
    }

    #[test]
    fn a_tilt_shows_a_hollow_on_a_slope() {
        let slope: Vec<f32> = (0..9)
            .map(|i| i as f32 - if i == 4 { 0.5 } else { 0.0 })
            .collect();
        let profile = of(&slope);
        assert_eq!(profile.groove(4, 3, &[0.0]), 0.0);
        assert!((profile.groove(4, 3, &[0.0, -1.0]) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn gaps_are_bridged() {
        let filled = bridged(&[None, Some(1.0), None, Some(3.0), None]).unwrap();
        assert_eq!(filled, [1.0, 1.0, 2.0, 3.0, 3.0]);
        assert_eq!(bridged(&[None, None]), None);
    }
}
