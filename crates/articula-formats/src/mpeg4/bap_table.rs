//! The 186 body animation parameters of MPEG-4, generated from two public lists
//! (`docs/formats/mpeg4.md`).
//!
//! All sources agree on order and joints, which are those of ISO/IEC 14496-2. Axes and signs are
//! those of the visage SDK, in the space of the standard humanoid (+Y up, facing +Z, left at +X);
//! two recorded files confirm them for shoulders and elbows. All rotations in the sagittal plane
//! share one axis, whichever way the joint bends, so an elbow bends with positive values and a knee
//! with negative ones. Uncertain: the signs of legs and feet, and the axes of the fingers, which
//! are chosen here for hands whose palms face the thighs.

use glam::Vec3;

/// Effect of a parameter on its joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Rotation about this axis, 1e-5 rad per unit.
    Turn(Vec3),
    /// Translation along this axis, 1 mm per unit.
    Shift(Vec3),
}

/// One body animation parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bap {
    /// Name in the standard's spelling, lower case.
    pub(super) name: &'static str,
    /// H-Anim 1.1 name of the joint.
    pub(super) joint: &'static str,
    /// Effect on the joint.
    pub(super) motion: Motion,
}

/// Number of parameters that the standard defines.
pub(super) const BAPS: usize = 186;

/// First and last index of the parameters of spine and skull, which are numbered from the top down.
const SPINE: std::ops::RangeInclusive<usize> = 47..=121;

