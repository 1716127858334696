//! Rotation vectors, for computations that are linear in them.

use articula_core::same_hemisphere;
use glam::{Quat, Vec3};

/// Rotation vector (axis times angle, radians) of the shorter rotation from `a` to `b`.
pub(crate) fn rotation_vector(a: Quat, b: Quat) -> Vec3 {
    let relative = same_hemisphere(Quat::IDENTITY, a.conjugate() * b);
    let v = Vec3::new(relative.x, relative.y, relative.z);
    let sine = v.length();
    if sine < 1e-9 {
        return 2.0 * v;
    }
    v * (2.0 * sine.atan2(relative.w) / sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn rotation_vector_is_axis_times_angle() {
        let v = rotation_vector(Quat::IDENTITY, -Quat::from_rotation_z(FRAC_PI_2));
        assert!((v - Vec3::Z * FRAC_PI_2).length() < 1e-5);
    }
}
