//! How the head is turned and the face shaped.

use glam::{EulerRot, Quat, Vec3};

/// Where the head looks, in degrees. The rotation is roll after yaw after pitch, about the
/// model's Z, Y and X axes: the figure faces +Z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeadPose {
    /// Turn about the vertical; positive towards the figure's left (the viewer's right).
    pub yaw_degrees: f32,
    /// Nod; positive looks down.
    pub pitch_degrees: f32,
    /// Tilt in the plane of the picture; positive is counter-clockwise as the viewer sees it.
    pub roll_degrees: f32,
}

impl HeadPose {
    /// A turn without nod and tilt.
    #[cfg(test)]
    pub(crate) fn yaw(yaw_degrees: f32) -> Self {
        Self {
            yaw_degrees,
            ..Self::default()
        }
    }

    /// The rotation in model space.
    pub(crate) fn rotation(&self) -> Quat {
        let of = f32::to_radians;
        Quat::from_euler(
            EulerRot::ZYX,
            of(self.roll_degrees),
            of(self.yaw_degrees),
            of(self.pitch_degrees),
        )
    }

    /// The angles of a rotation in model space.
    pub(crate) fn of_rotation(rotation: Quat) -> Self {
        let (roll, yaw, pitch) = rotation.to_euler(EulerRot::ZYX);
        Self {
            yaw_degrees: yaw.to_degrees(),
            pitch_degrees: pitch.to_degrees(),
            roll_degrees: roll.to_degrees(),
        }
    }

    /// Whether all angles are numbers.
    pub(crate) fn is_finite(&self) -> bool {
        self.yaw_degrees.is_finite()
            && self.pitch_degrees.is_finite()
            && self.roll_degrees.is_finite()
    }
}

/// What turns when the head turns.
#[derive(Debug, Clone, PartialEq)]
pub enum Head {
    /// The whole figure, about a point of model space.
    Whole {
        /// The point that stays.
        pivot: Vec3,
    },
    /// Joints of the rig, from the neck to the head, each by an equal share of the turn; the
    /// skin's weights make the falloff.
    Joints(Vec<usize>),
}

/// A joint as an expression turns it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointTurn {
    /// Joint of the rig.
    pub joint: usize,
    /// Its local rotation where the expression is full.
    pub rotation: Quat,
}

/// A named shape of the face, such as one of ARKit's.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PortraitExpression {
    /// Name by which players drive it.
    pub name: String,
    /// Morph slots and their weights where the expression is full, on top of the rest weights.
    pub morphs: Vec<(u16, f32)>,
    /// Joints that it turns.
    pub joints: Vec<JointTurn>,
}

impl PortraitExpression {
    /// An expression that is one morph target.
    pub fn of_morph(name: impl Into<String>, slot: u16) -> Self {
        Self {
            name: name.into(),
            morphs: vec![(slot, 1.0)],
            joints: Vec::new(),
        }
    }
}
