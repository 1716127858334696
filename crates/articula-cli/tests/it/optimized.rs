//! `optimize`: what it prints and writes, and how three.js and the Khronos validator read it.

use crate::judges::{ask, judges_are_here};
use crate::program::{fault, folder, json, short};
use std::path::Path;

#[test]
fn an_optimised_file_is_judged_by_others() {
    let folder = folder("optimized");
    let source = short().to_string_lossy().into_owned();
    let report = json(
        &folder,
        &["optimize", &source, "small.glb", "--error", "1mm"],
    );
    let number = |name: &str| report[name].as_f64().unwrap();
    assert!(number("bytes_out") < 0.55 * number("bytes_in"), "{report}");
    assert!(number("error_mm") <= 1.0);
    let small = folder.join("small.glb");
    assert_eq!(
        std::fs::metadata(&small).unwrap().len() as f64,
        number("bytes_out")
    );
    judged(&source, &small, "1");
}

/// Lets the Khronos validator and three.js judge a file beside its source, within an error in millimetres.
fn judged(source: &str, made: &Path, error_mm: &str) {
    if !judges_are_here() {
        return;
    }
    let made = made.to_string_lossy().into_owned();
    let (verdict, good) = ask("validate.mjs", std::slice::from_ref(&made));
    assert!(good, "{verdict}");
    let (answer, good) = ask("optimised.mjs", &[source.to_owned(), made, error_mm.into()]);
    assert!(good, "{answer}");
}

#[test]
fn integers_without_compression_are_judged_by_others() {
    let folder = folder("quantized");
    let source = short().to_string_lossy().into_owned();
    let of = |kind: &str| {
        let out = format!("{kind}.glb");
        let words = [
            "optimize",
            &source,
            &out,
            "--error",
            "1mm",
            "--compress",
            kind,
        ];
        json(&folder, &words)["bytes_out"].as_f64().unwrap()
    };
    assert!(of("quantize") < of("none"));
    judged(&source, &folder.join("quantize.glb"), "1");
}

#[test]
fn an_asset_can_be_built_of_what_is_left() {
    let folder = folder("built-lighter");
    let source = short().to_string_lossy().into_owned();
    let plain = json(&folder, &["build", &source, "plain.glb"]);
    let report = json(&folder, &["build", &source, "asset.glb", "--optimize=4mm"]);
    let first = &report["optimized"];
    assert!(first["error_mm"].as_f64().unwrap() <= 4.0, "{report}");
    assert!(first["triangles_out"].as_u64() < first["triangles_in"].as_u64());
    assert!(report["bytes_out"].as_u64() < plain["bytes_out"].as_u64());
    assert_eq!(report["bytes_in"], plain["bytes_in"]);
    assert!(plain["optimized"].is_null());
    // What was prepared belongs to what was written.
    let checked = json(&folder, &["build", "--check", "asset.glb"]);
    assert_eq!(checked["is_whole"], true, "{checked}");
}

#[test]
fn a_simplified_file_is_judged_by_others_and_joints_can_be_held() {
    let folder = folder("simplified");
    let source = short().to_string_lossy().into_owned();
    let coarse = [
        "optimize",
        &source,
        "coarse.glb",
        "--error",
        "8mm",
        "--lock",
        "hands",
    ];
    let report = json(&folder, &coarse);
    let number = |name: &str| report[name].as_f64().unwrap();
    assert!(
        number("triangles_out") < 0.95 * number("triangles_in"),
        "{report}"
    );
    assert!(number("surface_error_mm") > 1.0 && number("error_mm") <= 8.0);
    let held = [
        "optimize",
        &source,
        "held.glb",
        "--loa",
        "loa(VeryLow)",
        "--no-simplify",
        "--no-keys",
    ];
    let held = json(&folder, &held);
    assert!(held["joints"]["joints_active"].as_u64() < held["joints"]["joints"].as_u64());
    judged(&source, &folder.join("coarse.glb"), "8");
}

#[test]
fn a_file_with_fewer_joints_is_valid_and_tells_their_error() {
    let folder = folder("fewer-joints");
    let source = short().to_string_lossy().into_owned();
    let few = ["optimize", &source, "few.glb", "--max-joints", "24"];
    let report = json(&folder, &few);
    let merged = &report["merged_joints"];
    assert_eq!(merged["joints_out"], 24, "{report}");
    let names = merged["merged"].as_array().unwrap().len() as u64;
    assert_eq!(merged["joints_in"].as_u64(), Some(24 + names));
    assert!(merged["error_mm"].as_f64() > Some(0.0));
    assert_eq!(report["fit"]["limits"]["max_joints"], 24);
    if !judges_are_here() {
        return;
    }
    let file = folder.join("few.glb").to_string_lossy().into_owned();
    let (verdict, good) = ask("validate.mjs", &[file]);
    assert!(good, "{verdict}");
}

