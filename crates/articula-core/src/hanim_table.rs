//! The 94 joints of the standard H-Anim 1.1 humanoid, generated from ISO/IEC 19774 and thesis
//! 3.1.3.
//!
//! The first 89 are the body joints that the thesis counts, depth first, so a parent comes before
//! its children; the last 5 are the face joints that only the full standard set has. Centres,
//! parents and official levels are those of the standard. Data levels are those of the thesis (5,
//! 10, 24, 35, 51, 89 joints for levels 0 to 5); where it prints no complete list, the joints are
//! chosen to meet its counts (`docs/methods/hanim.md` part 3).
//!
//! The region counts of the thesis (feet 4, hands 40) fit no partition of the standard joints; here
//! the subtalars belong to the feet (6) and the hands have 38. The joints with which they fit are
//! those of a joint scheme (`articula_build::JointScheme`).

use crate::articulation::Region;
use glam::Vec3;

/// One joint of the standard humanoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HanimJoint {
    /// H-Anim 1.1 name; the left side starts with `l_`, the right with `r_`.
    pub name: &'static str,
    /// H-Anim 2 name; equal to `name` unless version 2 renamed the joint.
    pub name_v2: &'static str,
    /// Index of the parent in [`JOINTS`], always smaller than the joint's own index.
    pub parent: Option<usize>,
    /// Rest position in metres: +Y up, facing +Z, left at +X, arms hanging, feet at height 0.
    pub center: Vec3,
    /// Lowest official H-Anim level of articulation (0 to 3) that includes the joint.
    pub hanim_level: u8,
    /// Lowest data level (0 to 5) that includes the joint.
    pub level: u8,
    /// Region of the joint.
    pub region: Region,
}

/// Number of body joints, which are the first entries of [`JOINTS`].
pub const BODY_JOINTS: usize = 89;

