//! Joints of the reference human: the tree and order of H-Anim, with centres fitted to its body.
//!
//! Source: ISO/IEC 19774 through `articula_core::hanim_table`. The centres of the standard put the
//! spine beside the middle, both feet flat on the floor and the arms so close to the thighs that a
//! body around them would merge. Those centres are replaced here, and the right side is the exact
//! mirror image of the left.

use articula_core::hanim_table::{BODY_JOINTS, JOINTS};
use articula_core::source;
use articula_core::{Articulation, JointArticulation, Transform};
use glam::{Mat3, Vec3};

/// Centres that differ from the standard: pelvis, lumbar and cervical spine, and the legs and arms
/// of the left side.
const FITTED: [(&str, [f32; 3]); 33] = [
    ("humanoid_root", [0.0, 0.9, 0.0]),
    ("sacroiliac", [0.0, 0.93, -0.01]),
    ("vl5", [0.0, 1.0568, -0.05]),
    ("vl4", [0.0, 1.0925, -0.048]),
    ("vl3", [0.0, 1.1276, -0.048]),
    ("vl2", [0.0, 1.1546, -0.05]),
    ("vl1", [0.0, 1.1912, -0.055]),
    ("vt12", [0.0, 1.2278, -0.061]),
    ("vt11", [0.0, 1.2679, -0.068]),
    ("vt10", [0.0, 1.2848, -0.071]),
    ("vt4", [0.0, 1.432, -0.073]),
    ("vt3", [0.0, 1.4583, -0.068]),
    ("vt2", [0.0, 1.4761, -0.063]),
    ("vt1", [0.0, 1.4951, -0.057]),
    ("vc7", [0.0, 1.5132, -0.05]),
    ("vc6", [0.0, 1.5357, -0.041]),
    ("vc5", [0.0, 1.552, -0.034]),
    ("vc4", [0.0, 1.5662, -0.028]),
    ("vc3", [0.0, 1.58, -0.023]),
    ("vc2", [0.0, 1.5928, -0.018]),
    ("vc1", [0.0, 1.605, -0.013]),
    ("skullbase", [0.0, 1.612, -0.01]),
    ("l_hip", [0.088, 0.9124, 0.0]),
    ("l_knee", [0.097, 0.4867, 0.006]),
    ("l_ankle", [0.104, 0.082, -0.04]),
    ("l_subtalar", [0.105, 0.05, -0.036]),
    ("l_midtarsal", [0.109, 0.046, 0.03]),
    ("l_metatarsal", [0.114, 0.016, 0.094]),
    ("l_sternoclavicular", [0.022, 1.452, -0.005]),
    ("l_acromioclavicular", [0.145, 1.462, -0.035]),
    ("l_shoulder", [0.18, 1.4376, -0.03]),
    ("l_elbow", [0.2225, 1.1357, -0.045]),
    ("l_wrist", WRIST),
];

const WRIST: [f32; 3] = [0.247, 0.868, -0.02];

/// Names of the fingers, thumb first.
pub(crate) const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "pinky"];

/// Joint centres and tip of each finger in metres, in the frame of the hand: towards the back of
/// the hand, the finger tips and the side of the thumb.
pub(crate) const FINGER_POINTS: [[[f32; 3]; 5]; 5] = [
    [
        [-0.009, 0.026, 0.02],
        [-0.009, 0.026, 0.02],
        [-0.020, 0.060, 0.0395],
        [-0.0265, 0.0915, 0.0465],
        [-0.0305, 0.117, 0.0495],
    ],
    [
        [0.0, 0.03, 0.011],
        [0.003, 0.091, 0.027],
        [-0.0045, 0.1325, 0.028],
        [-0.0155, 0.1535, 0.0265],
        [-0.0295, 0.17, 0.0245],
    ],
    [
        [0.001, 0.03, 0.002],
        [0.004, 0.094, 0.0055],
        [-0.0045, 0.139, 0.0065],
        [-0.0175, 0.163, 0.006],
        [-0.033, 0.1795, 0.0055],
    ],
    [
        [0.0, 0.031, -0.007],
        [0.002, 0.089, -0.016],
        [-0.0075, 0.13, -0.0155],
        [-0.021, 0.1515, -0.0145],
        [-0.0365, 0.166, -0.0135],
    ],
    [
        [-0.002, 0.032, -0.015],
        [-0.002, 0.081, -0.036],
        [-0.011, 0.1125, -0.0365],
        [-0.0215, 0.1285, -0.035],
        [-0.0335, 0.1395, -0.0335],
    ],
];