#[test]
fn several_files_go_into_a_folder_and_what_cannot_shrink_is_kept() {
    let folder = folder("optimized-many");
    let source = short().to_string_lossy().into_owned();
    std::fs::copy(&source, folder.join("a.glb")).unwrap();
    json(&folder, &["optimize", "a.glb", "b.glb", "--error", "5mm"]);
    let report = json(
        &folder,
        &["optimize", "a.glb", "b.glb", "out/", "--error", "0.01mm"],
    );
    let files = report["files"].as_array().unwrap();
    assert_eq!(files.len(), 2);
    assert_eq!(files[0]["kept_as_it_is"], false);
    // It was stored with a hundredth of that precision.
    assert_eq!(files[1]["kept_as_it_is"], true, "{report}");
    let bytes = |name: &str| std::fs::read(folder.join(Path::new(name))).unwrap();
    assert_eq!(bytes("b.glb"), bytes("out/b.glb"));
    assert!(bytes("out/a.glb").len() < bytes("a.glb").len());
    assert_eq!(files[1]["bytes_out"], files[1]["bytes_in"]);
    assert_eq!(files[1]["error_mm"], 0.0);
    for limits in [&[][..], &["--max-triangles", "100000"]] {
        let again = ["optimize", "b.glb", "c.glb", "--error", "5mm", "--force"];
        let again = json(&folder, &[&again[..], limits].concat());
        assert_eq!(again["kept_as_it_is"], true, "{again}");
        assert_eq!(bytes("c.glb"), bytes("b.glb"));
    }
}

#[test]
fn wrong_uses_are_told() {
    let folder = folder("optimized-wrong");
    let source = short().to_string_lossy().into_owned();
    let line = fault(&folder, 2, &["optimize", &source, "out.bvh"]);
    assert!(line.contains("name the file .glb or .vrm"), "{line}");
    let line = fault(&folder, 2, &["optimize", &source, &source, "out/"]);
    assert!(line.contains("would both become"), "{line}");
    let line = fault(&folder, 1, &["optimize", "none.glb", "out.glb"]);
    assert!(line.contains("none.glb"), "{line}");
    let line = fault(
        &folder,
        2,
        &["optimize", &source, "out.glb", "--fit", "moon"],
    );
    assert!(line.contains("vrchat-quest"), "{line}");
    let line = fault(
        &folder,
        2,
        &["optimize", &source, "out.glb", "--lock", "tail"],
    );
    assert!(line.contains("materials: "), "{line}");
    let few = [
        "optimize",
        &source,
        "out.glb",
        "--no-keys",
        "--max-triangles",
        "1",
    ];
    let line = fault(&folder, 1, &few);
    assert!(line.contains("triangles: 1 allowed"), "{line}");
}

#[test]
fn clips_of_a_folder_are_put_into_one_file_or_each_into_its_own() {
    let folder = folder("optimized-library");
    let source = short().to_string_lossy().into_owned();
    std::fs::create_dir(folder.join("clips")).unwrap();
    for name in ["walk.bvh", "run.bvh"] {
        let out = format!("clips/{name}");
        json(&folder, &["convert", &source, &out]);
    }
    std::fs::write(folder.join("clips/notes.txt"), "no character").unwrap();
    let each = ["optimize", "clips", "each/", "--skin", &source];
    let each = json(&folder, &each);
    let files = each["files"].as_array().unwrap();
    assert_eq!(files.len(), 2);
    for file in files {
        let skin = &file["measured_on"]["skin"];
        assert_eq!(skin["joints_missing"], 0, "{file}");
        assert!(skin["joints"].as_u64() > Some(10), "{file}");
    }
    let one = ["optimize", "clips", "one.glb", "--together"];
    let one = json(&folder, &one);
    assert_eq!(one["measured_on"], "joints");
    let clips = one["clips"].as_array().unwrap();
    assert_eq!(clips.len(), 2, "{one}");
    let sizes: Vec<u64> = files
        .iter()
        .map(|f| f["bytes_in"].as_u64().unwrap())
        .collect();
    assert_eq!(one["bytes_in"].as_u64(), Some(sizes.iter().sum()));
    let refused = fault(&folder, 2, &["optimize", "clips", "two.glb"]);
    assert!(refused.contains("--together"), "{refused}");
    let refused = fault(&folder, 2, &["optimize", "clips", "out/", "--together"]);
    assert!(refused.contains("folder"), "{refused}");
    std::fs::create_dir(folder.join("empty")).unwrap();
    let refused = fault(&folder, 2, &["optimize", "empty", "out/"]);
    assert!(refused.contains("no character file"), "{refused}");
}

#[test]
fn what_would_be_saved_is_told_before_anything_is_written() {
    let folder = folder("savings");
    let source = short().to_string_lossy().into_owned();
    let made = json(&folder, &["optimize", &source, "small.glb"]);
    let told = json(&folder, &["inspect", &source, "--savings"]);
    let optimized = &told["optimized"];
    assert_eq!(optimized["bytes_out"], made["bytes_out"]);
    assert_eq!(optimized["error_mm"], made["error_mm"]);
    let sum = |parts: &serde_json::Value| -> u64 {
        let parts = parts.as_object().unwrap();
        parts.values().map(|bytes| bytes.as_u64().unwrap()).sum()
    };
    // Alignment and heads of chunks count as part of the document.
    let written = json(&folder, &["inspect", "small.glb"]);
    assert_eq!(written["parts"], made["after"]);
    assert!(written["optimized"].is_null());
    let (parts, bytes) = (sum(&written["parts"]), written["bytes"].as_u64().unwrap());
    assert!(parts <= bytes && parts + 64 > bytes, "{parts} of {bytes}");
    let refused = fault(&folder, 2, &["inspect", "--savings", "face.fap"]);
    assert!(refused.contains("no joints"), "{refused}");
}
