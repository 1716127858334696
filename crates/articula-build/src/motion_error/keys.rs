//! Keys of one joint at one tolerance.
//!
//! Source: `docs/methods/motion-lod.md` 4.5 and 11. All three forms take the longest run that fits
//! before they start the next one. A run of blends or of one rotation ends after at most
//! [`LONGEST_RUN`] frames: testing ever longer runs is quadratic in their length.

use articula_core::Libm;
use articula_core::{angle_between, nlerp, same_hemisphere};
use glam::Quat;
use std::f32::consts::PI;

/// Maximum number of frames of a run found by trial. The clips of the published numbers are
/// shorter.
pub(crate) const LONGEST_RUN: usize = 512;

/// An upper limit on the angle between rotations, tested on the chord between their quaternions:
/// many times cheaper than the angle, and as exact where it is small.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    chord_squared: f32,
}

impl Reach {
    pub(crate) fn new(radians: f32) -> Self {
        let half_chord = (0.25 * radians).libm_sin();
        Self {
            chord_squared: if radians < PI {
                4.0 * half_chord * half_chord
            } else {
                f32::INFINITY
            },
        }
    }

    /// Whether the angle between two unit quaternions is at most the limit.
    pub(crate) fn covers(self, a: Quat, b: Quat) -> bool {
        chord_squared(a, b) <= self.chord_squared
    }

    /// Whether the angle between two unit quaternions is less than the limit.
    pub(crate) fn exceeds(self, a: Quat, b: Quat) -> bool {
        chord_squared(a, b) < self.chord_squared
    }
}

/// Monotone in the angle between two unit quaternions: `4 sin^2(angle / 4)`.
fn chord_squared(a: Quat, b: Quat) -> f32 {
    (a - same_hemisphere(a, b)).length_squared()
}

/// A run of frames and the one rotation shown for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Segment {
    /// First frame of the run.
    pub start: usize,
    /// Rotation shown during the run.
    pub key: Quat,
}

/// Frames at which a held rotation is renewed: as soon as it differs from the frame's own by more
/// than `radians`. Frame 0 is always a key. `candidates` are the frames that may be keys,
/// ascending; a coarser level passes the keys of the finer one, so that levels nest.
pub(crate) fn hold_keys(values: &[Quat], radians: f32, candidates: &[u32]) -> Vec<u32> {
    let mut keys: Vec<u32> = candidates.first().copied().into_iter().collect();
    let mut next = 1;
    for frame in 0..values.len() {
        let Some(&held) = keys.last() else { break };
        if angle_between(values[held as usize], values[frame]) <= radians {
            continue;
        }
        // The latest candidate up to here; other frames were covered by an earlier candidate.
        while next < candidates.len() && candidates[next] as usize <= frame {
            next += 1;
        }
        let latest = candidates[next - 1];
        if latest > held {
            keys.push(latest);
        }
    }
    keys
}

/// Frames between which a normalised linear blend stays within `radians` of every frame. Both ends
/// are keys. `candidates` as for [`hold_keys`].
pub(crate) fn linear_keys(values: &[Quat], radians: f32, candidates: &[u32]) -> Vec<u32> {
    let mut keys: Vec<u32> = candidates.first().copied().into_iter().collect();
    let reach = Reach::new(radians);
    // Slightly less than half: frames this close to the first key fit every blend.
    let close = Reach::new(0.499 * radians);
    let mut at = 0;
    while at + 1 < candidates.len() {
        let from = candidates[at] as usize;
        let (mut reached, mut all_close, mut seen) = (at + 1, true, from);
        for (c, to) in candidates.iter().enumerate().skip(at + 1) {
            let to = *to as usize;
            all_close = all_close && (seen..=to).all(|f| close.covers(values[from], values[f]));
            seen = to;
            if c == at + 1 {
                continue;
            }
            let short = to - from <= LONGEST_RUN;
            if !short || !(all_close || blends_within(values, from, to, reach)) {
                break;
            }
            reached = c;
        }
        keys.push(candidates[reached]);
        at = reached;
    }
    keys
}

