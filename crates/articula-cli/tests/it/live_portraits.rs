//! Portraits driven while they are shown: `ArticulaPortrait.drive` in node, on documents that `flatten
//! --live` wrote.

use crate::judges::{ask_on_words, node_is_here};
use crate::program::{folder, json};
use articula::build::face::FapInterval;
use articula::core::fap_table::{LOW_FAPS, TABLE};
use articula::glam::{EulerRot, Quat};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json as object};
use std::path::Path;

/// A document with a face animation table beside 17 blend shapes.
fn document(here: &Path) -> Value {
    let head = format!(
        "{}/../../assets/glb/ict_head_talk_554.glb",
        env!("CARGO_MANIFEST_DIR")
    );
    let words = [
        "--profile",
        "portrait",
        "--triangles",
        "120",
        "--size",
        "64",
        "--views",
        "1",
    ];
    let report = json(
        here,
        &[&["flatten", &head, "a.json", "--live"], &words[..]].concat(),
    );
    assert!(report["inputs"].as_u64().unwrap() > 40, "{report}");
    serde_json::from_slice(&std::fs::read(here.join("a.json")).unwrap()).unwrap()
}

/// The player, as pages have it in them.
const PLAYER: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../articula-flat/src/portrait/player.js"
);

/// What the player shows for each input.
fn driven(here: &Path, document: &Value, inputs: &Value) -> Vec<Value> {
    asked(here, document, &object!({"inputs": inputs}))
}

/// Answers to a job about a document.
fn asked(here: &Path, document: &Value, job: &Value) -> Vec<Value> {
    let mut job = job.clone();
    job["json"] = document.clone();
    let player = here.join("player.js").to_string_lossy().into_owned();
    let (answer, good) = ask_on_words("portrait.mjs", &[player], &job.to_string());
    assert!(good, "{answer}");
    serde_json::from_str(&answer).unwrap()
}

/// What is embedded in a page under a name.
fn embedded(page: &str, name: &str) -> Value {
    let (_, rest) = page.split_once(&format!("const {name} = ")).unwrap();
    let mut values = serde_json::Deserializer::from_str(rest).into_iter();
    values.next().unwrap().unwrap()
}

#[test]
fn pictures_behind_a_portrait_change_with_its_clip() {
    if !node_is_here() {
        return;
    }
    let here = folder("slide-show");
    for name in ["a.png", "b.png", "c.png"] {
        std::fs::write(here.join(name), name).unwrap();
    }
    let head = format!(
        "{}/../../assets/glb/ict_head_talk_554.glb",
        env!("CARGO_MANIFEST_DIR")
    );
    let portrait = ["--triangles", "120", "--size", "64", "--views", "1"];
    // What is behind at each time, by the player of a document of the same head.
    let shown = |slides: &[&str], times: &[f64]| -> Vec<Value> {
        let words: Vec<&str> = slides.iter().flat_map(|s| ["--background", s]).collect();
        let out = format!("{}.html", slides.len());
        json(
            &here,
            &[&["flatten", &head, &out], &portrait[..], &words].concat(),
        );
        let page = std::fs::read_to_string(here.join(out)).unwrap();
        let [document, background] = ["json", "behind"].map(|name| embedded(&page, name));
        let job = object!({"json": document, "background": background, "times": times}).to_string();
        let (answer, good) = ask_on_words("portrait.mjs", &[PLAYER.to_owned()], &job);
        assert!(good, "{answer}");
        serde_json::from_str(&answer).unwrap()
    };
    let uri = |name: &str| {
        let bytes = STANDARD.encode(name);
        Value::from(format!("data:image/png;base64,{bytes}"))
    };
    let [a, b, c] = ["a.png", "b.png", "c.png"].map(uri);
    // In the order of their times, none before the first.
    let timed = shown(&["b.png@0.5", "a.png@0.2"], &[0.1, 0.3, 0.6, 0.3]);
    assert_eq!(timed, [Value::Null, a.clone(), b.clone(), a.clone()]);
    // Thirds of the clip, which begins anew.
    let page = std::fs::read_to_string(here.join("2.html")).unwrap();
    let document = embedded(&page, "json");
    let clip = &document["clips"][0];
    let number = |name: &str| clip[name].as_f64().unwrap();
    let secs = (number("frames") - 1.0) / number("rate");
    let times = [0.1, 0.4, 0.9, 1.1].map(|share| share * secs);
    let even = shown(&["a.png", "b.png", "c.png"], &times);
    assert_eq!(even, [a.clone(), b, c, a]);
    let job = object!({"json": document, "planes": [{"yaw": 20, "pitch": 10, "roll": 5}, {}, {"yaw": null}]});
    let (answer, good) = ask_on_words("portrait.mjs", &[PLAYER.to_owned()], &job.to_string());
    assert!(good, "{answer}");
    let planes: Vec<String> = serde_json::from_str(&answer).unwrap();
    let rest = "perspective(1600px) rotateY(0deg) rotateX(0deg) rotateZ(0deg)";
    let turned = "perspective(1600px) rotateY(20deg) rotateX(-10deg) rotateZ(-5deg)";
    assert_eq!(planes, [turned, rest, rest]);
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap().iter();
    list.map(|n| n.as_f64().unwrap()).collect()
}

