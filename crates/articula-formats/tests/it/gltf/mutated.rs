//! Seeded mutations of small files on stable Rust: for any bytes, reading returns a value of
//! bounded size or an error, and a value that was read can be written.

use super::tiny::Tiny;
use super::{clustered, compressed, khr_character, levels, single_weights, vrm};
use articula_core::source::{MorphBinding, Property};
use articula_formats::Limits;
use articula_formats::gltf::{self, Document, GltfFile};
use articula_mutate::{Edit, Mutations};
use serde_json::json;

/// Replacement words.
const WORDS: &[&str] = &[
    "-1",
    "0",
    "1e39",
    "99999999999",
    "null",
    "[]",
    "{}",
    "\"\"",
    "true",
    "5121",
    "5126",
    "\"VEC3\"",
    "\"SCALAR\"",
    "\"MAT4\"",
    "\"CUBICSPLINE\"",
    "\"weights\"",
];

/// Number of mutants of each file.
const TRIES: usize = 2000;

const MUTATIONS: Mutations<'_> = Mutations {
    edits: &[
        Edit::FlipBit,
        Edit::SetByte,
        Edit::Truncate,
        Edit::Repeat(32),
        Edit::Delete(32),
        Edit::Number(WORDS),
        Edit::Number(WORDS),
        Edit::Number(WORDS),
        Edit::NumberBelow(12),
        Edit::NumberBelow(12),
        Edit::NumberBelow(12),
        Edit::NumberBelow(12),
    ],
    most: 3,
};

/// Updates the lengths in the header, so that mutations reach the content.
fn mend_header(bytes: &mut [u8], json_length: impl Fn(&[u8]) -> Option<usize>) {
    if bytes.len() < 20 {
        return;
    }
    let total = (bytes.len() as u32).to_le_bytes();
    bytes[8..12].copy_from_slice(&total);
    if let Some(length) = json_length(bytes) {
        bytes[12..16].copy_from_slice(&(length as u32).to_le_bytes());
    }
}

/// Returns the end of the JSON if the binary chunk can still be found.
fn json_end(bytes: &[u8]) -> Option<usize> {
    let binary = bytes.windows(4).rposition(|w| w == b"BIN\0")?;
    binary.checked_sub(24)
}

fn fixtures() -> Vec<Vec<u8>> {
    let mut moving = Tiny::skinned();
    let turns = moving.floats("VEC4", &[0., 0., 0., 1., 0., 1., 0., 0.]);
    moving.channel(
        json!({"node": 1, "path": "rotation"}),
        "LINEAR",
        &[0., 1.],
        turns,
    );
    moving.json["skins"][0]["extensions"] = json!({"ARTICULA_articulation": {"profile": "x",
        "joints": [{"level": 0, "region": "pelvis"}, {"level": 1, "region": "torso"}]}});
    let mut morphing = Tiny::triangle();
    let at = morphing.view(&[0, 2]);
    let to = morphing.view(&[0; 24]);
    let offsets = morphing.accessor(json!({"componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": {"count": 2, "indices": {"bufferView": at, "componentType": 5121},
            "values": {"bufferView": to}}}));
    morphing.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": offsets}]);
    let weights = morphing.floats("SCALAR", &[0., 1., 0., 0., 0., 0.]);
    morphing.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"mesh": 0}]);
    let target = json!({"node": 0, "path": "weights"});
    morphing.channel(target, "CUBICSPLINE", &[0., 1.], weights);
    let mut pictured = Tiny::skinned();
    let view = pictured.view(b"\x89PNG");
    pictured.json["images"] = json!([{"bufferView": view}, {"uri": "data:;base64,TWFu"}]);
    pictured.json["textures"] = json!([{"source": 0}]);
    pictured.json["materials"] =
        json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    pictured.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    pictured.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    let human = [
        vrm::old(-0.1),
        vrm::new(),
        vrm::animation(),
        khr_character::character(),
    ];
    let views = [
        compressed::every_mode(),
        levels::skinned(),
        single_weights::every_mode(),
    ];
    let plain = [moving, morphing, pictured];
    let tiny = plain.iter().chain(&views).chain(&human).map(Tiny::glb);
    tiny.chain([clustered::stored()]).collect()
}

