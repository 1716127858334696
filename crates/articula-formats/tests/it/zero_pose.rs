//! BVH files whose zero pose is no standing figure are read in the same unit and with the same up
//! axis as the same motion from a standing one.

use crate::real::bytes;
use crate::world::places;
use articula_formats::bvh;
use articula_formats::{Limits, MotionFile, ReadOptions};
use articula_mutate::Dice;
use glam::{DQuat, DVec3, EulerRot, Quat, Vec3};

/// Returns the text of a BVH file with at most 100 of its frames, evenly chosen: enough to tell the
/// unit and the axis, and soon written and read.
fn thinned(text: &str) -> String {
    let is = |line: &str, word: &str| line.trim_start().to_ascii_lowercase().starts_with(word);
    let mut lines = text.lines();
    let head: Vec<&str> = lines
        .by_ref()
        .take_while(|line| !is(line, "frame time"))
        .collect();
    let interval = text.lines().nth(head.len()).unwrap();
    let frames: Vec<&str> = lines.filter(|line| !line.trim().is_empty()).collect();
    let step = frames.len().div_ceil(100);
    let kept: Vec<&str> = frames.into_iter().step_by(step).collect();
    let count = format!("Frames: {}", kept.len());
    let head = head
        .into_iter()
        .map(|line| if is(line, "frames") { &count } else { line });
    let lines = head.chain([interval]).chain(kept);
    lines.map(|line| format!("{line}\n")).collect()
}

/// Returns the text of a BVH file with another zero pose and the same motion: the offsets and
/// positions below a joint `j` become `C(j)⁻¹ · offset`, the rotation of a joint becomes
/// `C(parent)⁻¹ · R · C(j)`. A joint without three rotation channels keeps its parent's `C`.
fn with_zero_pose(text: &str, mut turn: impl FnMut(usize) -> Quat) -> String {
    let mut joints: Vec<Joint> = Vec::new();
    let mut open: Vec<Option<usize>> = Vec::new();
    let mut out = String::new();
    let mut lines = text.lines();
    let mut pending = None;
    for line in lines.by_ref() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let owner = open.last().copied().flatten();
        let above =
            |joints: &[Joint], j: Option<usize>| j.map_or(DQuat::IDENTITY, |j| joints[j].zero);
        match words.first().map(|w| w.to_ascii_lowercase()).as_deref() {
            Some("root" | "joint") => {
                joints.push(Joint {
                    parent: owner,
                    ..Joint::default()
                });
                pending = Some(joints.len() - 1);
            }
            Some("end") => pending = None,
            Some("{") => open.push(pending),
            Some("}") => drop(open.pop()),
            Some("offset") => {
                // An end site's own entry is `None`; its joint is the one around it.
                let parent = match owner {
                    Some(joint) => joints[joint].parent,
                    None => open[open.len() - 2],
                };
                let [x, y, z] = above(&joints, parent)
                    .inverse()
                    .mul_vec3(vec3(&words[1..]).as_dvec3())
                    .to_array();
                out.push_str(&format!("OFFSET {x:.7} {y:.7} {z:.7}\n"));
                continue;
            }
            Some("channels") => {
                let joint = owner.unwrap();
                joints[joint].channels = words[2..].iter().map(|w| channel(w)).collect();
                let turns = joints[joint].channels.iter().filter(|c| c.0).count();
                let parent = above(&joints, joints[joint].parent);
                joints[joint].zero = if turns == 3 {
                    turn(joint).as_dquat().normalize()
                } else {
                    parent
                };
            }
            Some("motion") => {
                out.push_str("MOTION\n");
                break;
            }
            _ => {}
        }
        out.push_str(line);
        out.push('\n');
    }
    for line in lines {
        if line.contains(':') || line.trim().is_empty() {
            out.push_str(line);
        } else {
            let values: Vec<f64> = line
                .split_whitespace()
                .map(|w| w.parse().unwrap())
                .collect();
            out.push_str(&frame(&joints, &values));
        }
        out.push('\n');
    }
    out
}

#[derive(Default)]
struct Joint {
    parent: Option<usize>,
    /// Whether it is a rotation, and its axis.
    channels: Vec<(bool, usize)>,
    zero: DQuat,
}

fn vec3(words: &[&str]) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|axis| words[axis].parse().unwrap()))
}

fn channel(name: &str) -> (bool, usize) {
    let lower = name.to_ascii_lowercase();
    let axis = lower.bytes().next().unwrap() - b'x';
    (lower.ends_with("rotation"), usize::from(axis))
}