/// BAP `n` is at index `n - 1`.
#[rustfmt::skip]
pub(super) static TABLE: [Bap; BAPS] = [
    turn("sacroiliac_tilt", "sacroiliac", Vec3::NEG_X),
    turn("sacroiliac_torsion", "sacroiliac", Vec3::Y),
    turn("sacroiliac_roll", "sacroiliac", Vec3::Z),
    turn("l_hip_flexion", "l_hip", Vec3::NEG_X),
    turn("r_hip_flexion", "r_hip", Vec3::NEG_X),
    turn("l_hip_abduct", "l_hip", Vec3::Z),
    turn("r_hip_abduct", "r_hip", Vec3::Z),
    turn("l_hip_twisting", "l_hip", Vec3::NEG_Y),
    turn("r_hip_twisting", "r_hip", Vec3::NEG_Y),
    turn("l_knee_flexion", "l_knee", Vec3::NEG_X),
    turn("r_knee_flexion", "r_knee", Vec3::NEG_X),
    turn("l_knee_twisting", "l_knee", Vec3::NEG_Y),
    turn("r_knee_twisting", "r_knee", Vec3::NEG_Y),
    turn("l_ankle_flexion", "l_ankle", Vec3::NEG_X),
    turn("r_ankle_flexion", "r_ankle", Vec3::NEG_X),
    turn("l_ankle_twisting", "l_ankle", Vec3::NEG_Y),
    turn("r_ankle_twisting", "r_ankle", Vec3::NEG_Y),
    turn("l_subtalar_flexion", "l_subtalar", Vec3::Z),
    turn("r_subtalar_flexion", "r_subtalar", Vec3::Z),
    turn("l_midtarsal_twisting", "l_midtarsal", Vec3::Z),
    turn("r_midtarsal_twisting", "r_midtarsal", Vec3::Z),
    turn("l_metatarsal_flexion", "l_metatarsal", Vec3::NEG_X),
    turn("r_metatarsal_flexion", "r_metatarsal", Vec3::NEG_X),
    turn("l_sternoclavicular_abduct", "l_sternoclavicular", Vec3::Z),
    turn("r_sternoclavicular_abduct", "r_sternoclavicular", Vec3::Z),
    turn("l_sternoclavicular_rotate", "l_sternoclavicular", Vec3::Y),
    turn("r_sternoclavicular_rotate", "r_sternoclavicular", Vec3::Y),
    turn("l_acromioclavicular_abduct", "l_acromioclavicular", Vec3::Z),
    turn("r_acromioclavicular_abduct", "r_acromioclavicular", Vec3::Z),
    turn("l_acromioclavicular_rotate", "l_acromioclavicular", Vec3::Y),
    turn("r_acromioclavicular_rotate", "r_acromioclavicular", Vec3::Y),
    turn("l_shoulder_flexion", "l_shoulder", Vec3::NEG_X),
    turn("r_shoulder_flexion", "r_shoulder", Vec3::NEG_X),
    turn("l_shoulder_abduct", "l_shoulder", Vec3::Z),
    turn("r_shoulder_abduct", "r_shoulder", Vec3::Z),
    turn("l_shoulder_twisting", "l_shoulder", Vec3::NEG_Y),
    turn("r_shoulder_twisting", "r_shoulder", Vec3::NEG_Y),
    turn("l_elbow_flexion", "l_elbow", Vec3::NEG_X),
    turn("r_elbow_flexion", "r_elbow", Vec3::NEG_X),
    turn("l_elbow_twisting", "l_elbow", Vec3::NEG_Y),
    turn("r_elbow_twisting", "r_elbow", Vec3::NEG_Y),
    turn("l_wrist_flexion", "l_wrist", Vec3::NEG_Z),
    turn("r_wrist_flexion", "r_wrist", Vec3::NEG_Z),
    turn("l_wrist_pivot", "l_wrist", Vec3::NEG_X),
    turn("r_wrist_pivot", "r_wrist", Vec3::NEG_X),
    turn("l_wrist_twisting", "l_wrist", Vec3::NEG_Y),
    turn("r_wrist_twisting", "r_wrist", Vec3::NEG_Y),
    turn("skullbase_roll", "skullbase", Vec3::Z),
    turn("skullbase_torsion", "skullbase", Vec3::Y),
    turn("skullbase_tilt", "skullbase", Vec3::NEG_X),
    turn("vc1_roll", "vc1", Vec3::Z),
    turn("vc1_torsion", "vc1", Vec3::Y),
    turn("vc1_tilt", "vc1", Vec3::NEG_X),
    turn("vc2_roll", "vc2", Vec3::Z),
    turn("vc2_torsion", "vc2", Vec3::Y),
    turn("vc2_tilt", "vc2", Vec3::NEG_X),
    turn("vc3_roll", "vc3", Vec3::Z),
    turn("vc3_torsion", "vc3", Vec3::Y),
    turn("vc3_tilt", "vc3", Vec3::NEG_X),
    turn("vc4_roll", "vc4", Vec3::Z),
    turn("vc4_torsion", "vc4", Vec3::Y),
    turn("vc4_tilt", "vc4", Vec3::NEG_X),
    turn("vc5_roll", "vc5", Vec3::Z),
    turn("vc5_torsion", "vc5", Vec3::Y),
    turn("vc5_tilt", "vc5", Vec3::NEG_X),
    turn("vc6_roll", "vc6", Vec3::Z),
    turn("vc6_torsion", "vc6", Vec3::Y),
    turn("vc6_tilt", "vc6", Vec3::NEG_X),
    turn("vc7_roll", "vc7", Vec3::Z),
    turn("vc7_torsion", "vc7", Vec3::Y),
    turn("vc7_tilt", "vc7", Vec3::NEG_X),
    turn("vt1_roll", "vt1", Vec3::Z),
    turn("vt1_torsion", "vt1", Vec3::Y),
    turn("vt1_tilt", "vt1", Vec3::NEG_X),
    turn("vt2_roll", "vt2", Vec3::Z),
    turn("vt2_torsion", "vt2", Vec3::Y),
    turn("vt2_tilt", "vt2", Vec3::NEG_X),
    turn("vt3_roll", "vt3", Vec3::Z),
    turn("vt3_torsion", "vt3", Vec3::Y),
    turn("vt3_tilt", "vt3", Vec3::NEG_X),
    turn("vt4_roll", "vt4", Vec3::Z),
    turn("vt4_torsion", "vt4", Vec3::Y),
    turn("vt4_tilt", "vt4", Vec3::NEG_X),
    turn("vt5_roll", "vt5", Vec3::Z),
    turn("vt5_torsion", "vt5", Vec3::Y),
    turn("vt5_tilt", "vt5", Vec3::NEG_X),
    turn("vt6_roll", "vt6", Vec3::Z),
    turn("vt6_torsion", "vt6", Vec3::Y),
    turn("vt6_tilt", "vt6", Vec3::NEG_X),
    turn("vt7_roll", "vt7", Vec3::Z),
    turn("vt7_torsion", "vt7", Vec3::Y),
    turn("vt7_tilt", "vt7", Vec3::NEG_X),
    turn("vt8_roll", "vt8", Vec3::Z),
    turn("vt8_torsion", "vt8", Vec3::Y),
    turn("vt8_tilt", "vt8", Vec3::NEG_X),
    turn("vt9_roll", "vt9", Vec3::Z),
    turn("vt9_torsion", "vt9", Vec3::Y),
    turn("vt9_tilt", "vt9", Vec3::NEG_X),
    turn("vt10_roll", "vt10", Vec3::Z),
    turn("vt10_torsion", "vt10", Vec3::Y),
    turn("vt10_tilt", "vt10", Vec3::NEG_X),
    turn("vt11_roll", "vt11", Vec3::Z),
    turn("vt11_torsion", "vt11", Vec3::Y),
    turn("vt11_tilt", "vt11", Vec3::NEG_X),
    turn("vt12_roll", "vt12", Vec3::Z),
    turn("vt12_torsion", "vt12", Vec3::Y),
    turn("vt12_tilt", "vt12", Vec3::NEG_X),
    turn("vl1_roll", "vl1", Vec3::Z),
    turn("vl1_torsion", "vl1", Vec3::Y),
    turn("vl1_tilt", "vl1", Vec3::NEG_X),
    turn("vl2_roll", "vl2", Vec3::Z),
    turn("vl2_torsion", "vl2", Vec3::Y),
    turn("vl2_tilt", "vl2", Vec3::NEG_X),
    turn("vl3_roll", "vl3", Vec3::Z),
    turn("vl3_torsion", "vl3", Vec3::Y),
    turn("vl3_tilt", "vl3", Vec3::NEG_X),
    turn("vl4_roll", "vl4", Vec3::Z),
    turn("vl4_torsion", "vl4", Vec3::Y),
    turn("vl4_tilt", "vl4", Vec3::NEG_X),
    turn("vl5_roll", "vl5", Vec3::Z),
    turn("vl5_torsion", "vl5", Vec3::Y),
    turn("vl5_tilt", "vl5", Vec3::NEG_X),
    turn("l_pinky0_flexion", "l_pinky0", Vec3::Z),
    turn("r_pinky0_flexion", "r_pinky0", Vec3::NEG_Z),
    turn("l_pinky1_flexion", "l_pinky1", Vec3::Z),
    turn("r_pinky1_flexion", "r_pinky1", Vec3::NEG_Z),
    turn("l_pinky1_pivot", "l_pinky1", Vec3::NEG_X),
    turn("r_pinky1_pivot", "r_pinky1", Vec3::X),
    turn("l_pinky1_twisting", "l_pinky1", Vec3::NEG_Y),
    turn("r_pinky1_twisting", "r_pinky1", Vec3::NEG_Y),
    turn("l_pinky2_flexion", "l_pinky2", Vec3::Z),
    turn("r_pinky2_flexion", "r_pinky2", Vec3::NEG_Z),
    turn("l_pinky3_flexion", "l_pinky3", Vec3::Z),
    turn("r_pinky3_flexion", "r_pinky3", Vec3::NEG_Z),
    turn("l_ring0_flexion", "l_ring0", Vec3::Z),
    turn("r_ring0_flexion", "r_ring0", Vec3::NEG_Z),
    turn("l_ring1_flexion", "l_ring1", Vec3::Z),
    turn("r_ring1_flexion", "r_ring1", Vec3::NEG_Z),
    turn("l_ring1_pivot", "l_ring1", Vec3::NEG_X),
    turn("r_ring1_pivot", "r_ring1", Vec3::X),
    turn("l_ring1_twisting", "l_ring1", Vec3::NEG_Y),
    turn("r_ring1_twisting", "r_ring1", Vec3::NEG_Y),
    turn("l_ring2_flexion", "l_ring2", Vec3::Z),
    turn("r_ring2_flexion", "r_ring2", Vec3::NEG_Z),
    turn("l_ring3_flexion", "l_ring3", Vec3::Z),
    turn("r_ring3_flexion", "r_ring3", Vec3::NEG_Z),
    turn("l_middle0_flexion", "l_middle0", Vec3::Z),
    turn("r_middle0_flexion", "r_middle0", Vec3::NEG_Z),
    turn("l_middle1_flexion", "l_middle1", Vec3::Z),
    turn("r_middle1_flexion", "r_middle1", Vec3::NEG_Z),
    turn("l_middle1_pivot", "l_middle1", Vec3::NEG_X),
    turn("r_middle1_pivot", "r_middle1", Vec3::X),
    turn("l_middle1_twisting", "l_middle1", Vec3::NEG_Y),
    turn("r_middle1_twisting", "r_middle1", Vec3::NEG_Y),
    turn("l_middle2_flexion", "l_middle2", Vec3::Z),
    turn("r_middle2_flexion", "r_middle2", Vec3::NEG_Z),
    turn("l_middle3_flexion", "l_middle3", Vec3::Z),
    turn("r_middle3_flexion", "r_middle3", Vec3::NEG_Z),
    turn("l_index0_flexion", "l_index0", Vec3::Z),
    turn("r_index0_flexion", "r_index0", Vec3::NEG_Z),
    turn("l_index1_flexion", "l_index1", Vec3::Z),
    turn("r_index1_flexion", "r_index1", Vec3::NEG_Z),
    turn("l_index1_pivot", "l_index1", Vec3::NEG_X),
    turn("r_index1_pivot", "r_index1", Vec3::X),
    turn("l_index1_twisting", "l_index1", Vec3::NEG_Y),
    turn("r_index1_twisting", "r_index1", Vec3::NEG_Y),
    turn("l_index2_flexion", "l_index2", Vec3::Z),
    turn("r_index2_flexion", "r_index2", Vec3::NEG_Z),
    turn("l_index3_flexion", "l_index3", Vec3::Z),
    turn("r_index3_flexion", "r_index3", Vec3::NEG_Z),
    turn("l_thumb1_flexion", "l_thumb1", Vec3::NEG_X),
    turn("r_thumb1_flexion", "r_thumb1", Vec3::NEG_X),
    turn("l_thumb1_pivot", "l_thumb1", Vec3::Y),
    turn("r_thumb1_pivot", "r_thumb1", Vec3::Y),
    turn("l_thumb1_twisting", "l_thumb1", Vec3::NEG_Z),
    turn("r_thumb1_twisting", "r_thumb1", Vec3::NEG_Z),
    turn("l_thumb2_flexion", "l_thumb2", Vec3::NEG_X),
    turn("r_thumb2_flexion", "r_thumb2", Vec3::NEG_X),
    turn("l_thumb3_flexion", "l_thumb3", Vec3::NEG_X),
    turn("r_thumb3_flexion", "r_thumb3", Vec3::NEG_X),
    shift("humanoid_root_tr_vertical", "humanoid_root", Vec3::Y),
    shift("humanoid_root_tr_lateral", "humanoid_root", Vec3::X),
    shift("humanoid_root_tr_frontal", "humanoid_root", Vec3::Z),
    turn("humanoid_root_rt_body_turn", "humanoid_root", Vec3::Y),
    turn("humanoid_root_rt_body_roll", "humanoid_root", Vec3::Z),
    turn("humanoid_root_rt_body_tilt", "humanoid_root", Vec3::X),
];

