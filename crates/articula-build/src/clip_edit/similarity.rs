//! Similarity transforms: rotation, uniform scale and translation, in double precision because
//! inverses of armatures of scale 100 are multiplied with their originals.

use articula_core::LibmQuat;
use articula_core::Transform;
use glam::{DQuat, DVec3};
use std::ops::Mul;

/// Maximum relative difference of the three scales of a similarity.
const SAME_SCALE: f32 = 1e-4;

/// Scale first, then rotation, then translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Similarity {
    pub(crate) translation: DVec3,
    pub(crate) rotation: DQuat,
    pub(crate) scale: f64,
}

impl Similarity {
    pub(crate) const IDENTITY: Self = Self {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: 1.0,
    };

    /// Whether a transform is a similarity: scaled uniformly, without mirroring.
    pub(crate) fn is(t: Transform) -> bool {
        let (least, greatest) = (t.scale.min_element(), t.scale.max_element());
        least > 0.0 && greatest - least <= SAME_SCALE * greatest
    }

    /// Converts a transform; scales that differ are replaced by their mean.
    pub(crate) fn of(t: Transform) -> Self {
        Self {
            translation: t.translation.as_dvec3(),
            rotation: t.rotation.as_dquat().normalize(),
            scale: f64::from(t.scale.element_sum()) / 3.0,
        }
    }

    /// A rotation about the vertical that takes one point of the ground to another.
    pub(crate) fn on_ground(yaw: f64, from: DVec3, to: DVec3) -> Self {
        let rotation = DQuat::libm_rotation_y(yaw);
        let level = |p: DVec3| DVec3::new(p.x, 0.0, p.z);
        Self {
            translation: level(to) - rotation * level(from),
            rotation,
            scale: 1.0,
        }
    }

    pub(crate) fn inverse(self) -> Self {
        let (rotation, scale) = (self.rotation.conjugate(), 1.0 / self.scale);
        Self {
            translation: rotation * self.translation * -scale,
            rotation,
            scale,
        }
    }

    pub(crate) fn point(self, p: DVec3) -> DVec3 {
        self.rotation * (p * self.scale) + self.translation
    }

    /// Applies this after any transform, which may be scaled arbitrarily.
    pub(crate) fn after(self, t: Transform) -> Transform {
        Transform {
            translation: self.point(t.translation.as_dvec3()).as_vec3(),
            rotation: (self.rotation * t.rotation.as_dquat())
                .normalize()
                .as_quat(),
            scale: t.scale * self.scale as f32,
        }
    }

    /// Converts it to a local transform.
    pub(crate) fn transform(self) -> Transform {
        self.after(Transform::IDENTITY)
    }
}

impl Mul for Similarity {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            translation: self.point(other.translation),
            rotation: (self.rotation * other.rotation).normalize(),
            scale: self.scale * other.scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    #[test]
    fn products_are_those_of_matrices_and_inverses_undo() {
        let of = |x: f32, scale: f32| Transform {
            translation: Vec3::new(x, 2.0, -x),
            rotation: Quat::from_rotation_x(x) * Quat::from_rotation_y(0.3),
            scale: Vec3::splat(scale),
        };
        let [a, b] = [of(0.7, 100.0), of(-1.1, 0.5)];
        let product = Similarity::of(a) * Similarity::of(b);
        let p = Vec3::new(0.2, -0.4, 0.9);
        let by_matrices = (a.to_affine() * b.to_affine()).transform_point3(p);
        assert!((product.point(p.as_dvec3()).as_vec3() - by_matrices).length() < 1e-4);
        let back = product.inverse() * product;
        assert!((back.point(DVec3::ONE) - DVec3::ONE).length() < 1e-9);
        assert!(
            (product.transform().to_affine().transform_point3(p) - by_matrices).length() < 1e-4
        );
    }

    #[test]
    fn mirrors_and_stretches_are_none() {
        let scaled = |scale| {
            Similarity::is(Transform {
                scale,
                ..Transform::IDENTITY
            })
        };
        assert!(!scaled(Vec3::new(1.0, 1.0, -1.0)));
        assert!(!scaled(Vec3::new(1.0, 1.1, 1.0)));
        assert!(!scaled(Vec3::ZERO));
        assert!(scaled(Vec3::splat(100.0)));
    }

    #[test]
    fn a_step_on_the_ground_takes_its_point_along() {
        let (from, to) = (DVec3::new(1.0, 0.9, 0.0), DVec3::new(3.0, 0.7, 2.0));
        let step = Similarity::on_ground(1.2, from, to);
        // It does not affect height.
        assert!((step.point(from) - DVec3::new(3.0, 0.9, 2.0)).length() < 1e-12);
    }
}
