//! BVA segments without a hierarchy are assembled by their names, with a warning.

use crate::program::{fault, folder, json};

/// A figure in inches that lifts its left arm, with Biovision's names.
fn figure(rename: impl Fn(&str) -> String) -> String {
    let places = [
        ("Hips", 0.0, 36.0),
        ("Chest", 0.0, 45.0),
        ("Head", 0.0, 60.0),
        ("LeftUpArm", 7.0, 55.0),
        ("LeftLowArm", 7.0, 44.0),
        ("RightUpArm", -7.0, 55.0),
        ("LeftUpLeg", 3.0, 34.0),
        ("LeftLowLeg", 3.0, 18.0),
        ("RightUpLeg", -3.0, 34.0),
        ("RightLowLeg", -3.0, 18.0),
    ];
    let segment = |(name, x, y): (&str, f32, f32)| {
        let mut text = format!(
            "Segment: {}\nFrames: 4\nFrame Time: 0.0333333\nXTRAN YTRAN ZTRAN XROT YROT ZROT\n\
             INCHES INCHES INCHES DEGREES DEGREES DEGREES\n",
            rename(name)
        );
        for frame in 0..4 {
            let turn = if matches!(name, "LeftUpArm" | "LeftLowArm") {
                30 * frame
            } else {
                0
            };
            // The elbow follows: 11 inches below the shoulder, rotated about z.
            let (sine, cosine) = (30.0 * frame as f32).to_radians().sin_cos();
            let (x, y) = match name {
                "LeftLowArm" => (7.0 + 11.0 * sine, 55.0 - 11.0 * cosine),
                _ => (x, y),
            };
            text.push_str(&format!("{x} {y} 0 0 0 {turn}\n"));
        }
        text
    };
    places.into_iter().map(segment).collect()
}

#[test]
fn known_names_make_a_figure() {
    let here = folder("known");
    std::fs::write(here.join("a.bva"), figure(str::to_owned)).unwrap();
    let found = json(&here, &["inspect", "a.bva"]);
    assert_eq!(found["format"], "bva");
    let skeleton = &found["skeletons"][0];
    assert_eq!(
        (&skeleton["joints"], &skeleton["profile"]),
        (&10.into(), &"biovision".into())
    );
    assert_eq!(skeleton["root"], "Hips");
    assert_eq!(
        found["clips"][0]["joints_animated"], 1,
        "the elbow only follows"
    );
    assert!(
        found["warnings"]
            .to_string()
            .contains("10 of 10 segments are connected")
    );
    let height = found["height_m"].as_f64().unwrap();
    assert!((height - 42.0 * 0.0254).abs() < 1e-4, "{height}");

    json(&here, &["convert", "a.bva", "b.bvh"]);
    let text = std::fs::read_to_string(here.join("b.bvh")).unwrap();
    assert!(text.contains("ROOT Hips") && text.contains("JOINT LeftLowArm"));
    assert_eq!(text.matches("CHANNELS 6").count(), 1, "only the root moves");
    let why = fault(&here, 2, &["convert", "a.bva", "c.bva"]);
    assert!(
        why.contains("conversion from bva to bva is not supported"),
        "{why}"
    );
}

#[test]
fn unknown_names_stay_side_by_side() {
    let here = folder("unknown");
    let named = |name: &str| format!("x{}", name.len());
    std::fs::write(here.join("a.txt"), figure(named)).unwrap();
    let found = json(&here, &["inspect", "a.txt"]);
    assert_eq!(found["format"], "bva", "detected by its first word");
    assert!(
        found["warnings"]
            .to_string()
            .contains("the segments move independently")
    );
    assert_eq!(found["clips"][0]["frames"], 4);
    json(&here, &["convert", "a.txt", "b.glb"]);
}
