//! Rigs of tests, written as indented text.

use super::{JointMapping, map};
use articula_core::Transform;
use articula_core::source::{Joint, Skeleton};
use articula_formats::joint_map::builtin;
use glam::Vec3;

/// A rig of one joint per line, indented by its depth in the tree: its name, optionally its position
/// at rest in model space, `=` and what it is. Returns the rig and what each joint is.
pub(super) fn rig(text: &str) -> (Skeleton, Vec<&str>) {
    let mut joints: Vec<Joint> = Vec::new();
    let mut places: Vec<Vec3> = Vec::new();
    let mut above: Vec<usize> = Vec::new();
    let mut wanted = Vec::new();
    for line in text.lines().filter(|l| !l.trim().is_empty()) {
        let depth = line.len() - line.trim_start().len();
        let (own, hanim) = line.trim().split_once(" = ").unwrap();
        let mut words = own.split(' ');
        let name = words.next().unwrap();
        let numbers: Vec<f32> = words.map(|w| w.parse().unwrap()).collect();
        let place = match numbers[..] {
            [x, y, z] => Vec3::new(x, y, z),
            _ => Vec3::ZERO,
        };
        above.truncate(depth);
        let parent = above.last().copied();
        let from = parent.map_or(Vec3::ZERO, |p| places[p]);
        joints.push(Joint {
            name: name.to_owned(),
            parent,
            rest: Transform::from_translation(place - from),
            in_skin: true,
        });
        places.push(place);
        above.push(joints.len() - 1);
        wanted.push(hanim);
    }
    (Skeleton { joints }, wanted)
}

/// Maps a rig with the built-in joint maps and compares every joint with what it is.
pub(super) fn check_map(text: &str) -> JointMapping {
    let (skeleton, wanted) = rig(text);
    let mapping = map(&skeleton, builtin(), None);
    let joints = skeleton.joints.iter().zip(&mapping.articulation.joints);
    for ((joint, own), wanted) in joints.zip(wanted) {
        assert_eq!(
            own.hanim.as_deref().unwrap_or("-"),
            wanted,
            "{}",
            joint.name
        );
    }
    mapping
}
