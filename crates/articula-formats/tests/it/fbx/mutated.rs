//! Seeded mutations of small files on stable Rust: for any bytes, reading returns a sound character or an error.

use super::tiny::{ascii, binary, figure};
use crate::real;
use articula_core::source::Character;
use articula_formats::{Limits, ReadOptions, fbx, joint_map};
use articula_mutate::{Edit, Mutations, cut_off};
use std::time::Instant;

/// Number of mutants of each file.
const TRIES: usize = 600;

const WORDS: &[&str] = &[
    "-1",
    "0",
    "1e39",
    "9223372036854775807",
    "nan",
    "*3 { a: 1,2,3 }",
    "{",
    "}",
    "\"",
    "C: \"OO\",3,0",
    "Model: 9, \"Model::X\", \"LimbNode\" {}",
    "Properties70: {",
    "P: \"Lcl Scaling\", \"\", \"\", \"\",0",
];

const TEXT: Mutations<'_> = Mutations {
    edits: &[
        Edit::Truncate,
        Edit::InsertByte,
        Edit::Word(WORDS),
        Edit::Delete(12),
        Edit::Number(WORDS),
        Edit::NumberBelow(40),
        Edit::NumberBelow(40),
    ],
    most: 3,
};

const BINARY: Mutations<'_> = Mutations {
    edits: &[
        Edit::FlipBit,
        Edit::FlipBit,
        Edit::SetByte,
        Edit::SetOf(&[0, 1, 255, b'C', b'S', b'L']),
    ],
    most: 3,
};

fn survives(bytes: &[u8], limits: &Limits) -> bool {
    let mut picture = |_: &str| Ok(vec![0x89, b'P', b'N', b'G']);
    let read = fbx::read(bytes, "a", &ReadOptions::default(), limits, &mut picture);
    let Ok(read) = read else { return false };
    sound(&read.value.character);
    true
}

/// Checks what readers promise of a character.
fn sound(character: &Character) {
    let joints = &character.skeleton.joints;
    assert!(!joints.is_empty());
    for (index, joint) in joints.iter().enumerate() {
        assert!(joint.parent.is_none_or(|p| p < index));
        assert!(joint.rest.is_finite());
    }
    for clip in &character.clips {
        assert!(clip.duration_secs >= 0.0 && clip.duration_secs.is_finite());
        for channel in &clip.channels {
            assert!(channel.times_secs.windows(2).all(|w| w[0] < w[1]));
            assert!(
                channel
                    .times_secs
                    .last()
                    .is_some_and(|t| *t <= clip.duration_secs)
            );
            assert!(channel.values.iter().all(|v| v.is_finite()));
        }
    }
    articula_core::Mesh::new(&character.meshes, joints.len()).unwrap();
    articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
}

#[test]
fn mutants_of_small_files() {
    let limits = Limits {
        bytes: 1 << 26,
        elements: 1 << 20,
        nodes: 1 << 12,
        frames: 1 << 10,
        ..Limits::default()
    };
    let files = [
        (binary(7400, &figure()), BINARY),
        (binary(7700, &figure()), BINARY),
        (ascii(&figure()), TEXT),
    ];
    for (good, mutations) in files {
        let reads = mutations.read_of(&good, TRIES, |bytes| survives(bytes, &limits));
        assert!(
            (TRIES / 20..TRIES).contains(&reads),
            "{reads} mutants were read"
        );
    }
    for good in [binary(7400, &figure()), ascii(&figure())] {
        for bytes in cut_off(&good).step_by(37) {
            survives(bytes, &limits);
        }
    }
}

/// Small files of the real ones, and all.
const SMALL: [&str; 3] = [
    "max_transformed_skin_7500_binary",
    "maya_blend_inbetween_7500_binary",
    "motionbuilder_sausage_rrss_7700_ascii",
];
const LARGE: [&str; 5] = [
    "blender_279_sausage_7400_binary",
    "maya_anim_layers_over_acc_orders_7500_binary",
    "pab_run",
    "q_robot",
    "rocketbox_m01",
];

/// A few mutants of the real files under the usual limits; with `ARTICULA_FBX_MUTANTS`, so many of each, which
/// says what the slowest took.
#[test]
#[allow(clippy::disallowed_methods, reason = "the test is about time")]
fn mutants_of_real_files() {
    let Some(folder) = real::fbx_folder() else {
        return;
    };
    let told = std::env::var("ARTICULA_FBX_MUTANTS").ok();
    let tries = told.as_ref().map_or(3, |n| n.parse().unwrap());
    let large = LARGE.iter().filter(|_| told.is_some());
    for name in SMALL.iter().chain(large) {
        let good = std::fs::read(folder.join(format!("{name}.fbx"))).unwrap();
        let mutations = if name.ends_with("ascii") {
            TEXT
        } else {
            BINARY
        };
        let mut slowest = 0.0_f32;
        let reads = mutations.read_of(&good, tries, |bytes| {
            let start = Instant::now();
            let survives = survives(bytes, &Limits::default());
            slowest = slowest.max(start.elapsed().as_secs_f32());
            survives
        });
        println!("{name}: {reads} of {tries} read, slowest {slowest} s");
    }
}
