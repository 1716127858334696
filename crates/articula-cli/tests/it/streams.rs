//! Streams of bones and of facial animation parameters: `convert` and `inspect`.

use crate::program::{articula, fault, folder, json, word};
use crate::real;
use serde_json::Value;

/// Sum of a field of rows.
fn sum(rows: &Value, field: &str) -> f64 {
    let rows = rows.as_array().unwrap();
    rows.iter().map(|row| row[field].as_f64().unwrap()).sum()
}

/// Sum of numbers.
fn sum_of(numbers: &Value) -> f64 {
    let numbers = numbers.as_array().unwrap();
    numbers.iter().map(|n| n.as_f64().unwrap()).sum()
}

/// Every bit belongs to a level and a region, or to what all have in common.
fn check_shares(found: &Value) {
    let stream = &found["stream"];
    let bytes = found["bytes"].as_f64().unwrap();
    let common = stream["bytes_common"].as_f64().unwrap();
    for shares in ["loa", "regions"] {
        assert_eq!(sum(&stream[shares], "bytes") + common, bytes, "{stream}");
    }
    assert_eq!(
        sum(&stream["loa"], "items"),
        sum(&stream["regions"], "items")
    );
}

#[test]
fn a_motion_goes_through_abp1_and_its_text() {
    let Some(walk) = real::file("bvh/cmu_12_01_walk.bvh") else {
        return;
    };
    let here = folder("abp1");
    let written = json(
        &here,
        &[
            "convert",
            word(&walk),
            "walk.abp",
            "--stream",
            "profile=abp1",
        ],
    );
    assert_eq!(written["format_out"], "abp");
    let found = json(&here, &["inspect", "walk.abp"]);
    assert_eq!(found["articulation_stored"], true);
    let stream = &found["stream"];
    // 524 frames, 16 in each.
    assert_eq!(
        (&stream["profile"], &stream["access_units"]),
        (&"ABP-1".into(), &33.into())
    );
    check_shares(&found);
    json(&here, &["convert", "walk.abp", "walk.abpt"]);
    let text = json(&here, &["inspect", "walk.abpt"]);
    let back = json(&here, &["convert", "walk.abpt", "walk.glb"]);
    assert_eq!(back["format_in"], "abpt");
    let glb = json(&here, &["inspect", "walk.glb"]);
    for other in [&text, &glb] {
        assert_eq!(other["clips"][0]["frames"], found["clips"][0]["frames"]);
        assert_eq!(other["stream"], Value::Null);
    }
    let why = fault(
        &here,
        2,
        &[
            "convert",
            word(&walk),
            "other.glb",
            "--stream",
            "profile=abp1",
        ],
    );
    assert!(
        why.contains("requires an .abp, .afp or .mp4 output"),
        "{why}"
    );
}

#[test]
fn a_motion_stream_comes_back_onto_its_character() {
    let Some(figure) = real::file("glb/pab_arnaud.glb") else {
        return;
    };
    let here = folder("abp2");
    let figure = word(&figure);
    let options = [
        "--clip",
        "walk",
        "--stream",
        "tolerance-mm=0.2,tiers=3,group-by=region",
    ];
    let written = json(
        &here,
        &[&["convert", figure, "walk.abp"][..], &options].concat(),
    );
    let tiers = written["tiers"].as_array().unwrap();
    assert_eq!(tiers.len(), 3);
    for (tier, tolerance_mm) in tiers.iter().zip([0.2, 0.6, 1.8]) {
        assert!((tier["tolerance_mm"].as_f64().unwrap() - tolerance_mm).abs() < 1e-9);
        assert!(
            tier["error_mm_max"].as_f64().unwrap() <= tolerance_mm,
            "{tier}"
        );
    }
    // What a cut to a tier has is told when it is written, by its map, and after a real cut.
    let found = json(&here, &["inspect", "walk.abp"]);
    let layers = json(
        &here,
        &["lod", "walk.abp", "--onto", figure, "--distances", "2"],
    );
    for (i, tier) in tiers.iter().enumerate() {
        assert_eq!(found["tiers"][i]["bytes"], tier["bytes"]);
        assert_eq!(layers["tiers"][i]["bytes"], tier["bytes"]);
    }
    let units: f64 = found["groups"]
        .as_array()
        .unwrap()
        .iter()
        .map(|group| sum_of(&group["bytes"]))
        .sum();
    let of = found["access_units"]["of"].as_f64().unwrap();
    assert_eq!(found["access_units"]["whole"], found["access_units"]["of"]);
    // Each access unit has a length of four bytes.
    let lengths = of * 4.0;
    let bytes = found["bytes"].as_f64().unwrap();
    assert_eq!(
        units + lengths + found["bytes_head"].as_f64().unwrap(),
        bytes
    );
    for layer in layers["groups"].as_array().unwrap() {
        assert!(layer["bytes"].as_f64().unwrap() < bytes, "{layer}");
        assert!(layer["error_mm_max"].as_f64().unwrap() > 0.0, "{layer}");
        assert!(layer["worst"]["vertex"].is_number(), "{layer}");
    }
    let back = json(
        &here,
        &["convert", "walk.abp", "back.glb", "--onto", figure],
    );
    assert_eq!(back["onto"]["motions"][0]["by_name"], true);
    let [before, after] = [&[figure, "--clip", "walk"][..], &["back.glb"]]
        .map(|words| json(&here, &[&["inspect"], words].concat()));
    assert_eq!(before["clips"][0]["frames"], after["clips"][0]["frames"]);
}

