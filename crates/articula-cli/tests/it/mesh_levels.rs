//! `build --levels` on the command line: files, numbers and refused input.

use crate::program::{BVH, articula, fault, folder, json, short, word};
use serde_json::Value;

/// Shares of five levels that are made whatever their errors are.
const FIVE: &str = "100,50,25,10,1.5";

fn numbers(list: &Value, name: &str) -> Vec<f64> {
    let all = list.as_array().unwrap().iter();
    all.map(|v| v[name].as_f64().unwrap()).collect()
}

#[test]
fn what_build_says_is_in_the_file_and_in_the_stream() {
    let here = folder("mesh-levels");
    let words = ["--targets", FIVE, "--mesh-stream", "h.ams", "--msft-lod"];
    let built = json(
        &here,
        &[&["build", word(short()), "h.glb"], &words[..]].concat(),
    );
    let levels = &built["levels"];
    let triangles = numbers(levels, "triangles");
    for (found, share) in triangles.iter().zip([1.0, 0.5, 0.25, 0.1, 0.015]) {
        assert!(*found <= share * triangles[0] * 1.02 + 2.0, "{triangles:?}");
    }
    for name in ["error_rest_m", "error_motion_m"] {
        let errors = numbers(levels, name);
        assert_eq!(errors[0], 0.0);
        assert!(errors.windows(2).all(|w| w[0] < w[1]), "{name}: {errors:?}");
        // Half of the triangles of a body of 1.7 m keep the error below centimetres.
        assert!(errors[1] < 0.02, "{name}: {errors:?}");
    }
    let bytes = &built["bytes"];
    let direct = numbers(levels, "bytes_direct");
    let stream = std::fs::read(here.join("h.ams")).unwrap();
    assert_eq!(bytes["clustered"].as_u64().unwrap(), stream.len() as u64);
    assert_eq!(bytes["finest_alone"].as_f64().unwrap(), direct[0]);
    assert_eq!(
        bytes["discrete_sum"].as_f64().unwrap(),
        direct.iter().sum::<f64>()
    );
    assert!(stream.len() < direct.iter().sum::<f64>() as usize);
    let store = bytes["store"].as_u64().unwrap();
    let plain = std::fs::metadata(short()).unwrap().len();
    assert!(
        store < 2 * plain,
        "vertices are stored once: {store} of {plain}"
    );

    let found = json(&here, &["inspect", "h.glb"]);
    let table = &found["mesh_levels"]["levels"];
    for name in ["level", "triangles", "vertices", "error_motion_m", "ranges"] {
        assert_eq!(numbers(table, name), numbers(levels, name), "{name}");
    }
    let meshes = found["meshes"].as_array().unwrap();
    let all: f64 = numbers(&found["meshes"], "triangles").iter().sum();
    assert_eq!(all, triangles[0]);
    let mut shown = 0.0;
    for mesh in meshes {
        assert_eq!(mesh["levels"].as_array().unwrap().len(), 4);
        let parts = mesh["levels"][3]["ranges"].as_array().unwrap().iter();
        let ranges = parts.flat_map(|part| part.as_array().unwrap());
        shown += ranges
            .map(|r| r[1].as_f64().unwrap() - r[0].as_f64().unwrap())
            .sum::<f64>();
    }
    assert_eq!(shown, triangles[4]);
    let skin = meshes.iter().find(|m| m["name"] == "skin").unwrap();
    assert!(skin["levels"][0]["screen_coverage"].is_number());
}

#[test]
fn levels_that_are_too_coarse_are_left_out_and_told() {
    let here = folder("mesh-levels-coarse");
    let words = ["build", word(short()), "h.glb"];
    let named = json(&here, &[&words[..], &["--targets", FIVE]].concat());
    let height = 1.8;
    let errors = numbers(&named["levels"], "error_motion_m");
    let within = errors.iter().filter(|e| **e <= 0.05 * height).count();
    assert_eq!((errors.len(), within), (5, 4), "{errors:?}");
    let said = |built: &Value| {
        let all = built["warnings"].as_array().unwrap().iter();
        let all = all.filter_map(|w| w.as_str().filter(|w| w.contains("level")));
        all.map(str::to_owned).collect::<Vec<_>>()
    };
    let [line] = &said(&named)[..] else {
        panic!("{:?}", said(&named));
    };
    assert!(
        line.starts_with("mesh level 4: its error in motion is"),
        "{line}"
    );

    let made = json(&here, &[&words[..], &["--levels", "5"]].concat());
    assert_eq!(numbers(&made["levels"], "error_motion_m"), errors[..4]);
    let [line] = &said(&made)[..] else {
        panic!("{:?}", said(&made));
    };
    let triangles = numbers(&named["levels"], "triangles")[4];
    let start = format!("4 of 5 mesh levels are made: the level of {triangles} triangles (1.5 %)");
    assert!(line.starts_with(&start), "{line}");
}

