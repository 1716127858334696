//! Angles of the head, joints of the head, and expressions of the face.

use glam::{EulerRot, Quat, Vec3};

/// Orientation of the head, in degrees. The rotation is roll after yaw after pitch, about the
/// model's Z, Y and X axes; the figure faces +Z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeadPose {
    /// Rotation about the vertical; positive towards the figure's left (the viewer's right).
    pub yaw_degrees: f32,
    /// Rotation about the horizontal; positive looks down.
    pub pitch_degrees: f32,
    /// Rotation in the plane of the picture; positive is counter-clockwise as the viewer sees it.
    pub roll_degrees: f32,
}

impl HeadPose {
    /// Returns a pose with yaw only.
    #[cfg(test)]
    pub(crate) fn yaw(yaw_degrees: f32) -> Self {
        Self {
            yaw_degrees,
            ..Self::default()
        }
    }

    /// Rotation in model space.
    pub(crate) fn rotation(&self) -> Quat {
        let of = f32::to_radians;
        Quat::from_euler(
            EulerRot::ZYX,
            of(self.roll_degrees),
            of(self.yaw_degrees),
            of(self.pitch_degrees),
        )
    }

    /// Angles of a rotation in model space.
    pub(crate) fn of_rotation(rotation: Quat) -> Self {
        let (roll, yaw, pitch) = rotation.to_euler(EulerRot::ZYX);
        Self {
            yaw_degrees: yaw.to_degrees(),
            pitch_degrees: pitch.to_degrees(),
            roll_degrees: roll.to_degrees(),
        }
    }

    /// Whether all angles are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.yaw_degrees.is_finite()
            && self.pitch_degrees.is_finite()
            && self.roll_degrees.is_finite()
    }
}

/// Part of the figure that head rotations turn: the whole figure, or the neck and head joints.
#[derive(Debug, Clone, PartialEq)]
pub enum Head {
    /// The whole figure, about a point of model space.
    Whole {
        /// Point that stays in place.
        pivot: Vec3,
    },
    /// Joints of the rig, from the neck to the head; each turns by an equal part, and the skin
    /// weights give the falloff.
    Joints(Vec<usize>),
}

/// Rotation of a joint by an expression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointTurn {
    /// Joint of the rig.
    pub joint: usize,
    /// Local rotation at full weight.
    pub rotation: Quat,
}

/// A named expression of the face, such as one of ARKit's.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PortraitExpression {
    /// Name of the expression.
    pub name: String,
    /// Morph slots and their weights at full weight of the expression, added to the rest weights.
    pub morphs: Vec<(u16, f32)>,
    /// Joints that the expression rotates.
    pub joints: Vec<JointTurn>,
}

impl PortraitExpression {
    /// Returns an expression that is one morph target.
    pub fn of_morph(name: impl Into<String>, slot: u16) -> Self {
        Self {
            name: name.into(),
            morphs: vec![(slot, 1.0)],
            joints: Vec::new(),
        }
    }
}
