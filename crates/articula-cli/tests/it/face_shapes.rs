//! `convert --face-shapes`: a face without morph targets gets the blend shapes of ARKit.

use crate::program::{articula, edited, fault, folder, json, word};
use crate::real;
use articula::core::source::{Channel, Character, Property, RawMesh, evaluate};
use glam::Vec3;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Writes a GLB file without its morph targets and animations.
fn without_morphs(glb: &Path, out: &Path) {
    edited(glb, out, |document| {
        document.as_object_mut().unwrap().remove("animations");
        for mesh in document["meshes"].as_array_mut().unwrap() {
            let mesh = mesh.as_object_mut().unwrap();
            mesh.remove("weights");
            mesh.remove("extras");
            for part in mesh["primitives"].as_array_mut().unwrap() {
                part.as_object_mut().unwrap().remove("targets");
            }
        }
    });
}

fn character(path: &Path) -> Character {
    articula::fs::open(path).unwrap().into_character()
}

/// Offsets of all vertices of a mesh in a morph target, by its name.
fn offsets(mesh: &RawMesh, name: &str) -> Vec<Vec3> {
    let target = mesh.morph_names.iter().position(|n| n == name).unwrap();
    let parts = mesh.primitives.iter();
    parts
        .flat_map(|p| p.morphs[target].positions.clone())
        .collect()
}

/// The head without its morph targets, in a folder, and the head itself.
fn bald(name: &str) -> Option<(PathBuf, PathBuf)> {
    let head = real::file("glb/ict_head_talk_1095.glb")?;
    let here = folder(name);
    without_morphs(&head, &here.join("bald.glb"));
    Some((here, head))
}

#[test]
fn made_shapes_move_as_those_of_the_face() {
    let Some((here, head)) = bald("face-shapes") else {
        return;
    };
    let report = json(
        &here,
        &["convert", "bald.glb", "shaped.glb", "--face-shapes"],
    );
    let made = report["face_shapes"]["made"].as_array().unwrap();
    assert_eq!(made.len(), 51);
    assert_eq!(
        report["face_shapes"]["not_made"],
        serde_json::json!(["tongueOut"])
    );
    let (own, shaped) = (character(&head), character(&here.join("shaped.glb")));
    let (own, shaped) = (&own.meshes[0], &shaped.meshes[0]);
    assert_eq!(shaped.morph_names.len(), 51);
    // All other contents stay.
    assert_eq!(own.primitives.len(), shaped.primitives.len());
    for (a, b) in own.primitives.iter().zip(&shaped.primitives) {
        assert_eq!((&a.positions, &a.triangles), (&b.positions, &b.triangles));
    }
    for name in ["jawOpen", "mouthSmile_L", "eyeBlink_R"] {
        let there = own.morph_names.iter().any(|n| n == name);
        let arkit = name.replace("_L", "Left").replace("_R", "Right");
        if !there {
            continue;
        }
        let (truth, found) = (offsets(own, name), offsets(shaped, &arkit));
        // Motions of other parts or in other directions have a correlation near 0 or below.
        let dot: f32 = truth.iter().zip(&found).map(|(a, b)| a.dot(*b)).sum();
        let size = |d: &[Vec3]| d.iter().map(|v| v.length_squared()).sum::<f32>().sqrt();
        let alike = dot / (size(&truth) * size(&found));
        assert!(alike > 0.5, "{name}: {alike}");
    }
    // The left smile moves the left corner, and the right side rests.
    let left = offsets(shaped, "mouthSmileLeft");
    let places = own.primitives.iter().flat_map(|p| p.positions.clone());
    let (mut of_left, mut of_right) = (0.0_f32, 0.0_f32);
    for (place, offset) in places.zip(&left) {
        let side = if place.x > 0.0 {
            &mut of_left
        } else {
            &mut of_right
        };
        *side = side.max(offset.length());
    }
    assert!(
        of_left > 0.008 && of_right < 0.3 * of_left,
        "{of_left} {of_right}"
    );
}

