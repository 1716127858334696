//! Additions to `glam`: decomposed transforms, hemisphere-safe angles and blends of rotations.
//!
//! [`dot`], [`normalised`] and [`cross`] replace those of `glam` in a frame: its versions for
//! AArch64 sum in another order or round once where the others round twice.

use crate::Libm;
use glam::{Affine3A, Mat4, Quat, Vec3, Vec3A, Vec3Swizzles, Vec4, Vec4Swizzles};

/// A transform as scale, rotation and translation, applied in this order (as in glTF).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Offset from the parent in metres, in the parent's space.
    pub translation: Vec3,
    /// Unit quaternion.
    pub rotation: Quat,
    /// Scale along each axis; a negative one mirrors.
    pub scale: Vec3,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// The identity transform.
    pub const IDENTITY: Self = Self {
        translation: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        scale: Vec3::ONE,
    };

    /// Creates a pure translation, in metres.
    pub fn from_translation(translation: Vec3) -> Self {
        Self {
            translation,
            ..Self::IDENTITY
        }
    }

    /// Returns the transform as a 3x4 matrix.
    pub fn to_affine(self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }

    /// Decomposes a matrix; `None` if it is singular, not finite, or sheared by more than `1e-4` of
    /// its scale, so that no such transform exists.
    pub fn from_matrix(matrix: Mat4) -> Option<Self> {
        if !matrix.is_finite() || matrix.determinant().abs() < 1e-30 {
            return None;
        }
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let split = Self {
            translation,
            rotation: rotation.normalize(),
            scale,
        };
        let size = scale.abs().max_element().max(1e-12);
        let back = Mat4::from_scale_rotation_translation(split.scale, split.rotation, translation);
        let shear = (0..3)
            .map(|c| (back.col(c) - matrix.col(c)).abs().max_element())
            .fold(0.0, f32::max);
        (split.is_finite() && shear <= 1e-4 * size).then_some(split)
    }

    /// Returns whether every component is finite.
    pub fn is_finite(&self) -> bool {
        self.translation.is_finite() && self.rotation.is_finite() && self.scale.is_finite()
    }
}

/// Returns the dot product of two quaternions, summed as `(x + z) + (y + w)`.
pub(crate) fn dot(a: Quat, b: Quat) -> f32 {
    let products = Vec4::from(a) * Vec4::from(b);
    let pairs = products + products.zwxy();
    (pairs + pairs.yxwz()).x
}

/// Returns a quaternion divided by its length; not finite if that is 0.
pub fn normalised(q: Quat) -> Quat {
    q / dot(q, q).sqrt()
}

/// Returns the cross product, each of its products rounded.
pub(crate) fn cross(a: Vec3A, b: Vec3A) -> Vec3A {
    (a.zxy() * b - a * b.zxy()).zxy()
}

/// Returns `b` or `-b`, whichever is in the hemisphere of `a`; both represent the same rotation.
pub fn same_hemisphere(a: Quat, b: Quat) -> Quat {
    if dot(a, b) < 0.0 { -b } else { b }
}

/// Returns the angle between two rotations in radians, 0 to pi.
///
/// Computed from the vector part of the relative rotation, which keeps the digits of small angles
/// (`acos` of a dot product near one loses half of them).
pub fn angle_between(a: Quat, b: Quat) -> f32 {
    let relative = a.conjugate() * b;
    let sine = Vec3::new(relative.x, relative.y, relative.z).length();
    2.0 * sine.libm_atan2(relative.w.abs())
}

/// Interpolates rotations linearly along the shorter arc and normalises the result; `t` is not
/// clamped.
pub fn nlerp(a: Quat, b: Quat, t: f32) -> Quat {
    let blend = a * (1.0 - t) + same_hemisphere(a, b) * t;
    let length = dot(blend, blend).sqrt();
    if length < 1e-6 { a } else { blend / length }
}

/// Returns the rotation vector (axis times angle, radians) of the shorter rotation from `a` to `b`.
pub fn rotation_vector(a: Quat, b: Quat) -> Vec3 {
    let relative = same_hemisphere(Quat::IDENTITY, a.conjugate() * b);
    let v = Vec3::new(relative.x, relative.y, relative.z);
    let sine = v.length();
    if sine < 1e-9 {
        return 2.0 * v;
    }
    v * (2.0 * sine.libm_atan2(relative.w) / sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn angle_of_small_rotation_keeps_its_digits() {
        let a = Quat::from_rotation_x(0.3);
        let b = Quat::from_rotation_x(0.3 + 1e-4);
        // f32 rotations differ by about one part in 1e7 of a radian.
        assert!((angle_between(a, b) - 1e-4).abs() < 2e-7);
        assert!(angle_between(a, -a) < 1e-6, "q and -q are one rotation");
        assert!((angle_between(Quat::IDENTITY, Quat::from_rotation_y(PI)) - PI).abs() < 1e-5);
    }

    #[test]
    fn blend_takes_the_short_way() {
        let a = Quat::from_rotation_y(0.2);
        let half = nlerp(a, -Quat::from_rotation_y(0.4), 0.5);
        assert!(angle_between(half, Quat::from_rotation_y(0.3)) < 1e-4);
    }

    #[test]
    fn sums_and_products_are_rounded_as_written() {
        // 1e8 absorbs a one: 1 from left to right, 0 in neighbouring pairs.
        let big = Quat::from_xyzw(1e8, 1.0, -1e8, 1.0);
        assert_eq!(dot(big, Quat::from_xyzw(1.0, 1.0, 1.0, 1.0)), 2.0);
        assert_eq!(dot(big, Quat::IDENTITY), 1.0);
        let long = Quat::from_xyzw(3.0, 0.0, 0.0, -4.0);
        assert_eq!(normalised(long), Quat::from_xyzw(0.6, 0.0, 0.0, -0.8));
        // Not 0 if one of the equal products keeps more digits than the other.
        let odd = Vec3A::splat(1.0 + 1.0 / 4096.0);
        assert_eq!(cross(odd, odd), Vec3A::ZERO);
        assert_eq!(cross(Vec3A::X, Vec3A::Y), Vec3A::Z);
        assert_eq!(cross(Vec3A::Y, Vec3A::Z), Vec3A::X);
        assert_eq!(cross(Vec3A::Z, Vec3A::X), Vec3A::Y);
    }

    #[test]
    fn matrix_splits_back_unless_sheared() {
        let t = Transform {
            translation: Vec3::new(1.0, 2.0, 3.0),
            rotation: Quat::from_rotation_x(0.7),
            scale: Vec3::new(1.0, -2.0, 3.0),
        };
        let split = Transform::from_matrix(Mat4::from(t.to_affine())).unwrap();
        assert!((split.to_affine().translation - t.to_affine().translation).length() < 1e-6);
        let mut sheared = Mat4::IDENTITY;
        sheared.x_axis.y = 0.5;
        assert!(Transform::from_matrix(sheared).is_none());
        assert!(Transform::from_matrix(Mat4::ZERO).is_none());
    }

    #[test]
    fn rotation_vector_is_axis_times_angle() {
        let v = rotation_vector(Quat::IDENTITY, -Quat::from_rotation_z(FRAC_PI_2));
        assert!((v - Vec3::Z * FRAC_PI_2).length() < 1e-5);
    }
}
