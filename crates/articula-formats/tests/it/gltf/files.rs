//! Every real file: the counts that its makers state, and round trips.

use crate::real::real_data;
use articula_core::source::{Property, RawClip};
use articula_core::{Articulation, JointArticulation, Region};
use articula_formats::gltf::{self, Document, GltfFile};
use articula_formats::{Limits, Parsed, ReadError};
use std::path::{Path, PathBuf};

fn read(path: &Path) -> Result<Parsed<GltfFile>, ReadError> {
    let bytes = std::fs::read(path).unwrap();
    let folder = path.parent().unwrap().to_owned();
    let mut beside = |uri: &str| std::fs::read(folder.join(uri)).map_err(|e| e.to_string());
    gltf::read(&bytes, &Limits::default(), &mut beside)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if path.is_dir() {
            found.extend(files_below(&path));
        } else if ["glb", "gltf", "vrm", "vrma"].contains(&extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Joints in skins, vertices, triangles, clips, seconds of all clips together, warnings.
type Counts = (usize, usize, usize, usize, f32, usize);

/// Stated by the makers of the files or, for counts of warnings, by the Khronos validator.
const STATED: &[(&str, Counts)] = &[
    ("glb/CesiumMan.glb", (19, 3273, 4672, 1, 2.0, 1)),
    ("glb/RiggedFigure.glb", (19, 370, 256, 1, 1.25, 1)),
    ("glb/RiggedSimple.glb", (2, 96, 188, 1, 2.1, 0)),
    ("glb/AnimatedMorphCube.glb", (0, 24, 12, 1, 4.2, 0)),
    ("glb/MorphStressTest.gltf", (0, 1528, 2412, 3, 17.6, 0)),
    ("glb/Fox.glb", (24, 1728, 576, 3, 5.3, 0)),
    ("glb/RobotExpressive.glb", (43, 7218, 3238, 14, 19.5, 0)),
    ("glb/KayKit_Knight.glb", (41, 7024, 6952, 76, 91.4, 0)),
    (
        "glb/kaykit_mannequin/manny_med_mod.gltf",
        (21, 6578, 6756, 0, 0.0, 0),
    ),
    ("glb/mannequiny.glb", (45, 12597, 13832, 10, 8.0, 0)),
    // One warning, about its compressed views.
    ("glb/viverse/mannequin.glb", (53, 7125, 12712, 0, 0.0, 1)),
    ("glb/webxr_hand_left.glb", (25, 1360, 2314, 0, 0.0, 0)),
    ("glb/mh_female_dance.glb", (163, 14517, 26756, 1, 23.97, 0)),
    ("glb/pab_arnaud.glb", (67, 3934, 6670, 4, 17.8, 0)),
    ("glb/ict_head_talk_554.glb", (0, 358, 554, 2, 9.92, 0)),
    (
        "face/ict_facekit_expressions.glb",
        (0, 28911, 52220, 0, 0.0, 0),
    ),
    ("vrm/Godette_vrm_v4.vrm", (68, 3109, 3439, 0, 0.0, 0)),
    // The finest of three levels each: 24 and 5796 corners.
    (
        "fixtures/msft_lod/SimpleSkinLOD.gltf",
        (2, 10, 8, 1, 5.5, 0),
    ),
    (
        "fixtures/msft_lod/msft-lod.gltf",
        (0, 3864, 1932, 0, 0.0, 0),
    ),
    ("vrm/hips_spine_twisting.vrma", (17, 0, 0, 1, 60.0, 0)),
];

#[test]
fn counts_are_those_that_the_makers_state() {
    let Some(data) = real_data() else { return };
    for (name, stated) in STATED {
        let file = read(&data.join(name)).unwrap();
        let character = &file.value.character;
        let primitives = || character.meshes.iter().flat_map(|m| &m.primitives);
        let seconds: f32 = character.clips.iter().map(|c| c.duration_secs).sum();
        let found = (
            character
                .skeleton
                .joints
                .iter()
                .filter(|j| j.in_skin)
                .count(),
            primitives().map(|p| p.positions.len()).sum(),
            primitives().map(|p| p.triangles.len()).sum(),
            character.clips.len(),
            stated.4,
            file.warnings.len(),
        );
        assert_eq!(found, *stated, "{name}");
        // Stated to a tenth of a second.
        assert!((seconds - stated.4).abs() < 0.06, "{name}: {seconds} s");
    }
}

#[test]
fn every_file_is_read_or_refused_with_a_mend_and_comes_back_the_same() {
    let Some(data) = real_data() else { return };
    let mut refused = Vec::new();
    for path in files_below(&data) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match read(&path) {
            Ok(file) => comes_back_the_same(&name, &file.value),
            Err(error) => refused.push((name, error.to_string())),
        }
    }
    let names: Vec<_> = refused.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Quaternius_Astronaut_Barbara_draco.glb"]);
    let (_, why) = &refused[0];
    assert!(why.contains("re-export without Draco"), "{why}");
}

fn again(document: &Document) -> GltfFile {
    let bytes = document.write_glb().unwrap();
    let mut alone = |uri: &str| Err(format!("{uri} was left outside"));
    let file = gltf::read(&bytes, &Limits::default(), &mut alone).unwrap();
    file.value
}

fn comes_back_the_same(name: &str, file: &GltfFile) {
    // The same bytes each time.
    let twice = [0, 1].map(|_| file.document.write_glb().unwrap());
    assert!(twice[0] == twice[1], "{name}");
    // Unchanged.
    assert_eq!(again(&file.document).character, file.character, "{name}");
    // With its own clips replaced.
    let mut replaced = file.document.clone();
    replaced
        .replace_clips(
            &file.character.clips,
            &file.node_of_joint,
            &file.node_of_mesh,
        )
        .unwrap();
    assert_eq!(again(&replaced).character, file.character, "{name}");
    // As a new document, with articulation.
    let mut described = file.character.clone();
    described.articulation = Some(invented(described.skeleton.joints.len()));
    let anew = again(&Document::from_character(&described).unwrap()).character;
    assert_eq!(anew.skeleton, file.character.skeleton, "{name}");
    assert_eq!(anew.meshes, file.character.meshes, "{name}");
    assert_eq!(anew.clips, without_expressions(file), "{name}");
    assert_eq!(anew.materials, file.character.materials, "{name}");
    assert_eq!(anew.images, file.character.images, "{name}");
    let Some(articulation) = anew.articulation else {
        assert!(anew.skeleton.joints.iter().all(|j| !j.in_skin), "{name}");
        return;
    };
    let wanted = invented(anew.skeleton.joints.len()).joints;
    for (j, joint) in anew.skeleton.joints.iter().enumerate() {
        if joint.in_skin {
            assert_eq!(articulation.joints[j], wanted[j], "{name} joint {j}");
        }
    }
}

/// A new document cannot hold channels that drive expressions.
fn without_expressions(file: &GltfFile) -> Vec<RawClip> {
    let mut clips = file.character.clips.clone();
    for clip in &mut clips {
        clip.channels.retain(|c| c.property != Property::Expression);
    }
    clips
}

fn invented(joints: usize) -> Articulation {
    let joint = |j: usize| JointArticulation {
        hanim: j.is_multiple_of(2).then(|| format!("joint_{j}")),
        level: (j % 6) as u8,
        region: Region::ALL[j % 7],
    };
    Articulation {
        profile: "invented".to_owned(),
        joints: (0..joints).map(joint).collect(),
    }
}