/// Greatest distance of a coordinate.
fn farthest(a: &Value, b: &Value) -> f64 {
    let (a, b) = (numbers(&a["places"]), numbers(&b["places"]));
    let all = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
    all.fold(0.0, f64::max)
}

#[test]
fn a_portrait_takes_parameters_shapes_and_visemes() {
    if !node_is_here() {
        return;
    }
    let here = folder("live-portrait");
    let document = document(&here);
    let list: Vec<i32> = (1..=68).map(|fap| i32::from(fap == 49) * 17_453).collect();
    let inputs = object!([
        {},
        {"faps": {"3": 300}},
        {"faps": list},
        {"faps": {"48": 20_000, "49": 30_000, "50": 10_000}},
        {"head": {"yaw": 10}},
        {"shapes": {"jawOpen": 0.5}},
        {"visemes": {"aa": 1}},
        {"visemes": {"sil": 1}, "shapes": {"none": 1}, "faps": {"1": 4, "3": -200}},
        {"head": {"roll": 90}},
        {"head": {"roll": 180}},
        {"faps": null, "shapes": {"jawOpen": null}, "head": {"yaw": "far"}},
    ]);
    let shown = driven(&here, &document, &inputs);
    let [
        rest,
        jaw,
        left,
        turned,
        yaw,
        open,
        aa,
        nothing,
        quarter,
        half,
        wrong,
    ] = &shown[..]
    else {
        panic!("{} answers", shown.len());
    };
    for moved in [jaw, left, turned, open, aa] {
        assert!(farthest(moved, rest) > 0.3, "{}", moved["pose"]);
    }
    for whole in [jaw, left, turned, open] {
        assert_eq!(whole["missing"], object!([]));
    }
    // Some points of the lips have no vertex of their own on so coarse a mesh.
    let missing = aa["missing"].as_array().unwrap().iter();
    let mut missing = missing.map(|name| name.as_str().unwrap());
    let has = |name: &str| {
        let mut table = document["expressions"].as_array().unwrap().iter();
        let begin = format!("{name}_");
        table.any(|of| of["name"].as_str().unwrap().starts_with(&begin))
    };
    assert!(missing.all(|name| name.starts_with("fap") && !has(name)));
    for still in [nothing, wrong] {
        assert!(farthest(still, rest) < 1e-9);
    }
    assert_eq!(nothing["missing"], object!(["none", "fap1"]));
    turned_about_one_centre(&document, rest, quarter, half);
    // 0.17453 rad are 10 degrees.
    assert!(farthest(left, yaw) < 1e-3);
    let angle = |axis: &str| turned["pose"][axis].as_f64().unwrap().to_radians();
    // Yaw, pitch and roll about turned axes, as the library turns heads.
    let (roll, yaw, pitch) = Quat::from_euler(EulerRot::YXZ, 0.3, 0.2, 0.1).to_euler(EulerRot::ZYX);
    for (axis, expected) in [("yaw", yaw), ("pitch", pitch), ("roll", roll)] {
        assert!((angle(axis) - f64::from(expected)).abs() < 1e-5, "{axis}");
    }
}

