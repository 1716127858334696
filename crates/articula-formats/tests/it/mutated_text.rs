//! Reading any text returns a value or an error.
//!
//! The counterpart on stable Rust of the fuzz targets `acclaim`, `bva`, `bvh`, `profile` and
//! `loa_profile`, `live_link` and `face_points`: seeded mutations of valid files.

use articula_core::source::Character;
use articula_formats::ReadOptions;
use articula_formats::bvh;
use articula_formats::{Limits, acclaim, bva, face_points, joint_map, live_link, loa_profile};
use articula_mutate::{Edit, Mutations};

/// Number of mutations per file.
const TRIES: usize = 3000;

const BVH: &str = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 90 0\n CHANNELS 6 Xposition Yposition Zposition \
    Zrotation Xrotation Yrotation\n JOINT Head\n {\n  OFFSET 0 60 0\n  CHANNELS 3 Zrotation Xrotation \
    Yrotation\n  End Site\n  {\n   OFFSET 0 20 0\n  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: .0333\n\
    0 90 0 1 2 3 4 5 6\n0 91 -1e-3 1 2 3 4 5 -6\n";

const ASF: &str = ":units\n length 0.45\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n \
    position 0 0 0\n orientation 0 5 0\n:bonedata\nbegin\nname hip\ndirection 0 -1 0\nlength 7\naxis 0 0 20 \
    XYZ\ndof rx ry rz\nlimits (-160 20)\n(-inf inf)\n(0 1)\nend\nbegin\nname head\ndirection 1 0 0\nlength 2\n\
    axis 0 0 0 XYZ\ndof tx rz l\nend\n:hierarchy\nbegin\nroot hip\nhip head\nend\n";

const AMC: &str = ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 1 2 3 4 5\nhip 1 2 3\nhead 1 2 3\n2\nhip 4 5 6\n3\n\
    root 1 1 1 1 1 1\nhead 0 90 0\n";

const BVA: &str = "Segment: Hips\nFrames: 2\nFrame Time: 0.1\nXTRAN YTRAN ZTRAN XROT YROT ZROT XSCALE\n\
    INCHES INCHES INCHES DEGREES DEGREES DEGREES INCHES\n0 40 0 0 0 0 1\n1 40 0 9 8 7 1\nSegment: Head\n\
    Frames: 2\nFrame Time: 0.1\nXTRAN YTRAN YROT ZSCALE\nCM MM RADIANS RATIO\n1 2 3 4\n5 6 7 8\n\
    Segment: LeftHip\nFrames: 1\nFrame Time: 0.1\nXTRAN\nCM\n1\nSegment: RightHip\nFrames: 1\nFrame Time: 0.1\n\
    XTRAN\n1\nSegment: LeftUpArm\nFrames: 0\nFrame Time: 0.1\nXTRAN\nCM\nSegment: RightUpArm\nFrames: 1\n\
    Frame Time: 0.1\nYTRAN\nCM\n90\nSegment: Hat\nFrames: 1\nFrame Time: 0.1\nYTRAN\nCM\n99\n";

const PROFILE: &str = r#"{"name": "x", "title": "t", "source": "s", "scope": "body",
    "prefixes": ["rig"], "suffixes": ["_end"], "joints": {"Hips": "humanoid_root",
    "{side}Arm": "{side}_shoulder", "Back": "spine", "wrist": "{hand}_wrist"},
    "helpers": {"hands": ["tip.{side}"]}, "ignored": ["twist"]}"#;

const LOA: &str = r#"{"manual": true, "rule": "sum", "depth": 3, "complexity": "None",
    "zones": ["torso", "legs"], "joints": {"plus": ["l_knee"], "minus": ["tail"]}}"#;

const CAPTURE: &str = "Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen,HeadYaw,Mood\n\
    01:02:03:04.125,61,0.5,0.25,-0.1,x\n01:02:03:05.125,61,0.4,1,0,y\n01:02:04:01.000,61,1e-3,0,0.2,z\n";

const POINTS: &str = r#"{"points": {"2.1": [0.0, 1.48, 0.08], "9.3": [0, 1.54, 0.11]}}"#;

