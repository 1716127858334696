//! BVA segments are where the file puts them, unconnected and assembled; no input panics.
//!
//! No BVA file by the format's makers is available. Files are therefore written by hand from the
//! description, and made from BVH files by the converter below, whose positions come from the BVH
//! reader.

use crate::real;
use crate::world::matrices as world;
use articula_core::source::{Character, Property};
use articula_formats::bva;
use articula_formats::{Limits, Parsed, ReadError, bvh, joint_map};
use articula_formats::{MotionFile, ReadOptions, UpAxis};
use glam::{Affine3A, DQuat, EulerRot, Quat, Vec3};
use std::fmt::Write as _;

const TWO: &str = "Segment: Hips
Frames: 2
Frame Time: 0.5
XTRAN YTRAN ZTRAN XROT YROT ZROT XSCALE YSCALE ZSCALE
INCHES INCHES INCHES DEGREES DEGREES DEGREES INCHES INCHES INCHES
0 40 0 0 0 0 5 9 4
10 40 20 90 90 0 5 9 4
Segment: Left Hand
Frames: 2
Frame Time: 0.5
XTRAN YTRAN ZTRAN XROT YROT ZROT XSCALE YSCALE ZSCALE
INCHES INCHES INCHES DEGREES DEGREES DEGREES RATIO RATIO RATIO
20 50 0 0 0 0 1 1 1
20 50 0 0 0 90 1 2 1
";

fn read(text: &str) -> Result<Parsed<MotionFile>, ReadError> {
    bva::read(text.as_bytes(), &ReadOptions::default(), &Limits::default())
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < 1e-5
}

#[test]
fn two_segments_by_hand() {
    let file = read(TWO).unwrap();
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    assert!(
        file.warnings[0]
            .what
            .contains("display size of the segment")
    );
    let file = file.value;
    let joints = &file.character.skeleton.joints;
    assert_eq!(joints[1].name, "Left Hand");
    assert!(joints.iter().all(|j| j.parent.is_none() && j.in_skin));
    assert!(near(joints[0].rest.translation, Vec3::Y * 1.016));
    let clip = &file.character.clips[0];
    assert_eq!((clip.duration_secs, file.frame_time_secs), (0.5, 0.5));
    // Only the second segment is scaled.
    let kinds = clip.channels.iter().map(|c| (c.target, c.property));
    use Property::{Rotation, Scale, Translation};
    let wanted = [
        (0, Translation),
        (0, Rotation),
        (1, Translation),
        (1, Rotation),
        (1, Scale),
    ];
    assert!(kinds.eq(wanted));
    let world = world(&file.character, 0.5);
    assert!(near(
        world[0].translation.into(),
        Vec3::new(0.254, 1.016, 0.508)
    ));
    // Z, then X, then Y about rotated axes: Y takes x̂ to -ẑ, then X takes it to ŷ.
    assert!(near(world[0].transform_vector3(Vec3::X), Vec3::Y));
    assert!(near(world[0].transform_vector3(Vec3::Z), Vec3::X));
    // Scale comes last, in the segment's own axes: ŷ is doubled, then rotated to -x̂.
    assert!(near(world[1].transform_vector3(Vec3::Y), Vec3::X * -2.0));
}

#[test]
fn odd_spelling_is_read_alike() {
    let odd = TWO
        .replace('\n', "\r\n\r\n")
        .replace("Segment:", "SEGMENT :")
        .replace("Frame Time:", "Frames Time:")
        .replace("XTRAN YTRAN ZTRAN", "XTran\tYTran ZTran")
        .replace("DEGREES", "Degrees");
    assert_eq!(read(&odd).unwrap().value, read(TWO).unwrap().value);
}

#[test]
fn columns_and_units_are_what_the_file_says() {
    let one = |labels: &str, units: &str, values: &str| {
        let text = format!("Segment: a\nFrames: 1\nFrame Time: .1\n{labels}\n{units}{values}\n");
        let read = read(&text).unwrap();
        let warned = read.warnings.len();
        (world(&read.value.character, 0.0)[0], warned)
    };
    let (placed, warned) = one("ZTRAN XTRAN", "CENTIMETERS MM\n", "100 500");
    assert!(near(placed.translation.into(), Vec3::new(0.5, 0.0, 1.0)) && warned == 0);
    let (turned, _) = one("YROT", "RADIANS\n", "1.5707964");
    assert!(near(turned.transform_vector3(Vec3::X), -Vec3::Z));
    let (scaled, _) = one("XSCALE", "PERCENT\n", "50");
    assert!(near(scaled.transform_vector3(Vec3::X), Vec3::X * 0.5));
    let (bare, warned) = one("XTRAN YROT", "", "100 90");
    assert!(near(bare.translation.into(), Vec3::X * 2.54) && warned == 1);
}