/// Half a turn tells the centre of each vertex: on the line from the middle of the picture through the pivot,
/// farther out for nearer vertices. A quarter turn has the same.
fn turned_about_one_centre(document: &Value, rest: &Value, quarter: &Value, half: &Value) {
    let [size, pivot] = ["size", "pivot"].map(|name| numbers(&document[name]));
    let places = [rest, quarter, half].map(|shown| numbers(&shown["places"]));
    let mut farthest: f64 = 0.0;
    for v in 0..places[0].len() / 2 {
        let [a, b, c] = [0, 1, 2].map(|i| [places[i][2 * v], places[i][2 * v + 1]]);
        let centre = [0.5 * (a[0] + c[0]), 0.5 * (a[1] + c[1])];
        let from_middle = [0, 1].map(|i| centre[i] - 0.5 * size[i]);
        let of_pivot = [0, 1].map(|i| pivot[i] - 0.5 * size[i]);
        let across = from_middle[0] * of_pivot[1] - from_middle[1] * of_pivot[0];
        assert!(
            across.abs() < 1e-2 * of_pivot[0].hypot(of_pivot[1]).max(1.0),
            "{across}"
        );
        // What is right of the centre moves up.
        let (x, y) = (a[0] - centre[0], a[1] - centre[1]);
        let [right, down] = [b[0] - centre[0], b[1] - centre[1]];
        assert!((right - y).abs() < 1e-2 && (down + x).abs() < 1e-2);
        farthest = farthest.max((centre[0] - pivot[0]).hypot(centre[1] - pivot[1]));
    }
    assert!(farthest > 0.1 && farthest < 20.0, "{farthest}");
}

#[test]
fn the_player_reads_a_table_as_the_library_does() {
    if !node_is_here() {
        return;
    }
    let here = folder("live-table");
    let document = document(&here);
    let names = document["expressions"].as_array().unwrap().iter();
    let names: Vec<&str> = names.map(|e| e["name"].as_str().unwrap()).collect();
    let parts: Vec<Option<FapInterval>> = names.iter().map(|n| FapInterval::parse(n)).collect();
    let table: Vec<FapInterval> = parts.iter().flatten().copied().collect();
    let shown: Vec<usize> = LOW_FAPS
        .filter(|f| table.iter().any(|p| p.fap == *f))
        .collect();
    assert!(shown.len() > 30, "{shown:?}");
    let values = [-700, -150, 90, 400, 1500];
    let one = |fap: &usize| values.map(|value| object!({"faps": {fap.to_string(): value}}));
    let inputs: Vec<Value> = shown.iter().flat_map(one).collect();
    let answers = driven(&here, &document, &inputs.into());
    for (answer, (fap, value)) in answers
        .iter()
        .zip(shown.iter().flat_map(|f| values.map(|v| (*f, v))))
    {
        let own: Vec<FapInterval> = table.iter().filter(|p| p.fap == fap).copied().collect();
        for ((part, name), weight) in parts.iter().zip(&names).zip(numbers(&answer["weights"])) {
            let expected = match part {
                Some(part) if part.fap == fap => part.weight(value as f32, &own),
                _ => 0.0,
            };
            let of = TABLE[fap - 1].name;
            assert!(
                (weight - f64::from(expected)).abs() < 1e-5,
                "{of} {value}: {name} {weight}"
            );
        }
    }
}

