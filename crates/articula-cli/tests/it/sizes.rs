//! Figures of any size: the unit of a file can be given for every format, sizes of no human are
//! told, and crowds are as exact for a giant as for an adult.

use crate::program::{articula, folder, human, json, small, word};
use serde_json::Value;

fn height(found: &Value) -> f64 {
    found["height_m"].as_f64().unwrap()
}

fn warnings(found: &Value) -> String {
    found["warnings"].to_string()
}

#[test]
fn the_unit_can_be_given_for_every_format() {
    let here = folder("units");
    let adult = json(&here, &["inspect", word(human())]);
    for name in ["a.glb", "a.x3d", "a.bvh", "a.asf", "a.bap"] {
        let ran = articula(&here, &["convert", word(human()), name, "--clip", "walk"]);
        assert_eq!(ran.status, 0, "{name}: {}", ran.err);
        let own = height(&json(&here, &["inspect", name, "--read", "unit-metres=1"]));
        let half = json(&here, &["inspect", name, "--read", "unit-metres=0.5"]);
        assert!(
            (height(&half) / own - 0.5).abs() < 1e-3,
            "{name}: {own} {half}"
        );
    }
    // A document keeps the size that it was given, and everything else.
    let big = json(
        &here,
        &[
            "convert",
            word(human()),
            "big.glb",
            "--read",
            "unit-metres=12",
        ],
    );
    assert_eq!(big["clips"].as_array().unwrap().len(), 3);
    let big = json(&here, &["inspect", "big.glb"]);
    assert!((height(&big) / height(&adult) - 12.0).abs() < 1e-3);
    json(
        &here,
        &[
            "convert",
            "big.glb",
            "back.glb",
            "--read",
            "unit-metres=0.083333333",
        ],
    );
    let back = json(&here, &["inspect", "back.glb"]);
    assert!((height(&back) / height(&adult) - 1.0).abs() < 1e-3);
    for field in ["meshes", "clips"] {
        assert_eq!(
            back[field].as_array().unwrap().len(),
            adult[field].as_array().unwrap().len()
        );
    }
}

#[test]
fn sizes_that_no_human_has_are_told_with_the_flag() {
    let here = folder("told-sizes");
    for (factor, is_odd) in [("0.12", true), ("0.5", false), ("1", false), ("12", true)] {
        let unit = format!("unit-metres={factor}");
        json(&here, &["convert", word(small()), "o.glb", "--read", &unit]);
        for command in ["inspect", "crowd", "build"] {
            let words: &[&str] = match command {
                "crowd" => &["crowd", "o.glb", "--count", "2", "--seconds", "0.1"],
                "build" => &["build", "o.glb", "b.glb"],
                _ => &["inspect", "o.glb"],
            };
            let told = warnings(&json(&here, words));
            assert_eq!(
                told.contains("size of no human"),
                is_odd,
                "{command} {factor}: {told}"
            );
        }
        let text = articula(&here, &["inspect", "o.glb"]).out;
        assert_eq!(text.contains("unit-metres="), is_odd, "{text}");
    }
}

#[test]
fn a_crowd_of_giants_is_as_exact_as_one_of_adults() {
    let here = folder("giants");
    let px = |level: &str| {
        let words = [
            "crowd",
            "o.glb",
            "--count",
            "200",
            "--seconds",
            "1",
            "--level",
            level,
        ];
        let found = json(&here, &words);
        ["p95", "near_max", "worst_vertex"].map(|name| found["error_px"][name].as_f64().unwrap())
    };
    for factor in ["0.1", "1", "20"] {
        let unit = format!("unit-metres={factor}");
        json(&here, &["convert", word(small()), "o.glb", "--read", &unit]);
        let [_, _, worst] = px("full");
        assert!(
            worst < 0.1,
            "{factor}: every joint is exact, but {worst} px"
        );
        let [p95, near, _] = px("auto");
        assert!(p95 <= 1.0 && near <= 2.0, "{factor}: {p95} {near}");
    }
}