#[test]
fn mutated_files_neither_panic_nor_grow() {
    let limits = Limits {
        bytes: 1 << 20,
        elements: 1 << 16,
        nodes: 1 << 10,
        ..Limits::default()
    };
    let mut reads = 0;
    let fixtures = fixtures();
    for good in &fixtures {
        let mut round = 0;
        reads += MUTATIONS.read_of(good, TRIES, |mutant| {
            let mut bytes = mutant.to_vec();
            if round % 4 > 0 {
                mend_header(&mut bytes, json_end);
            }
            round += 1;
            survives(&bytes, &limits)
        });
    }
    // At least one mutant in ten must be read, or the test would cover little.
    assert!(
        reads > TRIES / 10 * fixtures.len(),
        "only {reads} mutants were read"
    );
}

/// Returns whether the bytes were read; panics if the value violates a guarantee.
fn survives(bytes: &[u8], limits: &Limits) -> bool {
    let mut alone = |_: &str| Err("nothing".to_owned());
    let Ok(file) = gltf::read(bytes, limits, &mut alone) else {
        return false;
    };
    let character = &file.value.character;
    let floats: usize = character
        .meshes
        .iter()
        .flat_map(|m| &m.primitives)
        .map(|p| p.positions.len() * 3 + p.weights.len() + p.triangles.len() * 3)
        .chain(
            character
                .clips
                .iter()
                .flat_map(|c| &c.channels)
                .map(|c| c.values.len()),
        )
        .sum();
    assert!(floats as u64 <= limits.elements, "{floats} elements");
    assert!(file.warnings.len() <= 1001);
    names_what_is_there(&file.value);
    // A value that was read is consistent, so it can be written, and read again.
    let written = Document::from_character(character)
        .unwrap()
        .write_glb()
        .unwrap();
    gltf::read(&written, &Limits::default(), &mut alone).unwrap();
    let through = file.value.document.write_glb().unwrap();
    let again = gltf::read(&through, &Limits::default(), &mut alone).unwrap();
    assert_eq!(again.value.character, file.value.character);
    let mut document = file.value.document.clone();
    let bones = file.value.node_of_joint.iter().copied();
    let bones: Vec<_> = bones.zip(["hips", "head"].map(str::to_owned)).collect();
    if document.set_khr_character(&bones, "TPose", None).is_ok() {
        gltf::read(
            &document.write_glb().unwrap(),
            &Limits::default(),
            &mut alone,
        )
        .unwrap();
    }
    let mut document = file.value.document;
    let (joints, meshes) = (&file.value.node_of_joint, &file.value.node_of_mesh);
    document
        .replace_clips(&character.clips, joints, meshes)
        .unwrap();
    let again = gltf::read(
        &document.write_glb().unwrap(),
        &Limits::default(),
        &mut alone,
    );
    assert_eq!(again.unwrap().value.character.meshes, character.meshes);
    true
}

/// Checks that every index of the human extensions exists in the character.
fn names_what_is_there(file: &GltfFile) {
    let character = &file.character;
    let joints = character.skeleton.joints.len();
    let expressions = character.expressions.len();
    for expression in &character.expressions {
        let has = |m: &MorphBinding| m.target < character.meshes[m.mesh].morph_weights.len();
        assert!(expression.morphs.iter().all(has));
        assert!(expression.joints.iter().all(|b| b.joint < joints));
        assert!(expression.masks.iter().all(|m| m.target < expressions));
    }
    let bones = file.humanoid.iter().flatten();
    assert!(bones.map(|(joint, _)| *joint).all(|j| j < joints));
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        let is_driver = channel.property == Property::Expression;
        assert!(!is_driver || channel.target < expressions);
    }
    if let Some(khr) = &file.khr_character {
        let mapped = khr.rigs.iter().flat_map(|r| &r.joints);
        assert!(mapped.map(|(joint, _)| *joint).all(|j| j < joints));
        let responses = khr.expression_clips.iter().map(|(clip, _)| *clip);
        let mut clips = responses.chain(khr.reference_poses.iter().map(|p| p.clip));
        assert!(clips.all(|c| c < character.clips.len()));
    }
}
