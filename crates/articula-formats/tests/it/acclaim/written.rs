//! Written files reopen with every joint at its position.

use super::{AMC, ASF, plain, world};
use crate::real;
use articula_core::Transform;
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, Skeleton,
};
use articula_formats::acclaim::{self, WriteOptions};
use articula_formats::{Limits, bvh, gltf};
use articula_formats::{MotionFile, ReadOptions, WrittenFile};
use glam::{EulerRot, Quat, Vec3};
use proptest::prelude::*;

const RATE_HZ: f32 = 30.0;
const FRAMES: usize = 4;

fn reopened(written: &WrittenFile) -> MotionFile {
    let options = ReadOptions {
        up: articula_formats::UpAxis::Y,
        ..ReadOptions::default()
    };
    let amc = written.motion.as_deref();
    let read = acclaim::read(&written.bytes, amc, &options, &Limits::default()).unwrap();
    let warned: Vec<&str> = read.warnings.iter().map(|w| w.what.as_str()).collect();
    assert!(
        warned.len() == 1 && warned[0].contains("length 0.45"),
        "{warned:?}"
    );
    read.value
}

/// Returns the maximum distance between joints of the same name, in metres, at the frames of a
/// clip.
fn separation_metres(a: &Character, b: &Character, rate_hz: f32, frames: usize) -> f32 {
    let mut worst = 0.0f32;
    for frame in 0..frames {
        let time_secs = frame as f32 / rate_hz;
        let (places, others) = (world(a, time_secs), world(b, time_secs));
        for (index, joint) in a.skeleton.joints.iter().enumerate() {
            let plain = joint.name.replace(char::is_whitespace, "_");
            if let Some(twin) = b.skeleton.find(&plain) {
                worst = worst.max(places[index].distance(others[twin]));
            } else {
                assert!(!joint.in_skin, "{} is missing", joint.name);
            }
        }
    }
    worst
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    let one = || -size..size;
    (one(), one(), one()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn rotation() -> impl Strategy<Value = Quat> {
    vector(3.2).prop_map(|v| Quat::from_euler(EulerRot::XYZ, v.x, v.y, v.z))
}

#[derive(Debug, Clone)]
struct Made {
    parent: usize,
    rest: Transform,
    in_skin: bool,
    turns: Vec<Quat>,
    moves: Option<Vec<Vec3>>,
}

fn made() -> impl Strategy<Value = Made> {
    let rest = (
        vector(0.4),
        rotation(),
        prop::option::weighted(0.1, 0.5f32..2.0),
    );
    let rest = rest.prop_map(|(translation, rotation, scale)| Transform {
        translation,
        rotation,
        scale: Vec3::splat(scale.unwrap_or(1.0)),
    });
    let moves = prop::collection::vec(vector(0.4), FRAMES);
    (
        any::<usize>(),
        rest,
        prop::bool::weighted(0.8),
        prop::collection::vec(rotation(), FRAMES),
        prop::option::weighted(0.2, moves),
    )
        .prop_map(|(parent, rest, in_skin, turns, moves)| Made {
            parent,
            rest,
            in_skin,
            turns,
            moves,
        })
}

/// Makes any forest: some joints have the position of their parent, some are roots, some are not in
/// a skin.
fn character(made: &[Made]) -> Character {
    let times_secs: Vec<f32> = (0..FRAMES).map(|f| f as f32 / RATE_HZ).collect();
    let mut character = Character::default();
    let mut channels = Vec::new();
    for (target, own) in made.iter().enumerate() {
        character.skeleton.joints.push(Joint {
            name: format!("j{target}"),
            parent: (target > 0 && own.parent % 17 != 0).then(|| own.parent % target.max(1)),
            rest: own.rest,
            in_skin: own.in_skin,
        });
        let mut keyed = |property, values: Vec<f32>| {
            channels.push(Channel {
                target,
                property,
                interpolation: Interpolation::Linear,
                times_secs: times_secs.clone(),
                values,
            });
        };
        let turns = own.turns.iter().flat_map(|q| q.to_array());
        keyed(Property::Rotation, turns.collect());
        if let Some(moves) = &own.moves {
            keyed(
                Property::Translation,
                moves.iter().flat_map(|v| v.to_array()).collect(),
            );
        }
    }
    character.clips.push(RawClip {
        name: "any".to_owned(),
        duration_secs: times_secs[FRAMES - 1],
        channels,
    });
    character
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// The bound: six decimals of an angle and of a translation (6e-8 m), summed over a chain, and
    /// the rounding of f32 in chains of 24 rotations; bodies here are up to 10 m long.
    #[test]
    fn any_forest_reopens(made in prop::collection::vec(made(), 1..24)) {
        let character = character(&made);
        let options = WriteOptions { rate_hz: RATE_HZ, ..WriteOptions::default() };
        let written = acclaim::write(&character, Some(0), &options).unwrap();
        let back = reopened(&written);
        prop_assert_eq!(back.frame_time_secs, RATE_HZ.recip());
        let apart = separation_metres(&character, &back.character, RATE_HZ, FRAMES);
        prop_assert!(apart < 2e-5, "{} m", apart);
        // Written again it does not grow, and positions stay.
        let again = acclaim::write(&back.character, Some(0), &WriteOptions {
            rate_hz: RATE_HZ,
            end_sites: back.end_sites.clone(),
        }).unwrap();
        let twice = reopened(&again);
        let joints = |c: &Character| c.skeleton.joints.len();
        prop_assert_eq!(joints(&twice.character), joints(&back.character));
        let apart = separation_metres(&back.character, &twice.character, RATE_HZ, FRAMES);
        prop_assert!(apart < 2e-5, "{} m", apart);
    }
}

#[test]
fn a_pair_written_again_is_the_same_figure() {
    let first = plain(ASF, Some(AMC)).unwrap().value;
    let options = WriteOptions {
        rate_hz: 2.0,
        end_sites: first.end_sites.clone(),
    };
    let written = acclaim::write(&first.character, Some(0), &options).unwrap();
    assert!(written.left_out.is_empty(), "{:?}", written.left_out);
    let second = reopened(&written);
    assert!(separation_metres(&first.character, &second.character, 2.0, 2) < 1e-5);
    // Same joints in the same order with the same axes, and the same ends.
    for (a, b) in first
        .character
        .skeleton
        .joints
        .iter()
        .zip(&second.character.skeleton.joints)
    {
        assert_eq!((&a.name, a.parent), (&b.name, b.parent));
        assert!(a.rest.rotation.dot(b.rest.rotation).abs() > 1.0 - 1e-6);
    }
    for (a, b) in first.end_sites.iter().zip(&second.end_sites) {
        assert!(a.0 == b.0 && a.1.distance(b.1) < 1e-5);
    }
    // Only the arm moves, so it alone has translations.
    let asf = String::from_utf8(written.bytes).unwrap();
    assert_eq!(asf.matches("dof tx ty tz rx ry rz").count(), 1);
    assert_eq!(
        asf.matches("dof rx ry rz").count(),
        3,
        "also the joint that does not move"
    );
}

#[test]
fn names_that_the_format_cannot_hold_are_replaced() {
    let names = ["Hips (main)", "12", "a b", "a b", "root", "end", "", ":a:x"];
    let joint = |(index, name): (usize, &&str)| Joint {
        name: (*name).to_owned(),
        parent: index.checked_sub(1),
        rest: Transform::from_translation(Vec3::Y * 0.2),
        in_skin: true,
    };
    let character = Character {
        skeleton: Skeleton {
            joints: names.iter().enumerate().map(joint).collect(),
        },
        ..Character::default()
    };
    let written = acclaim::write(&character, None, &WriteOptions::default()).unwrap();
    assert!(written.motion.is_none());
    assert!(
        written.left_out.iter().any(|l| l.starts_with("7 names")),
        "{:?}",
        written.left_out
    );
    let back = reopened(&written).character.skeleton;
    let found: Vec<&str> = back.joints.iter().map(|j| j.name.as_str()).collect();
    // The root is at the origin, so its first child is attached by a connecting bone.
    assert_eq!(found[0], "Hips _main_");
    let wanted = [
        "joint_1", "a_b", "a_b_2", "root_2", "end_2", "joint_6", "_a:x",
    ];
    assert_eq!(found[2..], wanted);
}

#[test]
fn what_does_not_fit_is_said() {
    let mut character = plain(ASF, Some(AMC)).unwrap().value.character;
    character.skeleton.joints[3].rest.scale = Vec3::splat(2.0);
    let site = (3, Vec3::X);
    let options = WriteOptions {
        rate_hz: 2.0,
        end_sites: vec![site],
    };
    let written = acclaim::write(&character, Some(0), &options).unwrap();
    assert_eq!(written.left_out.len(), 2, "{:?}", written.left_out);
    assert!(written.left_out[0].contains("scale") && written.left_out[1].contains("end site"));
    let back = reopened(&written).character;
    assert!(separation_metres(&character, &back, 2.0, 2) < 1e-5);

    let rate = |rate_hz| WriteOptions {
        rate_hz,
        ..WriteOptions::default()
    };
    for (clip, options) in [(1, rate(30.0)), (0, rate(0.0)), (0, rate(f32::NAN))] {
        assert!(acclaim::write(&character, Some(clip), &options).is_err());
    }
    assert!(acclaim::write(&Character::default(), None, &rate(30.0)).is_err());
}

#[test]
fn real_motions_survive() {
    for name in [
        "cmu_01_01",
        "dance_fingers",
        "fair1_jumping",
        "makehuman_walk1",
        "pybvh_test1",
    ] {
        let Some(bytes) = real::bytes(&format!("bvh/{name}.bvh")) else {
            println!("skipped: no data");
            return;
        };
        let read = bvh::read(&bytes, &ReadOptions::default(), &Limits::default());
        let mut file = read.unwrap().value;
        for clip in &mut file.character.clips {
            clip.duration_secs = clip.duration_secs.min(2.0);
        }
        let rate_hz = 1.0 / file.frame_time_secs;
        let frames = (file.character.clips[0].duration_secs * rate_hz) as usize;
        let options = WriteOptions {
            rate_hz,
            end_sites: file.end_sites.clone(),
        };
        let written = acclaim::write(&file.character, Some(0), &options).unwrap();
        let back = reopened(&written);
        let apart = separation_metres(&file.character, &back.character, rate_hz, frames);
        println!("{name}: {:.4} mm", apart * 1000.0);
        assert!(apart < 2e-5, "{name}: {apart} m");
    }
}

/// Characters with rest rotations, scaled armatures, several roots and fingers.
#[test]
fn real_characters_survive() {
    let names = [
        "RobotExpressive",
        "KayKit_Knight",
        "mannequiny",
        "pab_arnaud",
        "Quaternius_cyberpunk_pack__Character",
        "Fox",
    ];
    for name in names {
        let Some(bytes) = real::bytes(&format!("glb/{name}.glb")) else {
            println!("skipped: no data");
            return;
        };
        let mut nothing_beside = |uri: &str| Err(format!("{uri} is not there"));
        let read = gltf::read(&bytes, &Limits::default(), &mut nothing_beside);
        let mut character = read.unwrap().value.character;
        character.clips.truncate(1);
        let clip = &mut character.clips[0];
        clip.duration_secs = clip.duration_secs.min(1.0);
        let frames = (clip.duration_secs * RATE_HZ) as usize;
        let options = WriteOptions {
            rate_hz: RATE_HZ,
            ..WriteOptions::default()
        };
        let written = acclaim::write(&character, Some(0), &options).unwrap();
        let back = reopened(&written);
        let apart = separation_metres(&character, &back.character, RATE_HZ, frames);
        println!("{name}: {:.4} mm, {:?}", apart * 1000.0, written.left_out);
        // A position that moves by less than 1e-5 of the figure has no key; that adds up along a
        // chain.
        assert!(apart < 1e-4, "{name}: {apart} m");
    }
}
