//! Real characters: the counts of `inspect` match the contents of the files.

use crate::program::{folder, json, word};
use crate::real::{file, real_data};

/// File, format, joints, clips, vertices and triangles in total, as in the data's manifest.
const FILES: [(&str, &str, usize, usize, usize, usize); 10] = [
    ("glb/CesiumMan.glb", "glb", 19, 1, 3273, 4672),
    ("glb/RobotExpressive.glb", "glb", 43, 14, 7218, 3238),
    ("glb/KayKit_Knight.glb", "glb", 41, 76, 7024, 6952),
    (
        "glb/Quaternius_modular_men__Casual2.glb",
        "glb",
        49,
        0,
        11662,
        5776,
    ),
    (
        "glb/Quaternius_platformer_game_pack__Character.glb",
        "glb",
        29,
        18,
        1895,
        2908,
    ),
    ("glb/mannequiny.glb", "glb", 45, 10, 12597, 13832),
    ("glb/mh_female_dance.glb", "glb", 163, 1, 14517, 26756),
    ("glb/pab_arnaud.glb", "glb", 67, 4, 3934, 6670),
    ("vrm/Godette_vrm_v4.vrm", "vrm", 68, 0, 3109, 3439),
    ("bvh/cmu_12_01_walk.bvh", "bvh", 31, 1, 0, 0),
];

#[test]
fn counts_are_those_of_the_list() {
    let here = folder("counts");
    for (name, format, joints, clips, vertices, triangles) in FILES {
        let Some(path) = file(name) else { continue };
        let found = json(&here, &["inspect", word(&path)]);
        let list = |field: &str| found[field].as_array().unwrap().clone();
        let sum = |list: &str, field: &str| -> u64 {
            found[list]
                .as_array()
                .unwrap()
                .iter()
                .map(|m| m[field].as_u64().unwrap())
                .sum()
        };
        assert_eq!(found["format"], format, "{name}");
        assert_eq!(sum("skeletons", "joints"), joints as u64, "{name}");
        assert_eq!(list("clips").len(), clips, "{name}");
        assert_eq!(sum("meshes", "vertices"), vertices as u64, "{name}");
        assert_eq!(sum("meshes", "triangles"), triangles as u64, "{name}");
        let height = found["height_m"].as_f64().unwrap();
        assert!(
            (0.5..5.0).contains(&height),
            "{name}: {height} m after skinning"
        );
    }
}

#[test]
fn keyed_joints_that_move_are_told_from_those_that_do_not() {
    let Some(pab) = file("glb/pab_arnaud.glb") else {
        return;
    };
    let here = folder("moving");
    let found = json(&here, &["inspect", word(&pab)]);
    let clips = found["clips"].as_array().unwrap();
    let rates: Vec<i64> = clips
        .iter()
        .map(|c| c["fps"].as_f64().unwrap().round() as i64)
        .collect();
    assert!(rates.iter().all(|r| *r == 30), "{rates:?}");
    // Every joint is keyed; the list counts 23, 21, 23 and 54 turning joints, and a few that
    // only shift.
    for (clip, turning) in clips.iter().zip([23, 21, 23, 54]) {
        let moving = clip["joints_animated"].as_u64().unwrap();
        assert!((turning..turning + 10).contains(&moving), "{clip}");
    }
}

#[test]
fn four_influences_and_morphs_are_counted() {
    let Some(data) = real_data() else { return };
    let here = folder("morphs");
    let found = json(
        &here,
        &["inspect", word(&data.join("glb/mh_female_dance.glb"))],
    );
    assert_eq!(found["face"]["morphs"], 52);
    assert_eq!(found["meshes"][0]["influences_max"], 4);
    assert_eq!(found["clips"][0]["morphs_animated"], 52);
}

#[test]
fn coarser_levels_are_listed_with_their_share_of_the_screen() {
    let Some(data) = real_data() else { return };
    let here = folder("levels-of-real-files");
    // 24, 12 and 6 corners; spheres of 5796, 324 and 36 corners, of 3864, 216 and 24 vertices.
    let files = [
        (
            "SimpleSkinLOD",
            [(8, 10), (4, 10), (2, 10)],
            [0.5, 0.2, 0.01],
        ),
        (
            "msft-lod",
            [(1932, 3864), (108, 216), (12, 24)],
            [0.2, 0.05, 0.001],
        ),
    ];
    for (name, sizes, shares) in files {
        let path = data.join(format!("fixtures/msft_lod/{name}.gltf"));
        let found = json(&here, &["inspect", word(&path)]);
        let meshes = found["meshes"].as_array().unwrap();
        assert_eq!(
            meshes.len(),
            1,
            "{name}: the coarser ones are not shown beside it"
        );
        let coarser = meshes[0]["levels"].as_array().unwrap();
        let levels: Vec<_> = std::iter::once(&meshes[0]).chain(coarser).collect();
        assert_eq!(levels.len(), 3, "{name}");
        for ((level, (triangles, vertices)), share) in levels.iter().zip(sizes).zip(shares) {
            assert_eq!(level["triangles"], triangles, "{name}");
            assert_eq!(level["vertices"], vertices, "{name}");
            let found = level["screen_coverage"].as_f64().unwrap();
            assert!((found - share).abs() < 1e-6, "{name}: {found}");
        }
    }
}
