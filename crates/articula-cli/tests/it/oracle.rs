//! Evaluation and written files, checked by other programs: three.js for the positions of joints,
//! the Khronos validator for the files. Both run in node, from the folder `oracle`.

use crate::judges::{ask, judges_are_here};
use crate::program;
use crate::real::{self, data_folder, data_is_here};
use articula::build::ClipOptions;
use articula::build::character;
use articula::core::source::{self, evaluate};
use articula::core::{Clip, JointSet, LocalPose, ModelPose, Rig, Wrap, local_to_model, sample};
use articula::formats::gltf::{self, Document, GltfFile};
use articula::formats::{Limits, joint_map};
use glam::Vec3;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Maximum distance of a joint from that of three.js, as a fraction of the figure's height.
const TOLERANCE: f32 = 1e-4;

/// Between two keys a runtime clip uses nlerp where three.js uses slerp. Over a rotation of
/// 0.6 rad between keys, faster than any joint here, the two differ by at most
/// `0.004 * 0.6^3 = 0.9` milliradians; along a chain of a third of the height: 3e-4.
const TOLERANCE_BETWEEN_FRAMES: f32 = 3e-4;

/// Fraction of a frame at which nlerp and slerp differ most; at the middle they agree.
const WORST_PART: f32 = 0.211;

/// Files with different features, and the clip to play; none for the rest pose.
const CHARACTERS: &[(&str, Option<&str>)] = &[
    // Raw capture: every joint keyed in translation, rotation and scale; mirrored joints.
    ("glb/pab_arnaud.glb", Some("walk")),
    // Nodes and clip without names: an empty name is the first clip.
    ("glb/CesiumMan.glb", Some("")),
    // Props attached rigidly to joints, several skinned meshes.
    ("glb/KayKit_Knight.glb", Some("Running_A")),
    // Four skins on one skeleton below an armature of scale 100.
    (
        "glb/Quaternius_cyberpunk_pack__Character.glb",
        Some("CharacterArmature|Run"),
    ),
    // Rigid parts, joints that belong to no skin.
    ("glb/RobotExpressive.glb", Some("Robot_Dance")),
    ("glb/mannequiny.glb", Some("run_root.001")),
    // 163 joints with fingers, toes and face.
    ("glb/mh_female_dance.glb", Some("dance")),
    // No clip at all.
    ("vrm/Godette_vrm_v4.vrm", None),
];

/// One character as read, and the file for three.js.
struct Subject {
    path: PathBuf,
    file: GltfFile,
    rig: Rig,
    /// Index of the clip in the file.
    clip: Option<usize>,
}

impl Subject {
    fn new(name: &str, clip: Option<&str>) -> Option<Self> {
        let path = real::file(name)?;
        let file = open(name);
        let skeleton = &file.character.skeleton;
        let mapping = articula::build::joint_names::map(skeleton, joint_map::builtin(), None);
        let rig = Rig::new(skeleton, mapping.articulation).unwrap();
        let clip = clip.map(|wanted| {
            let known = &file.character.clips;
            let named = |c: &source::RawClip| wanted.is_empty() || c.name == wanted;
            let found = known.iter().position(named);
            found.unwrap_or_else(|| panic!("{name} has no clip {wanted}"))
        });
        Some(Self {
            path,
            file,
            rig,
            clip,
        })
    }

    fn source_clip(&self) -> Option<&source::RawClip> {
        self.clip.map(|c| &self.file.character.clips[c])
    }

    /// Positions of every joint in three.js, for each time.
    fn judged(&self, times: &[f32]) -> Vec<Vec<Vec3>> {
        let mut words = vec![self.path.to_string_lossy().into_owned()];
        match self.clip {
            Some(clip) => {
                words.push(clip.to_string());
                words.extend(times.iter().map(ToString::to_string));
            }
            None => words.push("rest".to_owned()),
        }
        let (answer, good) = ask("joint_positions.mjs", &words);
        assert!(good, "{answer}");
        let answer: Value = serde_json::from_str(&answer).unwrap();
        let frames = answer["frames"].as_array().unwrap();
        frames
            .iter()
            .map(|frame| self.joints_of(&frame["positions"]))
            .collect()
    }

