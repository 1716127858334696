//! Rotations of head and eyes by FAP 23 to 26 and 48 to 50.

use crate::facing::facing_of;
use crate::open::CharacterFile;
use articula_build::face::FapValues;
use articula_core::LibmQuat;
use articula_core::fap_table::ANGLE_UNIT;
use articula_core::source::{Channel, Interpolation, Property};
use glam::{EulerRot, Quat, Vec3};

/// A joint that FAPs turn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    /// Index of the joint.
    joint: usize,
    /// FAPs of pitch (positive down), yaw (left) and roll (right).
    faps: [Option<usize>; 3],
    rest: Quat,
    /// Rotation from the axes of the figure (+X its left, +Y up, +Z forward) to the joint's parent.
    to_parent: Quat,
}

/// The head, and the eyes unless a control moves them, of a figure that has such joints.
pub(crate) fn turns(character: &CharacterFile, eyes: bool) -> Vec<Turn> {
    const PARTS: [(&str, [Option<usize>; 3]); 3] = [
        ("skullbase", [Some(48), Some(49), Some(50)]),
        ("l_eyeball_joint", [Some(25), Some(23), None]),
        ("r_eyeball_joint", [Some(26), Some(24), None]),
    ];
    let articulation = character.articulation();
    let joints = &character.character().skeleton.joints;
    let mut turned: Vec<Quat> = Vec::with_capacity(joints.len());
    for joint in joints {
        let above = joint.parent.map_or(Quat::IDENTITY, |p| turned[p]);
        turned.push((above * joint.rest.rotation).normalize());
    }
    let model = character.character().skeleton.model_rest();
    let facing = facing_of(&articulation, |joint| Vec3::from(model[joint].translation));
    let parts = &PARTS[..if eyes { 3 } else { 1 }];
    let found = parts.iter().filter_map(|(name, faps)| {
        let joint = articulation.find(name)?;
        let parent = joints[joint].parent.map_or(Quat::IDENTITY, |p| turned[p]);
        Some(Turn {
            joint,
            faps: *faps,
            rest: joints[joint].rest.rotation,
            to_parent: parent.inverse() * Quat::libm_rotation_y(facing),
        })
    });
    found.collect()
}

impl Turn {
    /// Name of the joint.
    pub(crate) fn name(&self, character: &CharacterFile) -> String {
        character.character().skeleton.joints[self.joint]
            .name
            .clone()
    }

    /// Index of the joint.
    pub(crate) fn joint(&self) -> usize {
        self.joint
    }

    /// FAPs of pitch, yaw and roll.
    pub(crate) fn faps(&self) -> [Option<usize>; 3] {
        self.faps
    }

    /// Whether a FAP turns the joint.
    pub(crate) fn has(&self, fap: usize) -> bool {
        self.faps.contains(&Some(fap))
    }

    /// Whether the joint moves in any frame.
    pub(crate) fn moves(&self, frames: &[FapValues]) -> bool {
        let faps = self.faps.iter().flatten();
        faps.into_iter()
            .any(|fap| frames.iter().any(|f| f.get(*fap) != 0.0))
    }

    /// Yaw, then pitch, then roll, each about the axes that the one before has turned.
    pub(crate) fn rotation(&self, values: &FapValues) -> Quat {
        let [pitch, yaw, roll] = self
            .faps
            .map(|fap| fap.map_or(0.0, |fap| values.get(fap) * ANGLE_UNIT));
        let turn =
            Quat::libm_rotation_y(yaw) * Quat::libm_rotation_x(pitch) * Quat::libm_rotation_z(roll);
        (self.to_parent * turn * self.to_parent.inverse() * self.rest).normalize()
    }

    /// Sets the parameters that turn the joint to a rotation, relative to its parent.
    pub(crate) fn read(&self, rotation: Quat, values: &mut FapValues) {
        let turn = self.to_parent.inverse() * rotation * self.rest.inverse() * self.to_parent;
        let (yaw, pitch, roll) = turn.normalize().to_euler(EulerRot::YXZ);
        for (fap, angle) in self.faps.iter().zip([pitch, yaw, roll]) {
            if let Some(fap) = fap {
                values.set(*fap, angle / ANGLE_UNIT);
            }
        }
    }

    /// The rotations of all frames.
    pub(crate) fn channel(&self, times_secs: &[f32], frames: &[FapValues]) -> Channel {
        Channel {
            target: self.joint,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: times_secs.to_vec(),
            values: frames
                .iter()
                .flat_map(|f| self.rotation(f).to_array())
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    fn head(to_parent: Quat) -> Turn {
        Turn {
            joint: 0,
            faps: [Some(48), Some(49), Some(50)],
            rest: Quat::IDENTITY,
            to_parent,
        }
    }

    /// A quarter turn of one FAP.
    fn quarter(fap: usize) -> FapValues {
        let mut values = FapValues::default();
        values.0[fap - 3] = FRAC_PI_2 / ANGLE_UNIT;
        values
    }

    #[test]
    fn the_head_looks_down_and_left_and_leans_right() {
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-5, "{a}, not {b}");
        let head = head(Quat::IDENTITY);
        near(head.rotation(&quarter(48)) * Vec3::Z, -Vec3::Y);
        // The subject's left is +X.
        near(head.rotation(&quarter(49)) * Vec3::Z, Vec3::X);
        near(head.rotation(&quarter(50)) * Vec3::Y, -Vec3::X);
    }

    #[test]
    fn angles_come_back() {
        let head = Turn {
            rest: Quat::from_rotation_z(0.7),
            ..head(Quat::from_euler(EulerRot::YXZ, 0.3, -0.8, 1.1))
        };
        let mut values = FapValues::default();
        for (fap, value) in [(48, 20_000.0), (49, -35_000.0), (50, 12_000.0)] {
            values.0[fap - 3] = value;
        }
        let mut read = FapValues::default();
        head.read(head.rotation(&values), &mut read);
        for fap in 48..=50 {
            assert!((read.get(fap) - values.get(fap)).abs() < 1.0, "FAP {fap}");
        }
    }

    #[test]
    fn axes_are_those_of_the_figure() {
        // A figure that faces -Z looks left towards -X, whatever the axes of its neck are.
        let neck = Quat::from_euler(EulerRot::YXZ, 0.3, -0.8, 1.1);
        let head = head(neck.inverse() * Quat::from_rotation_y(std::f32::consts::PI));
        let forward = neck.inverse() * -Vec3::Z;
        let left = neck * (head.rotation(&quarter(49)) * forward);
        assert!((left - -Vec3::X).length() < 1e-5, "{left}");
    }
}