#[test]
fn a_motion_stream_needs_its_character() {
    let (Some(figure), Some(other)) = (
        real::file("glb/pab_arnaud.glb"),
        real::file("glb/CesiumMan.glb"),
    ) else {
        return;
    };
    let here = folder("abp2-faults");
    json(&here, &["convert", word(&figure), "walk.abp"]);
    let why = fault(&here, 1, &["convert", "walk.abp", "out.glb"]);
    assert!(why.contains("--onto"), "{why}");
    let why = fault(
        &here,
        1,
        &["convert", "walk.abp", "out.glb", "--onto", word(&other)],
    );
    assert!(
        why.contains("walk.abp") && why.contains("67 joints"),
        "{why}"
    );
    let why = fault(
        &here,
        2,
        &["convert", word(&figure), "out.glb", "--stream", "tiers=3"],
    );
    assert!(
        why.contains("--stream requires an .abp, .afp or .mp4 output"),
        "{why}"
    );
    let walk = std::fs::read(here.join("walk.abp")).unwrap();
    std::fs::write(here.join("torn.abp"), &walk[..100]).unwrap();
    let why = fault(&here, 1, &["inspect", "torn.abp"]);
    assert!(why.contains("torn.abp") && why.contains("byte"), "{why}");
    let mut flipped = walk;
    let last = flipped.len() - 1;
    flipped[last] ^= 0x10;
    std::fs::write(here.join("flipped.abp"), flipped).unwrap();
    for words in [
        &["inspect", "flipped.abp"][..],
        &["convert", "flipped.abp", "out.glb", "--onto", word(&figure)],
    ] {
        let why = fault(&here, 1, words);
        assert!(why.contains("flipped.abp: byte"), "{why}");
        assert!(why.contains("the checksum of unit"), "{why}");
    }
}