/// Axes of the left hand in model space: towards the back of the hand, the finger tips and the side
/// of the thumb.
pub(crate) fn hand_axes() -> Mat3 {
    let down = Vec3::new(0.05, -1.0, 0.075).normalize();
    let back = Vec3::new(1.0, 0.05, -0.12);
    let back = (back - down * back.dot(down)).normalize();
    Mat3::from_cols(back, down, down.cross(back))
}

/// Converts a point of the left hand from the frame of the hand to model space.
pub(crate) fn hand_point(point: [f32; 3]) -> Vec3 {
    Vec3::from(WRIST) + hand_axes() * Vec3::from(point)
}

/// Rest centres of the 89 joints in model space, in the order of the joint table.
pub(crate) fn centers() -> Vec<Vec3> {
    let body = &JOINTS[..BODY_JOINTS];
    body.iter()
        .map(|joint| match joint.name.strip_prefix("r_") {
            Some(rest) => {
                left_center(&format!("l_{rest}"), joint.center) * Vec3::new(-1.0, 1.0, 1.0)
            }
            None => left_center(joint.name, joint.center),
        })
        .collect()
}

fn left_center(name: &str, standard: Vec3) -> Vec3 {
    if let Some((_, center)) = FITTED.iter().find(|(n, _)| *n == name) {
        return Vec3::from(*center);
    }
    if name.contains("eyeball") {
        return EYE;
    }
    for (finger, points) in FINGERS.iter().zip(&FINGER_POINTS) {
        let digit = name.strip_prefix("l_").and_then(|n| n.strip_prefix(finger));
        if let Some(index) = digit.and_then(|d| d.parse::<usize>().ok()) {
            return hand_point(points[index.min(3)]);
        }
    }
    // The rest is the spine and the skull.
    Vec3::new(0.0, standard.y, standard.z)
}

/// Centre of the left eyeball.
pub(crate) const EYE: Vec3 = Vec3::new(0.0315, 1.6332, 0.0655);

/// Index of a body joint by its H-Anim name.
///
/// # Panics
/// If the joint does not exist; the names are constants of this crate.
pub(crate) fn joint(name: &str) -> usize {
    JOINTS[..BODY_JOINTS]
        .iter()
        .position(|j| j.name == name)
        .unwrap_or_else(|| panic!("{name} is not an H-Anim body joint"))
}

/// The joint tree at rest: identity rotations, offsets between centres.
pub(crate) fn skeleton() -> source::Skeleton {
    let centers = centers();
    let joints = JOINTS[..BODY_JOINTS]
        .iter()
        .zip(&centers)
        .map(|(joint, center)| source::Joint {
            name: joint.name.to_owned(),
            parent: joint.parent,
            rest: Transform::from_translation(
                *center - joint.parent.map_or(Vec3::ZERO, |p| centers[p]),
            ),
            in_skin: true,
        })
        .collect();
    source::Skeleton { joints }
}

/// Level and region of each joint, from the joint table.
pub(crate) fn articulation() -> Articulation {
    let joints = JOINTS[..BODY_JOINTS]
        .iter()
        .map(|j| JointArticulation {
            hanim: Some(j.name.to_owned()),
            level: j.level,
            region: j.region,
        })
        .collect();
    Articulation {
        profile: "H-Anim".to_owned(),
        joints,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_right_side_mirrors_the_left_and_the_spine_is_in_the_middle() {
        let centers = centers();
        for (j, row) in JOINTS[..BODY_JOINTS].iter().enumerate() {
            match row.name.strip_prefix("l_") {
                Some(rest) => {
                    let twin = centers[joint(&format!("r_{rest}"))];
                    assert_eq!(centers[j], twin * Vec3::new(-1.0, 1.0, 1.0), "{}", row.name);
                    assert!(centers[j].x > 0.0);
                }
                None if row.name.starts_with("r_") => {}
                None => assert_eq!(centers[j].x, 0.0, "{}", row.name),
            }
        }
    }

    #[test]
    fn fitted_centers_stay_near_the_standard() {
        for (row, center) in JOINTS.iter().zip(centers()) {
            // The arms hang 5 cm farther out; the collar joints are at the collar bones.
            assert!(
                row.center.distance(center) < 0.11,
                "{} at {center}",
                row.name
            );
        }
    }

    #[test]
    fn hand_axes_are_a_right_angled_frame_with_the_thumb_in_front() {
        let axes = hand_axes();
        assert!(
            (axes * axes.transpose() - Mat3::IDENTITY)
                .to_cols_array()
                .iter()
                .all(|v| v.abs() < 1e-6)
        );
        assert!(axes.z_axis.z > 0.9 && axes.y_axis.y < -0.9 && axes.x_axis.x > 0.9);
    }
}
