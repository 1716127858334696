//! `crowd` behaves as documented in `docs/commands.md`.

use crate::program::{BVH, articula, fault, folder, json, prepared, small, word};
use serde_json::Value;
use std::path::Path;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// A crowd of the reference human, short enough for a test.
fn crowd(name: &str, words: &[&str]) -> Value {
    crowd_of(prepared(), name, words)
}

/// The first words of a command that plays thirty of the human for a moment.
fn thirty() -> [&'static str; 6] {
    let human = word(prepared());
    ["crowd", human, "--count", "30", "--seconds", "0.1"]
}

fn crowd_of(character: &Path, name: &str, words: &[&str]) -> Value {
    let here = folder(name);
    let mut all = vec!["crowd", word(character), "--seconds", "0.2"];
    all.extend(words);
    json(&here, &all)
}

#[test]
fn promised_fields_are_there() {
    let found = crowd("crowd-fields", &["--count", "200"]);
    assert_eq!(found["characters"], 200);
    assert_eq!(found["frames"], 12);
    // The whole frame comes first, with numbers that the report has in full below.
    assert_eq!(found.as_object().unwrap().keys().next().unwrap(), "frame");
    for (field, same) in [
        ("ms", &found["frame_ms"]["median"]),
        ("triangles", &found["renderer"]["triangles"]),
        ("draws", &found["renderer"]["draw_groups"]),
        ("error_p95_px", &found["error_px"]["p95"]),
        ("error_near_px", &found["error_px"]["near_max"]),
        ("worst_vertex_px", &found["error_px"]["worst_vertex"]),
    ] {
        assert_eq!(&found["frame"][field], same, "{field}");
    }
    let written = 1e6 * number(&found["written_mb"]["median"]);
    assert_eq!(number(&found["frame"]["bytes"]), written);
    for (group, fields) in [
        ("ns_per_character", &["median", "p95"][..]),
        ("error_px", &["p95", "max", "near_max", "worst_vertex"]),
        (
            "working_set",
            &["clips_bytes", "output_bytes", "state_bytes"],
        ),
        ("written_mb", &["median"]),
    ] {
        for field in fields {
            assert!(found[group][*field].is_number(), "{group}.{field}");
        }
    }
    assert!(number(&found["characters_per_ms"]) > 0.0);
    assert_eq!(found["budget_ms"], Value::Null);
    assert_eq!(found["overrun_p95"], Value::Null);
    let seen = ["visible", "in_cull_margin", "hidden"].map(|f| number(&found[f]));
    assert_eq!(seen.iter().sum::<f64>(), 200.0);
    let tiers = found["tiers"].as_object().unwrap();
    let shown: f64 = tiers.values().map(|t| number(&t["characters"])).sum();
    assert!((shown - seen[0]).abs() < 1e-9, "{shown} of {}", seen[0]);
    // Every character has its own palette, or a draw of a cached one.
    let palettes = |t: &Value| 48.0 * number(&t["matrices"]) * number(&t["poses"]);
    let bytes = |t: &Value| palettes(t) + 8.0 * number(&t["steps"]);
    let bytes: f64 = tiers.values().map(bytes).sum();
    assert!((bytes / 1e6 - number(&found["written_mb"]["median"])).abs() < 1e-6);
}

#[test]
fn full_detail_is_without_error_and_auto_within_its_tolerance() {
    let full = crowd("crowd-full", &["--count", "100", "--level", "full"]);
    assert_eq!(
        (&full["visible"], &full["hidden"]),
        (&100.into(), &0.into())
    );
    let tiers = full["tiers"].as_object().unwrap();
    assert_eq!(tiers.len(), 1);
    assert_eq!(tiers["level_0"]["joints"], 89);
    // Rounding of f32 at 0.5 m and more: a thousandth of a pixel.
    let worst = number(&full["error_px"]["worst_vertex"]);
    assert!(worst < 0.05, "{worst}");
    let auto = crowd("crowd-auto", &["--count", "400"]);
    let p95 = number(&auto["error_px"]["p95"]);
    assert!(p95 > 0.0 && p95 <= 1.0, "{p95}");
    let near = number(&auto["error_px"]["near_max"]);
    assert!(near <= 2.0, "{near}");
    assert!(
        number(&auto["written_mb"]["median"]) < 0.5 * number(&full["written_mb"]["median"]) * 4.0
    );
}

