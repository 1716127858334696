//! Numbers by frame, as few keys.

/// Maximum absolute coordinate, grid steps; players compute in `f32`.
const MAX_GRID: u32 = 1 << 20;

/// Numbers interpolated linearly from key to key.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct KeyedTrack {
    /// Frame of each key, ascending. A single key is constant. Otherwise the first is 0 and the
    /// last the clip's last frame.
    pub frames: Vec<u32>,
    /// `frames.len() * width` numbers.
    pub values: Vec<i32>,
    /// Numbers per key.
    pub width: usize,
}

impl KeyedTrack {
    pub(crate) fn check(&self, frames: u32) -> Result<(), &'static str> {
        if self.is_empty() || self.values.len() != self.width * self.len() {
            return Err("every key needs a full row of values");
        }
        let rises = self.frames.windows(2).all(|pair| pair[0] < pair[1]);
        let last = self.frames[self.len() - 1];
        if !rises || self.frames[0] != 0 || !(self.is_still() || last == frames - 1) {
            return Err("the keys must rise from the first frame to the last");
        }
        let reach = |v: &i32| v.unsigned_abs() <= MAX_GRID;
        if !self.values.iter().all(reach) {
            return Err("a value exceeds the grid");
        }
        Ok(())
    }

    /// Returns a constant track.
    pub(crate) fn still(values: Vec<i32>) -> Self {
        Self {
            frames: vec![0],
            width: values.len(),
            values,
        }
    }

    /// Whether the track has only one key.
    pub(crate) fn is_still(&self) -> bool {
        self.frames.len() < 2
    }

    /// Numbers of a key.
    pub(crate) fn key(&self, key: usize) -> &[i32] {
        &self.values[key * self.width..(key + 1) * self.width]
    }

    /// Number of keys.
    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether the track has no keys.
    pub(crate) fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Numbers at a time in frames; clamped at the ends.
    pub(crate) fn at(&self, frame: f64) -> Vec<f64> {
        let after = self.frames.partition_point(|f| f64::from(*f) <= frame);
        let of = |key: usize| self.key(key).iter().map(|v| f64::from(*v));
        if self.is_empty() {
            return Vec::new();
        }
        if after == 0 || after == self.len() {
            return of(after.saturating_sub(1)).collect();
        }
        let (from, to) = (
            f64::from(self.frames[after - 1]),
            f64::from(self.frames[after]),
        );
        let share = (frame - from) / (to - from);
        of(after - 1)
            .zip(of(after))
            .map(|(a, b)| a + (b - a) * share)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_track_runs_straight_and_holds_at_its_ends() {
        let track = KeyedTrack {
            frames: vec![0, 4, 6],
            values: vec![0, 10, 8, 10, 8, 0],
            width: 2,
        };
        assert_eq!(track.at(1.0), [2.0, 10.0]);
        assert_eq!(track.at(5.0), [8.0, 5.0]);
        assert_eq!(track.at(-1.0), [0.0, 10.0]);
        assert_eq!(track.at(9.0), [8.0, 0.0]);
        assert_eq!(KeyedTrack::still(vec![3]).at(7.5), [3.0]);
        assert!(KeyedTrack::default().at(0.0).is_empty());
    }
}