#[test]
fn unit_and_up_axis_can_be_given() {
    let options = ReadOptions {
        scale_to_metres: Some(0.1),
        up: UpAxis::Z,
        ..ReadOptions::default()
    };
    let file = bva::read(TWO.as_bytes(), &options, &Limits::default())
        .unwrap()
        .value;
    let world = world(&file.character, 0.5);
    // z points up and y backwards.
    assert!(near(world[0].translation.into(), Vec3::new(1.0, 2.0, -4.0)));
    // The rotation by 90 degrees about z becomes one about y, whose first axis is the same.
    assert!(near(world[1].transform_vector3(Vec3::X), -Vec3::Z));
    for scale in [0.0, -1.0, f32::NAN] {
        let options = ReadOptions {
            scale_to_metres: Some(scale),
            up: UpAxis::Auto,
            ..ReadOptions::default()
        };
        assert!(bva::read(TWO.as_bytes(), &options, &Limits::default()).is_err());
    }
}

#[test]
fn a_segment_that_ends_early_stays() {
    let text = TWO.replace("10 40 20 90 90 0 5 9 4\n", "");
    let read = read(&text).unwrap();
    assert!(
        read.warnings
            .iter()
            .any(|w| w.what.contains("\"Frames: 2\", but the file has 1"))
    );
    let world = world(&read.value.character, 0.5);
    assert!(near(world[0].translation.into(), Vec3::Y * 1.016));
    let text = TWO.replacen("Frame Time: 0.5", "Frame Time: 0.25", 1);
    let read = self::read(&text).unwrap();
    assert!(
        read.warnings
            .iter()
            .any(|w| w.at == "line 10" && w.what.contains("0.25 s are used"))
    );
    assert_eq!(read.value.character.clips[0].duration_secs, 0.25);
}

#[test]
fn every_fault_names_its_line() {
    let cases = [
        (
            "Segment: Hips",
            "Joint: Hips",
            "line 1: no \"Segment:\" found; is this a BVA file?",
        ),
        (
            "Frames: 2",
            "Count: 2",
            "line 2: \"Count: 2\" found, \"frames:\" expected",
        ),
        (
            "Frame Time: 0.5",
            "Time: 0.5",
            "line 3: \"Time: 0.5\" found, \"frame time:\"",
        ),
        ("Frame Time: 0.5", "Frame Time: 0", "line 3: frame time 0 s"),
        ("XTRAN", "WTRAN", "line 4: channel \"WTRAN\""),
        ("XTRAN", "XTRAN XTRAN", "line 4: 10 channels"),
        ("XTRAN", "éTRAN", "line 4: channel \"éTRAN\""),
        ("INCHES", "CUBITS", "line 5: unit \"CUBITS\" found, INCHES"),
        ("DEGREES", "TURNS", "line 5: unit \"TURNS\" found, DEGREES"),
        ("INCHES", "", "line 5: 8 units found, 9 expected"),
        ("0 40 0", "0 40", "line 6: 8 values found, 9 expected"),
        (
            "Segment: Left",
            "Part: Left",
            "line 8: \"Part: Left Hand\" found, a number or \"Segment:\"",
        ),
    ];
    for (from, to, wanted) in cases {
        let error = read(&TWO.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(wanted), "{to:?}: {error}");
    }
    assert!(
        read("")
            .unwrap_err()
            .to_string()
            .contains("is this a BVA file?")
    );
    assert!(
        read("Segment: a\nFrames: 1\n")
            .unwrap_err()
            .to_string()
            .contains("end of file")
    );
    assert!(read("\u{0}\u{1}glTF").is_err());
}

#[test]
fn counts_are_bounded() {
    let tight = |limits: Limits| bva::read(TWO.as_bytes(), &ReadOptions::default(), &limits);
    let all = Limits::default();
    for limits in [
        Limits { nodes: 1, ..all },
        Limits { frames: 1, ..all },
        Limits {
            elements: 35,
            ..all
        },
        Limits { bytes: 10, ..all },
    ] {
        let error = tight(limits);
        assert!(
            matches!(error, Err(ReadError::LimitExceeded { .. })),
            "{limits:?}"
        );
    }
    assert!(
        tight(Limits {
            nodes: 2,
            frames: 2,
            elements: 36,
            ..all
        })
        .is_ok()
    );
}

