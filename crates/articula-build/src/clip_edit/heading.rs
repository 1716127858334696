//! Heading of a rotated body.

use articula_core::Libm;
use glam::Quat;

/// Returns the part of a rotation that is about the vertical, radians from -pi to pi: the twist of
/// its swing-twist decomposition. A rotation by half a circle about a level axis has none and
/// yields 0.
pub(crate) fn yaw(turn: Quat) -> f32 {
    let half = turn.y.libm_atan2(turn.w);
    wrapped(2.0 * half)
}

/// The same angle from -pi to pi.
pub(crate) fn wrapped(radians: f32) -> f32 {
    use std::f32::consts::{PI, TAU};
    let turned = (radians + PI).rem_euclid(TAU) - PI;
    if turned < -PI { PI } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn the_twist_of_a_turn_by_hand() {
        for angle in [-3.0f32, -0.5, 0.0, 1.0, 3.1] {
            let turn = Quat::from_rotation_y(angle);
            assert!((yaw(turn) - angle).abs() < 1e-5);
            assert!(
                (yaw(-turn) - angle).abs() < 1e-5,
                "q and -q are one rotation"
            );
            // Leaning on top does not change it.
            let leaning = turn * Quat::from_rotation_x(0.4);
            assert!((yaw(leaning) - angle).abs() < 1e-5);
        }
        assert!(yaw(Quat::from_rotation_x(PI)).abs() < 1e-6);
        assert!((wrapped(4.0) - (4.0 - 2.0 * PI)).abs() < 1e-6);
    }
}