#[test]
fn a_stream_that_ends_early_is_partial() {
    let (Some(figure), Some(talk)) = (
        real::file("glb/pab_arnaud.glb"),
        real::file("fap/speech_synthetic.fap"),
    ) else {
        return;
    };
    let here = folder("partial");
    let figure = word(&figure);
    json(&here, &["convert", figure, "a.abp", "--clip", "walk"]);
    json(&here, &["convert", word(&talk), "a.afp"]);
    for (whole, part, out, onto) in [
        ("a.abp", "b.abp", "b.glb", &["--onto", figure][..]),
        ("a.afp", "b.afp", "b.fap", &[]),
    ] {
        let bytes = std::fs::read(here.join(whole)).unwrap();
        std::fs::write(here.join(part), &bytes[..bytes.len() * 3 / 4]).unwrap();
        let count = |file: &str| {
            let found = json(&here, &["inspect", file]);
            let stream = if onto.is_empty() {
                &found["stream"]
            } else {
                &found
            };
            let count = |name: &str| stream["access_units"][name].as_u64().unwrap();
            (count("whole"), count("of"))
        };
        let (arrived, of) = count(part);
        assert!(0 < arrived && arrived < of, "{arrived} of {of}");
        assert_eq!(count(whole), (of, of));
        let told = format!("partial: {arrived} of {of} access units");
        let converted = json(&here, &[&["convert", part, out], onto].concat());
        let warnings = converted["warnings"].to_string();
        assert!(warnings.contains(&told), "{warnings}");
        let shown = articula(&here, &["inspect", part]).out;
        assert!(shown.contains(&told), "{shown}");
        let shown = articula(&here, &["inspect", whole]).out;
        assert!(!shown.contains("partial"), "{shown}");
        if !onto.is_empty() {
            let measured = json(&here, &[&["lod", part], onto].concat());
            assert_eq!(measured["warnings"], serde_json::json!([told]));
            assert_eq!(measured["tiers"][0]["error_mm_max"], 0.0);
        }
    }
    // A stream without its finer tiers has all access units.
    json(
        &here,
        &[
            "convert", figure, "c.abp", "--clip", "walk", "--stream", "tiers=1",
        ],
    );
    let found = json(&here, &["inspect", "c.abp"]);
    assert_eq!(found["access_units"]["whole"], found["access_units"]["of"]);
}

#[test]
fn a_stream_that_carries_the_skeleton_opens_without_its_character() {
    let (Some(figure), Some(other)) = (
        real::file("glb/pab_arnaud.glb"),
        real::file("glb/CesiumMan.glb"),
    ) else {
        return;
    };
    let here = folder("abp2-skeleton");
    let figure = word(&figure);
    let clip = ["--clip", "walk"];
    json(
        &here,
        &[&["convert", figure, "bare.abp"][..], &clip].concat(),
    );
    let with = [
        &["convert", figure, "own.abp", "--stream", "skeleton=yes"][..],
        &clip,
    ]
    .concat();
    json(&here, &with);
    let carries = |file: &str| json(&here, &["inspect", file])["skeleton"].clone();
    assert_eq!(
        (carries("bare.abp"), carries("own.abp")),
        (false.into(), true.into())
    );
    json(&here, &["convert", "own.abp", "own.glb"]);
    json(&here, &["convert", "own.abp", "own.bvh"]);
    json(
        &here,
        &["convert", "bare.abp", "onto.glb", "--onto", figure],
    );
    let [own, onto] = ["own.glb", "onto.glb"].map(|file| json(&here, &["inspect", file]));
    assert_eq!(own["clips"][0]["frames"], onto["clips"][0]["frames"]);
    assert_eq!(
        own["skeletons"][0]["joints"],
        onto["skeletons"][0]["joints"]
    );
    // Onto another figure it is a motion like any other; onto its own the joints are the same.
    let fitted = json(
        &here,
        &["convert", "own.abp", "other.glb", "--onto", word(&other)],
    );
    assert_eq!(fitted["onto"]["motions"][0]["by_name"], false);
    let same = json(&here, &["convert", "own.abp", "same.glb", "--onto", figure]);
    assert_eq!(same["onto"]["motions"][0]["by_name"], true);
    let why = fault(
        &here,
        2,
        &["convert", figure, "a.glb", "--stream", "skeleton=yes"],
    );
    assert!(
        why.contains("--stream requires an .abp, .afp or .mp4 output, not .glb"),
        "{why}"
    );
}