/// The joints of the humanoid in the rest pose, parents before children; every rest rotation is the
/// identity.
///
/// One line per joint, so that it reads as a table.
#[rustfmt::skip]
pub static JOINTS: [HanimJoint; 94] = [
    joint(("humanoid_root", "humanoid_root"), None, [0.0, 0.824, 0.0277], (0, 0), Region::Pelvis),
    joint(("sacroiliac", "sacroiliac"), Some(0), [0.0, 0.9149, 0.0016], (1, 2), Region::Pelvis),
    joint(("l_hip", "l_hip"), Some(1), [0.0961, 0.9124, -0.0001], (1, 0), Region::Pelvis),
    joint(("l_knee", "l_knee"), Some(2), [0.104, 0.4867, 0.0308], (1, 1), Region::Legs),
    joint(("l_ankle", "l_talocrural"), Some(3), [0.1101, 0.0656, -0.0736], (1, 2), Region::Legs),
    joint(("l_subtalar", "l_talocalcaneonavicular"), Some(4), [0.1086, 0.0001, -0.0368], (2, 5), Region::Feet),
    joint(("l_midtarsal", "l_tarsometatarsal_2"), Some(5), [0.1086, 0.0001, 0.0368], (1, 2), Region::Feet),
    joint(("l_metatarsal", "l_metatarsophalangeal_2"), Some(6), [0.1086, 0.0, 0.0762], (2, 2), Region::Feet),
    joint(("r_hip", "r_hip"), Some(1), [-0.0961, 0.9124, -0.0001], (1, 0), Region::Pelvis),
    joint(("r_knee", "r_knee"), Some(8), [-0.104, 0.4867, 0.0308], (1, 1), Region::Legs),
    joint(("r_ankle", "r_talocrural"), Some(9), [-0.1101, 0.0656, -0.0736], (1, 2), Region::Legs),
    joint(("r_subtalar", "r_talocalcaneonavicular"), Some(10), [-0.1086, 0.0001, -0.0368], (2, 5), Region::Feet),
    joint(("r_midtarsal", "r_tarsometatarsal_2"), Some(11), [-0.1086, 0.0001, 0.0368], (1, 2), Region::Feet),
    joint(("r_metatarsal", "r_metatarsophalangeal_2"), Some(12), [-0.1086, 0.0, 0.0762], (2, 2), Region::Feet),
    joint(("vl5", "vl5"), Some(0), [0.0028, 1.0568, -0.0776], (1, 2), Region::Torso),
    joint(("vl4", "vl4"), Some(14), [0.0035, 1.0925, -0.0787], (3, 5), Region::Torso),
    joint(("vl3", "vl3"), Some(15), [0.0041, 1.1276, -0.0796], (2, 3), Region::Torso),
    joint(("vl2", "vl2"), Some(16), [0.0045, 1.1546, -0.08], (3, 5), Region::Torso),
    joint(("vl1", "vl1"), Some(17), [0.0048, 1.1912, -0.0805], (2, 3), Region::Torso),
    joint(("vt12", "vt12"), Some(18), [0.0051, 1.2278, -0.0808], (3, 3), Region::Torso),
    joint(("vt11", "vt11"), Some(19), [0.0053, 1.2679, -0.081], (3, 5), Region::Torso),
    joint(("vt10", "vt10"), Some(20), [0.0056, 1.2848, -0.0822], (2, 3), Region::Torso),
    joint(("vt9", "vt9"), Some(21), [0.0057, 1.3126, -0.0838], (3, 5), Region::Torso),
    joint(("vt8", "vt8"), Some(22), [0.0057, 1.3382, -0.0845], (3, 3), Region::Torso),
    joint(("vt7", "vt7"), Some(23), [0.0058, 1.3625, -0.0833], (3, 5), Region::Torso),
    joint(("vt6", "vt6"), Some(24), [0.0059, 1.3866, -0.08], (2, 3), Region::Torso),
    joint(("vt5", "vt5"), Some(25), [0.006, 1.4102, -0.0745], (3, 5), Region::Torso),
    joint(("vt4", "vt4"), Some(26), [0.0061, 1.432, -0.0675], (3, 5), Region::Torso),
    joint(("vt3", "vt3"), Some(27), [0.0062, 1.4583, -0.057], (3, 3), Region::Torso),
    joint(("vt2", "vt2"), Some(28), [0.0063, 1.4761, -0.0484], (3, 5), Region::Torso),
    joint(("vt1", "vt1"), Some(29), [0.0065, 1.4951, -0.0387], (2, 3), Region::Torso),
    joint(("vc7", "vc7"), Some(30), [0.0066, 1.5132, -0.0301], (3, 3), Region::Torso),
    joint(("vc6", "vc6"), Some(31), [0.0066, 1.5357, -0.0143], (3, 5), Region::Torso),
    joint(("vc5", "vc5"), Some(32), [0.0066, 1.552, -0.0082], (3, 5), Region::Torso),
    joint(("vc4", "vc4"), Some(33), [0.0066, 1.5662, -0.0084], (2, 3), Region::Torso),
    joint(("vc3", "vc3"), Some(34), [0.0066, 1.58, -0.0103], (3, 5), Region::Torso),
    joint(("vc2", "vc2"), Some(35), [0.0066, 1.5928, -0.0103], (2, 3), Region::Torso),
    joint(("vc1", "vc1"), Some(36), [0.0066, 1.6144, -0.0034], (3, 5), Region::Torso),
    joint(("skullbase", "skullbase"), Some(37), [0.0044, 1.6209, 0.0236], (1, 1), Region::Torso),
    joint(("l_eyeball_joint", "l_eyeball_joint"), Some(38), [0.0336, 1.6332, 0.0502], (3, 5), Region::Face),
    joint(("r_eyeball_joint", "r_eyeball_joint"), Some(38), [-0.0336, 1.6332, 0.0502], (3, 5), Region::Face),
    joint(("l_sternoclavicular", "l_sternoclavicular"), Some(30), [0.082, 1.4488, -0.0353], (2, 2), Region::Arms),
    joint(("l_acromioclavicular", "l_acromioclavicular"), Some(41), [0.0962, 1.4269, -0.0424], (2, 2), Region::Arms),
    joint(("l_shoulder", "l_shoulder"), Some(42), [0.2029, 1.4376, -0.0387], (1, 0), Region::Arms),
    joint(("l_elbow", "l_elbow"), Some(43), [0.2014, 1.1357, -0.0682], (1, 1), Region::Arms),
    joint(("l_wrist", "l_radiocarpal"), Some(44), [0.1984, 0.8663, -0.0583], (1, 2), Region::Arms),
    joint(("l_thumb1", "l_carpometacarpal_1"), Some(45), [0.1924, 0.8472, -0.0534], (2, 4), Region::Hands),
    joint(("l_thumb2", "l_metacarpophalangeal_1"), Some(46), [0.1951, 0.8226, 0.0246], (2, 4), Region::Hands),
    joint(("l_thumb3", "l_carpal_interphalangeal_1"), Some(47), [0.1955, 0.8159, 0.0464], (2, 5), Region::Hands),
    joint(("l_index0", "l_carpometacarpal_2"), Some(45), [0.1983, 0.8024, -0.028], (2, 5), Region::Hands),
    joint(("l_index1", "l_metacarpophalangeal_2"), Some(49), [0.1983, 0.7815, -0.028], (2, 4), Region::Hands),
    joint(("l_index2", "l_carpal_proximal_interphalangeal_2"), Some(50), [0.2017, 0.7363, -0.0248], (2, 4), Region::Hands),
    joint(("l_index3", "l_carpal_distal_interphalangeal_2"), Some(51), [0.2028, 0.7139, -0.0236], (2, 5), Region::Hands),
    joint(("l_middle0", "l_carpometacarpal_3"), Some(45), [0.1987, 0.8029, -0.053], (2, 5), Region::Hands),
    joint(("l_middle1", "l_metacarpophalangeal_3"), Some(53), [0.1987, 0.7818, -0.053], (2, 4), Region::Hands),
    joint(("l_middle2", "l_carpal_proximal_interphalangeal_3"), Some(54), [0.2013, 0.7273, -0.0503], (2, 4), Region::Hands),
    joint(("l_middle3", "l_carpal_distal_interphalangeal_3"), Some(55), [0.2026, 0.7011, -0.0494], (2, 5), Region::Hands),
    joint(("l_ring0", "l_carpometacarpal_4"), Some(45), [0.1956, 0.8019, -0.0794], (2, 5), Region::Hands),
    joint(("l_ring1", "l_metacarpophalangeal_4"), Some(57), [0.1956, 0.7815, -0.0794], (2, 4), Region::Hands),
    joint(("l_ring2", "l_carpal_proximal_interphalangeal_4"), Some(58), [0.1973, 0.7287, -0.0777], (2, 5), Region::Hands),
    joint(("l_ring3", "l_carpal_distal_interphalangeal_4"), Some(59), [0.1983, 0.7045, -0.0767], (2, 5), Region::Hands),
    joint(("l_pinky0", "l_carpometacarpal_5"), Some(45), [0.1925, 0.8066, -0.1036], (2, 5), Region::Hands),
    joint(("l_pinky1", "l_metacarpophalangeal_5"), Some(61), [0.1925, 0.7866, -0.1036], (2, 4), Region::Hands),
    joint(("l_pinky2", "l_carpal_proximal_interphalangeal_5"), Some(62), [0.1938, 0.7452, -0.1024], (2, 5), Region::Hands),
    joint(("l_pinky3", "l_carpal_distal_interphalangeal_5"), Some(63), [0.1948, 0.7277, -0.1017], (2, 5), Region::Hands),
    joint(("r_sternoclavicular", "r_sternoclavicular"), Some(30), [-0.082, 1.4488, -0.0353], (2, 2), Region::Arms),
    joint(("r_acromioclavicular", "r_acromioclavicular"), Some(65), [-0.0962, 1.4269, -0.0424], (2, 2), Region::Arms),
    joint(("r_shoulder", "r_shoulder"), Some(66), [-0.2029, 1.4376, -0.0387], (1, 0), Region::Arms),
    joint(("r_elbow", "r_elbow"), Some(67), [-0.2014, 1.1357, -0.0682], (1, 1), Region::Arms),
    joint(("r_wrist", "r_radiocarpal"), Some(68), [-0.1984, 0.8663, -0.0583], (1, 2), Region::Arms),
    joint(("r_thumb1", "r_carpometacarpal_1"), Some(69), [-0.1924, 0.8472, -0.0534], (2, 4), Region::Hands),
    joint(("r_thumb2", "r_metacarpophalangeal_1"), Some(70), [-0.1951, 0.8226, 0.0246], (2, 4), Region::Hands),
    joint(("r_thumb3", "r_carpal_interphalangeal_1"), Some(71), [-0.1955, 0.8159, 0.0464], (2, 5), Region::Hands),
    joint(("r_index0", "r_carpometacarpal_2"), Some(69), [-0.1983, 0.8024, -0.028], (2, 5), Region::Hands),
    joint(("r_index1", "r_metacarpophalangeal_2"), Some(73), [-0.1983, 0.7815, -0.028], (2, 4), Region::Hands),
    joint(("r_index2", "r_carpal_proximal_interphalangeal_2"), Some(74), [-0.2017, 0.7363, -0.0248], (2, 4), Region::Hands),
    joint(("r_index3", "r_carpal_distal_interphalangeal_2"), Some(75), [-0.2028, 0.7139, -0.0236], (2, 5), Region::Hands),
    joint(("r_middle0", "r_carpometacarpal_3"), Some(69), [-0.1987, 0.8029, -0.053], (2, 5), Region::Hands),
    joint(("r_middle1", "r_metacarpophalangeal_3"), Some(77), [-0.1987, 0.7818, -0.053], (2, 4), Region::Hands),
    joint(("r_middle2", "r_carpal_proximal_interphalangeal_3"), Some(78), [-0.2013, 0.7273, -0.0503], (2, 4), Region::Hands),
    joint(("r_middle3", "r_carpal_distal_interphalangeal_3"), Some(79), [-0.2026, 0.7011, -0.0494], (2, 5), Region::Hands),
    joint(("r_ring0", "r_carpometacarpal_4"), Some(69), [-0.1956, 0.8019, -0.0794], (2, 5), Region::Hands),
    joint(("r_ring1", "r_metacarpophalangeal_4"), Some(81), [-0.1956, 0.7815, -0.0794], (2, 4), Region::Hands),
    joint(("r_ring2", "r_carpal_proximal_interphalangeal_4"), Some(82), [-0.1973, 0.7287, -0.0777], (2, 5), Region::Hands),
    joint(("r_ring3", "r_carpal_distal_interphalangeal_4"), Some(83), [-0.1983, 0.7045, -0.0767], (2, 5), Region::Hands),
    joint(("r_pinky0", "r_carpometacarpal_5"), Some(69), [-0.1925, 0.8066, -0.1036], (2, 5), Region::Hands),
    joint(("r_pinky1", "r_metacarpophalangeal_5"), Some(85), [-0.1925, 0.7866, -0.1036], (2, 4), Region::Hands),
    joint(("r_pinky2", "r_carpal_proximal_interphalangeal_5"), Some(86), [-0.1938, 0.7452, -0.1024], (2, 5), Region::Hands),
    joint(("r_pinky3", "r_carpal_distal_interphalangeal_5"), Some(87), [-0.1948, 0.7277, -0.1017], (2, 5), Region::Hands),
    joint(("l_eyelid_joint", "l_eyelid_joint"), Some(38), [0.0336, 1.6332, 0.0502], (3, 5), Region::Face),
    joint(("r_eyelid_joint", "r_eyelid_joint"), Some(38), [-0.0336, 1.6332, 0.0502], (3, 5), Region::Face),
    joint(("l_eyebrow_joint", "l_eyebrow_joint"), Some(38), [0.0336, 1.635, 0.0506], (3, 5), Region::Face),
    joint(("r_eyebrow_joint", "r_eyebrow_joint"), Some(38), [-0.0336, 1.635, 0.0506], (3, 5), Region::Face),
    joint(("temporomandibular", "temporomandibular"), Some(38), [0.0, 1.63, 0.015], (3, 5), Region::Face),
];

