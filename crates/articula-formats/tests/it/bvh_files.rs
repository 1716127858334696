//! BVH files of every family are read in metres and upright, and round-trip.

use crate::real::bytes;
use crate::world::places as world;
use articula_core::source::{Character, Property};
use articula_formats::bvh::{self, ChannelOrder, WriteOptions};
use articula_formats::joint_map;
use articula_formats::{Limits, ReadError};
use articula_formats::{MotionFile, ReadOptions, UpAxis};
use glam::{Quat, Vec3};

fn read(bytes: &[u8]) -> MotionFile {
    let read = bvh::read(bytes, &ReadOptions::default(), &Limits::default());
    read.unwrap().value
}

/// Reads text in which one unit is a metre and +Y is up.
fn plain(text: &str) -> Result<articula_formats::Parsed<MotionFile>, ReadError> {
    let options = ReadOptions {
        scale_to_metres: Some(1.0),
        up: UpAxis::Y,
        ..ReadOptions::default()
    };
    bvh::read(text.as_bytes(), &options, &Limits::default())
}

fn height(character: &Character) -> f32 {
    let mut still = character.clone();
    still.clips.clear();
    let heights = world(&still, 0.0).into_iter().map(|p| p.y);
    let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
    high - low
}

const ARM: &str = "HIERARCHY
ROOT a
{
  OFFSET 0 1 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT b
  {
    OFFSET 0 0.5 0
    CHANNELS 3 Yrotation Zrotation Xrotation
    End Site
    {
      OFFSET 0 0.25 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.5
0 1 0 0 0 0 0 0 0
1 2 3 90 0 0 90 90 0
";

#[test]
fn an_arm_by_hand() {
    let file = plain(ARM).unwrap();
    assert!(file.warnings.is_empty(), "{:?}", file.warnings);
    let file = file.value;
    assert_eq!(file.end_sites, [(1, Vec3::new(0.0, 0.25, 0.0))]);
    let clip = &file.character.clips[0];
    assert_eq!((clip.duration_secs, file.frame_time_secs), (0.5, 0.5));
    let kinds: Vec<_> = clip
        .channels
        .iter()
        .map(|c| (c.target, c.property))
        .collect();
    use Property::{Rotation, Translation};
    assert_eq!(kinds, [(0, Translation), (0, Rotation), (1, Rotation)]);
    // The root rotates its child's offset by 90 degrees about Z: +Y becomes -X.
    let places = world(&file.character, 0.5);
    assert!(places[1].distance(Vec3::new(0.5, 2.0, 3.0)) < 1e-6);
    // Intrinsic, in declared order: first about Y, then about the rotated Z.
    let q = Quat::from_slice(&clip.channels[2].values[4..]);
    let quarter = std::f32::consts::FRAC_PI_2;
    let wanted = Quat::from_rotation_y(quarter) * Quat::from_rotation_z(quarter);
    assert!(q.dot(wanted).abs() > 1.0 - 1e-6);
}

#[test]
fn odd_spelling_is_read_alike() {
    let odd = ARM
        .replace('\n', "\r\n")
        .replace("  ", "\t ")
        .replace("JOINT b\r\n\t \t{", "joint b {")
        .replace("ROOT", "Root")
        .replace("Xposition", "XPOSITION")
        .replace("Frame Time:", "frame time :")
        .replace("Frames:", "FRAMES")
        .replace("0 1 0 0", "\r\n  0\t1   0 0");
    assert_eq!(plain(&odd).unwrap().value, plain(ARM).unwrap().value);
}

#[test]
fn several_roots_and_joints_without_channels() {
    let text = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Yposition\nJOINT c\n{\nOFFSET 1 0 0\n}\n}\n\
                ROOT b\n{\nOFFSET 2 0 0\nCHANNELS 2 Xrotation Xrotation\n}\nMOTION\nFrames: 1\nFrame Time: 1\n5 30 60\n";
    let file = plain(text).unwrap().value;
    let parents: Vec<_> = file
        .character
        .skeleton
        .joints
        .iter()
        .map(|j| j.parent)
        .collect();
    assert_eq!(parents, [None, Some(0), None]);
    let channels = &file.character.clips[0].channels;
    assert_eq!(channels[0].values, [0.0, 5.0, 0.0]);
    let q = Quat::from_slice(&channels[1].values);
    assert!(
        q.dot(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2))
            .abs()
            > 1.0 - 1e-6
    );
}

#[test]
fn a_wrong_frame_count_is_warned_about() {
    for count in ["1", "3", "99999999999999999999", "many"] {
        let text = ARM.replace("Frames: 2", &format!("Frames: {count}"));
        let read = plain(&text).unwrap();
        assert_eq!(read.warnings.len(), 1);
        assert!(read.warnings[0].what.contains("the file has 2"));
        assert_eq!(
            read.value.character.clips[0].channels[0].times_secs.len(),
            2
        );
    }
}

#[test]
fn every_fault_names_its_line() {
    let cases = [
        (
            "1 2 3 90 0 0 90 90 0",
            "1 2 3 90",
            "line 20: 4 values found, 9 expected",
        ),
        (
            "1 2 3 90 0 0 90 90 0",
            "1 2 3 90 0 0 90 90 0 7",
            "line 20: 10 values found",
        ),
        (
            "1 2 3 90 0 0 90 90 0",
            "NaN 1e99 x inf - 0 9 9 0",
            "line 20: \"NaN\" found",
        ),
        (
            "OFFSET 0 0.5 0",
            "OFFSET 0 0.5",
            "line 8: OFFSET has 2 numbers",
        ),
        (
            "CHANNELS 3 Y",
            "CHANNELS 4 Y",
            "line 9: CHANNELS declares 4",
        ),
        (
            "CHANNELS 3 Y",
            "CHANNELS 999999999999 Y",
            "line 9: CHANNELS",
        ),
        (
            "Yrotation Z",
            "Wrotation Z",
            "line 9: channel \"Wrotation\"",
        ),
        (
            "Frame Time: 0.5",
            "Frame Time: 0",
            "line 18: frame time 0 s",
        ),
        ("Frame Time: 0.5", "Frame Speed: 0.5", "line 18"),
        ("ROOT a\n{", "ROOT a\n", "line 4: OFFSET outside"),
        (
            "}\nMOTION",
            "MOTION",
            "line 15: the joint \"a\" is not closed",
        ),
        ("}\nMOTION", "}}\nMOTION", "line 15: \"}\" without a"),
        ("JOINT b", "ROOT b", "line 6: ROOT inside"),
        ("JOINT b", "BONE b", "line 6: \"BONE\" found"),
        (
            "Frames: 2",
            "",
            "line 18: \"Frame Time: 0.5\" found, \"frames:\" expected",
        ),
    ];
    for (from, to, wanted) in cases {
        let error = plain(&ARM.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(wanted), "{to:?}: {error}");
    }
    assert!(plain("").unwrap_err().to_string().contains("no ROOT"));
    assert!(plain("\u{0}\u{1}glTF").is_err());
}

#[test]
fn depth_and_counts_are_bounded() {
    let deep: String = (0..200).map(|i| format!("JOINT j{i}\n{{\n")).collect();
    let error = plain(&format!("HIERARCHY\nROOT r\n{{\n{deep}")).unwrap_err();
    assert!(
        matches!(error, ReadError::LimitExceeded { limit: 128, .. }),
        "{error}"
    );
    let tight = |limits: Limits| bvh::read(ARM.as_bytes(), &ReadOptions::default(), &limits);
    let all = Limits::default();
    for limits in [
        Limits { nodes: 1, ..all },
        Limits { frames: 1, ..all },
        Limits {
            elements: 17,
            ..all
        },
        Limits { bytes: 10, ..all },
        Limits { depth: 2, ..all },
    ] {
        assert!(
            matches!(tight(limits), Err(ReadError::LimitExceeded { .. })),
            "{limits:?}"
        );
    }
}

#[test]
fn truncated_anywhere_it_gives_a_value_or_an_error() {
    let read = |length: usize| {
        bvh::read(
            &ARM.as_bytes()[..length],
            &ReadOptions::default(),
            &Limits::default(),
        )
    };
    let good = (0..ARM.len()).filter(|&length| read(length).is_ok());
    // Valid prefixes end between the last brace and MOTION, or after the frame time.
    let first = ARM.find("MOTION").unwrap() - 1;
    assert!(good.clone().all(|length| length >= first));
    assert!(good.count() > 3);
}

/// Name, and accepted range in metres of the height of its joints at rest (without end sites).
const FILES: [(&str, std::ops::Range<f32>); 13] = [
    ("bvh/cmu_01_01.bvh", 1.3..1.5),
    ("bvh/cmu_01_03.bvh", 1.3..1.5),
    ("bvh/cmu_12_01_walk.bvh", 1.2..1.5),
    ("bvh/dance_fingers.bvh", 1.4..1.6),
    ("bvh/fair1_dab.bvh", 1.3..1.75),
    ("bvh/fair1_jumping.bvh", 1.3..1.75),
    ("bvh/fair1_wave_hello.bvh", 1.3..1.75),
    ("bvh/fair1_zombie.bvh", 1.3..1.75),
    ("bvh/makehuman_walk1.bvh", 1.3..1.7),
    ("bvh/makehuman_zombieWalk1.bvh", 1.3..1.7),
    ("bvh/pybvh_test1.bvh", 1.4..1.7),
    ("bvh/pybvh_test3_fingers.bvh", 1.4..1.7),
    ("face/makehuman_face-poseunits.bvh", 1.4..1.7),
];

#[test]
fn real_files_are_upright_humans_in_metres() {
    for (name, heights) in FILES {
        let Some(bytes) = bytes(name) else {
            println!("skipped: no data");
            return;
        };
        let character = read(&bytes).character;
        let found = height(&character);
        assert!(heights.contains(&found), "{name}: {found} m");
        let mapping =
            articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
        assert!(mapping.humanoid, "{name}");
        let joint = |hanim: &str| {
            let joints = &mapping.articulation.joints;
            let found = joints
                .iter()
                .position(|j| j.hanim.as_deref() == Some(hanim));
            found.unwrap_or_else(|| panic!("{name} lacks {hanim}"))
        };
        let middle = character.clips[0].duration_secs / 2.0;
        let places = world(&character, middle);
        let (head, root) = (places[joint("skullbase")], places[joint("humanoid_root")]);
        assert!(head.y > root.y + 0.1, "{name}: head {head}, root {root}");
        // Left joints are left of the toes' direction; one figure rests on straight feet, facing
        // +Z.
        let mut still = character.clone();
        still.clips.clear();
        let rest = world(&still, 0.0);
        let across = rest[joint("l_shoulder")] - rest[joint("r_shoulder")];
        let toes = rest[joint("l_metatarsal")] - rest[joint("l_ankle")];
        let straight = name.contains("pybvh_test3");
        let forward = if straight { Vec3::Z } else { toes };
        assert!(
            across.cross(Vec3::Y).dot(forward) > 0.0,
            "{name}: {across} {toes}"
        );
    }
}

#[test]
fn real_files_survive_writing() {
    for (name, _) in FILES {
        let Some(bytes) = bytes(name) else {
            println!("skipped: no data");
            return;
        };
        let mut first = read(&bytes);
        // The long files repeat themselves; their first seconds are enough.
        for clip in &mut first.character.clips {
            clip.duration_secs = clip.duration_secs.min(2.0);
        }
        for order in [ChannelOrder::Zxy, ChannelOrder::Xyz, ChannelOrder::Yzx] {
            let options = WriteOptions {
                rate_hz: 1.0 / first.frame_time_secs,
                order,
                end_sites: first.end_sites.clone(),
                ..WriteOptions::default()
            };
            let text = bvh::write(&first.character, 0, &options).unwrap();
            let second = bvh::read(
                &text,
                &ReadOptions {
                    scale_to_metres: Some(0.01),
                    up: UpAxis::Y,
                    ..ReadOptions::default()
                },
                &Limits::default(),
            )
            .unwrap();
            assert!(second.warnings.is_empty(), "{:?}", second.warnings);
            let second = second.value;
            assert_eq!(first.end_sites.len(), second.end_sites.len());
            let tolerance = 1e-4 * height(&first.character);
            for step in 0..20 {
                let time = first.frame_time_secs * step as f32 * 3.0;
                if time > first.character.clips[0].duration_secs {
                    break;
                }
                let (a, b) = (
                    world(&first.character, time),
                    world(&second.character, time),
                );
                for (joint, (a, b)) in a.iter().zip(&b).enumerate() {
                    let apart = a.distance(*b);
                    assert!(
                        apart <= tolerance,
                        "{name} {order:?} joint {joint}: {apart} m"
                    );
                }
            }
        }
    }
}

#[test]
fn rest_rotations_and_scale_are_written_as_positions() {
    let mut character = plain(ARM).unwrap().value.character;
    let joints = &mut character.skeleton.joints;
    joints[0].rest.rotation = Quat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 1.1);
    joints[0].rest.scale = Vec3::splat(2.0);
    joints[1].rest.rotation = Quat::from_rotation_x(0.9);
    let options = WriteOptions {
        rate_hz: 2.0,
        units_per_metre: 1.0,
        ..WriteOptions::default()
    };
    let text = bvh::write(&character, 0, &options).unwrap();
    let back = plain(std::str::from_utf8(&text).unwrap()).unwrap().value;
    for time in [0.0, 0.5] {
        let (a, b) = (world(&character, time), world(&back.character, time));
        for (a, b) in a.iter().zip(&b) {
            assert!(a.distance(*b) < 1e-5, "{time}: {a} {b}");
        }
    }
    let rest = back.character.skeleton.joints[1].rest;
    assert_eq!(rest.rotation, Quat::IDENTITY);
    assert!(
        (rest.translation.length() - 1.0).abs() < 1e-5,
        "scaled offset"
    );
}