    /// Selects the joints from the positions of all nodes.
    fn joints_of(&self, positions: &Value) -> Vec<Vec3> {
        let axis = |p: &Value, i: usize| p[i].as_f64().expect("the node is in the scene") as f32;
        let nodes = self.file.node_of_joint.iter();
        nodes
            .map(|&node| &positions[node])
            .map(|p| Vec3::new(axis(p, 0), axis(p, 1), axis(p, 2)))
            .map(|p| self.turned(p))
            .collect()
    }

    /// three.js shows a VRM 0.x character in the file's orientation, facing -Z.
    fn turned(&self, place: Vec3) -> Vec3 {
        let version = self.file.version.as_deref().unwrap_or_default();
        if version.starts_with("VRM 0") {
            return Vec3::new(-place.x, place.y, -place.z);
        }
        place
    }

    fn positions(&self, local: &LocalPose) -> Vec<Vec3> {
        let mut model = ModelPose::new(self.rig.len());
        local_to_model(&self.rig, local, &mut model);
        (0..self.rig.len()).map(|j| model.position(j)).collect()
    }

    /// Height from the lowest to the highest skin joint at rest: slightly less than the figure's.
    fn height(&self) -> f32 {
        let rest = self.positions(self.rig.rest_pose());
        let skeleton = &self.file.character.skeleton;
        let heights = (0..rest.len())
            .filter(|&j| skeleton.joints[j].in_skin)
            .map(|j| rest[j].y);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        high - low
    }

    /// Fails if some joint is not at its position in three.js.
    fn compare(&self, what: &str, ours: &[Vec3], judged: &[Vec3], tolerance: f32) {
        let height = self.height();
        assert!(height > 0.1, "{} has no height", self.path.display());
        for (joint, (a, b)) in ours.iter().zip(judged).enumerate() {
            let apart = a.distance(*b) / height;
            assert!(
                apart <= tolerance,
                "{} {what}: joint {joint} \"{}\" is at {a}, three.js has it at {b}: {apart:e} of the height",
                self.path.display(),
                self.rig.name(joint)
            );
        }
    }
}

/// Reads a real file that needs no other.
fn open(name: &str) -> GltfFile {
    let bytes = real::bytes(name).unwrap();
    let mut alone = |uri: &str| Err(format!("{uri} is not needed"));
    let read = gltf::read(&bytes, &Limits::default(), &mut alone);
    read.unwrap_or_else(|e| panic!("{name}: {e}")).value
}

/// Times on keys, between keys, at both ends and beyond the last.
fn times_of(clip: &source::RawClip) -> Vec<f32> {
    let keys = &clip
        .channels
        .iter()
        .max_by_key(|c| c.times_secs.len())
        .unwrap()
        .times_secs;
    let end = clip.duration_secs;
    let on_keys = [1, keys.len() / 3, keys.len() / 2].map(|k| keys[k.min(keys.len() - 1)]);
    let between = [0.1234, 0.4567, 0.789].map(|part| part * end);
    [
        vec![0.0],
        on_keys.to_vec(),
        between.to_vec(),
        vec![end, end + 1.0],
    ]
    .concat()
}

#[test]
fn joints_are_where_three_js_has_them() {
    if !judges_are_here() {
        return;
    }
    for (name, clip) in CHARACTERS {
        let Some(subject) = Subject::new(name, *clip) else {
            continue;
        };
        let Some(clip) = subject.source_clip() else {
            let judged = subject.judged(&[]);
            let ours = subject.positions(subject.rig.rest_pose());
            subject.compare("at rest", &ours, &judged[0], TOLERANCE);
            continue;
        };
        let times = times_of(clip);
        let mut local = subject.rig.rest_pose().clone();
        for (time, judged) in times.iter().zip(subject.judged(&times)) {
            evaluate::pose(clip, &subject.file.character.skeleton, *time, &mut local);
            let ours = subject.positions(&local);
            subject.compare(&format!("at {time} s"), &ours, &judged, TOLERANCE);
        }
    }
}

