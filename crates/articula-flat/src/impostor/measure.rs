//! The error of impostors, measured on vertices as an eye sees them.

use super::keys::{Key, judged, shown};
use super::samples::ClipSamples;
use super::views::{ImpostorView, ImpostorViews};
use glam::Vec3;

/// Maximum number of samples of a clip at which the error is measured.
const MAX_TIMES: usize = 48;

/// Measures the error of one clip in metres: at times and from eyes at the corners of what each
/// direction is shown to, the distance across the view between a vertex and where the picture shows
/// it; the larger of the 95th percentile and half of the maximum over vertices, the maximum over
/// times and eyes.
pub(super) fn error_m(samples: &ClipSamples, keys: &[Key], views: &ImpostorViews) -> f32 {
    let directions: Vec<ImpostorView> = views.iter().collect();
    let corners = views.corners();
    let mut worst = 0.0f32;
    let mut distances = Vec::new();
    for (turn, at) in times(samples.points.len(), keys).into_iter().enumerate() {
        let truth = &samples.points[at];
        let key = keys[shown(keys, at)].pose;
        let centre = samples.centres[key];
        let pose: Vec<Vec3> = samples.centred(key).collect();
        for (i, (view, corners)) in directions.iter().zip(&corners).enumerate() {
            // Each time looks from one of the corners, in turns, so that every corner is seen at
            // several times.
            let to_eye = corners[(turn + i) % corners.len()];
            distances.clear();
            let pairs = truth.iter().zip(&pose);
            distances.extend(pairs.map(|(p, q)| across(*p - centre - view.shown(*q), to_eye)));
            worst = worst.max(judged(&mut distances));
        }
    }
    worst
}

/// Length of a displacement as an eye in this direction sees it.
fn across(displacement: Vec3, to_eye: Vec3) -> f32 {
    (displacement - to_eye * to_eye.dot(displacement)).length()
}

/// Samples at which the error is measured: the ends of what keys show, where it is greatest, and
/// others evenly spaced.
fn times(count: usize, keys: &[Key]) -> Vec<usize> {
    let ends = keys.iter().flat_map(|k| [k.from.saturating_sub(1), k.from]);
    let mut all: Vec<usize> = ends.collect();
    all.push(count.saturating_sub(1));
    let every = all.len().div_ceil(MAX_TIMES).max(1);
    let mut all: Vec<usize> = all.into_iter().step_by(every).collect();
    let rest = MAX_TIMES.saturating_sub(all.len()).max(4);
    all.extend((0..count).step_by(count.div_ceil(rest).max(1)));
    all.sort_unstable();
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impostor::views::ViewRow;
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    #[test]
    fn the_error_is_depth_times_sine_and_motion() {
        // One row of four yaws with an upright plane, seen level: eyes are up to 45 degrees off.
        let views = ImpostorViews {
            rows: vec![ViewRow {
                from_radians: -FRAC_PI_2,
                pitch_radians: 0.0,
                lean: 0.0,
                yaws: 4,
            }],
            to_radians: FRAC_PI_2,
        };
        let still = |at: Vec3| ClipSamples {
            duration_secs: 0.0,
            times_secs: vec![0.0],
            points: vec![vec![at]],
            centres: vec![Vec3::ZERO],
        };
        let key = [Key { from: 0, pose: 0 }];
        // From straight above or below, a picture of the front shows a point on the axis that lies
        // on its plane where it is.
        assert!(error_m(&still(Vec3::Y), &key, &views) < 1e-6);
        // The corners are at the poles, from where all of the depth is seen.
        assert!((error_m(&still(Vec3::Z), &key, &views) - 1.0).abs() < 1e-6);
        let to_eye = Vec3::new(1.0, 0.0, 1.0) / 2f32.sqrt();
        let shown = views.rows[0].view(0).shown(Vec3::Z);
        assert!((across(Vec3::Z - shown, to_eye) - FRAC_PI_4.sin()).abs() < 1e-6);
        // A point that moves along the axis while its key stays.
        let moving = ClipSamples {
            duration_secs: 1.0,
            times_secs: vec![0.0, 1.0],
            points: vec![vec![Vec3::ZERO], vec![Vec3::X * 0.3]],
            centres: vec![Vec3::ZERO; 2],
        };
        let error = error_m(&moving, &key, &views);
        assert!((error - 0.3).abs() < 1e-6, "{error}");
    }
}
