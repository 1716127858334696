//! The per-joint metric of Ahn et al.: a view-independent baseline.
//!
//! Source: thesis 5.2 (its account of Ahn and Wohn), `docs/methods/motion-lod.md` 3.3. The error of
//! showing a key posture is `2 alpha ||log|| + r angle`, and since twice the norm of the quaternion
//! logarithm is the angle, `(alpha + r) angle`.

use crate::motion_error::keys::{LONGEST_RUN, Reach, Segment};
use glam::Quat;

/// Cuts one joint's motion greedily into the longest runs, of at most [`LONGEST_RUN`] frames, whose
/// error to their middle frame stays below `threshold`. `radius` is the joint's `r` in metres.
pub(crate) fn clusters(values: &[Quat], alpha: f32, radius: f32, threshold: f32) -> Vec<Segment> {
    let reach = Reach::new(threshold / (alpha + radius).max(1e-9));
    let mut segments = Vec::new();
    let mut start = 0;
    while start < values.len() {
        let mut key = values[start];
        let mut end = start + 1;
        while end < values.len().min(start + LONGEST_RUN) {
            let middle = values[(start + end) / 2];
            if !values[start..=end]
                .iter()
                .all(|q| reach.exceeds(middle, *q))
            {
                break;
            }
            key = middle;
            end += 1;
        }
        segments.push(Segment { start, key });
        start = end;
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_turn_by_hand() {
        let values: Vec<Quat> = (0..6)
            .map(|i| Quat::from_rotation_x(0.1 * i as f32))
            .collect();
        // alpha 1 and r 1: 0.3 is 0.15 rad, one frame to either side of the middle.
        let runs = clusters(&values, 1.0, 1.0, 0.3);
        assert_eq!(runs.iter().map(|s| s.start).collect::<Vec<_>>(), [0, 3]);
        assert_eq!(runs[1].key, values[4]);
    }
}
