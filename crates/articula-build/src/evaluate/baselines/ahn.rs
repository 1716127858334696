//! The per-joint metric of Ahn et al.: a view-independent baseline.
//!
//! Source: thesis 5.2 (its account of Ahn and Wohn), `docs/methods/motion-lod.md` 3.3. The error of
//! showing a key posture is `2 alpha ||log|| + r angle`, and since twice the norm of the quaternion
//! logarithm is the angle, `(alpha + r) angle`; a threshold on it is one on the angle.

use crate::motion_error::keys::{LONGEST_RUN, Reach, Segment};
use articula_core::angle_between;
use glam::Quat;

/// Cuts one joint's motion greedily into the longest runs, of at most [`LONGEST_RUN`] frames, whose
/// angle to their middle frame stays below `radians`.
pub(crate) fn clusters(values: &[Quat], radians: f32) -> Vec<Segment> {
    runs(values, radians, |start, end| (start + end) / 2)
}

/// As [`clusters`], with the frame that has the least sum of angles to all frames of the run, the
/// earliest of several.
pub(crate) fn least_sum_clusters(values: &[Quat], radians: f32) -> Vec<Segment> {
    // Sums of the angles from each frame of the run to all others.
    let mut sums = Vec::new();
    runs(values, radians, |start, end| {
        if end == start + 1 {
            sums = vec![0.0f64];
        }
        let mut own = 0.0;
        for (sum, q) in sums.iter_mut().zip(&values[start..end]) {
            let angle = f64::from(angle_between(*q, values[end]));
            *sum += angle;
            own += angle;
        }
        sums.push(own);
        let least = sums.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        start + least.map_or(0, |(frame, _)| frame)
    })
}

/// Cuts greedily into the longest runs that stay near their key frame. `key_frame` is called for
/// each frame that is tried as the end of a run, in order, with the first and that frame.
fn runs(
    values: &[Quat],
    radians: f32,
    mut key_frame: impl FnMut(usize, usize) -> usize,
) -> Vec<Segment> {
    let reach = Reach::new(radians);
    let mut segments = Vec::new();
    let mut start = 0;
    while start < values.len() {
        let mut key = values[start];
        let mut end = start + 1;
        while end < values.len().min(start + LONGEST_RUN) {
            let tried = values[key_frame(start, end)];
            if !values[start..=end].iter().all(|q| reach.exceeds(tried, *q)) {
                break;
            }
            key = tried;
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

    fn turns(radians: &[f32]) -> Vec<Quat> {
        radians.iter().map(|r| Quat::from_rotation_x(*r)).collect()
    }

    #[test]
    fn a_steady_turn_by_hand() {
        let values = turns(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        // 0.15 rad is one frame to either side of the middle.
        for cut in [clusters, least_sum_clusters] {
            let runs = cut(&values, 0.15);
            assert_eq!(runs.iter().map(|s| s.start).collect::<Vec<_>>(), [0, 3]);
            assert_eq!(runs[1].key, values[4]);
        }
    }

    #[test]
    fn the_key_has_the_least_sum_of_errors() {
        // Sums of the angles to the other frames, by hand: 0.52, 0.46, 0.44, 1.48 and 0.46 rad.
        let values = turns(&[0.0, 0.02, 0.04, 0.4, 0.06]);
        let runs = least_sum_clusters(&values, 1.0);
        assert_eq!(runs.len(), 1);
        assert_eq!(runs[0].key, values[2]);
        // Here it is the middle frame too, and another one where frames are unevenly spread.
        let late = turns(&[0.0, 0.3, 0.31, 0.32, 0.33, 0.01, 0.02]);
        let found = [clusters(&late, 1.0), least_sum_clusters(&late, 1.0)];
        assert_eq!(found[0][0].key, late[3], "the middle frame, at 0.32 rad");
        assert_eq!(found[1][0].key, late[1], "the median, at 0.30 rad");
    }
}
