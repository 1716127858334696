//! Transform of a node with `translation`, `rotation`, `scale` and `center`.
//!
//! Source: ISO/IEC 19775-1, 10.4.4 (Transform): P' = T · C · R · SR · S · -SR · -C · P.

use super::fields::Reader;
use super::scene::NodeId;
use crate::error::ReadError;
use articula_core::Libm;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Tolerance of a similarity: relative difference of lengths and angles between axes, as matrices
/// stored in 32 bits have it.
const SIMILAR: f64 = 2e-5;

/// The fields of a `Transform`, an `HAnimHumanoid`, an `HAnimJoint` or an `HAnimSite`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
    pub(super) scale_orientation: DQuat,
    pub(super) center: DVec3,
}

impl Placement {
    /// Reads the fields that a node has.
    pub(super) fn read(reader: &mut Reader<'_>, id: NodeId) -> Result<Self, ReadError> {
        Ok(Self {
            translation: reader.vector(id, "translation", DVec3::ZERO)?,
            rotation: reader.rotation(id, "rotation")?,
            scale: reader.vector(id, "scale", DVec3::ONE)?,
            scale_orientation: reader.rotation(id, "scaleOrientation")?,
            center: reader.vector(id, "center", DVec3::ZERO)?,
        })
    }

    /// Returns the same center and scale orientation without translation, rotation and scale.
    pub(super) fn at_rest(&self) -> Self {
        Self {
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
            ..*self
        }
    }

    /// Returns whether it is the identity.
    pub(super) fn is_at_rest(&self) -> bool {
        self.translation == DVec3::ZERO
            && self.rotation.angle_between(DQuat::IDENTITY) < 1e-9
            && self.scale == DVec3::ONE
    }

    /// Returns the matrix of the formula above.
    pub(super) fn matrix(&self) -> DAffine3 {
        let stretch = DMat3::from_quat(self.scale_orientation)
            * DMat3::from_diagonal(self.scale)
            * DMat3::from_quat(self.scale_orientation.inverse());
        let linear = DMat3::from_quat(self.rotation) * stretch;
        let translation = self.translation + self.center - linear * self.center;
        DAffine3::from_mat3_translation(linear, translation)
    }
}

/// A matrix with uniform scale; such matrices are closed under products.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Similarity {
    pub(super) scale: f64,
    pub(super) rotation: DQuat,
    pub(super) translation: DVec3,
}

impl Similarity {
    /// Splits a matrix; `None` if it has non-uniform scale or shear, mirrors or is singular.
    pub(super) fn of(matrix: &DAffine3) -> Option<Self> {
        let m = matrix.matrix3;
        let scale = m.determinant().libm_cbrt();
        if !(scale.is_finite() && scale > 1e-12 && matrix.translation.is_finite()) {
            return None;
        }
        let turned = m * (1.0 / scale);
        let off = turned.transpose() * turned - DMat3::IDENTITY;
        let worst = off
            .to_cols_array()
            .iter()
            .fold(0.0, |w: f64, e| w.max(e.abs()));
        let similarity = Self {
            scale,
            rotation: DQuat::from_mat3(&turned).normalize(),
            translation: matrix.translation,
        };
        (worst < SIMILAR).then_some(similarity)
    }

    /// Returns the similarity closest to a matrix.
    pub(super) fn near(matrix: &DAffine3) -> Self {
        let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
        let good = scale.is_finite() && rotation.is_finite() && translation.is_finite();
        let mean = scale.abs().element_sum() / 3.0;
        if !good || mean < 1e-12 {
            return Self {
                scale: 1.0,
                rotation: DQuat::IDENTITY,
                translation: DVec3::ZERO,
            };
        }
        Self {
            scale: mean,
            rotation: rotation.normalize(),
            translation,
        }
    }

    /// Transforms a point.
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.rotation * (point * self.scale) + self.translation
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn the_rule_by_hand() {
        let placement = Placement {
            translation: DVec3::new(0.0, 0.0, 5.0),
            rotation: DQuat::from_rotation_z(FRAC_PI_2),
            scale: DVec3::new(2.0, 1.0, 1.0),
            scale_orientation: DQuat::from_rotation_z(FRAC_PI_2),
            center: DVec3::new(1.0, 0.0, 0.0),
        };
        // (2, 1, 0) is (1, 1, 0) from the center. The scale orientation makes Y the scaled axis, so
        // (1, 2, 0); a quarter turn gives (-2, 1, 0); then center and translation are added.
        let moved = placement
            .matrix()
            .transform_point3(DVec3::new(2.0, 1.0, 0.0));
        assert!(
            moved.distance(DVec3::new(-1.0, 1.0, 5.0)) < 1e-12,
            "{moved}"
        );
        assert_eq!(placement.at_rest().matrix(), DAffine3::IDENTITY);
    }

    #[test]
    fn only_similarities_are_called_so() {
        let turn = DQuat::from_rotation_x(0.3);
        let of = |scale: DVec3| {
            let m = DAffine3::from_scale_rotation_translation(scale, turn, DVec3::Y);
            Similarity::of(&m)
        };
        let found = of(DVec3::splat(0.0225)).unwrap();
        assert!((found.scale - 0.0225).abs() < 1e-12);
        assert!(found.rotation.angle_between(turn) < 1e-6);
        assert_eq!(of(DVec3::new(1.0, 1.1, 1.0)), None);
        assert_eq!(of(DVec3::new(-1.0, 1.0, 1.0)), None);
        assert_eq!(of(DVec3::ZERO), None);
    }
}
