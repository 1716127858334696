//! `flatten` judged by the largest local difference: triangle count, lost painting, missed budgets,
//! and the Gouraud form of the thesis.

use crate::program::{fault, folder, json, short, small, word};
use articula::flat::Picture;
use serde_json::{Value, json as object};
use std::path::{Path, PathBuf};

/// A skin-coloured picture of 64 x 64 pixels, with a dark smile of 24 x 4 pixels or without.
fn painted(smiles: bool) -> Vec<u8> {
    let color = |x: u32, y: u32| {
        let is_mouth = (20..44).contains(&x) && (40..44).contains(&y);
        if smiles && is_mouth {
            [90, 20, 25, 255]
        } else {
            [225, 180, 150, 255]
        }
    };
    let pixels = (0..64).flat_map(|y| (0..64).map(move |x| color(x, y)));
    let picture = Picture::from_pixels(64, 64, pixels.collect()).unwrap();
    picture.to_png().unwrap()
}

/// A square face of two textured triangles, with a morph target that moves all of it.
fn face(path: &Path, smiles: bool) {
    let corners = [[-1.0f32, 0.0], [1.0, 0.0], [1.0, 2.0], [-1.0, 2.0]];
    let mut bytes = Vec::new();
    let mut views = Vec::new();
    let mut put = |values: &[f32]| {
        let start = bytes.len();
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        let length = bytes.len() - start;
        views.push(object!({"buffer": 0, "byteOffset": start, "byteLength": length}));
    };
    put(&corners.map(|[x, y]| [x, y, 0.0]).concat());
    put(&[[0.0, 0.0, 1.0]; 4].concat());
    put(&corners
        .map(|[x, y]| [0.5 * (x + 1.0), 1.0 - 0.5 * y])
        .concat());
    put(&[[0.0, 0.0, 0.1]; 4].concat());
    put(&[]);
    let start = bytes.len();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    views[4] = object!({"buffer": 0, "byteOffset": start, "byteLength": 12});
    let vectors = |view: usize| {
        object!({"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3",
                 "min": [-1, 0, 0], "max": [1, 2, 1]})
    };
    let (picture, buffer) = (path.with_extension("png"), path.with_extension("bin"));
    std::fs::write(&picture, painted(smiles)).unwrap();
    std::fs::write(&buffer, &bytes).unwrap();
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let file = object!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "head"}],
        "meshes": [{"name": "head", "extras": {"targetNames": ["nod"]}, "primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
            "indices": 4, "material": 0, "targets": [{"POSITION": 3}],
        }]}],
        "materials": [{"name": "skin",
                       "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": name(&picture)}],
        "accessors": [
            vectors(0),
            vectors(1),
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
            vectors(3),
            {"bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(),
                     "uri": name(&buffer)}],
    });
    std::fs::write(path, file.to_string()).unwrap();
}

/// A ball of 1152 triangles in one colour.
fn ball(path: &Path) {
    const SIDE: u16 = 24;
    let part = |i: u16| f32::from(i) / f32::from(SIDE) * std::f32::consts::PI;
    let rows = (0..=SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column)));
    let places = rows.map(|(row, column)| {
        let ((up, round), (sin, cos)) = (part(row).sin_cos(), (2.0 * part(column)).sin_cos());
        [up * cos, 1.0 + round, up * sin]
    });
    let corners = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column)));
    let corners = corners.flat_map(|(row, column)| {
        let at = |row: u16, column: u16| row * SIDE + column % SIDE;
        let (a, b) = (at(row, column), at(row, column + 1));
        let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
        [a, b, d, a, d, c]
    });
    let mut bytes: Vec<u8> = places.flatten().flat_map(f32::to_le_bytes).collect();
    let start = bytes.len();
    bytes.extend(corners.flat_map(u16::to_le_bytes));
    let buffer = path.with_extension("bin");
    std::fs::write(&buffer, &bytes).unwrap();
    let file = object!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "ball"}],
        "meshes": [{"name": "ball", "primitives": [{
            "attributes": {"POSITION": 0}, "indices": 1, "material": 0,
        }]}],
        "materials": [{"name": "clay"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": start / 12, "type": "VEC3",
             "min": [-1, 0, -1], "max": [1, 2, 1]},
            {"bufferView": 1, "componentType": 5123, "count": (bytes.len() - start) / 2,
             "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": start},
            {"buffer": 0, "byteOffset": start, "byteLength": bytes.len() - start},
        ],
        "buffers": [{"byteLength": bytes.len(), "uri": "ball.bin"}],
    });
    std::fs::write(path, file.to_string()).unwrap();
}

