//! Errors on the screen of what is no crowd of Articula.

use articula::crowd::{Camera, NEAR_METRES};
use articula_build::SceneCharacter;
use articula_core::percentile_at_or_above;
use glam::{Vec2, Vec3};

/// Points nearer to the camera's plane than this are not drawn.
const NEAR_PLANE_METRES: f32 = 0.1;

/// Errors of the measured characters, pixels.
#[derive(Default)]
pub(super) struct Errors {
    /// Errors of the random sample.
    pub(super) drawn: Vec<f32>,
    /// Maximum error of characters within 20 m, in the sample or not.
    pub(super) near_px: f32,
}

impl Errors {
    /// Adds a character at a distance from the camera.
    pub(super) fn add(&mut self, px: f32, metres: f32, drawn: bool) {
        if metres < NEAR_METRES {
            self.near_px = self.near_px.max(px);
        }
        if drawn {
            self.drawn.push(px);
        }
    }
}

/// 95th percentile, over the points on the screen, of the distance in pixels between two skins of
/// a character.
pub(super) fn distance_px(
    camera: &Camera,
    member: &SceneCharacter,
    shown: &[Vec3],
    truth: &[Vec3],
) -> f32 {
    let place = member.world_from_model();
    let size = Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
    let apart = shown.iter().zip(truth).filter_map(|(shown, truth)| {
        let (shown, _) = camera.project(place.transform_point3(*shown));
        let (truth, depth) = camera.project(place.transform_point3(*truth));
        let on_screen = truth.cmpge(Vec2::ZERO).all() && truth.cmple(size).all();
        (depth > NEAR_PLANE_METRES && on_screen).then(|| shown.distance(truth))
    });
    p95_px(apart.collect())
}

/// 95th percentile, the value at or above it; 0 without values.
pub(super) fn p95_px(values: Vec<f32>) -> f32 {
    let mut values: Vec<f64> = values.into_iter().map(f64::from).collect();
    percentile_at_or_above(&mut values, 0.95) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_the_screen_does_not_count() {
        use articula_build::{Plaza, plaza};
        let scene = plaza(4, &[1], 1, Plaza::Still);
        let camera = scene.camera_at(0.0).unwrap();
        let member = SceneCharacter {
            position: Vec3::ZERO,
            yaw_radians: 0.0,
            ..scene.members[0]
        };
        // 10 m ahead at the height of the camera, and beside it.
        let ahead = camera.eye + 10.0 * camera.forward();
        let (beside, moved) = (camera.eye + Vec3::X, 0.01 * Vec3::X);
        let both = [ahead, beside];
        let px = distance_px(&camera, &member, &both.map(|p| p + moved), &both);
        let expected = 0.01 * camera.viewport.pixels_per_metre(10.0);
        assert!((px - expected).abs() < 1e-2, "{px} px, {expected} expected");
    }

    #[test]
    fn the_95th_of_a_hundred() {
        let values: Vec<f32> = (0..=100).rev().map(|i| i as f32).collect();
        assert_eq!(p95_px(values), 95.0);
        assert_eq!(p95_px(Vec::new()), 0.0);
    }
}