#[test]
fn truncated_anywhere_it_gives_a_value_or_an_error() {
    let good = (0..TWO.len()).filter(|&length| read(&TWO[..length]).is_ok());
    let first = TWO.find("XTRAN").unwrap();
    assert!(good.clone().all(|length| length > first));
    assert!(good.count() > 3);
}

/// Returns the world transforms of a BVH file as a BVA file in inches, with every joint as a
/// segment.
fn converted(character: &Character, frame_time_secs: f32, frames: usize) -> String {
    let worlds: Vec<Vec<Affine3A>> = (0..frames)
        .map(|f| world(character, f as f32 * frame_time_secs))
        .collect();
    let mut text = String::new();
    for (index, joint) in character.skeleton.joints.iter().enumerate() {
        let _ = write!(
            text,
            "Segment: {}\nFrames: {frames}\nFrame Time: {frame_time_secs}\n\
             XTRAN YTRAN ZTRAN XROT YROT ZROT XSCALE YSCALE ZSCALE\n\
             INCHES INCHES INCHES DEGREES DEGREES DEGREES RATIO RATIO RATIO\n",
            joint.name
        );
        for world in &worlds {
            let [x, y, z] = (world[index].translation / 0.0254).to_array();
            let (_, turn, _) = world[index].to_scale_rotation_translation();
            let turn: DQuat = turn.as_dquat().normalize();
            let (rz, rx, ry) = turn.to_euler(EulerRot::ZXY);
            let [rx, ry, rz] = [rx, ry, rz].map(f64::to_degrees);
            let _ = writeln!(text, "{x:.6} {y:.6} {z:.6} {rx:.6} {ry:.6} {rz:.6} 1 1 1");
        }
    }
    text
}

/// File, and the number of its segments that keep their position in their parent's space: all but
/// the root where every joint is in the standard; fewer where joints that are not (a finger base,
/// the second half of a thigh) move between two that are.
const MOTIONS: [(&str, usize); 5] = [
    ("bvh/cmu_01_01.bvh", 28),
    ("bvh/dance_fingers.bvh", 93),
    ("bvh/fair1_jumping.bvh", 26),
    ("bvh/pybvh_test1.bvh", 23),
    ("bvh/makehuman_walk1.bvh", 72),
];

#[test]
fn motions_of_bvh_files_come_through() {
    for (name, rigid_wanted) in MOTIONS {
        let Some(bytes) = real::bytes(name) else {
            println!("skipped: no data");
            return;
        };
        let source = bvh::read(&bytes, &ReadOptions::default(), &Limits::default());
        let source = source.unwrap().value;
        let secs = source.frame_time_secs;
        let keys = source.character.clips[0].channels[0].times_secs.len();
        let frames = keys.min(240);
        let text = converted(&source.character, secs, frames);
        let flat = read(&text).unwrap();
        assert!(flat.warnings.is_empty(), "{:?}", flat.warnings);
        let flat = flat.value;
        let tree =
            articula_build::joint_names::segments(&flat.character.skeleton, joint_map::builtin())
                .and_then(|s| bva::tree(&flat, &s))
                .unwrap();
        assert_eq!(tree.warnings.len(), 1, "{name}: {:?}", tree.warnings);
        let tree = tree.value;
        let (mut flat_apart, mut tree_apart) = (0.0f32, 0.0f32);
        for frame in 0..frames {
            let time = frame as f32 * secs;
            let wanted = world(&source.character, time);
            let (flat_world, tree_world) = (world(&flat.character, time), world(&tree, time));
            for (index, joint) in source.character.skeleton.joints.iter().enumerate() {
                let place = wanted[index].translation;
                let twin = tree.skeleton.find(&joint.name).unwrap();
                flat_apart = flat_apart.max(place.distance(flat_world[index].translation));
                tree_apart = tree_apart.max(place.distance(tree_world[twin].translation));
            }
        }
        let moved = tree.clips[0].channels.iter();
        let moved = moved
            .filter(|c| c.property == Property::Translation)
            .count();
        let rigid = tree.skeleton.joints.len() - moved;
        println!(
            "{name}: {:.4} mm side by side, {:.4} mm together, {rigid} rigid",
            flat_apart * 1e3,
            tree_apart * 1e3
        );
        // Six decimals of an inch; six of a degree over a body; movements below 1e-5 of the figure
        // are not keyed, and add up along a chain.
        assert!(flat_apart < 5e-6 && tree_apart < 1e-4, "{name}");
        assert!(rigid >= rigid_wanted, "{name}: {rigid} of {rigid_wanted}");

        // The figure has the rest pose and the articulation of the BVH file.
        let meaning = |c: &Character| {
            articula_build::joint_names::map(&c.skeleton, joint_map::builtin(), None)
        };
        let (ours, theirs) = (meaning(&tree), meaning(&source.character));
        assert!(ours.humanoid);
        for (index, joint) in source.character.skeleton.joints.iter().enumerate() {
            let twin = tree.skeleton.find(&joint.name).unwrap();
            let own = &ours.articulation.joints[twin].hanim;
            assert_eq!(
                *own, theirs.articulation.joints[index].hanim,
                "{name} {}",
                joint.name
            );
            assert_eq!(tree.skeleton.joints[twin].rest.rotation, Quat::IDENTITY);
        }
    }
}

