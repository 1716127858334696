//! Elementary functions with the same bits on all platforms.
//!
//! Those of the standard library are the platform's own, which round differently; `glam` calls them, and
//! its `slerp` is another approximation for each set of instructions. What is stored in a file or hashed
//! takes these.

use glam::{DQuat, DVec3, Quat, Vec3};

/// Elementary functions of a number, by the crate `libm`.
pub trait Libm: Sized {
    /// Returns the sine of an angle in radians.
    #[must_use]
    fn libm_sin(self) -> Self;
    /// Returns the cosine of an angle in radians.
    #[must_use]
    fn libm_cos(self) -> Self;
    /// Returns the tangent of an angle in radians.
    #[must_use]
    fn libm_tan(self) -> Self;
    /// Returns the arc sine in radians.
    #[must_use]
    fn libm_asin(self) -> Self;
    /// Returns the arc cosine in radians.
    #[must_use]
    fn libm_acos(self) -> Self;
    /// Returns e to this power.
    #[must_use]
    fn libm_exp(self) -> Self;
    /// Returns 2 to this power.
    #[must_use]
    fn libm_exp2(self) -> Self;
    /// Returns the natural logarithm.
    #[must_use]
    fn libm_ln(self) -> Self;
    /// Returns the logarithm to base 2.
    #[must_use]
    fn libm_log2(self) -> Self;
    /// Returns the logarithm to base 10.
    #[must_use]
    fn libm_log10(self) -> Self;
    /// Returns the cube root.
    #[must_use]
    fn libm_cbrt(self) -> Self;
    /// Returns the sine and the cosine of an angle in radians.
    #[must_use]
    fn libm_sin_cos(self) -> (Self, Self);
    /// Returns the angle of the point `(x, self)` in radians.
    #[must_use]
    fn libm_atan2(self, x: Self) -> Self;
    /// Returns this to a power.
    #[must_use]
    fn libm_powf(self, power: Self) -> Self;
    /// Returns the length of the vector of two numbers.
    #[must_use]
    fn libm_hypot(self, other: Self) -> Self;
}

macro_rules! number {
    ($number:ty, $($name:ident: $function:ident),*; $sin_cos:ident, $atan2:ident, $pow:ident, $hypot:ident) => {
        impl Libm for $number {
            $(fn $name(self) -> Self {
                libm::$function(self)
            })*

            fn libm_sin_cos(self) -> (Self, Self) {
                libm::$sin_cos(self)
            }

            fn libm_atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }

            fn libm_powf(self, power: Self) -> Self {
                libm::$pow(self, power)
            }

            fn libm_hypot(self, other: Self) -> Self {
                libm::$hypot(self, other)
            }
        }
    };
}

number! {
    f32,
    libm_sin: sinf,
    libm_cos: cosf,
    libm_tan: tanf,
    libm_asin: asinf,
    libm_acos: acosf,
    libm_exp: expf,
    libm_exp2: exp2f,
    libm_ln: logf,
    libm_log2: log2f,
    libm_log10: log10f,
    libm_cbrt: cbrtf;
    sincosf, atan2f, powf, hypotf
}

number! {
    f64,
    libm_sin: sin,
    libm_cos: cos,
    libm_tan: tan,
    libm_asin: asin,
    libm_acos: acos,
    libm_exp: exp,
    libm_exp2: exp2,
    libm_ln: log,
    libm_log2: log2,
    libm_log10: log10,
    libm_cbrt: cbrt;
    sincos, atan2, pow, hypot
}

/// Rotations by angles, by [`Libm`].
pub trait LibmQuat: Sized {
    /// An angle in radians.
    type Scalar;
    /// An axis.
    type Vector;

    /// Returns the rotation about a unit axis.
    #[must_use]
    fn libm_axis_angle(axis: Self::Vector, radians: Self::Scalar) -> Self;
    /// Returns the rotation about the x axis.
    #[must_use]
    fn libm_rotation_x(radians: Self::Scalar) -> Self;
    /// Returns the rotation about the y axis.
    #[must_use]
    fn libm_rotation_y(radians: Self::Scalar) -> Self;
    /// Returns the rotation about the z axis.
    #[must_use]
    fn libm_rotation_z(radians: Self::Scalar) -> Self;
    /// Returns the rotation about a vector by its length in radians.
    #[must_use]
    fn libm_scaled_axis(vector: Self::Vector) -> Self;
    /// Returns the unit axis and the angle, from 0 to twice pi; x and 0 for no rotation.
    #[must_use]
    fn libm_to_axis_angle(self) -> (Self::Vector, Self::Scalar);
    /// Returns the axis times the angle.
    #[must_use]
    fn libm_to_scaled_axis(self) -> Self::Vector;
    /// Returns the shorter arc to another rotation.
    #[must_use]
    fn libm_arc(self, end: Self) -> LibmArc<Self>;
    /// Interpolates along the shorter arc at constant speed.
    #[must_use]
    fn libm_slerp(self, end: Self, share: Self::Scalar) -> Self;
}

/// The shorter arc between two rotations. It interpolates many shares with the bits of [`LibmQuat::libm_slerp`], and
/// finds its angle once.
#[derive(Debug, Clone, Copy)]
pub struct LibmArc<Q: LibmQuat> {
    start: Q,
    end: Q,
    /// The angle between both as vectors in radians, and its sine; `None` where it is too small to divide by.
    angle: Option<(Q::Scalar, Q::Scalar)>,
}