#[test]
fn a_face_clip_goes_through_fba() {
    let Some(talk) = real::file("fap/xface_joy.fap") else {
        return;
    };
    let here = folder("fba");
    let talk = word(&talk);
    let written = json(&here, &["convert", talk, "talk.fba"]);
    assert_eq!(written["format_out"], "fba");
    let [before, after] = [talk, "talk.fba"].map(|file| json(&here, &["inspect", file, "--map"]));
    assert_eq!(before["clips"][0]["frames"], after["clips"][0]["frames"]);
    let moving = |found: &Value| {
        let rows = found["parameters"].as_array().unwrap().iter();
        rows.filter(|row| row["moves"] == true)
            .map(|row| row["fap"].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(moving(&before), moving(&after));
    // Quantiser 1 changes no whole number; a FAP file selects what moves.
    json(&here, &["convert", "talk.fba", "talk.fap"]);
    std::fs::create_dir_all(here.join("again")).unwrap();
    json(&here, &["convert", "talk.fap", "again/talk.fba"]);
    json(&here, &["convert", "again/talk.fba", "again/talk.fap"]);
    let read = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert!(read("talk.fap") == read("again/talk.fap"));
    let first = read("talk.fba");
    std::fs::write(here.join("torn.fba"), &first[..first.len() / 2]).unwrap();
    let why = fault(&here, 1, &["inspect", "torn.fba"]);
    assert!(why.contains("torn.fba") && why.contains("byte"), "{why}");
}

#[test]
fn a_face_clip_goes_through_afp1() {
    let Some(talk) = real::file("fap/speech_synthetic.fap") else {
        return;
    };
    let here = folder("afp1");
    let talk = word(&talk);
    json(
        &here,
        &["convert", talk, "talk.afp", "--stream", "profile=afp1"],
    );
    let found = json(&here, &["inspect", "talk.afp"]);
    assert_eq!(found["stream"]["profile"], "AFP-1");
    check_shares(&found);
    json(
        &here,
        &[
            "convert",
            "talk.afp",
            "low.afp",
            "--stream",
            "profile=afp1",
            "--face-level",
            "low",
        ],
    );
    let low = json(&here, &["inspect", "low.afp"]);
    check_shares(&low);
    // Of the jaw, which alone moves, eleven parameters are left of 31.
    assert_eq!(sum(&found["stream"]["loa"], "items"), 31.0);
    assert_eq!(sum(&low["stream"]["loa"], "items"), 11.0);
    json(&here, &["convert", "talk.afp", "back.fap"]);
    let [before, after] = [talk, "back.fap"].map(|file| json(&here, &["inspect", file]));
    assert_eq!(before["clips"][0]["frames"], after["clips"][0]["frames"]);
    json(&here, &["convert", "talk.afp", "shapes.csv"]);
    json(&here, &["convert", "shapes.csv", "shapes.afp"]);
}

#[test]
fn a_face_clip_goes_through_afp2() {
    let Some(talk) = real::file("fap/speech_synthetic.fap") else {
        return;
    };
    let here = folder("afp2");
    let talk = word(&talk);
    let made = json(&here, &["convert", talk, "talk.afp"]);
    let found = json(&here, &["inspect", "talk.afp"]);
    assert_eq!(found["stream"]["profile"], "AFP-2");
    let (tiers, groups) = (&found["stream"]["tiers"], &found["stream"]["groups"]);
    assert_eq!(tiers.as_array().unwrap().len(), 3);
    for tier in 0..3 {
        assert_eq!(made["tiers"][tier]["bytes"], tiers[tier]["bytes"]);
    }
    // Only the jaw moves: one group for each of its levels.
    let groups: Vec<_> = groups.as_array().unwrap().iter().collect();
    assert_eq!(groups.len(), 4);
    assert!(groups.iter().all(|group| group["region"] == "jaw"));
    let low = json(
        &here,
        &[
            "convert",
            "talk.afp",
            "low.afp",
            "--face-level",
            "low",
            "--stream",
            "tiers=1",
        ],
    );
    assert_eq!(low["tiers"].as_array().unwrap().len(), 1);
    let groups = &json(&here, &["inspect", "low.afp"])["stream"]["groups"];
    assert_eq!(groups.as_array().unwrap().len(), 2);
    json(&here, &["convert", "talk.afp", "back.fap"]);
    let [before, after] = [talk, "back.fap"].map(|file| json(&here, &["inspect", file]));
    assert_eq!(before["clips"][0]["frames"], after["clips"][0]["frames"]);
    json(&here, &["convert", "talk.afp", "shapes.csv"]);
    json(
        &here,
        &[
            "convert",
            "shapes.csv",
            "shapes.afp",
            "--stream",
            "order=value",
        ],
    );
    for (flag, out) in [
        ("--stream=group-by=joint", "a.afp"),
        ("--stream=tiers=2", "a.fap"),
    ] {
        let why = fault(&here, 2, &["convert", "talk.afp", out, flag]);
        assert!(why.contains("requires an"), "{why}");
    }
}
