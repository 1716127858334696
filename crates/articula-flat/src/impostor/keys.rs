//! Key poses of a clip: the fewest whose pose differs from the motion by no more than a distance.

use super::samples::ClipSamples;
use articula_core::{lod_error_metres, percentile};

/// Vertices by which poses are compared.
const MAX_VERTICES: usize = 250;

/// A pose that is shown for a stretch of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Key {
    /// First sample that shows it.
    pub(super) from: usize,
    /// Sample of the pose.
    pub(super) pose: usize,
}

/// Distances between the samples of a clip, computed when they are first needed.
#[derive(Debug)]
pub(super) struct Distances<'a> {
    samples: &'a ClipSamples,
    every: usize,
    known: Vec<f32>,
    room: Vec<f32>,
}

impl<'a> Distances<'a> {
    pub(super) fn new(samples: &'a ClipSamples) -> Self {
        let count = samples.points.len();
        let vertices = samples.points.first().map_or(0, Vec::len);
        Self {
            samples,
            every: vertices.div_ceil(MAX_VERTICES).max(1),
            known: vec![f32::NAN; count * count],
            room: Vec::new(),
        }
    }

    /// Distance between two samples, at least what any eye sees of it: the larger of the 95th
    /// percentile and half of the maximum over vertices.
    fn between(&mut self, a: usize, b: usize) -> f32 {
        let count = self.samples.points.len();
        let known = self.known[a * count + b];
        if !known.is_nan() {
            return known;
        }
        let points = &self.samples.points;
        let pairs = points[a].iter().zip(&points[b]).step_by(self.every);
        self.room.clear();
        self.room.extend(pairs.map(|(a, b)| a.distance(*b)));
        let found = judged(&mut self.room);
        self.known[a * count + b] = found;
        self.known[b * count + a] = found;
        found
    }

    /// The fewest keys with every sample within `most_m` of the key that it shows, each shown for
    /// one stretch.
    pub(super) fn keys(&mut self, most_m: f32) -> Vec<Key> {
        let count = self.samples.points.len();
        let mut keys = Vec::new();
        let mut from = 0;
        while from < count {
            // The farthest pose that serves all samples before it, then the farthest that it serves.
            let mut pose = from;
            while pose + 1 < count && (from..=pose).all(|s| self.between(s, pose + 1) <= most_m) {
                pose += 1;
            }
            let mut to = pose + 1;
            while to < count && self.between(pose, to) <= most_m {
                to += 1;
            }
            keys.push(Key { from, pose });
            from = to;
        }
        keys
    }
}

/// Error of distances: the larger of the 95th percentile and half of the maximum. Reorders them.
pub(super) fn judged(distances: &mut [f32]) -> f32 {
    let most = distances.iter().copied().fold(0.0, f32::max);
    lod_error_metres(percentile(distances, 0.95), most)
}

/// The key that a sample shows.
pub(super) fn shown(keys: &[Key], sample: usize) -> usize {
    keys.partition_point(|k| k.from <= sample).saturating_sub(1)
}

/// Start of each key in seconds: halfway between the last sample of the one before and its first.
pub(super) fn starts(keys: &[Key], samples: &ClipSamples) -> Vec<f32> {
    let times = &samples.times_secs;
    let start = |key: &Key| match key.from {
        0 => 0.0,
        from => 0.5 * (times[from - 1] + times[from]),
    };
    keys.iter().map(start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// One vertex that moves along x by these metres.
    fn motion(places: &[f32]) -> ClipSamples {
        ClipSamples {
            duration_secs: places.len() as f32 - 1.0,
            times_secs: (0..places.len()).map(|i| i as f32).collect(),
            points: places.iter().map(|x| vec![Vec3::X * *x]).collect(),
            centres: vec![Vec3::ZERO; places.len()],
        }
    }

    #[test]
    fn keys_serve_both_sides_and_are_fewest() {
        let samples = motion(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        let mut distances = Distances::new(&samples);
        let keys = distances.keys(1.0);
        let expected = [Key { from: 0, pose: 1 }, Key { from: 3, pose: 4 }];
        assert_eq!(keys, expected);
        assert_eq!(starts(&keys, &samples), [0.0, 2.5]);
        assert_eq!([0, 2, 3, 5].map(|s| shown(&keys, s)), [0, 0, 1, 1]);
        assert_eq!(distances.keys(0.5).len(), 6);
        assert_eq!(
            distances.keys(2.5),
            [Key { from: 0, pose: 2 }, Key { from: 5, pose: 5 }]
        );
    }
}