fn frame(joints: &[Joint], values: &[f64]) -> String {
    let mut first = 0;
    let mut words = Vec::new();
    for joint in joints {
        let above = joint
            .parent
            .map_or(DQuat::IDENTITY, |p| joints[p].zero)
            .inverse();
        let own = &values[first..first + joint.channels.len()];
        first += joint.channels.len();
        let (mut place, mut rotation) = (DVec3::ZERO, DQuat::IDENTITY);
        for (&(turns, axis), &value) in joint.channels.iter().zip(own) {
            if turns {
                rotation *= DQuat::from_axis_angle(DVec3::AXES[axis], value.to_radians());
            } else {
                place[axis] = value;
            }
        }
        let place = above * place;
        let turns: Vec<usize> = joint.channels.iter().filter(|c| c.0).map(|c| c.1).collect();
        let order = match turns[..] {
            [0, 1, 2] => EulerRot::XYZ,
            [0, 2, 1] => EulerRot::XZY,
            [1, 0, 2] => EulerRot::YXZ,
            [1, 2, 0] => EulerRot::YZX,
            [2, 0, 1] => EulerRot::ZXY,
            _ => EulerRot::ZYX,
        };
        let (a, b, c) = (above * rotation * joint.zero).to_euler(order);
        let mut angles = [a, b, c].into_iter();
        for &(turns, axis) in &joint.channels {
            words.push(if turns {
                format!("{:.6}", angles.next().unwrap().to_degrees())
            } else {
                format!("{:.6}", place[axis])
            });
        }
    }
    words.join(" ")
}

/// The offset of the first child or end site of each joint.
fn bones(text: &str) -> Vec<Vec3> {
    let mut bones: Vec<Option<Vec3>> = Vec::new();
    let mut open: Vec<Option<usize>> = Vec::new();
    let mut pending = None;
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first().map(|w| w.to_ascii_lowercase()).as_deref() {
            Some("root" | "joint") => {
                bones.push(None);
                pending = Some(bones.len() - 1);
            }
            Some("end") => pending = None,
            Some("{") => open.push(pending),
            Some("}") => drop(open.pop()),
            Some("offset") => {
                let above = open.len().checked_sub(2).and_then(|at| open[at]);
                if let Some(above) = above {
                    bones[above].get_or_insert(vec3(&words[1..]));
                }
            }
            Some("motion") => break,
            _ => {}
        }
    }
    let known = bones.into_iter();
    known.map(Option::unwrap_or_default).collect()
}

fn random_turn(dice: &mut Dice) -> Quat {
    let mut number = || dice.roll(2001) as f32 / 1000.0 - 1.0;
    loop {
        let [x, y, z, w] = [number(), number(), number(), number()];
        let length = glam::Vec4::new(x, y, z, w).length();
        if (0.1..1.0).contains(&length) {
            return Quat::from_xyzw(x, y, z, w).normalize();
        }
    }
}

fn read(text: &str) -> MotionFile {
    let read = bvh::read(text.as_bytes(), &ReadOptions::default(), &Limits::default());
    read.unwrap().value
}

/// Name, and whether the unit is known. Where it is not, the figure is scaled to a fixed height,
/// which the lengths of the bones give less exactly than a standing rest figure.
const FILES: [(&str, bool); 12] = [
    ("bvh/cmu_01_01.bvh", true),
    ("bvh/cmu_12_01_walk.bvh", true),
    ("bvh/dance_fingers.bvh", true),
    ("bvh/fair1_dab.bvh", false),
    ("bvh/fair1_jumping.bvh", false),
    ("bvh/fair1_wave_hello.bvh", false),
    ("bvh/fair1_zombie.bvh", false),
    ("bvh/makehuman_walk1.bvh", true),
    ("bvh/makehuman_zombieWalk1.bvh", true),
    ("bvh/pybvh_test1.bvh", true),
    ("bvh/pybvh_test3_fingers.bvh", true),
    ("face/makehuman_face-poseunits.bvh", true),
];

#[test]
fn any_zero_pose_has_the_unit_and_up_axis_of_a_standing_one() {
    let mut dice = Dice::new(7);
    for (name, known_unit) in FILES {
        let Some(bytes) = bytes(name) else {
            println!("skipped: no data");
            return;
        };
        let text = thinned(&String::from_utf8_lossy(&bytes));
        let standing = read(&text).character;
        // Four random ones, and all bones along one axis as in research exports.
        let bones = bones(&text);
        let along = |axis: Vec3| {
            let turn = |joint: usize| match bones[joint].try_normalize() {
                Some(bone) => Quat::from_rotation_arc(axis, bone),
                None => Quat::IDENTITY,
            };
            with_zero_pose(&text, turn)
        };
        let random = (0..4).map(|_| with_zero_pose(&text, |_| random_turn(&mut dice)));
        for zeroed in random.chain([Vec3::Y, Vec3::Z, Vec3::X].map(along)) {
            let folded = read(&zeroed).character;
            let middle = standing.clips[0].duration_secs / 2.0;
            let (a, b) = (places(&standing, middle), places(&folded, middle));
            let size =
                |places: &[Vec3]| -> f32 { places.iter().map(|p| p.distance(places[0])).sum() };
            let ratio = size(&b) / size(&a);
            let allowed = if known_unit { 1e-3 } else { 0.06 };
            assert!(
                (ratio - 1.0).abs() < allowed,
                "{name}: scale {ratio} of the standing one"
            );
            for (joint, (a, b)) in a.iter().zip(&b).enumerate() {
                let apart = (*a * ratio).distance(*b);
                assert!(apart < 2e-3, "{name} joint {joint}: {a} and {b}");
            }
        }
    }
}
