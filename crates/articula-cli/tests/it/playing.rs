//! `inspect`, `build`, `lod` and `demo` behave as documented in `docs/commands.md`.

use crate::program::{BVH, articula, fault, folder, human, json, short, small, word};
use crate::serving::{request, started};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn has(value: &Value, fields: &[&str]) {
    for field in fields {
        assert!(!value[*field].is_null(), "{field} is not in {value}");
    }
}

#[test]
fn inspect_has_its_fields() {
    let here = folder("inspect");
    let found = json(&here, &["inspect", word(human())]);
    assert_eq!(found["format"], "glb");
    let skeleton = &found["skeletons"][0];
    has(skeleton, &["joints", "mapped", "levels"]);
    let levels: Vec<u64> = skeleton["levels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|l| l.as_u64().unwrap())
        .collect();
    // The cumulative counts of the standard's levels (docs/methods/hanim.md part 3).
    assert_eq!(levels, [5, 10, 24, 35, 51, 89]);
    assert_eq!(
        (&skeleton["joints"], &skeleton["mapped"]),
        (&89.into(), &89.into())
    );
    let clip = &found["clips"][1];
    has(
        clip,
        &["name", "duration_secs", "fps", "frames", "joints_animated"],
    );
    let frames = number(&clip["duration_secs"]) * number(&clip["fps"]) + 1.0;
    assert!((number(&clip["frames"]) - frames).abs() < 0.5);
    let mesh = &found["meshes"][0];
    has(
        mesh,
        &[
            "name",
            "vertices",
            "triangles",
            "influences_max",
            "morph_targets",
            "levels",
        ],
    );
    assert_eq!(found["face"], Value::Null);
    assert!(found["warnings"].is_array());
    let height = number(&found["height_m"]);
    assert!((1.6..1.9).contains(&height), "{height}");
    assert_eq!(found["map"].as_array().unwrap().len(), 89);
}

#[test]
fn meshes_can_be_chosen() {
    let here = folder("meshes");
    let human = word(human());
    let names = |words: &[&str]| -> Vec<String> {
        let found = json(&here, &[&["inspect", human], words].concat());
        let meshes = found["meshes"].as_array().unwrap().clone();
        meshes
            .iter()
            .map(|m| m["name"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(
        names(&["--hide", "brows", "--hide", "lips"]),
        ["skin", "eyes"]
    );
    assert_eq!(names(&["--only", "eyes"]), ["eyes"]);
}

#[test]
fn bvh_counts_joints_without_end_sites() {
    let here = folder("bvh");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let found = json(&here, &["inspect", "a.bvh"]);
    assert_eq!(found["format"], "bvh");
    assert_eq!(found["skeletons"][0]["joints"], 5);
    let clip = &found["clips"][0];
    assert_eq!(
        (&clip["frames"], number(&clip["fps"]).round()),
        (&4.into(), 30.0)
    );
    assert_eq!(found["meshes"].as_array().unwrap().len(), 0);
}

#[test]
fn built_assets_carry_tables_that_must_fit() {
    let here = folder("built");
    let report = json(&here, &["build", word(short()), "a.glb", "--levels", "1"]);
    assert_eq!(report["levels"].as_array().unwrap().len(), 0);
    let found = json(&here, &["inspect", "a.glb"]);
    assert_eq!(found["articulation_stored"], true);
    for (stored, made) in found["clips"]
        .as_array()
        .unwrap()
        .iter()
        .zip(report["clips"].as_array().unwrap())
    {
        assert_eq!(stored["motion_tables"]["segs"], made["segs_bytes"]);
        assert_eq!(stored["motion_tables"]["posekeys"], made["posekeys_bytes"]);
        let keys: Vec<u64> = made["keys"]
            .as_array()
            .unwrap()
            .iter()
            .map(|k| k.as_u64().unwrap())
            .collect();
        assert!(
            keys.is_sorted_by(|a, b| a >= b),
            "coarser levels have fewer keys: {keys:?}"
        );
    }
    // Another name of a joint makes another rig.
    let mut bytes = std::fs::read(here.join("a.glb")).unwrap();
    let name = b"\"l_knee\"";
    let places: Vec<usize> = (0..bytes.len() - name.len())
        .filter(|i| bytes[*i..].starts_with(name))
        .collect();
    for place in places {
        bytes[place..place + name.len()].copy_from_slice(b"\"l_kneX\"");
    }
    std::fs::write(here.join("stale.glb"), bytes).unwrap();
    for command in ["lod", "inspect"] {
        let told = json(&here, &[command, "stale.glb"])["warnings"].to_string();
        assert!(told.contains("animations[0]"), "{told}");
        assert!(told.contains("skeleton of this file"), "{told}");
        assert!(told.contains("`articula build` renews it"), "{told}");
    }
}

#[test]
fn lod_meets_its_target_and_has_its_fields() {
    let here = folder("lod");
    let report = json(
        &here,
        &["lod", word(human()), "--clip", "walk", "--calibrate", "1"],
    );
    assert_eq!(report["method"], "skin-px");
    let rows = report["rows"].as_array().unwrap();
    let distances: Vec<f64> = rows.iter().map(|r| number(&r["distance_m"])).collect();
    for (found, wanted) in distances.iter().zip([3.5, 5.65, 9.05, 16.0, 25.6]) {
        assert!((found - wanted).abs() < 1e-5);
    }
    let mut last = -1.0;
    for row in rows {
        has(
            row,
            &[
                "joint_update_gain",
                "evaluations_saved",
                "parameter",
                "joints_sampled",
                "fk_joints",
            ],
        );
        let [p50, p95, max] = ["p50", "p95", "max"].map(|p| number(&row["error_px"][p]));
        assert!(p50 <= p95 && p95 <= max && p95 <= 1.0 + 1e-4, "{row}");
        // Farther away more is hidden by a pixel.
        let gain = number(&row["joint_update_gain"]);
        assert!(gain >= last && gain <= 1.0, "{row}");
        last = gain;
    }
    assert!(last > 0.3, "{last}");
}

#[test]
fn every_method_plays_and_parameters_reach_it() {
    let here = folder("methods");
    let human = word(human());
    let all = json(
        &here,
        &["lod", human, "--method", "all", "--distances", "9"],
    );
    let rows = all["rows"].as_array().unwrap();
    for method in [
        "skin-px",
        "thesis",
        "ahn",
        "pc",
        "skip-hold",
        "skip-lerp",
        "loa",
    ] {
        assert!(rows.iter().any(|r| r["method"] == method), "{method}");
    }
    let gain = |words: &[&str]| {
        let base = ["lod", human, "--clip", "walk", "--distances", "9"];
        number(&json(&here, &[&base, words].concat())["rows"][0]["joint_update_gain"])
    };
    // Every second frame is half of the updates; no joint is all of them.
    assert!((gain(&["--method", "skip-hold", "--parameter", "2"]) - 0.5).abs() < 1e-6);
    assert_eq!(gain(&["--method", "loa", "--loa", "loa(None)"]), 1.0);
    assert_eq!(gain(&["--method", "loa", "--loa", "loa(VeryHigh)"]), 0.0);
    // Postures as far apart as a radian are held for longer than those of a hundredth.
    let pc = |radians: &str| gain(&["--method", "pc", "--parameter", radians]);
    assert!(pc("1") > pc("0.01"));
    // Either key of a run is within the tolerance of all its frames.
    let ahn = |method: &str| gain(&["--method", method, "--parameter", "0.05"]);
    assert!(ahn("ahn") > 0.0 && ahn("ahn-least-sum") > 0.0);
    assert!(gain(&["--method", "skin-px-hull", "--parameter", "0.02"]) > 0.0);
    let thesis = |thr: &str| gain(&["--method", "thesis", "--thr-init", thr]);
    assert!(
        thesis("0.1") > thesis("0.0001"),
        "a looser threshold holds more"
    );
}

#[test]
fn the_same_words_give_the_same_bytes() {
    let here = folder("same");
    let words = |sheet: &'static str| {
        [
            "lod",
            word(human()),
            "--distances",
            "5,20",
            "--contact-sheet",
            sheet,
            "--plot",
            "p.svg",
            "--json",
            "--force",
        ]
    };
    let (a, b) = (
        articula(&here, &words("a.png")),
        articula(&here, &words("b.png")),
    );
    assert_eq!(a.out.replace("a.png", ""), b.out.replace("b.png", ""));
    let read = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert_eq!(read("a.png"), read("b.png"));
    assert!(read("a.png").starts_with(b"\x89PNG"));
    let svg = String::from_utf8(read("p.svg")).unwrap();
    assert_eq!(svg.matches("<svg").count(), svg.matches("</svg>").count());
}

#[test]
fn all_plots_go_into_a_folder() {
    let here = folder("plots");
    let words = [
        "lod",
        word(human()),
        "--distances",
        "5,20",
        "--plot",
        "plots",
    ];
    let costs = json(&here, &words)["costs"].clone();
    let levels = costs["complexities"].as_array().unwrap();
    assert_eq!(levels.len(), 7);
    let sampled: Vec<f64> = levels
        .iter()
        .map(|l| number(&l["joints_sampled"]))
        .collect();
    assert!(sampled.is_sorted() && sampled[0] == 0.0, "{sampled:?}");
    for name in [
        "gain",
        "error",
        "over-the-clip",
        "cost-by-zone",
        "cost-by-depth",
        "cost-by-complexity",
    ] {
        let svg = std::fs::read_to_string(here.join("plots").join(format!("{name}.svg"))).unwrap();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{name}");
    }
}

#[test]
fn a_moving_camera_stays_within_the_bound() {
    let here = folder("camera");
    let path = "[{\"t\":0,\"eye\":[0,1.5,25],\"target\":[0,1,0]},{\"t\":4.6,\"eye\":[0,1.5,2],\"target\":[0,1,0]}]";
    std::fs::write(here.join("p.json"), path).unwrap();
    let words = [
        "lod",
        word(human()),
        "--clip",
        "walk",
        "--camera-path",
        "p.json",
        "--contact-sheet",
        "s.png",
        "--force",
    ];
    let report = json(&here, &words);
    let camera = &report["camera_path"];
    assert!(
        number(&camera["joint_error_px_max"]) <= number(&camera["bound_px"]) + 1e-3,
        "{camera}"
    );
    assert!(number(&camera["distance_m_max"]) > 20.0 && number(&camera["distance_m_min"]) < 3.0);
    assert_eq!(report["rows"].as_array().unwrap().len(), 1);
    assert!(here.join("s.png").exists());
    let line = fault(&here, 2, &[&words[..], &["--method", "ahn"]].concat());
    assert!(line.contains("skin-px"), "{line}");
    // Every controller of the live playback moves with the camera.
    let words = &words[..6];
    let played = |more: &[&str]| json(&here, &[words, more].concat());
    let saved = |more: &[&str]| number(&played(more)["rows"][0]["joint_update_gain"]);
    let tables = played(&["--method", "skin-px-tables"]);
    assert_eq!(tables["rows"][0]["variant"], "tables");
    assert!(
        saved(&["--method", "skin-px-view"])
            >= number(&report["rows"][0]["joint_update_gain"]) - 0.05
    );
    let thesis = played(&["--method", "thesis", "--thr-init", "0.02"]);
    assert!(thesis["camera_path"]["bound_px"].is_null());
    assert!(number(&thesis["rows"][0]["joint_update_gain"]) > 0.0);
    let rarely = [
        "--method",
        "thesis",
        "--thr-init",
        "0.02",
        "--thesis",
        "lookup-every=30",
    ];
    assert_ne!(
        saved(&rarely),
        number(&thesis["rows"][0]["joint_update_gain"])
    );
    assert_eq!(saved(&["--loa", "loa(None)"]), 1.0);
    for words in [
        &["--method", "thesis", "--calibrate", "1"][..],
        &["--method", "loa", "--parameter", "9"],
        &["--thesis", "lookup-every=0"],
    ] {
        let all = [
            &["lod", word(human()), "--camera-path", "p.json"][..],
            words,
        ]
        .concat();
        assert_eq!(articula(&here, &all).status, 2, "{words:?}");
    }
}

/// Changes of level are reported with every kind of transition, and drawn.
#[test]
fn a_schedule_of_levels_is_played_reported_and_drawn() {
    let here = folder("schedule");
    let list = r#"[{"t": 0.5, "level": 5}, {"t": 1.0, "loa": "loa(High) + zone(hands)"}, {"t": 1.5, "loa": "loa(None)"}]"#;
    std::fs::write(here.join("s.json"), list).unwrap();
    let words = [
        "lod",
        word(human()),
        "--clip",
        "walk",
        "--schedule",
        "s.json",
    ];
    let report = json(&here, &[&words[..], &["--plot", "plots"]].concat());
    let played = report["schedule"].as_array().unwrap();
    let kinds: Vec<&str> = played
        .iter()
        .map(|p| p["transition"].as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["smooth", "linear", "none"]);
    let jump = |kind: usize, change: usize| number(&played[kind]["changes"][change]["jump_deg"]);
    assert!(jump(0, 1) < 0.5 * jump(2, 1) && jump(1, 1) < 0.5 * jump(2, 1));
    let change = &played[0]["changes"][0];
    assert_eq!(change["level"], "5: loa(VeryLow)");
    assert!(number(&change["error_px"]["after"]) > number(&change["error_px"]["before"]));
    assert_eq!(number(&played[0]["changes"][2]["joints"]), 0.0);
    // Frames up to a second after the last transition, at 60 Hz.
    assert_eq!(played[0]["frames"].as_array().unwrap().len(), 163);
    for name in ["schedule-error", "schedule-joints", "schedule-jump"] {
        let svg = std::fs::read_to_string(here.join("plots").join(format!("{name}.svg"))).unwrap();
        let lines = ["smooth transition", "linear transition", "no transition"];
        assert!(lines.iter().all(|line| svg.contains(line)), "{name}");
    }
    // A device that allows level 4 at most starts there.
    let capped = json(
        &here,
        &[
            &words[..],
            &["--finest-level", "4", "--thesis", "transition=linear"],
        ]
        .concat(),
    );
    let capped = &capped["schedule"][0];
    assert_eq!(capped["transition"], "linear");
    let joints = |report: &Value, frame: usize| number(&report["frames"][frame]["joints"]);
    assert!(joints(capped, 0) < joints(&played[0], 0));
    std::fs::write(here.join("bad.json"), r#"[{"t": 0, "loa": "joint(tail)"}]"#).unwrap();
    let bad = ["lod", word(human()), "--schedule", "bad.json"];
    let line = fault(&here, 1, &bad);
    assert!(line.contains("[0].loa") && line.contains("tail"), "{line}");
    let both = [&words[..], &["--camera-path", "s.json"]].concat();
    assert_eq!(articula(&here, &both).status, 2);
}

/// A profile that is not manual bounds what a metric may choose.
#[test]
fn a_profile_that_is_not_manual_bounds_the_metric() {
    let here = folder("bounded");
    let profile = |manual: bool, complexity: &str| {
        let text = format!(r#"{{"manual": {manual}, "complexity": "{complexity}"}}"#);
        std::fs::write(here.join("p.json"), text).unwrap();
    };
    let words = ["lod", word(human()), "--clip", "walk", "--distances", "3.5"];
    let row = |more: &[&str]| json(&here, &[&words[..], more].concat())["rows"][0].clone();
    profile(false, "Low");
    let bounded = row(&["--loa-profile", "p.json"]);
    assert_eq!(bounded["method"], "skin-px");
    let free = row(&[]);
    assert!(number(&bounded["joints_sampled"]) < number(&free["joints_sampled"]));
    let thesis = row(&["--loa-profile", "p.json", "--method", "thesis"]);
    profile(true, "Low");
    let decided = row(&["--loa-profile", "p.json"]);
    assert_eq!(decided["method"], "loa");
    // What the metric may choose is at most what the selection alone moves.
    for chosen in [&bounded, &thesis] {
        assert!(number(&chosen["joints_sampled"]) <= number(&decided["joints_sampled"]));
        assert!(number(&chosen["error_px"]["p95"]) >= 0.99 * number(&decided["error_px"]["p95"]));
    }
    let refused = [
        &words[..],
        &["--loa-profile", "p.json", "--method", "thesis"],
    ]
    .concat();
    assert!(fault(&here, 2, &refused).contains("manual"));
    profile(false, "VeryHigh");
    assert_eq!(
        row(&["--loa-profile", "p.json"])["error_px"],
        free["error_px"]
    );
}

#[test]
fn without_a_clip_the_rest_pose_is_shown_and_said() {
    let here = folder("still");
    let still = BVH.split("MOTION").next().unwrap();
    std::fs::write(here.join("a.bvh"), still).unwrap();
    let report = json(&here, &["lod", "a.bvh", "--contact-sheet", "s.png"]);
    assert_eq!(report["rows"].as_array().unwrap().len(), 0);
    assert!(report["warnings"][0].as_str().unwrap().contains("no clip"));
    assert!(here.join("s.png").exists());
    let line = fault(&here, 1, &["lod", "a.bvh", "--plot", "p.svg"]);
    assert!(line.contains("no clip"), "{line}");
}

/// What `lod` writes as a profile selects the same joints in `lod` and in `convert`.
#[test]
fn a_saved_selection_is_the_level_that_was_played() {
    let here = folder("lod-selection");
    let human = word(human());
    let lod = |more: &[&str]| {
        let words = ["lod", human, "--clip", "walk", "--distances", "5"];
        json(&here, &[&words[..], more].concat())
    };
    let expression = ["--loa", "loa(Low) + zone(hands)", "--with-ancestors"];
    let played = lod(&[&expression[..], &["--write", "loa-profile=p.json"]].concat());
    assert_eq!(played["written"][0], "p.json");
    let again = lod(&["--loa-profile", "p.json"]);
    let figures = |report: &Value| {
        let row = &report["rows"][0];
        ["joint_update_gain", "joints_sampled", "error_px"].map(|f| row[f].clone())
    };
    assert_eq!(figures(&again), figures(&played));
    assert!(number(&played["rows"][0]["joint_update_gain"]) > 0.0);
    let convert = |words: &[&str]| {
        let report = json(&here, &[&["convert", human, "o.glb"][..], words].concat());
        report["reduction"]["joints_active"].clone()
    };
    let active = convert(&["--loa-profile", "p.json"]);
    assert_eq!(active, convert(&expression));
    assert!(number(&active) > 40.0, "{active}");
    // No joint at all is a selection, too.
    lod(&["--loa", "loa(None)", "--write", "loa-profile=none.json"]);
    let still = lod(&["--loa-profile", "none.json"]);
    assert_eq!(number(&still["rows"][0]["joint_update_gain"]), 1.0);

    for words in [
        &["--write", "loa-profile=q.json"][..],
        &["--with-ancestors"],
        &["--loa", "loa(Low)", "--loa-profile", "p.json"],
    ] {
        let all = [&["lod", human][..], words].concat();
        assert_eq!(articula(&here, &all).status, 2, "{words:?}");
    }
    assert!(!here.join("q.json").exists());
    std::fs::write(here.join("bad.json"), r#"{"joints": {"plus": ["tail"]}}"#).unwrap();
    let line = fault(&here, 1, &["lod", human, "--loa-profile", "bad.json"]);
    assert!(line.contains("bad.json") && line.contains("tail"), "{line}");
}

#[test]
fn a_demo_of_a_character_without_clips_says_what_to_add() {
    let here = folder("demo-still");
    let Some(woman) = crate::real::file("glb/Quaternius_modular_women__Casual.glb") else {
        return;
    };
    let line = fault(&here, 1, &["demo", word(&woman), "--out", "d"]);
    assert!(line.contains("Casual.glb: the file has no clip"), "{line}");
    assert!(!here.join("d").exists());
}

#[test]
fn the_demo_tells_the_numbers_that_it_computed() {
    let here = folder("demo");
    // Every step runs whatever the character is; the human itself takes ten times as long.
    let cut = ["convert", word(small()), "a.glb", "--clip", "walk"];
    json(&here, &cut);
    let ran = articula(&here, &["demo", "a.glb", "--out", "d"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.out.trim_end().ends_with("index.html"), "{}", ran.out);
    let page = std::fs::read_to_string(here.join("d/index.html")).unwrap();
    let report = std::fs::read_to_string(here.join("d/report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    for method in report["methods"].as_array().unwrap() {
        for row in method["rows"].as_array().unwrap() {
            let gain = format!("{:.1} %", 100.0 * number(&row["joint_update_gain"]));
            assert!(page.contains(&gain), "{gain} is not on the page");
        }
    }
    for level in report["levels"].as_array().unwrap() {
        assert!(page.contains(&format!("{:.1} %", 100.0 * number(&level["saved"]))));
    }
    for attribute in ["src=\"", "href=\""] {
        for part in page.split(attribute).skip(1) {
            let file = part.split('"').next().unwrap();
            assert!(
                here.join("d").join(file).is_file(),
                "{file} is not beside the page"
            );
        }
    }
    assert!(!page.contains("://"), "the page fetches nothing");
    let images = page.matches("<img ").count();
    assert_eq!(images, page.matches(" alt=\"").count());
    let (server, address) = started(&here.join("d/store"), &[]);
    let listed = request(&address, "GET /v1/characters HTTP/1.1\r\n", b"");
    for name in ["character", "guide"] {
        assert!(listed.contains(&format!("\"name\":\"{name}\"")), "{listed}");
    }
    drop(server);
    assert!(json(&here, &["inspect", "d/asset.glb"])["articulation_stored"] == true);
}