#[test]
fn segments_of_unknown_names_stay_side_by_side() {
    assert_eq!(
        articula_build::joint_names::segments(
            &read(TWO).unwrap().value.character.skeleton,
            joint_map::builtin()
        )
        .and_then(|s| bva::tree(&read(TWO).unwrap().value, &s)),
        None
    );
    let empty = MotionFile::default();
    assert_eq!(
        articula_build::joint_names::segments(&empty.character.skeleton, joint_map::builtin())
            .and_then(|s| bva::tree(&empty, &s)),
        None
    );
}

/// Biovision's own names, upside down at zero rotations: the first frame becomes the rest pose.
#[test]
fn what_does_not_stand_at_zero_rests_in_its_first_frame() {
    let segment = |name: &str, [x, y]: [f32; 2]| {
        format!(
            "Segment: {name}\nFrames: 1\nFrame Time: 0.1\nXTRAN YTRAN ZTRAN ZROT\n\
             INCHES INCHES INCHES DEGREES\n{x} {y} 0 180\n"
        )
    };
    let text: String = [
        ("Head", [0.0, 60.0]),
        ("Hips", [0.0, 35.0]),
        ("Chest", [0.0, 45.0]),
        ("LeftUpLeg", [3.0, 33.0]),
        ("LeftLowLeg", [3.0, 17.0]),
        ("LeftFoot", [3.0, 2.0]),
        ("RightUpLeg", [-3.0, 33.0]),
        ("LeftUpArm", [7.0, 52.0]),
        ("RightUpArm", [-7.0, 52.0]),
        ("RightLowArm", [-7.0, 41.0]),
        ("Hat", [0.0, 66.0]),
    ]
    .into_iter()
    .map(|(name, place)| segment(name, place))
    .collect();
    let file = read(&text).unwrap().value;
    let tree =
        articula_build::joint_names::segments(&file.character.skeleton, joint_map::builtin())
            .and_then(|s| bva::tree(&file, &s))
            .unwrap();
    assert!(
        tree.warnings[0].what.contains("10 of 11 segments")
            && tree.warnings[0].what.contains("biovision")
    );
    assert!(
        tree.warnings[1]
            .what
            .contains("first frame is used as the rest pose")
    );
    let skeleton = &tree.value.skeleton;
    let parent = |name: &str| {
        let joint = &skeleton.joints[skeleton.find(name).unwrap()];
        joint.parent.map(|p| skeleton.joints[p].name.as_str())
    };
    let parents = [
        ("Hips", None),
        ("Chest", Some("Hips")),
        ("Head", Some("Chest")),
        ("Hat", Some("Head")),
        ("LeftUpArm", Some("Chest")),
        ("RightLowArm", Some("RightUpArm")),
        ("LeftUpLeg", Some("Hips")),
        ("LeftFoot", Some("LeftLowLeg")),
    ];
    for (name, wanted) in parents {
        assert_eq!(parent(name), wanted, "{name}");
    }
    let still = Character {
        clips: Vec::new(),
        ..tree.value.clone()
    };
    for (index, place) in world(&still, 0.0).iter().enumerate() {
        let name = &skeleton.joints[index].name;
        let flat = file.character.skeleton.find(name).unwrap();
        let wanted = file.character.skeleton.joints[flat].rest.translation;
        assert!(near(place.translation.into(), wanted), "{name}");
    }
}