#[test]
fn runtime_clips_follow_three_js() {
    if !judges_are_here() {
        return;
    }
    for (name, clip) in CHARACTERS {
        let Some(subject) = Subject::new(name, *clip) else {
            continue;
        };
        let Some(index) = subject.clip else { continue };
        let mapping = articula::build::joint_names::map(
            &subject.file.character.skeleton,
            joint_map::builtin(),
            None,
        );
        let mut source = subject.file.character.clone();
        source.clips = vec![source.clips[index].clone()];
        let options = ClipOptions::default();
        let asset = character(&source, Some(mapping.articulation), &options).unwrap();
        let clip = &asset.clips[0];
        let frame_secs = 1.0 / clip.rate_hz();
        let last = clip.frames() - 1;
        let on_frames = [0, 1, last / 3, last / 2, last].map(|f| f as f32 * frame_secs);
        let between = [0.37, 0.62].map(|part| (last as f32 * part).floor() + WORST_PART);
        let between = between.map(|f| f.min(last as f32) * frame_secs);
        let on_frames = on_frames.map(|secs| (secs, TOLERANCE));
        let between = between.map(|secs| (secs, TOLERANCE_BETWEEN_FRAMES));
        follow(&subject, clip, &[&on_frames[..], &between].concat());
    }
}

/// Compares a clip with three.js at times, each with its tolerance.
fn follow(subject: &Subject, clip: &Clip, at: &[(f32, f32)]) {
    let every = JointSet::first(subject.rig.len());
    let mut local = subject.rig.rest_pose().clone();
    let times: Vec<f32> = at.iter().map(|(time, _)| *time).collect();
    for ((time, tolerance), judged) in at.iter().zip(subject.judged(&times)) {
        sample(clip, f64::from(*time), Wrap::Clamp, &every, &mut local);
        let ours = subject.positions(&local);
        subject.compare(
            &format!("as a runtime clip at {time} s"),
            &ours,
            &judged,
            *tolerance,
        );
    }
}

/// Characters whose own files the validator accepts, with different content.
const ROUND_TRIPS: &[&str] = &[
    "glb/pab_arnaud.glb",
    "glb/KayKit_Knight.glb",
    "glb/Quaternius_cyberpunk_pack__Character.glb",
    "glb/RobotExpressive.glb",
    // Buffers as data URIs.
    "glb/MorphStressTest.gltf",
    // Sparse accessors.
    "glb/mh_female_default163_arkit52.glb",
    // No skin at all.
    "glb/AnimatedMorphCube.glb",
    "vrm/Godette_vrm_v4.vrm",
];

/// A character whose own file the validator rejects, for weights that do not sum to 1: passed
/// through it keeps its errors, written as a new document it is repaired.
const FAULTY: &str = "glb/CesiumMan.glb";

#[test]
fn what_we_write_is_valid() {
    if !judges_are_here() {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("valid");
    std::fs::create_dir_all(&folder).unwrap();
    let mut written = Vec::new();
    let mut write = |name: &str, how: &str, document: &Document| {
        let stem = Path::new(name).file_stem().unwrap().to_string_lossy();
        let path = folder.join(format!("{stem}.{how}.glb"));
        std::fs::write(&path, document.write_glb().unwrap()).unwrap();
        written.push(path.to_string_lossy().into_owned());
    };
    for name in ROUND_TRIPS.iter().chain([&FAULTY]) {
        if real::file(name).is_none() {
            continue;
        }
        let file = open(name);
        let anew = Document::from_character(&file.character).unwrap();
        write(name, "anew", &anew);
        if *name != FAULTY {
            write(name, "through", &file.document);
        }
    }
    let (verdict, good) = ask("validate.mjs", &written);
    assert!(good, "{}", faults_of(&verdict));
}

/// Motions and the characters onto which they are retargeted.
const RETARGETS: &[(&str, &str)] = &[
    ("bvh/cmu_12_01_walk.bvh", "glb/KayKit_Knight.glb"),
    (
        "bvh/fair1_dab.bvh",
        "glb/Quaternius_modular_women__Casual.glb",
    ),
    ("vrm/idle_loop.vrma", "vrm/Godette_vrm_v4.vrm"),
    (
        "glb/kaykit_mannequin/Med_MovementBasic.glb",
        "glb/mh_female_default163_arkit52.glb",
    ),
];

#[test]
fn what_is_retargeted_is_valid() {
    if !judges_are_here() || !data_is_here() {
        return;
    }
    let here = program::folder("valid-retargets");
    let human = program::word(program::human()).to_owned();
    let mut written = Vec::new();
    let mut convert = |motion: &str, onto: &str| {
        let out = here.join(format!("{}.glb", written.len()));
        let out = program::word(&out).to_owned();
        program::json(&here, &["convert", motion, &out, "--onto", onto]);
        written.push(out);
    };
    for (motion, onto) in RETARGETS {
        let (motion, onto) = (data_folder().join(motion), data_folder().join(onto));
        convert(program::word(&motion), program::word(&onto));
    }
    let motions = here.join("bvh");
    cut_motions(&data_folder().join("bvh"), &motions);
    convert(program::word(&motions), &human);
    let (verdict, good) = ask("validate.mjs", &written);
    assert!(good, "{}", faults_of(&verdict));
}

#[test]
fn the_reference_human_is_valid() {
    if !judges_are_here() {
        return;
    }
    let here = program::folder("valid-humans");
    let kinds: [&[&str]; 3] = [&[], &["--painted"], &["--mannequin"]];
    let written = kinds.iter().enumerate().map(|(i, kind)| {
        let out = program::word(&here.join(format!("{i}.glb"))).to_owned();
        let words = [&["human", &out, "--triangles", "2000"], *kind].concat();
        program::json(&here, &words);
        out
    });
    let (verdict, good) = ask("validate.mjs", &written.collect::<Vec<_>>());
    assert!(good, "{}", faults_of(&verdict));
}

/// Copies the BVH files of a folder with at most 40 frames each: most of their time is that of two
/// long ones.
fn cut_motions(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "bvh") {
            let text = std::fs::read_to_string(&path).unwrap();
            std::fs::write(to.join(path.file_name().unwrap()), cut_motion(&text)).unwrap();
        }
    }
}

