//! Weight of each view picture for a triangle in a pose.
//!
//! Source: `docs/methods/vector.md` part 10: the square of the area in the view over the area in
//! the pose, capped at 2, times the nearness of the view; zero where the triangle was covered.
//! Nearness falls linearly with the angle, so a pose that is a view shows that view alone.

use super::head::HeadPose;

/// Maximum ratio of areas.
const CAP: f32 = 2.0;
/// Minimum nearness of a view, reached at the distance of its neighbour.
const FAR: f32 = 0.004;

/// Nearness of the pose to each view: 1 at the view, falling linearly to nearly 0 at its neighbour.
/// An axis on which all views agree is ignored.
pub(super) fn nearness(views: &[HeadPose], pose: &HeadPose) -> Vec<f32> {
    let yaw = span(views.iter().map(|v| v.yaw_degrees));
    let pitch = span(views.iter().map(|v| v.pitch_degrees));
    let fall = |from: f32, to: f32, span: Option<f32>| match span {
        Some(span) => (1.0 - (from - to).abs() / span).max(FAR),
        None => 1.0,
    };
    let near = |v: &HeadPose| {
        fall(v.yaw_degrees, pose.yaw_degrees, yaw)
            * fall(v.pitch_degrees, pose.pitch_degrees, pitch)
    };
    views.iter().map(near).collect()
}

/// Maximum absolute value; `None` if all values are zero.
fn span(values: impl Iterator<Item = f32>) -> Option<f32> {
    let most = values.map(f32::abs).fold(0.0, f32::max);
    (most > 0.0).then_some(most)
}

/// Weight of each view for one triangle; they sum to 1.
///
/// `view_areas` and `area` are in square pixels, `seen` contains the views in which nothing covers
/// the triangle. Without any such view, the one in which its area is largest has weight 1.
pub(super) fn view_weights(
    view_areas: &[f32],
    seen: &[bool],
    nearness: &[f32],
    area: f32,
) -> Vec<f32> {
    let pose_area = area.abs().max(1e-3);
    let weight = |i: usize| {
        if !seen[i] {
            return 0.0;
        }
        let ratio = (view_areas[i].abs() / pose_area).min(CAP);
        ratio * ratio * nearness[i]
    };
    let mut weights: Vec<f32> = (0..view_areas.len()).map(weight).collect();
    let sum: f32 = weights.iter().sum();
    if sum > 0.0 {
        weights.iter_mut().for_each(|w| *w /= sum);
        return weights;
    }
    let areas = view_areas.iter().map(|a| a.abs());
    let most = areas
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    if let Some((i, _)) = most {
        weights[i] = 1.0;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_by_hand() {
        let near = [1.0; 3];
        // Ratios 1, 0.5 and 3 (capped at 2): squares 1, 0.25 and 4.
        let found = view_weights(&[10.0, 5.0, 30.0], &[true; 3], &near, 10.0);
        let expected = [1.0 / 5.25, 0.25 / 5.25, 4.0 / 5.25];
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-6, "{found:?}");
        }
        // A view in which it was covered has no weight.
        let found = view_weights(&[10.0, 5.0, 30.0], &[true, true, false], &near, 10.0);
        assert!(
            (found[0] - 0.8).abs() < 1e-6 && found[2] == 0.0,
            "{found:?}"
        );
        let hidden = view_weights(&[1.0, 4.0, -3.0], &[false; 3], &near, 10.0);
        assert_eq!(hidden, [0.0, 1.0, 0.0]);
        assert!(view_weights(&[], &[], &[], 1.0).is_empty());
    }

    #[test]
    fn a_view_is_nearest_to_itself() {
        let views = [0.0, -45.0, 45.0].map(HeadPose::yaw);
        assert_eq!(nearness(&views, &HeadPose::yaw(0.0)), [1.0, FAR, FAR]);
        assert_eq!(nearness(&views, &HeadPose::yaw(45.0)), [FAR, FAR, 1.0]);
        let found = nearness(&views, &HeadPose::yaw(15.0));
        assert!((found[0] - 2.0 / 3.0).abs() < 1e-6 && (found[2] - 1.0 / 3.0).abs() < 1e-6);
        let one = [HeadPose::default()];
        assert_eq!(nearness(&one, &HeadPose::yaw(40.0)), [1.0]);
    }
}