impl<Q: LibmQuat> LibmArc<Q> {
    /// Whether there is an angle between both, so that shares of it differ.
    pub(crate) fn turns(&self) -> bool {
        self.angle.is_some()
    }
}

macro_rules! rotation {
    ($quat:ty, $scalar:ty, $vector:ty) => {
        impl LibmQuat for $quat {
            type Scalar = $scalar;
            type Vector = $vector;

            fn libm_axis_angle(axis: $vector, radians: $scalar) -> Self {
                let (sin, cos) = (0.5 * radians).libm_sin_cos();
                let along = axis * sin;
                Self::from_xyzw(along.x, along.y, along.z, cos)
            }

            fn libm_rotation_x(radians: $scalar) -> Self {
                let (sin, cos) = (0.5 * radians).libm_sin_cos();
                Self::from_xyzw(sin, 0.0, 0.0, cos)
            }

            fn libm_rotation_y(radians: $scalar) -> Self {
                let (sin, cos) = (0.5 * radians).libm_sin_cos();
                Self::from_xyzw(0.0, sin, 0.0, cos)
            }

            fn libm_rotation_z(radians: $scalar) -> Self {
                let (sin, cos) = (0.5 * radians).libm_sin_cos();
                Self::from_xyzw(0.0, 0.0, sin, cos)
            }

            fn libm_scaled_axis(vector: $vector) -> Self {
                let radians = vector.length();
                if radians == 0.0 {
                    return Self::IDENTITY;
                }
                Self::libm_axis_angle(vector / radians, radians)
            }

            fn libm_to_axis_angle(self) -> ($vector, $scalar) {
                let along = <$vector>::new(self.x, self.y, self.z);
                let length = along.length();
                if length < 1e-8 {
                    return (<$vector>::X, 0.0);
                }
                (along / length, 2.0 * length.libm_atan2(self.w))
            }

            fn libm_to_scaled_axis(self) -> $vector {
                let (axis, radians) = self.libm_to_axis_angle();
                axis * radians
            }

            fn libm_arc(self, end: Self) -> LibmArc<Self> {
                let cos = LibmArc::<$quat>::dot(self, end);
                let end = if cos < 0.0 { -end } else { end };
                let cos = cos.abs();
                let is_far = cos <= 1.0 - <$scalar>::EPSILON;
                let angle = is_far.then(|| cos.libm_acos());
                LibmArc {
                    start: self,
                    end,
                    angle: angle.map(|angle| (angle, angle.libm_sin())),
                }
            }

            fn libm_slerp(self, end: Self, share: $scalar) -> Self {
                self.libm_arc(end).at(share)
            }
        }

        impl LibmArc<$quat> {
            /// The rotation at a share of the arc, at constant speed.
            #[must_use]
            pub fn at(&self, share: $scalar) -> $quat {
                let Some((angle, sin)) = self.angle else {
                    let blend = self.start + (self.end - self.start) * share;
                    return blend / Self::dot(blend, blend).sqrt();
                };
                let first = (angle * (1.0 - share)).libm_sin();
                let second = (angle * share).libm_sin();
                (self.start * first + self.end * second) / sin
            }

            /// Summed as `math::dot` does.
            fn dot(a: $quat, b: $quat) -> $scalar {
                (a.x * b.x + a.z * b.z) + (a.y * b.y + a.w * b.w)
            }
        }
    };
}

rotation!(Quat, f32, Vec3);
rotation!(DQuat, f64, DVec3);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_those_of_glam() {
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        for step in -20..=20 {
            let radians = 0.3 * step as f32;
            let pairs = [
                (
                    Quat::libm_axis_angle(axis, radians),
                    Quat::from_axis_angle(axis, radians),
                ),
                (
                    Quat::libm_rotation_x(radians),
                    Quat::from_rotation_x(radians),
                ),
                (
                    Quat::libm_rotation_y(radians),
                    Quat::from_rotation_y(radians),
                ),
                (
                    Quat::libm_rotation_z(radians),
                    Quat::from_rotation_z(radians),
                ),
                (
                    Quat::libm_scaled_axis(axis * radians),
                    Quat::from_scaled_axis(axis * radians),
                ),
            ];
            for (ours, theirs) in pairs {
                assert!(ours.abs_diff_eq(theirs, 1e-6), "{ours} {theirs}");
            }
            let turn = Quat::from_axis_angle(axis, radians);
            let back = Quat::libm_scaled_axis(turn.libm_to_scaled_axis());
            assert!(back.abs_diff_eq(turn, 1e-6), "{back} {turn}");
        }
    }

    #[test]
    fn interpolation_is_along_the_shorter_arc_at_constant_speed() {
        for whole in [1e-9, 1e-4, 0.5, 2.0, 3.0] {
            let end = DQuat::from_rotation_y(whole);
            for share in [0.0, 0.25, 0.5, 1.0] {
                let wanted = DQuat::from_rotation_y(whole * share);
                for end in [end, -end] {
                    let found = DQuat::IDENTITY.libm_slerp(end, share);
                    assert!(found.abs_diff_eq(wanted, 1e-12), "{found} {wanted}");
                }
            }
        }
    }
}