/// Runs of frames that one rotation represents within `radians`: halfway between the two frames of
/// the run that differ most.
pub(crate) fn pose_segments(values: &[Quat], radians: f32) -> Vec<Segment> {
    let (reach, twice) = (Reach::new(radians), Reach::new(2.0 * radians));
    let mut segments = Vec::new();
    let mut start = 0;
    while start < values.len() {
        let mut key = values[start];
        let mut widest = (0.0, values[start], values[start]);
        let mut end = start + 1;
        while end < values.len().min(start + LONGEST_RUN) {
            for q in &values[start..end] {
                let chord = chord_squared(*q, values[end]);
                if chord > widest.0 {
                    widest = (chord, *q, values[end]);
                }
            }
            let middle = nlerp(widest.1, widest.2, 0.5);
            let run = &values[start..=end];
            if !twice.covers(widest.1, widest.2) || !run.iter().all(|q| reach.covers(*q, middle)) {
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

/// Approximation of the rotation whose maximum angle to all values is smallest: halfway between the
/// two values that differ most, or the best value where that fails (of many values, the best of
/// [`LONGEST_RUN`] of them).
pub(crate) fn central_rotation(values: &[Quat]) -> Option<Quat> {
    let first = *values.first()?;
    let farthest = |from: Quat| {
        values
            .iter()
            .copied()
            .max_by(|a, b| chord_squared(from, *a).total_cmp(&chord_squared(from, *b)))
    };
    let a = farthest(first)?;
    let b = farthest(a)?;
    let middle = nlerp(a, b, 0.5);
    let worst = |q: Quat| {
        values
            .iter()
            .map(|v| chord_squared(q, *v))
            .fold(0.0, f32::max)
    };
    // A candidate is rejected at the first value that is at least as far away as the farthest value
    // of the best one.
    let mut best = (worst(middle), middle);
    for q in values.iter().step_by(values.len().div_ceil(LONGEST_RUN)) {
        if values.iter().all(|v| chord_squared(*q, *v) < best.0) {
            best = (worst(*q), *q);
        }
    }
    Some(best.1)
}

fn blends_within(values: &[Quat], from: usize, to: usize, reach: Reach) -> bool {
    let span = (to - from) as f32;
    (from + 1..to).all(|f| {
        let blend = nlerp(values[from], values[to], (f - from) as f32 / span);
        reach.covers(blend, values[f])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(values: &[Quat]) -> Vec<u32> {
        (0..values.len() as u32).collect()
    }

    fn turn(angles: &[f32]) -> Vec<Quat> {
        angles.iter().map(|a| Quat::from_rotation_z(*a)).collect()
    }

    #[test]
    fn a_steady_turn_by_hand() {
        let values = turn(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        // 0.25 rad: frames 0, 1, 2 are within it of frame 0; frame 3 is not, and holds to the end.
        assert_eq!(hold_keys(&values, 0.25, &all(&values)), [0, 3]);
        assert_eq!(linear_keys(&values, 0.01, &all(&values)), [0, 5]);
        let segments = pose_segments(&values, 0.105);
        // One rotation covers a width of 0.21, three frames: 0..=2 by frame 1, 3..=5 by frame 4.
        assert_eq!(segments.iter().map(|s| s.start).collect::<Vec<_>>(), [0, 3]);
        assert!(angle_between(segments[1].key, values[4]) < 1e-4);
        assert!(
            angle_between(
                central_rotation(&values).unwrap(),
                Quat::from_rotation_z(0.25)
            ) < 1e-4
        );
        assert!(central_rotation(&[]).is_none());
    }

    #[test]
    fn chords_order_rotations_as_angles_do() {
        let a = Quat::from_rotation_x(0.4);
        for radians in [1e-4f32, 0.01, 0.5, 2.0, 3.1] {
            let near = -(a * Quat::from_rotation_y(0.999 * radians));
            let far = a * Quat::from_rotation_y(1.001 * radians);
            let reach = Reach::new(radians);
            assert!(reach.covers(a, near) && reach.exceeds(a, near), "{radians}");
            assert!(!reach.covers(a, far) && !reach.exceeds(a, far), "{radians}");
        }
        assert!(Reach::new(PI).covers(a, a * Quat::from_rotation_y(PI)));
    }

    #[test]
    fn a_long_stand_still_is_cut_into_runs_of_bounded_length() {
        let frames = 20_000usize;
        let values: Vec<Quat> = (0..frames)
            .map(|i| Quat::from_rotation_z(1e-3 * (0.01 * i as f32).sin()))
            .collect();
        let cuts = frames.div_ceil(LONGEST_RUN);
        let segments = pose_segments(&values, 0.5);
        assert_eq!(segments.len(), cuts);
        let keys = linear_keys(&values, 0.5, &all(&values));
        assert_eq!(keys.len(), cuts + 1);
        assert!(keys.windows(2).all(|w| w[1] - w[0] <= LONGEST_RUN as u32));
        assert_eq!(hold_keys(&values, 0.5, &all(&values)), [0]);
        let central = central_rotation(&values).unwrap();
        assert!(angle_between(central, Quat::IDENTITY) < 1e-5);
    }

    fn motion() -> impl Strategy<Value = Vec<Quat>> {
        prop::collection::vec((-0.2f32..0.2, -0.2f32..0.2), 2..60).prop_map(|steps| {
            let mut q = Quat::IDENTITY;
            steps
                .iter()
                .map(|(x, y)| {
                    q = (q * Quat::from_rotation_x(*x) * Quat::from_rotation_y(*y)).normalize();
                    q
                })
                .collect()
        })
    }

    proptest! {
        #[test]
        fn every_frame_is_within_the_tolerance_and_levels_nest(values in motion(), tolerance in 0.01f32..0.6) {
            let fine = hold_keys(&values, tolerance, &all(&values));
            let coarse = hold_keys(&values, 2.0 * tolerance, &fine);
            prop_assert!(coarse.iter().all(|k| fine.contains(k)));
            for (keys, limit) in [(&fine, tolerance), (&coarse, 2.0 * tolerance)] {
                for (f, q) in values.iter().enumerate() {
                    let held = keys.iter().rev().find(|k| **k as usize <= f).unwrap();
                    prop_assert!(angle_between(values[*held as usize], *q) <= limit + 1e-5);
                }
            }
            for keys in [linear_keys(&values, tolerance, &all(&values))] {
                prop_assert_eq!(*keys.last().unwrap() as usize, values.len() - 1);
                for w in keys.windows(2) {
                    let [from, to] = [w[0], w[1]].map(|k| k as usize);
                    for (f, q) in values.iter().enumerate().take(to).skip(from) {
                        let share = (f - from) as f32 / (to - from) as f32;
                        let blend = nlerp(values[from], values[to], share);
                        prop_assert!(angle_between(blend, *q) <= tolerance + 1e-4);
                    }
                }
            }
            let segments = pose_segments(&values, tolerance);
            for (f, q) in values.iter().enumerate() {
                let segment = segments.iter().rev().find(|s| s.start <= f).unwrap();
                prop_assert!(angle_between(segment.key, *q) <= tolerance + 1e-5);
            }
        }
    }
}