/// A BVH file with at most 40 frames.
fn cut_motion(text: &str) -> String {
    let (figure, motion) = text.split_once("Frames:").unwrap();
    let mut lines = motion.lines();
    let (count, rate) = (lines.next().unwrap(), lines.next().unwrap());
    let count = count.trim().parse::<usize>().unwrap().min(40);
    let frames: Vec<&str> = lines.filter(|l| !l.trim().is_empty()).take(count).collect();
    let frames = frames.join("\n");
    format!("{figure}Frames: {count}\n{rate}\n{frames}\n")
}

/// Characters that are written with the draft extensions for characters: VRM of both versions, and
/// files whose human bones are recognised by names only.
const KHR_CHARACTERS: &[&str] = &[
    "vrm/Godette_vrm_v4.vrm",
    "vrm/debug_robot.vrm",
    "vrm/VRMC_vrm_expressions_isBinary_Overrides.vrm",
    "glb/KayKit_Knight.glb",
    "glb/mh_male_cmu31.glb",
    "bvh/cmu_12_01_walk.bvh",
];

#[test]
fn khr_characters_are_valid_and_keep_to_the_schemas() {
    if !judges_are_here() || !data_is_here() {
        return;
    }
    let folder = program::folder("khr-oracle");
    let mut written = Vec::new();
    for name in KHR_CHARACTERS {
        let stem = Path::new(name).file_stem().unwrap().to_string_lossy();
        let out = folder.join(format!("{stem}.glb"));
        let input = data_folder().join(name);
        let words = [
            "convert",
            program::word(&input),
            program::word(&out),
            "--khr-character",
        ];
        assert_eq!(program::articula(&folder, &words).status, 0, "{name}");
        written.push(out.to_string_lossy().into_owned());
    }
    let (verdict, good) = ask("validate.mjs", &written);
    assert!(good, "{}", faults_of(&verdict));
    let schemas = data_folder().join("fixtures/khr_character_schema_pr2512");
    let mut words = vec![schemas.to_string_lossy().into_owned()];
    words.extend(written);
    let (verdict, good) = ask("schemas.mjs", &words);
    assert!(good, "{verdict}");
    let verdict: Value = serde_json::from_str(&verdict).unwrap();
    for file in verdict.as_array().unwrap() {
        // Character, skeleton mapping and reference pose.
        assert_eq!(file["judged"], 3, "{file}");
    }
}

/// Validator errors only, without warnings.
fn faults_of(verdict: &str) -> String {
    let Ok(Value::Array(files)) = serde_json::from_str(verdict) else {
        return verdict.to_owned();
    };
    let bad = files.iter().filter(|file| file["errors"] != 0);
    bad.map(|file| format!("{}: {}\n", file["file"], file["messages"]))
        .collect()
}
