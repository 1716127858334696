//! Clip hygiene on real motion.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, opens real files, and says what it measured"
)]

use articula_build::character::Asset;
use articula_build::clip::ClipOptions;
use articula_build::clip_edit::Subject;
use articula_build::clip_edit::key_reduction::{ReduceOptions, reduce_keys};
use articula_core::hierarchy::local_to_model;
use articula_core::pose::ModelPose;
use articula_core::skin::{palette, skin_points};
use articula_core::source::{Character, Clip, evaluate};
use articula_formats::{Limits, bvh, gltf, profile};
use glam::{Affine3A, Vec3};
use std::path::{Path, PathBuf};

fn real_data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("ARTICULA_DATA").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(
        std::env::var_os("ARTICULA_REQUIRE_DATA").is_none_or(|v| v != "1"),
        "{} is required",
        folder.display()
    );
    println!("skipped: no data");
    None
}

fn read(data: &Path, name: &str) -> (Character, Vec<(usize, Vec3)>) {
    let bytes = std::fs::read(data.join(name)).unwrap();
    let limits = Limits::default();
    if name.ends_with(".bvh") {
        let file = bvh::read(&bytes, &bvh::ReadOptions::default(), &limits)
            .unwrap()
            .value;
        return (file.character, file.end_sites);
    }
    let mut alone = |uri: &str| Err(format!("{uri} is not needed"));
    let file = gltf::read(&bytes, &limits, &mut alone).unwrap().value;
    (file.character, Vec::new())
}

/// Where a clip has every joint and every vertex (without morph targets).
fn shown(figure: &Asset, character: &Character, clip: &Clip, secs: f32) -> Vec<Vec3> {
    let mut pose = figure.rig.rest_pose().clone();
    evaluate::pose(clip, &character.skeleton, secs, &mut pose);
    let mut model = ModelPose::new(figure.rig.len());
    local_to_model(&figure.rig, &pose, &mut model);
    let mut matrices = vec![Affine3A::IDENTITY; figure.mesh.bindings.len()];
    palette(&figure.mesh, &model, &mut matrices);
    let every: Vec<u32> = (0..figure.mesh.len() as u32).collect();
    let mut skin = vec![Vec3::ZERO; every.len()];
    skin_points(&figure.mesh, &matrices, &every, &mut skin);
    let joints = (0..figure.rig.len()).map(|j| model.position(j));
    joints.chain(skin).collect()
}

/// File, clip, and by what factor its bytes shrink at least at 1 mm and at 1 cm.
const REDUCED: [(&str, &str, f32, f32); 6] = [
    ("glb/mh_female_dance.glb", "dance", 2.0, 5.0),
    ("bvh/cmu_12_01_walk.bvh", "motion", 2.0, 12.0),
    ("bvh/fair1_dab.bvh", "motion", 1.2, 1.9),
    ("glb/KayKit_Knight.glb", "1H_Ranged_Aiming", 2.0, 3.0),
    ("glb/pab_arnaud.glb", "atlas", 2.5, 6.0),
    (
        "glb/Quaternius_cyberpunk_pack__Character.glb",
        "CharacterArmature|Idle_Gun_Pointing",
        2.5,
        7.0,
    ),
];

#[test]
fn fewer_keys_move_no_vertex_of_real_figures_farther_than_the_bound() {
    let Some(data) = real_data() else { return };
    for (name, clip, at_1_mm, at_1_cm) in REDUCED {
        let (character, ends) = read(&data, name);
        let clip = character.clips.iter().find(|c| c.name == clip).unwrap();
        let mapping = profile::map(&character.skeleton, profile::builtin(), None);
        let subject = Subject::new(&character, mapping.articulation.clone(), &ends).unwrap();
        let posed = articula_build::character::character(
            &Character {
                clips: Vec::new(),
                ..character.clone()
            },
            Some(mapping.articulation),
            &ClipOptions::default(),
        );
        let posed = posed.unwrap();
        for (bound_metres, factor) in [(1e-3, at_1_mm), (1e-2, at_1_cm)] {
            let opts = ReduceOptions {
                bound_metres,
                drop_rest: true,
            };
            let out = reduce_keys(&subject, clip, &opts).unwrap();
            let (before, after) = (out.before, out.after);
            println!(
                "{name} \"{}\" at {bound_metres} m: {} -> {} keys, {} -> {} bytes, worst {:.6} m",
                clip.name, before.keys, after.keys, before.bytes, after.bytes, out.worst_metres
            );
            assert!(out.worst_metres <= bound_metres);
            let shrunk = before.bytes as f32 / after.bytes as f32;
            assert!(shrunk >= factor, "{name}: {shrunk} times smaller");
            // Times that are on no grid of the reduction.
            for i in 0..30 {
                let secs = clip.duration_secs * (i as f32 + 0.37) / 30.0;
                let [a, b] = [clip, &out.clip].map(|c| shown(&posed, &character, c, secs));
                let apart = a.iter().zip(&b).map(|(p, q)| p.distance(*q));
                let apart = apart.fold(0.0, f32::max);
                assert!(
                    apart <= 1.01 * bound_metres,
                    "{name} at {secs} s: {apart} m"
                );
            }
        }
    }
}
