//! X3D files as read and written, checked by X_ITE, an X3D player: positions of joints and skin,
//! and whether every node, field and route belongs to the standard.

use crate::judges::{ask, judges_are_here};
use crate::program;
use crate::real::{data_folder, data_is_here, file};
use articula::core::LocalPose;
use articula::core::source::{Character, Property, RawClip, RawMesh, evaluate};
use articula::formats::{Limits, gltf, x3d};
use glam::{Affine3A, Mat4, Vec3};
use serde_json::Value;
use std::path::Path;

/// Maximum distance of a joint or point from that of X_ITE, as a fraction of the figure's height.
/// Both use slerp between keys; X_ITE computes in 64 bits, Articula in 32, along chains of up to
/// 15 joints.
const TOLERANCE: f32 = 1e-5;

/// Output of X_ITE for a file.
struct Judged {
    joints: Vec<String>,
    /// Joints and skin points of each time.
    frames: Vec<(Vec<Vec3>, Vec<Vec3>)>,
}

fn judged(path: &Path, clip: &str, times: &[f32]) -> Judged {
    let mut words = vec![program::word(path).to_owned(), clip.to_owned()];
    words.extend(times.iter().map(ToString::to_string));
    let (answer, good) = ask("x_ite.mjs", &words);
    assert!(good, "{answer}");
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["complaints"], Value::Array(Vec::new()), "{path:?}");
    let points = |list: &Value| -> Vec<Vec3> {
        let axis = |p: &Value, i: usize| p[i].as_f64().unwrap() as f32;
        let list = list.as_array().unwrap().iter();
        list.map(|p| Vec3::new(axis(p, 0), axis(p, 1), axis(p, 2)))
            .collect()
    };
    let frames = answer["frames"].as_array().unwrap().iter();
    let names = answer["joints"].as_array().unwrap().iter();
    Judged {
        joints: names.map(|n| n.as_str().unwrap().to_owned()).collect(),
        frames: frames
            .map(|f| (points(&f["positions"]), points(&f["skin"])))
            .collect(),
    }
}

/// Model matrices of all joints at a time.
fn globals(character: &Character, clip: &RawClip, time_secs: f32) -> Vec<Affine3A> {
    let joints = &character.skeleton.joints;
    let mut pose = LocalPose {
        translations: joints.iter().map(|j| j.rest.translation).collect(),
        rotations: joints.iter().map(|j| j.rest.rotation).collect(),
        scales: joints.iter().map(|j| j.rest.scale).collect(),
    };
    evaluate::pose(clip, &character.skeleton, time_secs, &mut pose);
    let mut all: Vec<Affine3A> = Vec::new();
    for (index, joint) in joints.iter().enumerate() {
        let local = Affine3A::from_scale_rotation_translation(
            pose.scales[index],
            pose.rotations[index],
            pose.translations[index],
        );
        all.push(joint.parent.map_or(local, |p| all[p] * local));
    }
    all
}

/// The vertices of the meshes that follow several joints, in order.
fn skin(character: &Character, clip: &RawClip, time_secs: f32) -> Vec<Vec3> {
    let globals = globals(character, clip, time_secs);
    let mut points = Vec::new();
    for (index, mesh) in character.meshes.iter().enumerate() {
        let mut weights = mesh.morph_weights.clone();
        for channel in &clip.channels {
            if channel.property == Property::Weights && channel.target == index {
                evaluate::channel(channel, time_secs, &mut weights);
            }
        }
        if follows_many(mesh) {
            add_skinned(mesh, &globals, &weights, &mut points);
        }
    }
    points
}

fn follows_many(mesh: &RawMesh) -> bool {
    let primitives = mesh.primitives.iter();
    let used = primitives.flat_map(|p| p.joints.iter().zip(&p.weights));
    let mut used = used.filter(|(_, w)| **w > 0.0).map(|(joint, _)| joint);
    let first = used.next();
    used.any(|joint| Some(joint) != first)
}

fn add_skinned(mesh: &RawMesh, globals: &[Affine3A], morphs: &[f32], points: &mut Vec<Vec3>) {
    let binds = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
    let palette: Vec<Mat4> = binds
        .map(|(j, bind)| Mat4::from(globals[*j] * *bind))
        .collect();
    for primitive in &mesh.primitives {
        for (vertex, position) in primitive.positions.iter().enumerate() {
            let mut at = *position;
            for (morph, weight) in primitive.morphs.iter().zip(morphs) {
                at += morph.positions[vertex] * *weight;
            }
            let range = vertex * primitive.influences..(vertex + 1) * primitive.influences;
            let pairs = primitive.joints[range.clone()]
                .iter()
                .zip(&primitive.weights[range]);
            points.push(
                pairs
                    .map(|(j, w)| palette[usize::from(*j)].transform_point3(at) * *w)
                    .sum(),
            );
        }
    }
}

fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len(), "as many points on both sides");
    let distances = a.iter().zip(b).map(|(a, b)| a.distance(*b));
    distances.fold(0.0, f32::max)
}

fn extent(points: &[Vec3]) -> f32 {
    let low = points.iter().fold(Vec3::MAX, |l, p| l.min(*p));
    let high = points.iter().fold(Vec3::MIN, |h, p| h.max(*p));
    (high - low).length()
}

#[test]
fn frames_of_a_motion_are_where_x_ite_shows_them() {
    if !judges_are_here() || !data_is_here() {
        return;
    }
    let path = data_folder().join("hanim/HAnimMotion.x3d");
    let bytes = std::fs::read(&path).unwrap();
    let mut alone = |_: &str| Err("no picture is needed".to_owned());
    let file = x3d::read(&bytes, &Limits::default(), &mut alone)
        .unwrap()
        .value;
    let clip = &file.character.clips[0];
    let times = [0.0, 0.1, 7.3, 20.0, 39.1];
    let judged = judged(&path, &clip.name, &times);
    let names = file
        .character
        .skeleton
        .joints
        .iter()
        .map(|j| j.name.clone());
    assert!(judged.joints.iter().cloned().eq(names));
    for (time, (wanted, _)) in times.iter().zip(&judged.frames) {
        let found = globals(&file.character, clip, *time);
        let found: Vec<Vec3> = found.iter().map(|g| g.translation.into()).collect();
        let apart = farthest(&found, wanted) / extent(wanted);
        println!("HAnimMotion.x3d at {time} s: {apart:.1e} of the figure");
        assert!(apart < TOLERANCE, "at {time} s: {apart}");
    }
}

#[test]
fn what_is_written_moves_in_x_ite_as_in_the_source() {
    if !judges_are_here() {
        return;
    }
    let folder = program::folder("x3d-oracle");
    check(&folder, program::small(), "walk", &[]);
    for (name, clip) in [
        ("glb/pab_arnaud.glb", "walk"),
        ("glb/RiggedFigure.glb", ""),
        // Bound in another pose than that of rest, below an armature of scale 100.
        (
            "glb/Quaternius_cyberpunk_pack__Character.glb",
            "CharacterArmature|Run",
        ),
    ] {
        let alone: &[&str] = if clip.is_empty() {
            &[]
        } else {
            &["--clip", clip]
        };
        if let Some(path) = file(name) {
            check(&folder, &path, clip, alone);
        }
    }
}

/// Writes a character as X3D and compares the output of X_ITE with the source. `more` may name the
/// only clip to write, since X_ITE is slow with those that it does not play.
fn check(folder: &Path, source: &Path, clip: &str, more: &[&str]) {
    let stem = source.file_stem().unwrap().to_str().unwrap();
    let out = folder.join(format!("{stem}.x3d"));
    let words = ["convert", program::word(source), program::word(&out)];
    program::json(folder, &[&words, more].concat());
    let bytes = std::fs::read(source).unwrap();
    let mut alone = |_: &str| Err("nothing beside it is needed".to_owned());
    let character = gltf::read(&bytes, &Limits::default(), &mut alone).unwrap();
    let character = character.value.character;
    let named = |c: &&RawClip| clip.is_empty() || c.name == clip;
    let clip = character.clips.iter().find(named).unwrap();
    let end = clip.duration_secs;
    let times = [0.0, 0.31 * end, 0.77 * end];
    let def: String = clip
        .name
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || c == '.' {
                c
            } else {
                '_'
            }
        })
        .collect();
    let judged = judged(&out, if def.is_empty() { "clip" } else { &def }, &times);
    assert!(!judged.joints.is_empty());
    for (time, (positions, points)) in times.iter().zip(&judged.frames) {
        let wanted = skin(&character, clip, *time);
        let apart = farthest(points, &wanted) / extent(positions);
        println!(
            "{stem} at {time} s: {} points, {apart:.1e} of the figure",
            points.len()
        );
        assert!(apart < TOLERANCE, "{stem} at {time} s: {apart}");
        // Joints too: each is at the position of some joint of the source.
        let joints = globals(&character, clip, *time);
        for (name, position) in judged.joints.iter().zip(positions) {
            let near = joints
                .iter()
                .map(|j| Vec3::from(j.translation).distance(*position));
            let near = near.fold(f32::MAX, f32::min) / extent(positions);
            assert!(near < TOLERANCE, "{stem} at {time} s: {name} is {near} off");
        }
    }
}
