//! A folder of FBX motions on one character, in one call.

use crate::program::{folder, json, word};
use crate::real;

#[test]
fn a_folder_of_motions_becomes_the_clips_of_a_figure() {
    let Some(files) = real::fbx_folder() else {
        return;
    };
    let here = folder("fbx-motions");
    let motions = here.join("motions");
    std::fs::create_dir_all(&motions).unwrap();
    let run = std::fs::read(files.join("pab_run.fbx")).unwrap();
    for name in ["Fast Run.fbx", "Run.fbx"] {
        std::fs::write(motions.join(name), &run).unwrap();
    }
    let Some(figure) = real::file("glb/pab_arnaud.glb") else {
        return;
    };
    json(
        &here,
        &["convert", "motions", "all.glb", "--onto", word(&figure)],
    );
    let found = json(&here, &["inspect", "all.glb"]);
    let clips = found["clips"].as_array().unwrap();
    let names: Vec<&str> = clips.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Fast Run", "Run"]);
    let moved = json(&here, &["convert", "motions/Run.fbx", "run.bvh"]);
    assert_eq!(moved["clips"][0], "run");
}
