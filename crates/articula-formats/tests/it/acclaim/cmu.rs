//! CMU 01/01 as ASF/AMC and as BVH: the same motion through two readers that share only the
//! quaternions.
//!
//! The BVH file was converted by others. Its first frame is a T-pose that they inserted before the
//! motion, so its frame `n + 1` is frame `n` of the AMC file. Three bones have no length in it:
//! `thorax` (2.06488 units), `lwrist` (1.74178) and `rwrist` (1.72209). So in the BVH file
//! everything above `thorax` is 116.6 mm too low along the thorax, and the hands are shorter by
//! 98.3 and 97.2 mm. With these offsets restored, all joints agree.

use super::world;
use crate::real;
use articula_core::source::Character;
use articula_formats::ReadOptions;
use articula_formats::acclaim;
use articula_formats::bvh;
use articula_formats::{Limits, joint_map};
use glam::Vec3;

/// Corresponding joints of the ASF file and of the BVH file.
const TWINS: [(&str, &str); 31] = [
    ("root", "Hips"),
    ("lhipjoint", "LHipJoint"),
    ("lfemur", "LeftUpLeg"),
    ("ltibia", "LeftLeg"),
    ("lfoot", "LeftFoot"),
    ("ltoes", "LeftToeBase"),
    ("rhipjoint", "RHipJoint"),
    ("rfemur", "RightUpLeg"),
    ("rtibia", "RightLeg"),
    ("rfoot", "RightFoot"),
    ("rtoes", "RightToeBase"),
    ("lowerback", "LowerBack"),
    ("upperback", "Spine"),
    ("thorax", "Spine1"),
    ("lowerneck", "Neck"),
    ("upperneck", "Neck1"),
    ("head", "Head"),
    ("lclavicle", "LeftShoulder"),
    ("lhumerus", "LeftArm"),
    ("lradius", "LeftForeArm"),
    ("lwrist", "LeftHand"),
    ("lhand", "LeftFingerBase"),
    ("lfingers", "LFingers"),
    ("lthumb", "LThumb"),
    ("rclavicle", "RightShoulder"),
    ("rhumerus", "RightArm"),
    ("rradius", "RightForeArm"),
    ("rwrist", "RightHand"),
    ("rhand", "RightFingerBase"),
    ("rfingers", "RFingers"),
    ("rthumb", "RThumb"),
];

/// Pairs before this index agree in the files as they are.
const SOUND: usize = 14;

/// Joints of the BVH file that lack the length of a bone, and that bone: direction times length,
/// from the ASF file.
const LOST: [(&str, [f32; 3], f32); 7] = [
    ("Neck", THORAX, 2.06488),
    ("LeftShoulder", THORAX, 2.06488),
    ("RightShoulder", THORAX, 2.06488),
    ("LeftFingerBase", [1.0, 0.0, 0.0], 1.74178),
    ("LThumb", [1.0, 0.0, 0.0], 1.74178),
    ("RightFingerBase", [-1.0, 0.0, 0.0], 1.72209),
    ("RThumb", [-1.0, 0.0, 0.0], 1.72209),
];

const THORAX: [f32; 3] = [0.019782, 0.999531, 0.0233827];

const FRAMES: usize = 2751;

fn acclaim() -> Option<Character> {
    let (asf, amc) = (
        real::bytes("bvh/cmu_01.asf")?,
        real::bytes("bvh/cmu_01_01.amc")?,
    );
    let read = acclaim::read(
        &asf,
        Some(&amc),
        &ReadOptions::default(),
        &Limits::default(),
    );
    let read = read.unwrap();
    let warned: Vec<&str> = read.warnings.iter().map(|w| w.what.as_str()).collect();
    assert_eq!(warned.len(), 2, "{warned:?}");
    assert!(warned[0].contains("120 frames per second") && warned[1].contains("length 0.45"));
    assert_eq!(read.value.frame_time_secs, 1.0 / 120.0);
    // Toes, head, fingers and thumbs.
    assert_eq!(read.value.end_sites.len(), 7);
    Some(read.value.character)
}

