//! Captures of Live Link Face: to FAP and back, onto faces, and from their clips.

use crate::program::{fault, folder, json, word};
use crate::real;
use articula::core::arkit_table::BLEND_SHAPES;
use articula::face::{FaceRig, capture_of_clip, capture_to_faps};
use articula::formats::{Limits, live_link};
use std::fmt::Write as _;

/// Two seconds at 30 Hz: the jaw opens and closes, the left eye blinks, the head turns.
fn capture() -> String {
    let mut text = "Timecode,BlendShapeCount,jawOpen,eyeBlinkLeft,HeadYaw\n".to_owned();
    for frame in 0..61 {
        let (jaw, blink) = (f64::from(frame % 30) / 30.0, f64::from(frame % 7) / 7.0);
        let _ = writeln!(
            text,
            "10:00:{:02}:{:02}.0,61,{jaw},{blink},0.1",
            frame / 30,
            frame % 30
        );
    }
    text
}

#[test]
fn a_capture_becomes_fap_and_comes_back() {
    let here = folder("capture");
    std::fs::write(here.join("a.csv"), capture()).unwrap();
    let found = json(&here, &["inspect", "a.csv"]);
    assert_eq!(
        (&found["format"], &found["clips"][0]["fps"]),
        (&"csv".into(), &30.0.into())
    );
    assert_eq!(found["shapes"].as_array().unwrap().len(), 2);
    let report = json(&here, &["convert", "a.csv", "a.fap"]);
    assert_eq!(report["capture"]["frames"], 61);
    assert_eq!(report["capture"]["shapes_moving"], 2);
    for shape in report["capture"]["shapes"].as_array().unwrap() {
        assert!(shape["max_percent"].as_f64().unwrap() < 1.0, "{shape}");
    }
    let faps = json(&here, &["inspect", "a.fap"]);
    let moving = faps["parameters"].as_array().unwrap().iter();
    let moving: Vec<u64> = moving
        .filter(|p| p["moves"] == true)
        .map(|p| p["fap"].as_u64().unwrap())
        .collect();
    // Jaw, lower lips inside and outside, left lids, yaw of the head.
    assert_eq!(moving, [3, 5, 10, 11, 19, 21, 49, 52, 57, 58]);
    let back = json(&here, &["convert", "a.fap", "b.csv"]);
    assert_eq!(back["capture"]["shapes_moving"], 2);
    assert!(back["capture"]["not_shown"].as_array().unwrap().is_empty());
    let read = |name: &str| {
        let bytes = std::fs::read(here.join(name)).unwrap();
        live_link::read(&bytes, &Limits::default()).unwrap().value
    };
    for (a, b) in read("a.csv").frames.iter().zip(&read("b.csv").frames) {
        assert!((a.secs - b.secs).abs() < 1e-3);
        let pairs = a.shapes.iter().zip(&b.shapes);
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 0.01));
        // An angle unit is 1e-5 rad.
        assert!((a.angles[0] - b.angles[0]).abs() < 1e-5);
    }
    let said = fault(&here, 2, &["convert", "a.csv", "b.glb"]);
    assert!(said.contains("a CSV capture animates a face"), "{said}");
    std::fs::write(here.join("bad.csv"), capture().replace("10:00:", "ten:")).unwrap();
    let said = fault(&here, 1, &["convert", "bad.csv", "c.fap"]);
    assert!(
        said.contains("bad.csv: line 2: column 1: \"ten:00:00.0\" found"),
        "{said}"
    );
}

#[test]
fn a_face_takes_a_capture_as_it_is_and_gives_it_back() {
    let Some(head) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let here = folder("capture-onto");
    std::fs::write(here.join("a.csv"), capture()).unwrap();
    let report = json(&here, &["convert", "a.csv", "a.glb", "--onto", word(&head)]);
    let face = &report["onto"]["faces"][0];
    assert_eq!((&face["name"], &face["frames"]), (&"a".into(), &61.into()));
    assert_eq!(face["error_mm_max"], 0.0);
    let read = articula::fs::open(here.join("a.glb")).unwrap();
    let capture = capture_of_clip(&read, &read.character().clips[0]).unwrap();
    assert_eq!(capture.frames.len(), 61);
    let shape = |name: &str| BLEND_SHAPES.iter().position(|s| s.name == name).unwrap();
    for (index, frame) in capture.frames.iter().enumerate() {
        assert!((frame.shapes[shape("jawOpen")] - (index % 30) as f32 / 30.0).abs() < 1e-5);
    }
    // The same by the command.
    json(&here, &["convert", "a.glb", "b.fap", "--clip", "a"]);
    let bridge = FaceRig::new(&read).unwrap().capture_bridge(&read).unwrap();
    let (faps, _) = capture_to_faps(&capture, "a", &bridge).unwrap();
    let written = articula::formats::mpeg4::fap::write(&faps);
    assert_eq!(std::fs::read(here.join("b.fap")).unwrap(), written);
    let said = fault(&here, 2, &["convert", "a.glb", "c.fap", "--clip", "none"]);
    assert!(said.contains("there is no clip \"none\""), "{said}");
}