#[test]
fn errors_are_told_relative_to_the_figure_whatever_the_unit_of_its_vertices() {
    let here = folder("mesh-levels-unit");
    // The scale is that of a node: the vertices stay in the unit of the file.
    let scale = [
        "convert",
        word(short()),
        "big.glb",
        "--read",
        "unit-metres=100",
    ];
    json(&here, &scale);
    for (targets, told) in [("100,50", 0), (FIVE, 1)] {
        let built = json(&here, &["build", "big.glb", "b.glb", "--targets", targets]);
        let warnings = built["warnings"].as_array().unwrap().iter();
        let coarse = warnings.filter(|w| w.as_str().is_some_and(|w| w.contains("mesh level")));
        assert_eq!(coarse.count(), told, "{}", built["warnings"]);
    }
}

#[test]
fn a_stream_tells_what_is_in_it_whole_cut_or_altered() {
    let here = folder("mesh-stream");
    let words = ["--targets", FIVE, "--mesh-stream", "h.ams"];
    let built = json(
        &here,
        &[&["build", word(short()), "h.glb"], &words[..]].concat(),
    );
    let levels = &built["levels"];
    let stream = std::fs::read(here.join("h.ams")).unwrap();
    let streamed = json(&here, &["inspect", "h.ams"]);
    for name in [
        "level",
        "triangles",
        "vertices",
        "error_motion_m",
        "bytes_added",
    ] {
        assert_eq!(
            numbers(&streamed["levels"], name),
            numbers(levels, name),
            "{name}"
        );
    }
    // A truncated stream is a coarser character; a modified one is an error.
    let added = numbers(levels, "bytes_added");
    std::fs::write(
        here.join("cut.ams"),
        &stream[..stream.len() - added[0] as usize],
    )
    .unwrap();
    let cut = json(&here, &["inspect", "cut.ams"]);
    let whole = cut["levels"].as_array().unwrap().iter();
    let whole: Vec<bool> = whole.map(|l| l["complete"] == true).collect();
    assert_eq!(whole, [false, true, true, true, true]);
    let mut altered = stream.clone();
    altered[stream.len() / 2] ^= 1;
    std::fs::write(here.join("bad.ams"), altered).unwrap();
    let line = fault(&here, 1, &["inspect", "bad.ams"]);
    assert!(line.contains("bad.ams: chunk of level"), "{line}");
}