#[test]
fn a_portrait_leaves_out_what_its_level_does() {
    if !node_is_here() {
        return;
    }
    let here = folder("level-portrait");
    let document = document(&here);
    let names = document["expressions"].as_array().unwrap().iter();
    let names: Vec<&str> = names.map(|e| e["name"].as_str().unwrap()).collect();
    // So large that every motion is seen.
    let css = [6400, 6400];
    // The lower lids go as the upper ones, which is what coarser levels have them do.
    let lids = |left: i32, right: i32| object!({"3": 300, "19": left, "20": right, "21": left, "22": right});
    let faps = |left: i32, right: i32| {
        let mut faps = lids(left, right);
        faps["14"] = 200.into();
        faps
    };
    let answers = asked(
        &here,
        &document,
        &object!({"css": css, "inputs": [
            {"level": "high", "faps": faps(500, 200)},
            {"level": "veryLow", "faps": faps(500, 200)},
            {"level": "high", "faps": lids(200, 200)},
            {"level": "low", "faps": faps(500, 200)},
            {"level": "veryLow", "shapes": {"eyeBlinkLeft": 1}},
            {"level": "veryLow", "shapes": {"eyeBlinkRight": 1}},
            {"level": "none", "shapes": {"eyeBlinkRight": 1}},
        ]}),
    );
    let shown: Vec<Vec<f64>> = answers.iter().map(|a| numbers(&a["shown"])).collect();
    assert_eq!(shown[0], numbers(&answers[0]["weights"]));
    assert_eq!(shown[1], shown[2]);
    for ((name, high), low) in names.iter().zip(&shown[0]).zip(&shown[3]) {
        let is_gone = name.starts_with("fap14_");
        assert_eq!(*low, if is_gone { 0.0 } else { *high }, "{name}");
    }
    let blink = |weights: &[f64]| {
        ["eyeblink_l", "eyeblink_r"].map(|side| {
            let at = names.iter().position(|n| n.to_lowercase() == side);
            weights[at.unwrap()]
        })
    };
    // The right side leads; a level of no name changes nothing.
    assert_eq!(blink(&shown[4]), [0.0, 0.0]);
    assert_eq!(blink(&shown[5]), [1.0, 1.0]);
    assert_eq!(blink(&shown[6]), [1.0, 1.0]);

    // As small as an icon, what is not seen is left out.
    let weights: serde_json::Map<String, Value> =
        names.iter().map(|n| ((*n).to_owned(), 1.into())).collect();
    let input = object!({"level": "high", "shapes": weights});
    let icon = &asked(
        &here,
        &document,
        &object!({"css": [16, 16], "inputs": [input]}),
    )[0];
    let reaches = numbers(&icon["reaches"]);
    let pixels = 16.0 / numbers(&document["size"])[0];
    let mut left_out = 0;
    for (weight, reach) in numbers(&icon["shown"]).iter().zip(&reaches) {
        let is_seen = reach * pixels > 0.5;
        assert_eq!(*weight, f64::from(u8::from(is_seen)), "{reach}");
        left_out += usize::from(!is_seen);
    }
    assert!(left_out > 10 && left_out < names.len(), "{left_out}");
}

#[test]
fn slow_frames_make_the_level_coarser() {
    if !node_is_here() {
        return;
    }
    let here = folder("slow-portrait");
    let document = document(&here);
    let levels = |level: &str, means: &[u32]| -> Vec<String> {
        let frames: Vec<u32> = means.iter().flat_map(|mean| [*mean; 30]).collect();
        let job = object!({"frames": frames, "options": {"level": level, "budget": 12}});
        let answers = asked(&here, &document, &job);
        let last = answers
            .chunks(30)
            .map(|c| c[29].as_str().unwrap().to_owned());
        last.collect()
    };
    let fast = levels("auto", &[20, 15, 10, 10, 5, 5]);
    assert_eq!(fast, ["medium", "low", "low", "low", "medium", "high"]);
    // A level that saves nothing is taken back, and not tried again soon.
    let useless = levels("auto", &[20, 20, 20, 20]);
    assert_eq!(useless, ["medium", "high", "high", "high"]);
    let later = levels("auto", &[20; 24]);
    assert_eq!(later.iter().filter(|l| *l == "medium").count(), 2);
    assert_eq!(levels("low", &[20, 5, 5]), ["low"; 3]);
}