#[test]
fn a_face_clip_goes_onto_a_face_without_shapes() {
    let (Some((here, _)), Some(speech)) = (
        bald("face-shapes-fap"),
        real::file("fap/speech_synthetic.fap"),
    ) else {
        return;
    };
    let speech = word(&speech);
    let said = fault(
        &here,
        1,
        &["convert", speech, "a.glb", "--onto", "bald.glb"],
    );
    assert!(said.contains("--face-shapes"), "{said}");
    assert!(said.contains("--face-shapes=fat"), "{said}");
    let words = [
        "convert",
        speech,
        "a.glb",
        "--onto",
        "bald.glb",
        "--face-shapes",
    ];
    let report = json(&here, &words);
    assert_eq!(report["face_shapes"]["made"].as_array().unwrap().len(), 51);
    let face = &report["onto"]["faces"][0];
    assert_eq!(
        (&face["kind"], &face["controls"]),
        (&"morph-targets".into(), &51.into())
    );
    assert!(face["error_mm_mean"].as_f64().unwrap() < 0.5);
    let read = character(&here.join("a.glb"));
    assert_eq!(
        (read.clips.len(), read.meshes[0].morph_names.len()),
        (1, 51)
    );
    // All shapes of the result are drawn.
    let drawn = json(
        &here,
        &["inspect", "a.glb", "--write", "shape-sheet=shapes.png"],
    );
    assert_eq!(drawn["written"], serde_json::json!(["shapes.png"]));
    assert!(
        std::fs::read(here.join("shapes.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    let said = fault(
        &here,
        2,
        &["inspect", "bald.glb", "--write", "shape-sheet=none.png"],
    );
    assert!(said.contains("no morph target"), "{said}");
    // Points can be given; a face that has shapes keeps them.
    json(
        &here,
        &["inspect", "bald.glb", "--write", "face-points=points.json"],
    );
    let given = ["--face-shapes", "--face-points", "points.json"];
    json(
        &here,
        &[&["convert", "bald.glb", "b.glb"], &given[..]].concat(),
    );
    let said = fault(&here, 1, &["convert", "a.glb", "c.glb", "--face-shapes"]);
    assert!(said.contains("has morph targets"), "{said}");
}

#[test]
fn a_head_whose_lids_do_not_close_tells_why() {
    // Its eyes are pieces on the skin, without lids around them.
    let Some(suit) = real::file("glb/Quaternius_modular_men__Suit.glb") else {
        return;
    };
    let here = folder("face-shapes-refused");
    let words = ["convert", word(&suit), "a.glb", "--face-shapes"];
    let report = json(&here, &words);
    let refused = report["face_shapes"]["refused"].as_array().unwrap();
    let of = |key: &'static str| refused.iter().map(move |r| r[key].as_str().unwrap());
    let lids = ["eyeBlink", "eyeSquint", "eyeWide"];
    let mut expected: Vec<String> = ["Left", "Right"]
        .iter()
        .flat_map(|side| lids.map(|lids| format!("{lids}{side}")))
        .collect();
    let mut shapes: Vec<&str> = of("shape").collect();
    expected.sort();
    shapes.sort_unstable();
    assert_eq!(shapes, expected);
    // They are neither made nor lost among what nothing shows.
    let made = character(&here.join("a.glb"));
    let names = made.meshes.iter().flat_map(|m| &m.morph_names);
    let names: Vec<&String> = names.collect();
    assert!(names.iter().any(|n| *n == "jawOpen") && !names.iter().any(|n| expected.contains(n)));
    let not_made = &report["face_shapes"]["not_made"];
    assert!(expected.iter().all(|e| !not_made.to_string().contains(e)));
    // People read the reason in both reports, and it is the same.
    let told = articula(&here, &[&words[..], &["--force"]].concat()).out;
    let inspected = articula(&here, &["inspect", word(&suit), "--face"]).out;
    for why in of("why") {
        assert!(why.contains("lid"), "{why}");
        assert!(told.contains(&format!(": {why}")), "{told}");
        assert!(inspected.contains(&format!(": {why}")), "{inspected}");
    }
    let told = told.lines().find(|l| l.contains("not made")).unwrap();
    assert!(told.contains("eyeBlinkLeft"), "{told}");
}

/// Displacements of all vertices by the first clip.
fn displacements(file: &Path, secs: f32) -> Vec<Vec3> {
    let read = character(file);
    let mut all = Vec::new();
    for (m, mesh) in read.meshes.iter().enumerate() {
        let mut weights = vec![0.0; mesh.morph_names.len()];
        let is_it = |c: &&Channel| c.property == Property::Weights && c.target == m;
        if let Some(channel) = read.clips[0].channels.iter().find(is_it) {
            evaluate::channel(channel, secs, &mut weights);
        }
        for primitive in &mesh.primitives {
            let mut sum = vec![Vec3::ZERO; primitive.positions.len()];
            for (target, weight) in primitive.morphs.iter().zip(&weights) {
                for (sum, offset) in sum.iter_mut().zip(&target.positions) {
                    *sum += *weight * *offset;
                }
            }
            all.extend(sum);
        }
    }
    all
}

/// Writes a FAP file of two seconds: the jaw opens by 900 units, the left lid closes by 600.
fn say(path: &Path) {
    let mut text = "2.1 say 10 21\n".to_owned();
    for frame in 0..21 {
        let mask: Vec<&str> = (1..=68)
            .map(|fap| if matches!(fap, 3 | 19) { "1" } else { "0" })
            .collect();
        writeln!(
            text,
            "{}\n{frame} {} {}",
            mask.join(" "),
            45 * frame,
            30 * frame
        )
        .unwrap();
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_table_shows_parameters_as_they_are() {
    let Some((here, _)) = bald("face-table") else {
        return;
    };
    say(&here.join("say.fap"));
    let words = [
        "convert",
        "say.fap",
        "a.glb",
        "--onto",
        "bald.glb",
        "--face-shapes=fat",
    ];
    let report = json(&here, &words);
    let table = &report["face_table"];
    let face = &report["onto"]["faces"][0];
    assert_eq!(
        (&face["columns"], &face["error_mm_max"]),
        (&"table".into(), &0.0.into())
    );
    assert_eq!(face["controls"], table["targets"]);
    let faps = table["faps"].as_array().unwrap();
    assert!(faps.contains(&3.into()) && faps.contains(&19.into()));
    // The lid goes round the eye, in several parts.
    let meshes = character(&here.join("a.glb")).meshes;
    let names: Vec<&String> = meshes.iter().flat_map(|m| &m.morph_names).collect();
    let of = |start: &str| names.iter().filter(|n| n.starts_with(start)).count();
    assert!(of("fap19_") > 2, "{names:?}");

    // Chin and lid go down by what the values say in the units of the face.
    let layout = json(&here, &["inspect", "bald.glb", "--face"]);
    let layout = &layout["face_layout"];
    let vertex = |name: &str| {
        let points = layout["points"].as_array().unwrap();
        let point = points.iter().find(|p| p["name"] == name).unwrap();
        point["vertex"].as_u64().unwrap() as usize
    };
    let unit = |name: &str| {
        let units = layout["units"].as_array().unwrap();
        let unit = units.iter().find(|u| u["name"] == name).unwrap();
        unit["distance_m"].as_f64().unwrap() as f32 / 1024.0
    };
    for secs in [0.3, 1.0, 2.0] {
        let moved = displacements(&here.join("a.glb"), secs);
        let (chin, lid) = (moved[vertex("2.1")].y, moved[vertex("3.1")].y);
        assert!(
            (chin + 450.0 * secs * unit("MNS")).abs() < 2e-4,
            "{chin} at {secs} s"
        );
        // Beyond 205 units a lid makes up for the opening being another than the iris, so that 1024
        // close the eye.
        let said = 300.0 * secs * unit("IRISD");
        let off = if 300.0 * secs < 205.0 {
            4e-4
        } else {
            0.3 * said
        };
        assert!((lid + said).abs() < off, "{lid} at {secs} s");
    }
}

#[test]
fn a_table_leaves_blend_shapes_and_clips_as_they_are() {
    let Some((here, head)) = bald("face-table-kept") else {
        return;
    };
    say(&here.join("say.fap"));
    let words = [
        "convert",
        "say.fap",
        "b.glb",
        "--onto",
        word(&head),
        "--face-shapes=fat",
        "--keep-clips",
    ];
    let report = json(&here, &words);
    assert_eq!(report["onto"]["faces"][0]["columns"], "table");
    let (before, after) = (character(&head), character(&here.join("b.glb")));
    let shapes = before.meshes[0].morph_names.len();
    assert_eq!(
        after.meshes[0].morph_names[..shapes],
        before.meshes[0].morph_names[..]
    );
    let clip = |read: &Character, count: usize| {
        let is_it = |c: &&Channel| c.property == Property::Weights && c.target == 0;
        let channel = read.clips[0].channels.iter().find(is_it).unwrap();
        let mut weights = vec![0.0; count];
        evaluate::channel(channel, 0.7, &mut weights);
        weights
    };
    let all = after.meshes[0].morph_names.len();
    let own = clip(&before, shapes);
    assert_eq!(clip(&after, all)[..shapes], own[..]);
    assert!(own.iter().any(|w| *w > 0.0));
    let said = fault(
        &here,
        1,
        &["convert", "b.glb", "c.glb", "--face-shapes=fat"],
    );
    assert!(said.contains("a face animation table already"), "{said}");
}