fn warnings(report: &Value) -> Vec<&str> {
    let all = report["warnings"].as_array().unwrap().iter();
    all.map(|w| w.as_str().unwrap()).collect()
}

#[test]
fn a_painted_smile_does_not_vanish_unnoticed() {
    let here = folder("flatten-smile");
    face(&here.join("smile.gltf"), true);
    face(&here.join("plain.gltf"), false);
    let smile = json(&here, &["flatten", "smile.gltf", "smile.svg"]);
    // Similarity of the whole picture does not see it.
    assert!(smile["error"]["ssim"].as_f64().unwrap() > 0.97);
    let worst = &smile["error"]["local"]["face"];
    assert!(worst["delta_e"].as_f64().unwrap() > 24.0, "{worst}");
    // The mouth is in the middle, two thirds down; the picture shows the square with a margin.
    let side = 400.0 / 1.12;
    let row = 200.0 + side * (42.0 / 64.0 - 0.5);
    let (x, y) = (worst["x"].as_f64().unwrap(), worst["y"].as_f64().unwrap());
    assert!(
        (y - row).abs() < 15.0 && (130.0..270.0).contains(&x),
        "{worst}"
    );
    let dropped = &smile["dropped_detail"][0];
    assert!(
        dropped["region"] == "face" && dropped["mesh"] == "head",
        "{dropped}"
    );
    let told = warnings(&smile);
    let told = told
        .iter()
        .find(|w| w.contains("texture detail of the face was dropped"));
    assert!(told.unwrap().contains("--profile portrait"), "{told:?}");

    let plain = json(&here, &["flatten", "plain.gltf", "plain.svg"]);
    assert_eq!(warnings(&plain), Vec::<&str>::new());
    assert_eq!(plain["dropped_detail"], object!([]));
    assert!(plain["error"]["local"]["face"]["delta_e"].as_f64().unwrap() < 5.0);
    let text = crate::program::articula(
        &here,
        &["flatten", "smile.gltf", "again.svg", "--size", "120"],
    )
    .out;
    assert!(
        text.contains("\nwarning: texture detail of the face"),
        "{text}"
    );
    assert!(text.contains("largest local difference: face"), "{text}");
}

#[test]
fn the_player_shows_a_painted_smile() {
    let here = folder("flatten-smile-player");
    face(&here.join("smile.gltf"), true);
    let player = |more: &[&str]| {
        let all = ["flatten", "smile.gltf", "smile.svg", "--profile", "player"];
        json(&here, &[&all[..], more].concat())
    };
    let shown = player(&[]);
    assert!(shown["texture"]["triangles"].as_u64() >= Some(1));
    assert_eq!(shown["dropped_detail"], object!([]));
    assert_eq!(warnings(&shown), Vec::<&str>::new());
    let plain = player(&["--texture", "none"]);
    assert!(plain.get("texture").is_none());
    let told = warnings(&plain);
    let dropped = told.iter().find(|w| w.contains("was dropped"));
    assert!(dropped.unwrap().contains("--texture none"), "{told:?}");
    let of = |report: &Value| report["error"]["local"]["face"]["delta_e"].as_f64();
    let (shown, plain) = (of(&shown).unwrap(), of(&plain).unwrap());
    assert!(shown < 0.5 * plain, "{shown} {plain}");
    // Other profiles have no textures.
    let refused = crate::program::articula(
        &here,
        &["flatten", "smile.gltf", "smile.json", "--texture", "none"],
    );
    assert!(refused.err.contains("--texture"), "{}", refused.err);
}

#[test]
fn the_largest_local_difference_decides_count_and_weights() {
    let here = folder("flatten-judged");
    let asset = |name: &str| -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/glb");
        root.join(name)
    };
    let still = |file: &str, more: &[&str]| {
        let file = asset(file);
        let words = [
            &["flatten", word(&file), "a.svg", "--profile", "still"],
            more,
        ]
        .concat();
        json(&here, &words)
    };
    let delta = |report: &Value, region: &str| report[region]["delta_e"].as_f64().unwrap();
    // Fingers and lids of the robot are lost at the least count, at a similarity above 0.97.
    let robot = "RobotExpressive.glb";
    let few = still(robot, &["--triangles", "600"]);
    assert!(few["error"]["ssim"].as_f64().unwrap() > 0.97);
    assert!(few.get("triangle_choice").is_none());
    let judged = still(robot, &[]);
    let choice = &judged["triangle_choice"];
    assert!(choice["count"].as_u64().unwrap() > 600, "{choice}");
    let worst = |report: &Value, region| delta(&report["error"]["local"], region);
    assert!(worst(&few, "rest") > 36.0 && worst(&judged, "rest") <= 36.0);
    assert!(worst(&few, "face") > 24.0 && worst(&judged, "face") <= 24.0);
    // The choice is the first of what was tried that is within the bounds.
    let tried = choice["tried"].as_array().unwrap();
    let holds = |t: &Value| delta(t, "face") <= 24.0 && delta(t, "rest") <= 36.0;
    let first = tried.iter().find(|t| holds(t)).unwrap();
    assert_eq!(first["count"], choice["count"]);
    assert_eq!(first["triangles"], judged["triangles"]);

    // The face of the suit is the worst at the least count; a greater weight mends it without more
    // triangles.
    let suit = still("Quaternius_modular_men__Suit.glb", &[]);
    let choice = &suit["triangle_choice"];
    let tried = choice["tried"].as_array().unwrap();
    assert!(delta(&tried[0], "face") > 24.0 && tried[0]["face_weight"] == 3.0);
    assert_eq!(
        (&choice["count"], &choice["face_weight"]),
        (&object!(600), &object!(6.0))
    );
    assert!(worst(&suit, "face") <= 24.0);
}

