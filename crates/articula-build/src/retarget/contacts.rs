//! Contacts: intervals in which feet and hands of the source stand still.
//!
//! Source: the method of `motion_error::contacts`, on the source's joints, with these differences:
//! speeds and heights are in leg lengths, so that they are independent of the figure's size; two
//! thresholds instead of one, so that a contact does not flicker; heel and toe are separate points,
//! because a step rolls from one to the other; and rest on something higher than the floor is
//! detected by standing still for longer.

use super::motion::Motion;
use glam::Vec3;
use std::ops::Range;

/// Speeds in leg lengths per second below which a contact begins and above which it ends.
const FLOOR_SPEEDS: [f32; 2] = [0.18, 0.35];
/// Heights in leg lengths above the floor, likewise.
const FLOOR_HEIGHTS: [f32; 2] = [0.06, 0.11];
/// Minimum duration of a contact with the floor.
const FLOOR_SECS: f32 = 0.07;
/// Speeds for contact with something above the floor, where height gives no indication.
const RAISED_SPEEDS: [f32; 2] = [0.06, 0.15];
const RAISED_SECS: f32 = 0.3;
/// Maximum distance of a point in contact from where the contact began, in leg lengths.
const FARTHEST: f32 = 0.12;
/// Time over which speeds are measured, so that noise of fast captures does not end a contact.
const SPEED_SECS: f32 = 0.04;

/// One contact of one point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Contact {
    /// Frames during which the point stands still.
    pub(super) frames: Range<usize>,
    /// Whether it stands on the floor rather than on something above.
    pub(super) on_floor: bool,
}

/// Finds the contacts of a point that moves along a path above a floor.
pub(super) fn contacts(path: &[Vec3], motion: &Motion, leg: f32, floor: f32) -> Vec<Contact> {
    let rate = motion.rate_hz;
    let speeds = speeds(path, rate, leg);
    let height = |f: usize| (path[f].y - floor) / leg;
    let frames = |secs: f32| ((secs * rate).ceil() as usize).max(1);
    let on_floor = runs(
        path.len(),
        |f| speeds[f] < FLOOR_SPEEDS[0] && height(f) < FLOOR_HEIGHTS[0],
        |f| speeds[f] < FLOOR_SPEEDS[1] && height(f) < FLOOR_HEIGHTS[1],
        frames(FLOOR_SECS),
    );
    let mut found: Vec<Contact> = on_floor
        .into_iter()
        .map(|frames| Contact {
            frames,
            on_floor: true,
        })
        .collect();
    let raised = still(&speeds, frames(RAISED_SECS));
    for frames in raised {
        let free = |c: &Contact| c.frames.end <= frames.start || frames.end <= c.frames.start;
        if found.iter().all(free) {
            found.push(Contact {
                frames,
                on_floor: false,
            });
        }
    }
    found.sort_by_key(|c| c.frames.start);
    keep_still(&mut found, path, leg);
    found
}

/// Drops contacts during which a point moves far: it slides on purpose, or the whole clip is in
/// slow motion.
fn keep_still(contacts: &mut Vec<Contact>, path: &[Vec3], leg: f32) {
    contacts.retain(|c| {
        let start = path[c.frames.start];
        let way = c.frames.clone().map(|f| path[f].distance(start));
        way.fold(0.0, f32::max) < FARTHEST * leg
    });
}

/// Finds the contacts of a point that may rest on anything, such as a hand.
pub(super) fn rests(path: &[Vec3], motion: &Motion, leg: f32) -> Vec<Contact> {
    let speeds = speeds(path, motion.rate_hz, leg);
    let least = ((RAISED_SECS * motion.rate_hz).ceil() as usize).max(1);
    let still = still(&speeds, least).into_iter();
    let mut found: Vec<Contact> = still
        .map(|frames| Contact {
            frames,
            on_floor: false,
        })
        .collect();
    keep_still(&mut found, path, leg);
    found
}

fn still(speeds: &[f32], least: usize) -> Vec<Range<usize>> {
    runs(
        speeds.len(),
        |f| speeds[f] < RAISED_SPEEDS[0],
        |f| speeds[f] < RAISED_SPEEDS[1],
        least,
    )
}

/// Speed at each frame in leg lengths per second, measured over a short time around it.
fn speeds(path: &[Vec3], rate_hz: f32, leg: f32) -> Vec<f32> {
    let around = ((0.5 * SPEED_SECS * rate_hz).round() as usize).max(1);
    (0..path.len())
        .map(|f| {
            let (a, b) = (f.saturating_sub(around), (f + around).min(path.len() - 1));
            let secs = (b - a).max(1) as f32 / rate_hz;
            path[b].distance(path[a]) / (secs * leg)
        })
        .collect()
}

/// Runs of at least `least` frames that begin where `enters` holds, in both directions of time, and
/// last as long as `stays` holds.
fn runs(
    frames: usize,
    enters: impl Fn(usize) -> bool,
    stays: impl Fn(usize) -> bool,
    least: usize,
) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    let mut f = 0;
    while f < frames {
        if !stays(f) {
            f += 1;
            continue;
        }
        let start = f;
        while f < frames && stays(f) {
            f += 1;
        }
        // Within frames that are calm enough to stay, from the first to the last that is calm
        // enough to enter.
        let first = (start..f).find(|g| enters(*g));
        let last = (start..f).rev().find(|g| enters(*g));
        if let (Some(first), Some(last)) = (first, last)
            && last + 1 - first >= least
        {
            runs.push(first..last + 1);
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_bridges_what_is_between_the_thresholds() {
        let value = [9, 1, 5, 1, 9, 1, 9, 5, 5, 5];
        let found = runs(10, |f| value[f] < 3, |f| value[f] < 7, 1);
        assert_eq!(found, [1..4, 5..6]);
        let long = runs(10, |f| value[f] < 3, |f| value[f] < 7, 2);
        assert_eq!(long, vec![1..4; 1]);
        assert!(runs(0, |_| true, |_| true, 1).is_empty());
    }

    #[test]
    fn speed_is_in_legs_a_second() {
        let path: Vec<Vec3> = (0..9).map(|f| Vec3::X * (0.1 * f as f32)).collect();
        for speed in speeds(&path, 10.0, 0.5) {
            assert!((speed - 2.0).abs() < 1e-5);
        }
        assert_eq!(speeds(&path[..1], 10.0, 0.5), [0.0]);
    }
}