/// Words of the formats, inserted at random.
const WORDS: [&str; 27] = [
    "2.10",
    "23:59:59:59.9",
    ",JawOpen",
    "{",
    "}",
    "ROOT x",
    "JOINT",
    "End Site",
    "OFFSET",
    "CHANNELS 3",
    "MOTION",
    "Frames: 1e9",
    "NaN",
    "-1e39",
    "\"",
    "[",
    "{side}",
    "null",
    "99999999999999999999",
    "begin",
    "end",
    "dof rx ry rz",
    "axis 90 90 90 ZYX",
    "root hip",
    ":DEGREES",
    "\n7\n",
    "\nSegment: Chest\n",
];

const MUTATIONS: Mutations<'_> = Mutations {
    edits: &[
        Edit::Truncate,
        Edit::InsertByte,
        Edit::RepeatTail,
        Edit::Word(&WORDS),
        Edit::Delete(12),
    ],
    most: 4,
};

fn check(good: &str, read: impl FnMut(&[u8]) -> bool) {
    let good_ones = MUTATIONS.read_of(good.as_bytes(), TRIES, read);
    assert!(good_ones < TRIES, "no mutation was noticed");
}

#[test]
fn bvh_files() {
    check(BVH, |bytes| {
        let read = bvh::read(bytes, &ReadOptions::default(), &Limits::default());
        let Ok(read) = read else { return false };
        sound(&read.value.character);
        true
    });
}

/// Checks that a character is a forest of finite joints with ascending key times.
fn sound(character: &Character) {
    for (index, joint) in character.skeleton.joints.iter().enumerate() {
        assert!(joint.parent.is_none_or(|p| p < index));
        assert!(joint.rest.is_finite());
    }
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        assert!(channel.times_secs.windows(2).all(|w| w[0] < w[1]));
        assert!(channel.values.iter().all(|v| v.is_finite()));
    }
    articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
}

#[test]
fn acclaim_pairs() {
    let read = |asf: &[u8], amc: &[u8]| {
        let options = ReadOptions::default();
        let read = acclaim::read(asf, Some(amc), &options, &Limits::default());
        let Ok(read) = read else { return false };
        sound(&read.value.character);
        true
    };
    check(ASF, |bytes| read(bytes, AMC.as_bytes()));
    check(AMC, |bytes| read(ASF.as_bytes(), bytes));
}

#[test]
fn bva_files() {
    let mut trees = 0;
    check(BVA, |bytes| {
        let read = bva::read(bytes, &ReadOptions::default(), &Limits::default());
        let Ok(read) = read else { return false };
        sound(&read.value.character);
        if let Some(tree) = articula_build::joint_names::segments(
            &read.value.character.skeleton,
            joint_map::builtin(),
        )
        .and_then(|s| bva::tree(&read.value, &s))
        {
            trees += 1;
            sound(&tree.value);
        }
        true
    });
    assert!(trees > 30, "{trees}");
}

#[test]
fn profiles() {
    check(PROFILE, |bytes| {
        joint_map::parse(bytes, &Limits::default()).is_ok()
    });
}

#[test]
fn saved_selections() {
    check(LOA, |bytes| {
        loa_profile::read(bytes, &Limits::default()).is_ok()
    });
}

#[test]
fn captures() {
    check(CAPTURE, |bytes| {
        let Ok(read) = live_link::read(bytes, &Limits::default()) else {
            return false;
        };
        let frames = &read.value.frames;
        assert!(frames.windows(2).all(|w| w[0].secs < w[1].secs));
        let finite = |f: &live_link::LiveLinkFrame| {
            f.secs.is_finite() && f.shapes.iter().chain(&f.angles).all(|v| v.is_finite())
        };
        assert!(frames.iter().all(finite));
        live_link::read(&live_link::write(&read.value), &Limits::default()).is_ok()
    });
}

#[test]
fn feature_points() {
    check(POINTS, |bytes| {
        let Ok(points) = face_points::read(bytes, &Limits::default()) else {
            return false;
        };
        assert!(points.iter().all(|(_, place)| place.is_finite()));
        let again = face_points::read(&face_points::write(&points), &Limits::default());
        assert_eq!(again.map(|a| a.len()), Ok(points.len()));
        true
    });
}