#[test]
fn a_missed_budget_writes_the_smallest_file_and_says_by_how_much() {
    let here = folder("flatten-over");
    let base = [
        "flatten",
        word(small()),
        "a.svg",
        "--clip",
        "walk",
        "--size",
        "120",
        "--fps",
        "10",
    ];
    let with = |more: &[&str]| json(&here, &[&base[..], more].concat());
    let raw = |report: &Value| report["bytes"]["raw"].as_u64().unwrap();
    let given = with(&["--triangles", "200", "--max-bytes", "500"]);
    assert_eq!(
        std::fs::metadata(here.join("a.svg")).unwrap().len(),
        raw(&given)
    );
    assert_eq!(given["bytes_over"].as_u64(), Some(raw(&given) - 500));
    let sizes = given["tried"].as_array().unwrap().iter();
    let least = sizes.map(|t| t["bytes"].as_u64().unwrap()).min();
    assert_eq!(least, Some(raw(&given)));
    let told = warnings(&given).join(" ");
    assert!(
        told.contains(&format!("{} more than --max-bytes 500", raw(&given) - 500)),
        "{told}"
    );

    // A count that is not given may fall, too.
    ball(&here.join("ball.gltf"));
    let still = |out, most: &str, more: &[&str]| {
        let words = [
            "flatten",
            "ball.gltf",
            out,
            "--size",
            "120",
            "--max-bytes",
            most,
        ];
        json(&here, &[&words[..], more].concat())
    };
    let given = still("b.svg", "500", &["--triangles", "200"]);
    let free = still("c.svg", "500", &[]);
    assert!(free["triangles"].as_u64().unwrap() < 200 && raw(&free) < raw(&given));
    let most = (raw(&given) + raw(&free)) / 2;
    let held = still("c.svg", &most.to_string(), &[]);
    assert!(raw(&held) <= most && held["bytes_over"] == Value::Null);
}

#[test]
fn the_gouraud_form_of_the_thesis_has_a_flag() {
    let here = folder("flatten-gouraud");
    let human = word(short());
    let base = [
        "flatten",
        human,
        "a.svg",
        "--clip",
        "walk",
        "--triangles",
        "150",
        "--size",
        "120",
    ];
    let thesis = ["--profile", "thesis", "--form", "gouraud", "--at", "0.4"];
    let report = json(&here, &[&base[..], &thesis].concat());
    assert_eq!(
        (&report["frames"], &report["settings"]["shading"]),
        (&object!(1), &object!("gouraud"))
    );
    assert!(report["error"]["ssim"].as_f64().unwrap() > 0.8);
    let text = std::fs::read_to_string(here.join("a.svg")).unwrap();
    let count = |what: &str| text.matches(what).count();
    // Three copies of a face, each with a gradient to transparent, are added over the mean colour.
    let faces = count("<filter ");
    assert!(faces > 60, "{faces}");
    assert_eq!(count("<linearGradient "), 3 * faces);
    assert_eq!(count("stop-opacity=\"0\""), 3 * faces);
    assert_eq!(
        (count("<feComposite "), count("<polygon ")),
        (2 * faces, 4 * faces)
    );
    assert_eq!(count("<animate"), 0);
    // Another time, another picture.
    let thesis = ["--profile", "thesis", "--form", "gouraud"];
    json(&here, &[&base[..], &thesis].concat());
    assert_ne!(text, std::fs::read_to_string(here.join("a.svg")).unwrap());
    let line = fault(&here, 2, &["flatten", human, "b.svg", "--form", "gouraud"]);
    assert!(line.contains("--form"), "{line}");
}