#[test]
fn a_named_level_keeps_what_it_names() {
    let words = ["--count", "50", "--level", "loa(Low)"];
    let found = crowd("crowd-named", &words);
    let tiers = found["tiers"].as_object().unwrap();
    assert_eq!(tiers.keys().collect::<Vec<_>>(), ["level_1"]);
    // The ten joints of Low with their ancestors among the 89 joints of the standard: both
    // shoulders, elbows and wrists hang at the end of the whole spine.
    assert_eq!(number(&tiers["level_1"]["joints"]), 39.0);
}

#[test]
fn threads_and_repetition_change_no_bit() {
    let hash = |name: &str, more: &[&str]| {
        let usual = ["--count", "300", "--scene", "plaza-2"];
        let found = crowd_of(small(), name, &[&usual[..], more].concat());
        found["palette_hash"].as_str().unwrap().to_owned()
    };
    let one = hash("crowd-one", &[]);
    assert_eq!(one, hash("crowd-three", &["--threads", "3"]));
    assert_ne!(one, hash("crowd-seed", &["--seed", "2"]));
    let records = hash("crowd-records", &["--source", "records"]);
    let records_2 = ["--source", "records", "--threads", "2"];
    assert_eq!(records, hash("crowd-records-2", &records_2));
}

#[test]
fn cached_poses_stay_within_the_tolerance() {
    let play = |how: &str| {
        let name = format!("crowd-cache-{how}");
        crowd(&name, &["--count", "2000", "--source", how])
    };
    let (cpu, gpu) = (play("auto"), play("records"));
    for found in [&cpu, &gpu] {
        assert!(number(&found["poses"]["cached"]) > 0.0);
        assert!(number(&found["working_set"]["cache_bytes"]) > 0.0);
        let p95 = number(&found["error_px"]["p95"]);
        assert!(p95 <= 1.0, "{p95}");
    }
    // Neither palettes blended by the GPU nor cached ones that are shown as they are are written.
    let own = |tier: &Value| 48.0 * number(&tier["matrices"]) * number(&tier["characters"]);
    for found in [&cpu, &gpu] {
        let tiers = found["tiers"].as_object().unwrap();
        let all_own: f64 = tiers.values().map(own).sum();
        let written = 1e6 * number(&found["written_mb"]["median"]);
        assert!(written < 0.5 * all_own, "{written} of {all_own}");
    }
    let stepped = |found: &Value| number(&found["poses"]["stepped"]);
    assert_eq!(stepped(&gpu), 0.0);
    let steps = number(&cpu["renderer"]["step_bytes"]);
    assert!(stepped(&cpu) > 100.0 && (steps - 8.0 * stepped(&cpu)).abs() < 1e-6);
    let wrong = fault(
        &folder("crowd-cache-full"),
        2,
        &[
            "crowd",
            word(prepared()),
            "--source",
            "records",
            "--level",
            "full",
        ],
    );
    assert!(wrong.contains("--level auto"), "{wrong}");
}

#[test]
fn a_clip_that_travels_is_played_on_the_spot() {
    let here = folder("crowd-travel");
    // 3 m in a second, keyed on the hips only.
    let mut walk = BVH[..BVH.find("Frames").unwrap()].to_owned();
    walk.push_str("Frames: 31\nFrame Time: 0.0333333\n");
    for frame in 0..31 {
        walk.push_str(&format!(
            "0 90 {} 0 0 0 0 5 0 0 10 0 20 0 0 30 0 0\n",
            10 * frame
        ));
    }
    std::fs::write(here.join("walk.bvh"), walk).unwrap();
    std::fs::write(here.join("arm.bvh"), BVH).unwrap();
    let play = |file: &str| {
        let words = ["crowd", file, "--read", "unit-metres=0.01"];
        let more = ["--count", "20", "--seconds", "0.1"];
        json(&here, &[&words[..], &more].concat())
    };
    assert_eq!(
        play("walk.bvh")["clips_in_place"].as_array().unwrap().len(),
        1
    );
    assert_eq!(
        play("arm.bvh")["clips_in_place"].as_array().unwrap().len(),
        0
    );
}