/// The joints that the joint scheme of the thesis has beyond the standard's: a fourth joint of each
/// thumb, between wrist and `thumb1`, with the centre of the wrist.
#[rustfmt::skip]
pub static THUMB_BASES: [HanimJoint; 2] = [
    joint(("l_thumb0", "l_thumb0"), Some(45), [0.1984, 0.8663, -0.0583], (2, 5), Region::Hands),
    joint(("r_thumb0", "r_thumb0"), Some(69), [-0.1984, 0.8663, -0.0583], (2, 5), Region::Hands),
];

/// Returns the joint of this name, ignoring case: of the standard, as [`find`] does, or of
/// [`THUMB_BASES`].
pub fn named(name: &str) -> Option<&'static HanimJoint> {
    let is_named = |joint: &&HanimJoint| joint.name.eq_ignore_ascii_case(name);
    let standard = find(name).map(|index| &JOINTS[index]);
    standard.or_else(|| THUMB_BASES.iter().find(is_named))
}

/// Returns the index of the joint with this H-Anim 1.1 or 2 name, ignoring case.
///
/// The root's old spelling `HumanoidRoot` is accepted as well.
pub fn find(name: &str) -> Option<usize> {
    if name.eq_ignore_ascii_case("HumanoidRoot") {
        return Some(0);
    }
    JOINTS.iter().position(|joint| {
        joint.name.eq_ignore_ascii_case(name) || joint.name_v2.eq_ignore_ascii_case(name)
    })
}