#[test]
fn zones_and_locked_vertices_are_kept_apart() {
    let here = folder("mesh-levels-split");
    std::fs::write(here.join("lock.json"), r#"{"skin": [0, 1, 2]}"#).unwrap();
    let human = word(short());
    let words = [
        "--targets",
        "100,30",
        "--split",
        "upper",
        "--lock",
        "lock.json",
    ];
    json(
        &here,
        &[
            &["build", human, "s.glb", "--region-weight", "face=8,hands=4"],
            &words[..],
        ]
        .concat(),
    );
    let found = json(&here, &["inspect", "s.glb"]);
    let regions = &found["mesh_levels"]["regions"];
    assert_eq!(regions, &serde_json::json!(["upper", "rest"]));

    std::fs::write(here.join("lock.json"), r#"{"hat": [0]}"#).unwrap();
    let line = fault(&here, 1, &[&["build", human, "t.glb"], &words[..]].concat());
    assert!(
        line.contains("lock.json: there is no mesh \"hat\"; the meshes are skin"),
        "{line}"
    );
    std::fs::write(here.join("lock.json"), r#"{"skin": [999999]}"#).unwrap();
    let line = fault(&here, 1, &[&["build", human, "t.glb"], &words[..]].concat());
    assert!(
        line.contains("skin: vertex 999999 is out of range"),
        "{line}"
    );
    std::fs::write(here.join("lock.json"), "[1]").unwrap();
    let line = fault(&here, 1, &[&["build", human, "t.glb"], &words[..]].concat());
    assert!(line.contains("the expected form is"), "{line}");
    assert!(!here.join("t.glb").exists());
}

#[test]
fn convert_writes_a_mix_of_levels_and_draws_it() {
    let here = folder("mesh-levels-mix");
    let words = ["--targets", "100,50,20,3", "--split", "face,hands"];
    let human = word(short());
    json(&here, &[&["build", human, "b.glb"], &words[..]].concat());
    let words = [
        "--mesh-level",
        "face=0,hands=1,rest=2",
        "--mesh-distance",
        "4",
    ];
    let words = [&words[..], &["--mesh-picture", "mix.png"]].concat();
    let made = json(
        &here,
        &[&["convert", "b.glb", "mix.glb"], &words[..]].concat(),
    );
    let mesh = &made["mesh"];
    let regions = mesh["regions"].as_array().unwrap();
    let named: Vec<&str> = regions
        .iter()
        .map(|r| r["region"].as_str().unwrap())
        .collect();
    assert_eq!(named, ["face", "hands", "rest"]);
    assert_eq!(numbers(&mesh["regions"], "level"), [0.0, 1.0, 2.0]);
    let sum: f64 = numbers(&mesh["regions"], "triangles").iter().sum();
    assert_eq!(sum, mesh["triangles"].as_f64().unwrap());
    assert!(mesh["view"]["error_px"].as_f64().unwrap() > 0.0);
    assert_eq!(mesh["view"]["from_m"], Value::Null, "the level was given");
    assert_eq!(made["written"], serde_json::json!(["mix.png"]));
    let picture = std::fs::read(here.join("mix.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    let found = json(&here, &["inspect", "mix.glb"]);
    assert_eq!(found["mesh_levels"], Value::Null);
    let triangles: f64 = numbers(&found["meshes"], "triangles").iter().sum();
    assert_eq!(triangles, sum);
    assert_eq!(found["clips"].as_array().unwrap().len(), 3);
    let none = serde_json::json!({"segs": 0, "posekeys": 0, "compact": 0});
    assert_eq!(found["clips"][0]["motion_tables"], none);
    // The text says the same, and a distance alone chooses the level.
    let ran = articula(
        &here,
        &["convert", "b.glb", "far.glb", "--mesh-distance", "9"],
    );
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.out.contains("this level is kept from"), "{}", ran.out);

    let torn = [
        "convert",
        "b.glb",
        "no.glb",
        "--mesh-level",
        "face=0,rest=3",
    ];
    let line = fault(&here, 1, &torn);
    assert!(line.contains("give regions levels of 0 to 2"), "{line}");
    let line = fault(&here, 1, &["convert", human, "no.glb", "--mesh-level", "1"]);
    assert!(line.contains("no levels"), "{line}");
    assert!(!here.join("no.glb").exists());
    let alone = ["convert", "b.glb", "no.glb", "--mesh-picture", "a.png"];
    assert!(fault(&here, 2, &alone).contains("--mesh-level"));
}

#[test]
fn the_same_build_gives_the_same_bytes_and_builds_again() {
    let here = folder("mesh-levels-again");
    for out in ["a.glb", "b.glb"] {
        json(&here, &["build", word(short()), out, "--levels", "3"]);
    }
    let read = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert!(read("a.glb") == read("b.glb"));
    // An asset is a character file: it can be built again with other levels.
    let built = json(&here, &["build", "a.glb", "c.glb", "--targets", "100,40"]);
    assert_eq!(built["levels"].as_array().unwrap().len(), 2);
    let found = json(&here, &["inspect", "c.glb"]);
    assert_eq!(found["mesh_levels"]["levels"].as_array().unwrap().len(), 2);
    assert_eq!(found["warnings"], serde_json::json!([]));
}

#[test]
fn a_character_without_a_mesh_has_nothing_to_simplify() {
    let here = folder("mesh-levels-none");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let ran = articula(&here, &["build", "a.bvh", "a.glb", "--levels", "5"]);
    assert_eq!(ran.status, 1, "{}", ran.out);
    assert!(ran.err.contains("no mesh"), "{}", ran.err);
}