#[test]
fn a_budget_is_reported() {
    // Far more than any machine needs, and less than any clock can measure.
    let play = |name, budget| crowd_of(small(), name, &["--count", "200", "--budget-ms", budget]);
    let rich = play("crowd-rich", "500");
    let poor = play("crowd-poor", "0.000001");
    for found in [&rich, &poor] {
        assert!(number(&found["overrun_p95"]) >= 0.0);
        assert!(number(&found["budget"]["worst_px"]) >= 0.0);
    }
    assert_eq!(rich["budget_ms"], 500.0);
    let budget = &rich["budget"];
    assert!(number(&budget["expected_ms"]) <= 500.0);
    assert_eq!(budget["overloaded"], 0);
    assert_eq!(budget["tolerance_px"]["median"], 1.0);
    assert_eq!(budget["budget_satisfied"], true);
    assert_eq!(budget["sacrificed"]["pixels"], 0);
    // Nothing is affordable: what would fit is told, and frames are above the cap.
    assert!(number(&poor["budget"]["overloaded"]) > 0.0);
    assert!(number(&poor["budget"]["worst_px"]) > 1.0);
    assert_eq!(poor["budget"]["budget_satisfied"], false);
    assert_eq!(poor["budget"]["sacrificed"]["time"], poor["frames"]);
    assert!(number(&poor["budget"]["floor_ms"]) > 0.0);
    assert!(number(&poor["budget"]["near_px"]) <= 2.0);
    assert!(number(&poor["overrun_p95"]) > 0.0);
    let wrong = articula(
        &folder("crowd-budget-full"),
        &[
            "crowd",
            word(prepared()),
            "--budget-ms",
            "1",
            "--level",
            "full",
        ],
    );
    assert_eq!(wrong.status, 2, "{}", wrong.err);
}

#[test]
fn a_saved_scene_plays_the_same() {
    let here = folder("crowd-scene");
    let words = |scene: &'static str| {
        vec![
            "crowd",
            word(prepared()),
            "--scene",
            scene,
            "--seconds",
            "0.1",
        ]
    };
    let mut first = words("plaza-2");
    first.extend(["--count", "60", "--save-scene", "square.json"]);
    let first = json(&here, &first);
    let again = json(&here, &words("square.json"));
    assert_eq!(again["characters"], 60);
    // Converting to degrees and back costs the last digit of a yaw; visibility stays the same.
    assert_eq!(again["visible"], first["visible"]);
    let few = json(
        &here,
        &[words("square.json"), vec!["--count", "5"]].concat(),
    );
    assert_eq!(few["characters"], 5);
    let many = fault(
        &here,
        2,
        &[words("square.json"), vec!["--count", "61"]].concat(),
    );
    assert!(many.contains("60 characters"), "{many}");
}

