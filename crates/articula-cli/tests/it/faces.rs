//! Feature points of faces: `inspect --face`.

use crate::judges::{ask, judges_are_here};
use crate::program::{articula, edited, fault, folder, json, word};
use crate::real;
use articula::formats::Limits;
use articula::formats::mpeg4::fap::FapClip;
use articula::formats::mpeg4::fdp;
use articula::{Data, DataFormat, OpenOptions};
use serde_json::Value;
use std::path::Path;

/// A point of a report.
fn point<'a>(found: &'a Value, name: &str) -> &'a Value {
    let points = found["face_layout"]["points"].as_array().unwrap();
    points.iter().find(|p| p["name"] == name).unwrap()
}

fn place(found: &Value, name: &str) -> Vec<f64> {
    let place = point(found, name)["place_m"].as_array().unwrap();
    place.iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn points_of_a_face_are_found_drawn_written_and_given_back() {
    let Some(head) = real::file("glb/ict_head_talk_1095.glb") else {
        return;
    };
    let here = folder("face-points");
    let head = word(&head);
    let words = [
        "inspect",
        head,
        "--write",
        "face-sheet=face.png,face-points=face.json",
    ];
    let found = json(&here, &words);
    assert_eq!(
        found["written"],
        serde_json::json!(["face.png", "face.json"])
    );
    let picture = std::fs::read(here.join("face.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    let points = found["face_layout"]["points"].as_array().unwrap();
    assert_eq!(points.len(), 84);
    // The head looks along +Z and its left is +X.
    let at = |name: &str| place(&found, name);
    assert!(at("3.7")[0] > at("3.11")[0] && at("3.11")[0] > at("3.8")[0]);
    assert!(at("9.3")[2] > at("2.2")[2] && at("2.2")[2] > at("10.5")[2]);
    assert!(at("11.4")[1] > at("4.1")[1] && at("4.1")[1] > at("2.2")[1]);
    assert!(at("2.2")[1] > at("2.1")[1]);
    // The decimated head keeps the proportions of the one that it was made from.
    for unit in found["face_layout"]["units"].as_array().unwrap() {
        let ratio = unit["ratio"].as_f64().unwrap();
        assert!((0.8..1.25).contains(&ratio), "{unit}");
    }

    // Files are kept, and points are not written over those that were read.
    let said = fault(&here, 1, &words);
    assert!(
        said.contains("face.png") && said.contains("--force"),
        "{said}"
    );
    let same = [
        "--face-points",
        "face.json",
        "--write",
        "face-points=face.json",
    ];
    fault(
        &here,
        2,
        &[&["inspect", head, "--force"], &same[..]].concat(),
    );

    let mut given: Value =
        serde_json::from_slice(&std::fs::read(here.join("face.json")).unwrap()).unwrap();
    let members = given["points"].as_object_mut().unwrap();
    members.retain(|name, _| name == "2.1");
    members["2.1"][1] = (at("2.1")[1] - 0.004).into();
    std::fs::write(here.join("chin.json"), given.to_string()).unwrap();
    let moved = json(&here, &["inspect", head, "--face-points", "chin.json"]);
    assert_eq!(point(&moved, "2.1")["source"], "given");
    let lower = |name: &str| at(name)[1] - place(&moved, name)[1];
    assert!((lower("2.1") - 0.004).abs() < 1e-5);
    // What is near follows, what is far stays.
    assert!(lower("2.11") > 0.001 && lower("4.1").abs() < 0.001);
}

#[test]
fn what_cannot_be_done_is_said() {
    let here = folder("face-points-refused");
    if let Some(robot) = real::file("glb/RobotExpressive.glb") {
        let said = fault(&here, 1, &["inspect", word(&robot), "--face"]);
        assert!(said.contains("RobotExpressive.glb: face: "), "{said}");
    }
    let Some(head) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let head = word(&head);
    std::fs::write(here.join("bad.json"), r#"{"points": {"2.99": [0, 0, 0]}}"#).unwrap();
    let said = fault(&here, 1, &["inspect", head, "--face-points", "bad.json"]);
    assert!(
        said.contains("bad.json: points.2.99: no such feature point"),
        "{said}"
    );
    let words = ["inspect", head, "--write", "face-sheet=face.jpg"];
    let ran = articula(&here, &words);
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("name the file .png"), "{}", ran.err);
    let fdp = r#"<?xml version="1.0"?><xfdp><file version="0.2"/><fapu IRISD0="1" ES0="1" ENS0="1" MNS0="1" MW0="1"/>
<fdp index="99999" affects="head" name="2.1"><indices></indices></fdp></xfdp>"#;
    std::fs::write(here.join("far.fdp"), fdp).unwrap();
    let said = fault(&here, 2, &["inspect", head, "--face-points", "far.fdp"]);
    assert!(
        said.contains("far.fdp: point 2.1: the figure has no vertex 99999"),
        "{said}"
    );
    std::fs::write(here.join("near.fdp"), fdp.replace("99999", "3")).unwrap();
    let found = json(&here, &["inspect", head, "--face-points", "near.fdp"]);
    assert_eq!(point(&found, "2.1")["source"], "given");
}

#[test]
fn a_face_is_written_as_fdp_and_read_back() {
    let Some(head) = real::file("glb/ict_head_talk_1095.glb") else {
        return;
    };
    let here = folder("face-fdp");
    let head = word(&head);
    let found = json(&here, &["inspect", head, "--write", "face-points=a.fdp"]);
    let bytes = std::fs::read(here.join("a.fdp")).unwrap();
    let file = fdp::read(&bytes, &Limits::default()).unwrap().value;
    for unit in found["face_layout"]["units"].as_array().unwrap() {
        let length = unit["distance_m"].as_f64().unwrap() as f32;
        let written = match unit["name"].as_str().unwrap() {
            "IRISD" => file.fapu.irisd0,
            "ES" => file.fapu.es0,
            "ENS" => file.fapu.ens0,
            "MNS" => file.fapu.mns0,
            "MW" => file.fapu.mw0,
            other => panic!("{other}"),
        };
        assert!((written - length).abs() < 1e-6, "{unit}");
    }
    // Left and right corners of the lips: zones of their own, each with its vertex.
    let of = |point| file.points.iter().find(|p| p.point == point).unwrap();
    let [left, right, chin] = [(2, 4), (2, 5), (2, 1)].map(of);
    assert!(left.zone.contains(&left.vertex) && !left.zone.contains(&right.vertex));
    assert_eq!(
        left.influences.iter().map(|i| i.fap).collect::<Vec<_>>(),
        [6, 12]
    );
    assert!(chin.zone.len() > left.zone.len());
    // The vertices that stand for the points are given back.
    let back = json(&here, &["inspect", head, "--face-points", "a.fdp"]);
    for at in &file.points {
        let name = format!("{}.{}", at.point.0, at.point.1);
        assert_eq!(point(&back, &name)["source"], "given");
        assert_eq!(point(&found, &name)["vertex"], at.vertex, "{name}");
    }
}

/// How each point of a report was found.
fn sources(found: &Value) -> Vec<&Value> {
    let points = found["face_layout"]["points"].as_array().unwrap();
    points.iter().map(|p| &p["source"]).collect()
}

#[test]
fn assets_keep_the_points_of_their_face() {
    let Some(head) = real::file("glb/ict_head_talk_1095.glb") else {
        return;
    };
    let here = folder("face-asset");
    let head = word(&head);
    let built = json(&here, &["build", head, "a.glb"]);
    assert_eq!(built["face_points"], 84);
    let [found, kept] = [head, "a.glb"].map(|file| json(&here, &["inspect", file, "--face"]));
    assert_eq!(sources(&found), sources(&kept));
    for name in ["2.1", "6.1", "9.3", "10.7"] {
        assert_eq!(point(&found, name)["vertex"], point(&kept, name)["vertex"]);
        for (a, b) in place(&found, name).iter().zip(place(&kept, name)) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    // A point that is given stays given when the asset is built again.
    let mut nose = place(&found, "9.3");
    nose[1] += 0.004;
    let given = serde_json::json!({"points": {"9.3": nose}});
    std::fs::write(here.join("nose.json"), given.to_string()).unwrap();
    let built = json(
        &here,
        &["build", head, "b.glb", "--face-points", "nose.json"],
    );
    assert_eq!(built["face_points"], 84);
    json(&here, &["build", "b.glb", "c.glb"]);
    let kept = json(&here, &["inspect", "c.glb", "--face"]);
    assert_eq!(point(&kept, "9.3")["source"], "given");
    assert!((place(&kept, "9.3")[1] - nose[1]).abs() < 1e-6);

    // Points of another face are found again.
    edited(&here.join("b.glb"), &here.join("d.glb"), |document| {
        let face = &mut document["extensions"]["ARTICULA_face"];
        for point in face["points"].as_object_mut().unwrap().values_mut() {
            let height = &mut point["position"][1];
            *height = (height.as_f64().unwrap() + 0.1).into();
        }
    });
    let again = json(&here, &["inspect", "d.glb", "--face"]);
    assert_eq!(sources(&again), sources(&found));

    if judges_are_here() {
        let judged = |file: &str| {
            let schemas = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/formats");
            let words = [schemas.to_owned(), word(&here.join(file)).to_owned()];
            ask("schemas.mjs", &words)
        };
        let (verdict, good) = judged("c.glb");
        assert!(good, "{verdict}");
        edited(&here.join("c.glb"), &here.join("e.glb"), |document| {
            let face = document["extensions"]["ARTICULA_face"].as_object_mut();
            face.unwrap().remove("rotation");
        });
        let (verdict, good) = judged("e.glb");
        assert!(!good && verdict.contains("ARTICULA_face"), "{verdict}");
    }
}

/// The FAP clip of a file.
fn fap_clip(file: &Path) -> FapClip {
    let bytes = std::fs::read(file).unwrap();
    let options = OpenOptions::default();
    let read = articula::open_data(&bytes, word(file), DataFormat::Fap, &options);
    match read.unwrap().data {
        Data::Fap(clip) => clip,
        _ => panic!("{} is no FAP clip", file.display()),
    }
}

#[test]
fn a_face_clip_becomes_a_vrm_animation_and_comes_back() {
    let Some(talk) = real::file("fap/speech_synthetic.fap") else {
        return;
    };
    let here = folder("face-vrma");
    let made = json(&here, &["convert", word(&talk), "a.vrma"]);
    assert_eq!(made["format_out"], "vrma");
    let tracks = made["capture"]["shapes_moving"].as_u64().unwrap();
    let found = json(&here, &["inspect", "a.vrma"]);
    let names = found["expressions"].as_array().unwrap();
    assert_eq!(names.len() as u64, tracks);
    assert!(names.iter().any(|e| e["name"] == "aa"));
    let back = json(&here, &["convert", "a.vrma", "b.fap"]);
    assert_eq!(back["format_in"], "vrma");
    // What the presets say of the speech: the jaw opens as far, within what five vowels can show.
    let [a, b] = [talk.clone(), here.join("b.fap")].map(|file| {
        let (_, most) = fap_clip(&file).range(3).unwrap();
        most
    });
    assert!(2 * a > b && 2 * b > a, "{a} and {b}");
    fault(&here, 2, &["convert", "a.vrma", "b.vrma", "--loa", "Low"]);
}

#[test]
fn the_parameters_of_a_distance_are_written() {
    let (Some(talk), Some(head)) = (
        real::file("fap/speech_synthetic.fap"),
        real::file("glb/ict_head_talk_1095.glb"),
    ) else {
        return;
    };
    let here = folder("face-chosen");
    let words = ["lod", word(&talk), "--onto", word(&head)];
    let line = fault(&here, 2, &[&words[..], &["--write", "fap=c.fap"]].concat());
    assert!(line.contains("--distances"), "{line}");
    let more = ["--distances", "3.5", "--write", "fap=c.fap"];
    let chosen = json(&here, &[&words[..], &more].concat());
    assert_eq!(chosen["written"], serde_json::json!(["c.fap"]));
    let kept = chosen["rows"][0]["chosen"].as_array().unwrap();
    let moving = fap_clip(&here.join("c.fap")).moving();
    let faps: Vec<u64> = (1..=68_u64).filter(|f| moving[*f as usize - 1]).collect();
    assert_eq!(serde_json::json!(faps), serde_json::json!(kept));
    assert!(faps.len() < 12 && faps.contains(&3), "{faps:?}");
}
