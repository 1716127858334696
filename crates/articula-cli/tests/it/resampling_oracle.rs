//! The posed skin of written motions against their source files, judged by three.js
//! (`oracle/resampling.mjs`).

use crate::judges::{ask, judges_are_here};
use crate::real;
use serde_json::Value;
use std::path::Path;

fn check(files: &[String]) {
    let program = env!("CARGO_BIN_EXE_articula").to_owned();
    let words: Vec<String> = [program].into_iter().chain(files.iter().cloned()).collect();
    let (answer, is_within) = ask("resampling.mjs", &words);
    assert!(is_within, "{answer}");
    // The table for people is between them.
    let rows: Vec<Value> = answer
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    // GLB, two streams, the asset and BVH of each clip; no asset of a VRMA file.
    let ways = |file: &String| if file.contains(".vrma") { 4 } else { 5 };
    assert_eq!(
        rows.len(),
        files.iter().map(ways).sum::<usize>(),
        "{answer}"
    );
    for row in &rows {
        let [max, bound] = ["max_mm", "bound_mm"].map(|key| row[key].as_f64().unwrap());
        assert!(max <= bound, "{row}");
    }
}

#[test]
fn hand_set_keys_are_shown_as_in_the_file() {
    if !judges_are_here() {
        return;
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula/tests/keys");
    let file = folder.join("hand_keyed_wave.glb");
    check(&[file.to_str().unwrap().to_owned()]);
}

#[test]
fn clips_that_begin_late_or_pause_are_shown_as_in_the_file() {
    if !judges_are_here() {
        return;
    }
    let clips = [
        ("glb/Fox.glb", "Run"),
        ("glb/mannequiny.glb", "air_land_root.001"),
        ("glb/mannequiny.glb", "run_root.001"),
        ("vrm/test.vrma", "animation_0"),
    ];
    let here = clips.map(|(file, clip)| Some(format!("{}#{clip}", real::file(file)?.display())));
    let here: Vec<String> = here.into_iter().flatten().collect();
    if !here.is_empty() {
        check(&here);
    }
}