const fn turn(name: &'static str, joint: &'static str, axis: Vec3) -> Bap {
    Bap {
        name,
        joint,
        motion: Motion::Turn(axis),
    }
}

const fn shift(name: &'static str, joint: &'static str, axis: Vec3) -> Bap {
    Bap {
        name,
        joint,
        motion: Motion::Shift(axis),
    }
}

/// Returns the indices of a joint's rotations, from the parent's side to the child's: their product
/// in this order is the joint's rotation.
///
/// The order is a choice of this crate, since no source defines it. The numbering is that of a
/// chain of one-axis joints from the pelvis outwards, except for spine and skull, which are
/// numbered from the top down; there the order is reversed, as for the pelvis: tilt, torsion, roll.
pub(super) fn turns(joint: &str) -> Vec<(usize, Vec3)> {
    let mut found: Vec<(usize, Vec3)> = Vec::new();
    for (index, bap) in TABLE.iter().enumerate() {
        if let Motion::Turn(axis) = bap.motion
            && bap.joint == joint
        {
            found.push((index, axis));
        }
    }
    if found
        .first()
        .is_some_and(|(index, _)| SPINE.contains(index))
    {
        found.reverse();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::hanim_table;

    #[test]
    fn the_order_is_that_of_the_standard() {
        let numbers = [
            (1, "sacroiliac_tilt"),
            (4, "l_hip_flexion"),
            (11, "r_knee_flexion"),
            (23, "r_metatarsal_flexion"),
            (32, "l_shoulder_flexion"),
            (47, "r_wrist_twisting"),
            (48, "skullbase_roll"),
            (122, "vl5_tilt"),
            (123, "l_pinky0_flexion"),
            (180, "r_thumb3_flexion"),
            (181, "humanoid_root_tr_vertical"),
            (186, "humanoid_root_rt_body_tilt"),
        ];
        for (number, name) in numbers {
            assert_eq!(TABLE[number - 1].name, name);
        }
    }

    #[test]
    fn joints_are_of_the_standard_humanoid() {
        // Rotations per joint, as `docs/formats/mpeg4.md` counts them.
        let mut counts = [0; 4];
        for joint in &hanim_table::JOINTS[..hanim_table::BODY_JOINTS] {
            counts[turns(joint.name).len()] += 1;
        }
        assert!(TABLE.iter().all(|b| hanim_table::find(b.joint).is_some()));
        // No rotation: eyeballs. One: subtalar, midtarsal, metatarsal, two thumb joints, three per
        // finger. Two: knee, ankle, elbow, both clavicle joints. Three: the others.
        assert_eq!(counts, [2, 2 * (3 + 2 + 4 * 3), 2 * 5, 43]);
    }

    #[test]
    fn turns_go_outwards() {
        let names = |joint: &str| -> Vec<&str> {
            let turns = turns(joint).into_iter();
            turns.map(|(index, _)| TABLE[index].name).collect()
        };
        assert_eq!(
            names("l_hip"),
            ["l_hip_flexion", "l_hip_abduct", "l_hip_twisting"]
        );
        assert_eq!(names("vl5"), ["vl5_tilt", "vl5_torsion", "vl5_roll"]);
        assert_eq!(names("sacroiliac").len(), 3);
        assert_eq!(names("sacroiliac")[0], "sacroiliac_tilt");
    }
}