#[test]
fn writing_nonsense_is_refused() {
    let character = plain(ARM).unwrap().value.character;
    let rate = |rate_hz| WriteOptions {
        rate_hz,
        ..WriteOptions::default()
    };
    for (clip, options) in [(1, rate(30.0)), (0, rate(0.0)), (0, rate(f32::NAN))] {
        assert!(bvh::write(&character, clip, &options).is_err());
    }
}

/// Maximum distance that the maker of both files measured, in metres.
const DANCE_APART: f32 = 0.041e-3;

#[test]
fn the_dance_is_the_same_in_both_formats() {
    let names = ["bvh/dance_fingers.bvh", "glb/mh_female_dance.glb"];
    let [Some(text), Some(binary)] = names.map(bytes) else {
        println!("skipped: no data");
        return;
    };
    let dance = read(&text);
    let mut nothing_beside = |uri: &str| Err(format!("{uri} is not there"));
    let other = articula_formats::gltf::read(&binary, &Limits::default(), &mut nothing_beside);
    let other = other.unwrap().value.character;
    for frame in (0..720).step_by(24) {
        let ours = world(&dance.character, dance.frame_time_secs * frame as f32);
        let theirs = world(&other, frame as f32 / 30.0);
        for (index, joint) in dance.character.skeleton.joints.iter().enumerate() {
            let twin = other.skeleton.find(&joint.name).unwrap();
            let apart = ours[index].distance(theirs[twin]);
            // Sums of 163 offsets in f32 add less than a micrometre.
            let allowed = DANCE_APART + 1e-6;
            assert!(apart <= allowed, "{} at {frame}: {apart} m", joint.name);
        }
    }
}
