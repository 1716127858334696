//! Written files read back: joints and skinned corners within a bound at every time.

use super::compare::{corners, extent, farthest, globals};
use crate::real;
use articula_core::Articulation;
use articula_core::hanim_table;
use articula_core::source::Character;
use articula_formats::WriteError;
use articula_formats::x3d::{self, X3dFile};
use articula_formats::{Limits, gltf, joint_map};
use articula_human::{HumanOptions, human};
use glam::DVec3;
use std::sync::OnceLock;

/// Maximum error after writing and reading, as a fraction of the figure. Numbers round-trip
/// exactly; what remains is rounding of rotations (3e-8 each) along a chain of joints, in 32 bits,
/// and of the matrices that bring vertices to rest.
const BOUND: f64 = 5e-6;

/// The reference human with the fewest triangles, created once.
fn small_human() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| human(&HumanOptions::mannequin(2000)).unwrap())
}

/// Writes and reads a character; also returns whether the rest pose is that of the source.
fn written(character: &Character) -> (X3dFile, bool) {
    let mapping = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
    let written = x3d::write(character, &mapping.articulation, &[]).unwrap();
    let mut alone = |name: &str| Err(format!("{name}: nothing lies here"));
    let read = x3d::read(&written.bytes, &Limits::default(), &mut alone).unwrap();
    assert_eq!(read.warnings, []);
    // If the skin was bound in a pose other than rest, that pose becomes the figure's zero pose.
    let at_rest = written
        .left_out
        .iter()
        .all(|w| !w.contains("the bind pose"));
    (read.value, at_rest)
}

/// Returns the written joint for each joint read. Joints that never move are left out; the others
/// come depth first.
fn sources(character: &Character, back: &Character) -> Vec<usize> {
    let mapping = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
    let own = |joint: usize| {
        let hanim = mapping.articulation.joints[joint].hanim.as_deref();
        hanim.map_or(character.skeleton.joints[joint].name.clone(), |name| {
            let found = hanim_table::find(name);
            found
                .map_or(name, |i| hanim_table::JOINTS[i].name_v2)
                .to_owned()
        })
    };
    let names: Vec<String> = (0..character.skeleton.joints.len()).map(own).collect();
    let of = |name: &str| names.iter().position(|own| own == name);
    let joints = back.skeleton.joints.iter();
    joints
        .map(|j| of(&j.name).unwrap_or_else(|| panic!("{} is no joint of the source", j.name)))
        .collect()
}

/// Returns the maximum distance of joints and corners over all clips, as a fraction of the figure.
/// Joints are compared at five times of each clip, corners, of which there are many more, at two of
/// them, which differ from clip to clip.
fn worst(character: &Character, back: &Character, at_rest: bool) -> f64 {
    let sources = sources(character, back);
    let meshes: Vec<(usize, usize)> = (0..character.meshes.len())
        .map(|mesh| (mesh, twin(character, mesh, back)))
        .collect();
    let mut figure: Vec<DVec3> = globals(character, None, 0.0)
        .iter()
        .map(|g| g.translation)
        .collect();
    figure.extend((0..character.meshes.len()).flat_map(|m| corners(character, m, None, 0.0)));
    let size = extent(&figure);
    let mut worst: f64 = 0.0;
    let rest = at_rest.then_some(None);
    let clips = character.clips.iter().map(Some).chain(rest);
    for (index, clip) in clips.enumerate() {
        let other = clip.map(|_| &back.clips[index]);
        if let (Some(clip), Some(other)) = (clip, other) {
            assert!((clip.duration_secs - other.duration_secs).abs() < 1e-6);
        }
        let end = clip.map_or(0.0, |c| c.duration_secs);
        let steps = if clip.is_some() { 5 } else { 1 };
        for step in 0..steps {
            let time = end * step as f32 / 4.0;
            let places = |c: &Character, clip| -> Vec<DVec3> {
                globals(c, clip, time)
                    .iter()
                    .map(|g| g.translation)
                    .collect()
            };
            let (all, found) = (places(character, clip), places(back, other));
            let wanted: Vec<DVec3> = sources.iter().map(|&j| all[j]).collect();
            worst = worst.max(farthest(&wanted, &found) / size);
            let has_corners = clip.is_none() || [1, 3].contains(&((step + 5 - index % 5) % 5));
            for &(mesh, twin) in meshes.iter().filter(|_| has_corners) {
                let wanted = corners(character, mesh, clip, time);
                let found = corners(back, twin, other, time);
                worst = worst.max(farthest(&wanted, &found) / size);
            }
        }
    }
    worst
}

/// Returns the mesh of the same name among those read.
fn twin(character: &Character, mesh: usize, back: &Character) -> usize {
    let name = &character.meshes[mesh].name;
    let plain = |s: &str| s.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let found = back
        .meshes
        .iter()
        .position(|m| plain(&m.name) == plain(name));
    found.unwrap_or_else(|| panic!("mesh {name} is not there"))
}

#[test]
fn the_reference_human_reads_again() {
    let character = small_human();
    let (back, at_rest) = written(character);
    let back = back.character;
    assert!(at_rest);
    assert_eq!(back.clips.len(), character.clips.len());
    let names = |c: &Character| -> Vec<String> { c.clips.iter().map(|c| c.name.clone()).collect() };
    assert_eq!(names(&back), names(character));
    let worst = worst(character, &back, at_rest);
    println!("reference human: {worst:.1e} of the figure");
    assert!(worst < BOUND, "{worst}");
    // Required by the standard.
    assert!(
        back.skeleton
            .joints
            .iter()
            .all(|j| j.rest.rotation == glam::Quat::IDENTITY)
    );
}

#[test]
fn real_characters_read_again() {
    for (name, worst_expected) in [
        ("glb/pab_arnaud.glb", BOUND),
        ("glb/RiggedFigure.glb", BOUND),
        ("glb/CesiumMan.glb", BOUND),
        ("glb/AnimatedMorphCube.glb", BOUND),
        ("glb/KayKit_Knight.glb", BOUND),
        ("glb/RobotExpressive.glb", BOUND),
        ("glb/mh_female_dance.glb", BOUND),
        // Bound in a pose other than rest, below an armature of scale 100.
        ("glb/Quaternius_cyberpunk_pack__Character.glb", BOUND),
        (
            "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
            BOUND,
        ),
        ("glb/Fox.glb", BOUND),
    ] {
        let Some(bytes) = real::bytes(name) else {
            println!("skipped: no data ({name})");
            continue;
        };
        let mut alone = |_: &str| Err("nothing lies here".to_owned());
        let read = gltf::read(&bytes, &Limits::default(), &mut alone).unwrap();
        let character = read.value.character;
        let (back, at_rest) = written(&character);
        let worst = worst(&character, &back.character, at_rest);
        println!("{name}: {worst:.1e} of the figure");
        assert!(worst < worst_expected, "{name}: {worst}");
    }
}

#[test]
fn what_cannot_be_written_is_refused() {
    let none = Character::default();
    let unmapped = Articulation::default();
    let refused = |c: &Character, a: &Articulation| x3d::write(c, a, &[]).unwrap_err();
    assert_eq!(refused(&none, &unmapped), WriteError::NoJoint);
    let other = refused(small_human(), &unmapped);
    assert!(other.to_string().contains("has 0 joints"), "{other}");
}