#[test]
fn plots_and_pictures_are_written() {
    let here = folder("crowd-files");
    let words = thirty();
    let more = ["--plot", "time.svg", "--picture", "crowd.png"];
    let found = json(&here, &[&words[..], &more].concat());
    assert_eq!(found["written"].as_array().unwrap().len(), 2);
    let svg = std::fs::read_to_string(here.join("time.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("Error of the crowd"));
    let png = std::fs::read(here.join("crowd.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && png.len() > 5000);
    let wrong = fault(&here, 2, &[&words[..], &["--plot", "time.png"]].concat());
    assert!(wrong.contains("name a .svg file"), "{wrong}");
}

#[test]
fn buffers_are_written_with_what_they_hold() {
    let here = folder("crowd-buffers");
    let words = thirty();
    let more = ["--buffers", "frame", "--source", "records"];
    let all = [&words[..], &more].concat();
    let found = json(&here, &all);
    assert_eq!(found["written"].as_array().unwrap().len(), 10);
    let text = std::fs::read_to_string(here.join("frame/crowd.json")).unwrap();
    let manifest: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&manifest["version"], &manifest["form"]),
        (&2.into(), &"matrix".into())
    );
    for (name, bytes) in manifest["bytes"].as_object().unwrap() {
        let file = here.join("frame").join(name).metadata().unwrap();
        assert_eq!(file.len(), bytes.as_u64().unwrap(), "{name}");
    }
    let count = |list: &str| manifest[list]["count"].as_u64().unwrap();
    assert!(count("records") > 0);
    // A fixed camera: whoever is seen at first is seen later, and those in the margin are evaluated.
    let seen = ["visible", "in_cull_margin"].map(|f| found[f].as_u64().unwrap());
    assert_eq!(count("draws") + count("records"), seen.iter().sum::<u64>());
    let again = fault(&here, 1, &all);
    assert!(again.contains("exists and is kept"), "{again}");
    // Palettes of the skin whatever the level; other bytes over the first ones.
    let full = ["--buffers", "frame", "--level", "full", "--force"];
    let other = [&words[..], &full].concat();
    assert_eq!(json(&here, &other)["palette"], "skin");
    std::fs::write(here.join("file"), "").unwrap();
    let no_folder = [&words[..], &["--buffers", "file"]].concat();
    let why = fault(&here, 2, &no_folder);
    assert!(why.contains("name a folder"), "{why}");
}

#[test]
fn figures_without_mesh_or_motion_play() {
    let here = folder("crowd-bare");
    std::fs::write(here.join("arm.bvh"), BVH).unwrap();
    // One joint, and a clip of one frame.
    let one = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 90 0\n CHANNELS 3 Zrotation Xrotation Yrotation\n \
               End Site\n {\n OFFSET 0 60 0\n }\n}\nMOTION\nFrames: 1\nFrame Time: 0.033\n10 0 0\n";
    std::fs::write(here.join("one.bvh"), one).unwrap();
    for file in ["arm.bvh", "one.bvh"] {
        let words = ["crowd", file, "--count", "40", "--seconds", "0.1"];
        let found = json(&here, &words);
        assert_eq!(found["characters"], 40, "{file}");
        let p95 = number(&found["error_px"]["p95"]);
        assert!(p95 <= 1.0, "{file}: {p95}");
        assert_eq!(number(&found["renderer"]["skinned_vertices"]), 0.0);
        let warnings = found["warnings"].to_string();
        assert!(warnings.contains("no mesh"), "{warnings}");
    }
    let drawn = fault(
        &here,
        1,
        &["crowd", "arm.bvh", "--count", "4", "--picture", "x.png"],
    );
    assert!(drawn.contains("arm.bvh: no mesh"), "{drawn}");
}

#[test]
fn coarser_meshes_go_with_coarser_joints_and_stay_within_the_tolerance() {
    let play = |name, more: &[&str]| crowd(name, &[&["--count", "1500"], more].concat());
    let plain = play("crowd-mesh-1", &["--mesh-levels", "1"]);
    let found = play("crowd-mesh-5", &["--mesh-levels", "5"]);
    let sums = |found: &Value| {
        let all = &found["renderer"];
        ["triangles", "triangles_full", "skinned_vertices"].map(|f| number(&all[f]))
    };
    let [drawn, full, vertices] = sums(&plain);
    assert_eq!(drawn, full, "everyone has the original");
    let [coarse, same, fewer] = sums(&found);
    assert!((same - full).abs() < 1e-6 * full, "the same characters");
    assert!(
        coarse < 0.7 * drawn && fewer < 0.7 * vertices,
        "{coarse} of {drawn}"
    );
    let p95 = number(&found["error_px"]["p95"]);
    assert!(p95 <= 1.0, "{p95}");
    let mut last = [f64::INFINITY; 3];
    for tier in found["tiers"].as_object().unwrap().values() {
        let size = ["joints", "triangles", "influences"].map(|f| number(&tier[f]));
        let (bound, seen) = (number(&tier["error_bound_px"]), &tier["error_px"]["p95"]);
        assert!(bound <= 1.0 + 1e-3, "{tier}");
        assert!(seen.is_null() || number(seen) <= 1.2, "{tier}");
        assert!(size.iter().zip(&last).all(|(a, b)| a <= b), "{tier}");
        last = size;
    }
    let again = play(
        "crowd-mesh-again",
        &["--mesh-levels", "5", "--threads", "2"],
    );
    assert_eq!(again["palette_hash"], found["palette_hash"]);
    let cached = play(
        "crowd-mesh-cache",
        &["--mesh-levels", "5", "--source", "records"],
    );
    assert!(number(&cached["error_px"]["p95"]) <= 1.0);
    let wrong = fault(
        &folder("crowd-mesh-full"),
        2,
        &[
            "crowd",
            word(prepared()),
            "--mesh-levels",
            "2",
            "--level",
            "full",
        ],
    );
    assert!(wrong.contains("--level auto"), "{wrong}");
}

#[test]
fn mistakes_are_answered_with_their_mend() {
    let here = folder("crowd-wrong");
    let with = |more: &[&'static str]| -> Vec<&str> {
        [&["crowd", word(small()), "--seconds", "0.1"], more].concat()
    };
    for (status, words, part) in [
        (2, ["--clip", "fly"], "the file has \"idle\""),
        (2, ["--level", "loa(Lowest)"], "Lowest"),
        (2, ["--scene", "piazza"], "plaza-2-in-step"),
        (1, ["--scene", "gone.json"], "does not exist"),
        (1, ["--camera-path", "gone.json"], "does not exist"),
    ] {
        let found = fault(&here, status, &with(&words));
        assert!(found.contains(part), "{words:?}: {found}");
    }
    for words in [
        ["--count", "0"],
        ["--count", "1e9"],
        ["--threads", "0"],
        ["--mesh-levels", "13"],
        ["--budget-ms", "NaN"],
        ["--epsilon-px", "-1"],
    ] {
        let ran = articula(&here, &with(&words));
        assert_eq!(ran.status, 2, "{words:?}: {}", ran.err);
    }
    let member = r#"{"position": [0, 0, NaN], "clip": "idle"}"#;
    let camera = r#"[{"t": 0, "eye": [0, 1, 5], "target": [0, 1, 0]}]"#;
    let scene = format!("{{\"camera\": {camera}, \"members\": [{member}]}}");
    std::fs::write(here.join("nan.json"), scene).unwrap();
    let found = fault(&here, 1, &with(&["--scene", "nan.json"]));
    assert!(found.contains("nan.json: line 1"), "{found}");
}

#[test]
fn roles_and_walls_of_a_scene_are_played_and_reported() {
    let here = folder("crowd-roles");
    let save = [
        "--count",
        "100",
        "--seconds",
        "0.1",
        "--save-scene",
        "s.json",
    ];
    let open = json(&here, &[&["crowd", word(prepared())], &save[..]].concat());
    let text = std::fs::read_to_string(here.join("s.json")).unwrap();
    let mut scene: Value = serde_json::from_str(&text).unwrap();
    // Across the middle of the plaza, higher than anyone.
    let wall = r#"[{"centre": [0, 2, 0], "size": [60, 4, 0.2]}]"#;
    scene["walls"] = serde_json::from_str(wall).unwrap();
    std::fs::write(here.join("walled.json"), scene.to_string()).unwrap();
    let walled = ["crowd", word(prepared()), "--scene", "walled.json"];
    let play = |more: &[&str]| json(&here, &[&walled[..], &["--seconds", "0.1"], more].concat());
    let found = play(&["--role", "main=0-99"]);
    let occluded = number(&found["occluded"]);
    assert!(occluded > 0.2 * number(&open["visible"]), "{occluded}");
    assert_eq!(
        number(&found["visible"]) + occluded,
        number(&open["visible"])
    );
    let role = &found["roles"][0];
    assert_eq!(
        (&role["role"], &role["importance"]),
        (&"main".into(), &4.0.into())
    );
    // A quarter of the tolerance.
    assert!(number(&role["p95_px"]) <= 0.25, "{role}");
    let all = play(&["--hiders", "none"]);
    assert_eq!(
        (&all["occluded"], &all["visible"]),
        (&0.into(), &open["visible"])
    );
    assert_eq!(all["roles"].as_array().unwrap().len(), 0);
    for (flag, value, says) in [
        ("--role", "main=100", "0 to 99"),
        ("--role", "king=1", "\"audience\""),
    ] {
        let words = [&walled[..], &[flag, value]].concat();
        let wrong = fault(&here, 2, &words);
        assert!(wrong.contains(says), "{flag} {value}: {wrong}");
    }
    let ran = articula(&here, &[&walled[..], &["--role", "main=5-3"]].concat());
    assert_eq!(ran.status, 2, "{}", ran.err);
    assert!(ran.err.contains("above the last"), "{}", ran.err);
}

#[test]
fn several_characters_share_a_scene_that_can_be_saved() {
    let here = folder("crowd-cast");
    std::fs::write(here.join("walker.bvh"), BVH).unwrap();
    let path = r#"[{"t": 0, "eye": [9, 2, 9], "target": [0, 1, 0]}]"#;
    std::fs::write(here.join("side.json"), path).unwrap();
    let usual = ["--count", "60", "--seconds", "0.1"];
    let views = ["--camera-path", "side.json", "--camera-path", "side.json"];
    let files = ["crowd", word(prepared()), "walker.bvh", "walker.bvh"];
    let save = ["--save-scene", "sub/s.json", "--buffers", "out"];
    std::fs::create_dir_all(here.join("sub")).unwrap();
    let made = json(&here, &[&files[..], &usual, &views, &save].concat());
    assert_eq!(
        (&made["characters"], &made["views"]),
        (&60.into(), &2.into())
    );
    let cast = made["cast"].as_array().unwrap();
    let names: Vec<_> = cast.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names[1..], ["walker", "walker-2"]);
    let all: f64 = cast.iter().map(|c| number(&c["characters"])).sum();
    assert_eq!(all, 60.0);
    let shown = cast
        .iter()
        .flat_map(|c| c["tiers"].as_object().unwrap().values());
    let shown: f64 = shown.map(|t| number(&t["characters"])).sum();
    assert!((shown - number(&made["visible"])).abs() < 1e-9);
    for name in names {
        assert!(
            here.join("out").join(name).join("crowd.json").is_file(),
            "{name}"
        );
    }
    // The saved scene names its characters by files relative to its folder or absolute ones.
    let played = json(
        &here,
        &["crowd", "--scene", "sub/s.json", "--seconds", "0.1"],
    );
    assert_eq!(played["palette_hash"], made["palette_hash"]);
    assert_eq!(played["views"], 2);
    let of_each = |run: &Value| -> Vec<[Value; 3]> {
        let cast = run["cast"].as_array().unwrap().iter();
        cast.map(|c| ["name", "characters", "clips"].map(|f| c[f].clone()))
            .collect()
    };
    assert_eq!(of_each(&played), of_each(&made));
    for (words, says) in [
        (
            &["crowd", word(prepared()), "--scene", "sub/s.json"][..],
            "names its characters",
        ),
        (&["crowd", "--count", "9"], "no character"),
    ] {
        let found = fault(&here, 2, words);
        assert!(found.contains(says), "{found}");
    }
    let gone = std::fs::read_to_string(here.join("sub/s.json")).unwrap();
    let gone = gone.replace("walker.bvh", "gone.bvh");
    std::fs::write(here.join("sub/gone.json"), gone).unwrap();
    let found = fault(&here, 1, &["crowd", "--scene", "sub/gone.json"]);
    assert!(found.contains("gone.bvh"), "{found}");
}