const fn joint(
    names: (&'static str, &'static str),
    parent: Option<usize>,
    center: [f32; 3],
    levels: (u8, u8),
    region: Region,
) -> HanimJoint {
    HanimJoint {
        name: names.0,
        name_v2: names.1,
        parent,
        center: Vec3::from_array(center),
        hanim_level: levels.0,
        level: levels.1,
        region,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::articulation::MAX_LEVEL;

    fn body() -> &'static [HanimJoint] {
        &JOINTS[..BODY_JOINTS]
    }

    #[test]
    fn levels_hold_the_counts_of_the_thesis() {
        let counts: Vec<usize> = (0..=MAX_LEVEL)
            .map(|level| body().iter().filter(|j| j.level <= level).count())
            .collect();
        assert_eq!(counts, [5, 10, 24, 35, 51, 89]);
    }

    #[test]
    fn official_levels_hold_the_counts_of_the_standard() {
        let counts: Vec<usize> = (0..=3)
            .map(|level| body().iter().filter(|j| j.hanim_level <= level).count())
            .collect();
        assert_eq!(counts, [1, 18, 71, 89]);
    }

    #[test]
    fn regions_partition_the_body() {
        let counts = Region::ALL.map(|r| body().iter().filter(|j| j.region == r).count());
        assert_eq!(counts, [2, 10, 25, 4, 4, 6, 38]);
    }

    #[test]
    fn sides_mirror_each_other() {
        for (index, left) in JOINTS.iter().enumerate() {
            if let Some(parent) = left.parent {
                assert!(parent < index, "{} stands before its parent", left.name);
            }
            let Some(rest) = left.name.strip_prefix("l_") else {
                continue;
            };
            let right = &JOINTS[find(&format!("r_{rest}")).unwrap()];
            assert_eq!(right.center, left.center * Vec3::new(-1.0, 1.0, 1.0));
            assert_eq!((right.level, right.region), (left.level, left.region));
            assert!(left.center.x > 0.0);
        }
    }

    #[test]
    fn every_name_is_found_once() {
        for (index, joint) in JOINTS.iter().enumerate() {
            assert_eq!(find(joint.name), Some(index));
            assert_eq!(find(joint.name_v2), Some(index));
        }
        assert_eq!(find("HumanoidRoot"), Some(0));
        assert_eq!(find("tail"), None);
    }

    #[test]
    fn thumb_bases_rest_at_the_wrists() {
        for base in &THUMB_BASES {
            assert!(find(base.name).is_none(), "the standard does not have it");
            assert_eq!(named(&base.name.to_uppercase()), Some(base));
            let wrist = &JOINTS[base.parent.unwrap()];
            assert_eq!(wrist.name, base.name.replace("thumb0", "wrist"));
            assert_eq!(base.center, wrist.center);
        }
        assert_eq!(named("l_radiocarpal").unwrap().name, "l_wrist");
    }
}
