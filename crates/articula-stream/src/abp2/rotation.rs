//! Rotations from rotation vectors, with the same bits on every platform.
//!
//! Form: `docs/formats/abp2.md`, part 4. Only additions and multiplications of 32-bit floats in the
//! written order occur, which IEEE 754 defines to the bit.

use articula_core::Libm;
use glam::{DQuat, DVec3, Quat};

/// Square of pi, rounded up: the series are used up to half a turn.
const HALF_TURN: f32 = 9.87;

/// `sin(h) / h` and `cos h` by powers of `h²`.
const SINE: [f32; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COSINE: [f32; 9] = [
    1.0,
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

#[inline]
fn series<const TERMS: usize>(terms: &[f32; TERMS], x: f32) -> f32 {
    terms.iter().rev().fold(0.0, |sum, term| sum * x + term)
}

/// Returns the rotation by a rotation vector (axis times angle, radians).
#[inline]
pub(super) fn exp(vector: [f32; 3]) -> Quat {
    let mut h = vector.map(|x| x * 0.5);
    let mut halvings = 0;
    let square = |h: [f32; 3]| h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
    while square(h) > HALF_TURN {
        h = h.map(|x| x * 0.5);
        halvings += 1;
    }
    let s = series(&SINE, square(h));
    let mut q = Quat::from_xyzw(h[0] * s, h[1] * s, h[2] * s, series(&COSINE, square(h)));
    for _ in 0..halvings {
        q = product(q, q);
    }
    q
}

/// Returns the product of two rotations. That of `glam` adds in another order with SIMD.
#[inline]
pub(super) fn product(a: Quat, b: Quat) -> Quat {
    Quat::from_xyzw(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )
}

/// Returns the rotation vector of a unit quaternion that is nearest to `near`: of the equivalent
/// ones, which differ by whole turns about the axis.
pub(super) fn log(q: DQuat, near: DVec3) -> DVec3 {
    let v = DVec3::new(q.x, q.y, q.z);
    let sine = v.length();
    if sine < 1e-12 {
        // Any axis will do for whole turns.
        let turns = (near.length() / std::f64::consts::TAU).round();
        return near.normalize_or_zero() * (turns * std::f64::consts::TAU);
    }
    let axis = v / sine;
    let angle = 2.0 * sine.libm_atan2(q.w);
    let turns = ((near.dot(axis) - angle) / std::f64::consts::TAU).round();
    axis * (angle + turns * std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    #[test]
    fn a_small_and_a_large_turn() {
        assert_eq!(exp([0.0; 3]), Quat::IDENTITY);
        let quarter = exp([std::f32::consts::FRAC_PI_2, 0.0, 0.0]);
        assert!((quarter.x - 0.5_f32.sqrt()).abs() < 1e-7 && quarter.y == 0.0);
        // Three turns and a bit.
        let more = exp([0.0, 6.0 * std::f32::consts::PI + 0.2, 0.0]);
        assert!((more.y.abs() - 0.1_f32.sin()).abs() < 1e-5, "{more}");
    }

    #[test]
    fn a_vector_goes_on_beyond_half_a_turn() {
        let mut near = DVec3::ZERO;
        for step in 0..100 {
            let angle = f64::from(step) * 0.1;
            near = log(DQuat::from_rotation_z(angle), near);
            assert!((near - DVec3::Z * angle).length() < 1e-9, "{angle}: {near}");
        }
    }

    proptest! {
        #[test]
        fn a_rotation_comes_back(v in prop::array::uniform3(-3.0f32..3.0)) {
            let wanted = Quat::from_scaled_axis(Vec3::from(v));
            let found = exp(v);
            prop_assert!((found.dot(wanted).abs() - 1.0).abs() < 3e-6);
            prop_assert!((product(found, wanted.conjugate()).xyz().length()) < 3e-6);
            let back = log(found.as_dquat().normalize(), Vec3::from(v).as_dvec3());
            prop_assert!((back.as_vec3() - Vec3::from(v)).length() < 1e-5);
        }
    }
}