fn biovision(lost_lengths_back: bool) -> Option<Character> {
    let bytes = real::bytes("bvh/cmu_01_01.bvh")?;
    let mut text = String::from_utf8(bytes).unwrap();
    for (name, direction, length) in LOST.iter().filter(|_| lost_lengths_back) {
        let joint = text.find(&format!("JOINT {name}\n")).unwrap();
        let offset = joint + text[joint..].find("OFFSET 0 0 0").unwrap();
        let [x, y, z] = direction.map(|d| d * length);
        let found = "OFFSET 0 0 0".len();
        text.replace_range(offset..offset + found, &format!("OFFSET {x} {y} {z}"));
    }
    let read = bvh::read(text.as_bytes(), &ReadOptions::default(), &Limits::default());
    Some(read.unwrap().value.character)
}

/// Returns the maximum distance of each pair over all frames, in millimetres.
fn apart_mm(ours: &Character, theirs: &Character) -> Vec<f32> {
    let joint = |c: &Character, name: &str| c.skeleton.find(name).unwrap();
    let twins = TWINS.map(|(a, b)| (joint(ours, a), joint(theirs, b)));
    let mut worst = vec![0.0f32; TWINS.len()];
    let times = |c: &Character| c.clips[0].channels[0].times_secs.clone();
    let (times, other_times) = (times(ours), times(theirs));
    assert_eq!((times.len(), other_times.len()), (FRAMES, FRAMES + 1));
    for frame in 0..FRAMES {
        let (a, b) = (
            world(ours, times[frame]),
            world(theirs, other_times[frame + 1]),
        );
        for (worst, (x, y)) in worst.iter_mut().zip(&twins) {
            *worst = worst.max(1000.0 * a[*x].distance(b[*y]));
        }
    }
    worst
}

#[test]
fn cmu_01_01_is_the_same_in_both_formats() {
    let (Some(ours), Some(theirs), Some(mended)) = (acclaim(), biovision(false), biovision(true))
    else {
        println!("skipped: no data");
        return;
    };
    let (plain, mended) = (apart_mm(&ours, &theirs), apart_mm(&ours, &mended));
    for ((twins, plain), mended) in TWINS.iter().zip(&plain).zip(&mended) {
        println!(
            "{:>10} {:<16} {plain:9.4} mm {mended:9.4} mm",
            twins.0, twins.1
        );
    }
    let worst = |list: &[f32]| list.iter().copied().fold(0.0, f32::max);
    let (sound, all) = (worst(&plain[..SOUND]), worst(&mended));
    println!("worst: {sound:.4} mm as the files are, up to the thorax; {all:.4} mm of all joints");
    assert!(sound < 1.0 && all < 1.0);
    // The others differ by the lost lengths and nothing else.
    let unit_mm = 25.4 / 0.45;
    for ((_, theirs), plain) in TWINS.iter().zip(&plain).skip(SOUND) {
        let side = if theirs.starts_with('L') {
            1.74178
        } else {
            1.72209
        };
        let hand = if theirs.contains("Finger") || theirs.contains("Thumb") {
            side
        } else {
            0.0
        };
        let (least, most) = ((2.06488 - hand) * unit_mm, (2.06488 + hand) * unit_mm);
        assert!(
            (least - 0.1..most + 0.1).contains(plain),
            "{theirs}: {plain} mm"
        );
    }
}

#[test]
fn bones_are_named_after_the_joint_at_their_start() {
    let (Some(ours), Some(theirs)) = (acclaim(), biovision(false)) else {
        println!("skipped: no data");
        return;
    };
    let meaning = |c: &Character| {
        let mapping = articula_build::joint_names::map(&c.skeleton, joint_map::builtin(), None);
        assert!(mapping.humanoid && mapping.crossed.is_empty());
        mapping
    };
    let (a, b) = (meaning(&ours), meaning(&theirs));
    assert_eq!(a.articulation.profile, "cmu-asf");
    for (own, other) in TWINS {
        let hanim = |c: &Character, m: &articula_build::joint_names::JointMapping, name: &str| {
            let joint = c.skeleton.find(name).unwrap();
            m.articulation.joints[joint].hanim.clone()
        };
        let (own_meaning, other_meaning) = (hanim(&ours, &a, own), hanim(&theirs, &b, other));
        assert_eq!(own_meaning, other_meaning, "{own} {other}");
    }
    // Left is on the left, and the figure is upright.
    let rest = super::at_rest(&ours);
    let place = |name: &str| rest[ours.skeleton.find(name).unwrap()];
    assert!(place("lfemur").x > place("rfemur").x && place("head").y > place("ltoes").y + 1.0);
    assert!(
        (place("ltoes") - place("lfoot")).dot(Vec3::Z) > 0.0,
        "facing +Z"
    );
}
