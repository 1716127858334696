//! MP4 files around streams: `convert` into them and out of them, what opens them, and how other
//! programs (a walker of boxes in node, ffprobe) read them.

use crate::judges::{ask, is_here, node_is_here};
use crate::program::{BVH, fault, folder, json, word};
use crate::real;
use articula::stream::{StreamLimits, Unit, abp1, abp2, afp1};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const FIGURE: &str = "glb/pab_arnaud.glb";
const TALK: &str = "fap/speech_synthetic.fap";

/// A figure and a face clip, and a folder for the streams of both.
fn made(name: &str) -> Option<(PathBuf, PathBuf)> {
    let (figure, talk) = (real::file(FIGURE)?, real::file(TALK)?);
    let here = folder(name);
    json(
        &here,
        &["convert", word(&figure), "walk.abp", "--clip", "walk"],
    );
    json(&here, &["convert", word(&talk), "talk.afp"]);
    Some((here, figure))
}

/// A part of an answer without the name of the file.
fn unnamed(part: &Value) -> Value {
    let mut part = part.clone();
    part.as_object_mut().map(|part| part.remove("file"));
    part
}

fn same(here: &Path, a: &str, b: &str) {
    let [a_bytes, b_bytes] = [a, b].map(|name| fs::read(here.join(name)).unwrap());
    assert!(a_bytes == b_bytes, "{a} and {b}");
}

#[test]
fn a_stream_comes_back_from_a_box_to_the_byte() {
    let Some((here, _)) = made("mp4-back") else {
        return;
    };
    fs::write(here.join("nod.bvh"), BVH).unwrap();
    json(
        &here,
        &["convert", "nod.bvh", "nod.abp", "--stream", "profile=abp1"],
    );
    json(
        &here,
        &["convert", "talk.afp", "old.afp", "--stream", "profile=afp1"],
    );
    json(&here, &["convert", "talk.afp", "talk.fba"]);
    for (stream, profile) in [
        ("walk.abp", "ABP-2"),
        ("nod.abp", "ABP-1"),
        ("talk.afp", "AFP-2"),
        ("old.afp", "AFP-1"),
        ("talk.fba", "FBA"),
    ] {
        let into = json(&here, &["convert", stream, "box.mp4"]);
        assert_eq!(
            (&into["format_out"], &into["warnings"]),
            (&"mp4".into(), &Value::Array(vec![]))
        );
        // From box to box, and out of it.
        json(&here, &["convert", "box.mp4", "again.mp4"]);
        let back = format!("back.{}", &stream[stream.len() - 3..]);
        let out = json(&here, &["convert", "again.mp4", &back]);
        assert_eq!(
            (&out["format_in"], &out["clips"]),
            (&"mp4".into(), &into["clips"])
        );
        same(&here, stream, &back);
        let found = json(&here, &["inspect", "box.mp4"]);
        let whole = json(&here, &["inspect", stream]);
        assert_eq!(found["tracks"][0]["profile"], profile);
        assert_eq!(found["tracks"][0]["bytes"], whole["bytes"]);
        assert_eq!(found["format"], "mp4");
        let size = fs::metadata(here.join("box.mp4")).unwrap().len();
        assert_eq!(
            (&found["bytes"], &into["bytes_out"]),
            (&size.into(), &size.into())
        );
        assert_eq!(whole["tracks"], Value::Null);
        for same in ["access_units", "tiers", "groups", "stream", "skeletons"] {
            assert_eq!(
                unnamed(&found[same]),
                unnamed(&whole[same]),
                "{stream}: {same}"
            );
        }
    }
}

#[test]
fn motions_go_into_a_box_as_into_a_stream() {
    let Some((here, figure)) = made("mp4-into") else {
        return;
    };
    let talk = real::file(TALK).unwrap();
    let options = ["--clip", "walk", "--stream", "tolerance-mm=0.4,tiers=2"];
    for (from, options, out) in [
        (word(&figure), &options[..], "x.abp"),
        (word(&talk), &options[2..], "x.afp"),
        (
            word(&talk),
            &["--stream", "profile=afp1", "--face-level", "low"],
            "y.afp",
        ),
        ("walk.abp", &["--onto", word(&figure)], "z.abp"),
    ] {
        let [plain, boxed] =
            [out, "x.mp4"].map(|out| json(&here, &[&["convert", from, out][..], options].concat()));
        assert_eq!(plain["tiers"], boxed["tiers"]);
        assert_eq!(plain["warnings"], boxed["warnings"]);
        let back = format!("back.{}", &out[2..]);
        json(&here, &["convert", "x.mp4", &back]);
        same(&here, out, &back);
    }
}

#[test]
fn a_box_opens_where_its_stream_does() {
    let (Some((here, figure)), Some(head)) =
        (made("mp4-opens"), real::file("glb/ict_head_talk_554.glb"))
    else {
        return;
    };
    let figure = word(&figure);
    json(&here, &["convert", "walk.abp", "walk.mp4"]);
    json(&here, &["convert", "talk.afp", "talk.mp4"]);
    let [plain, of_box] = ["walk.abp", "walk.mp4"].map(|from| {
        let report = json(&here, &["convert", from, "out.glb", "--onto", figure]);
        (report, fs::read(here.join("out.glb")).unwrap())
    });
    assert!(plain.1 == of_box.1);
    assert_eq!(of_box.0["format_in"], "mp4");
    let lod = |from| json(&here, &["lod", from, "--onto", figure, "--distances", "2"]);
    assert_eq!(lod("walk.abp")["tiers"], lod("walk.mp4")["tiers"]);
    for out in ["t.fap", "t.csv"] {
        let [plain, of_box] = ["talk.afp", "talk.mp4"].map(|from| {
            json(&here, &["convert", from, out]);
            fs::read(here.join(out)).unwrap()
        });
        assert_eq!(plain, of_box);
    }
    let [plain, of_box] = ["talk.afp", "talk.mp4"].map(|from| {
        json(&here, &["convert", from, "face.glb", "--onto", word(&head)]);
        fs::read(here.join("face.glb")).unwrap()
    });
    assert!(plain == of_box);
    // Of bones, with a skeleton of its own.
    fs::write(here.join("nod.bvh"), BVH).unwrap();
    json(
        &here,
        &["convert", "nod.bvh", "nod.mp4", "--stream", "profile=abp1"],
    );
    json(
        &here,
        &["convert", "nod.bvh", "nod.abp", "--stream", "profile=abp1"],
    );
    for from in ["nod.mp4", "nod.abp"] {
        json(&here, &["convert", from, &format!("{from}.glb")]);
    }
    let [a, b] = ["nod.mp4.glb", "nod.abp.glb"].map(|name| json(&here, &["inspect", name]));
    assert_eq!(a["clips"], b["clips"]);
    assert_eq!(a["map"], b["map"]);
}

#[test]
fn two_streams_share_a_box() {
    let Some((here, figure)) = made("mp4-two") else {
        return;
    };
    let both = json(
        &here,
        &["convert", "walk.abp", "both.mp4", "--with", "talk.afp"],
    );
    assert_eq!(both["clips"].as_array().unwrap().len(), 2);
    let talk = real::file(TALK).unwrap();
    json(
        &here,
        &["convert", "walk.abp", "same.mp4", "--with", word(&talk)],
    );
    same(&here, "both.mp4", "same.mp4");
    // In the same order from wherever the first comes.
    let clip = ["--clip", "walk", "--with", "talk.afp"];
    json(
        &here,
        &[&["convert", word(&figure), "same.mp4"][..], &clip].concat(),
    );
    same(&here, "both.mp4", "same.mp4");
    json(&here, &["convert", "both.mp4", "same.mp4"]);
    same(&here, "both.mp4", "same.mp4");
    json(
        &here,
        &["convert", word(&talk), "turned.mp4", "--with", "walk.abp"],
    );
    for (file, first, other) in [
        ("both.mp4", "ABP-2", "AFP-2"),
        ("turned.mp4", "AFP-2", "ABP-2"),
    ] {
        let found = json(&here, &["inspect", file]);
        let profile = |track: usize| &found["tracks"][track]["profile"];
        assert_eq!((profile(0), profile(1)), (&first.into(), &other.into()));
        let warnings = found["warnings"].as_array().unwrap();
        let left_out = warnings.iter().find(|w| w["at"] == "track 2").unwrap();
        assert!(
            left_out["what"].as_str().unwrap().contains(other),
            "{left_out}"
        );
        for stream in ["walk.abp", "talk.afp"] {
            let back = format!("back.{}", &stream[5..]);
            let out = json(&here, &["convert", file, &back]);
            same(&here, stream, &back);
            assert!(
                out["warnings"][0].as_str().unwrap().contains("left out"),
                "{out}"
            );
        }
        let fap = json(&here, &["convert", file, "out.fap"]);
        assert!(fap.to_string().contains("ABP-2 is left out"), "{fap}");
    }
    let glb = json(
        &here,
        &["convert", "both.mp4", "out.glb", "--onto", word(&figure)],
    );
    assert!(glb.to_string().contains("AFP-2 is left out"), "{glb}");
    let lod = json(
        &here,
        &[
            "lod",
            "both.mp4",
            "--onto",
            word(&figure),
            "--distances",
            "2",
        ],
    );
    assert!(lod["warnings"].to_string().contains("AFP-2 is left out"));
}

#[test]
fn what_cannot_be_boxed_or_opened_is_refused_in_one_line() {
    let Some((here, _)) = made("mp4-refused") else {
        return;
    };
    json(&here, &["convert", "walk.abp", "walk.mp4"]);
    json(&here, &["convert", "talk.afp", "talk.mp4"]);
    let mut cut = fs::read(here.join("walk.mp4")).unwrap();
    cut.truncate(cut.len() - 9);
    fs::write(here.join("cut.mp4"), &cut).unwrap();
    // The name of the sample entry is another one, as that of a video, and the file is by another writer:
    // it has neither the brand nor the box of checksums.
    let mut video = fs::read(here.join("walk.mp4")).unwrap();
    for (name, other) in [(b"urim", b"avcX"), (b"artc", b"mp41"), (b"uuid", b"free")] {
        let at = video.windows(4).position(|w| w == name).unwrap();
        video[at..at + 4].copy_from_slice(other);
    }
    fs::write(here.join("video.mp4"), &video).unwrap();
    for (status, words, expected) in [
        (1, &["convert", "cut.mp4", "a.abp"][..], "box mdat of"),
        (1, &["inspect", "cut.mp4"], "box mdat of"),
        (1, &["inspect", "video.mp4"], "its tracks hold avcX"),
        (
            1,
            &["convert", "video.mp4", "a.mp4"],
            "its tracks hold avcX",
        ),
        (
            1,
            &["convert", "video.mp4", "a.glb"],
            "its tracks hold avcX",
        ),
        (1, &["convert", "walk.mp4", "a.glb"], "--onto"),
        (2, &["convert", "talk.mp4", "a.glb"], "stream of a face"),
        (2, &["convert", "talk.mp4", "a.abp"], "stream of a face"),
        (
            2,
            &["convert", "walk.abp", "a.glb", "--with", "talk.afp"],
            "requires an .mp4 output",
        ),
        (
            1,
            &["convert", "walk.abp", "a.mp4", "--with", "none.afp"],
            "does not exist",
        ),
        (
            1,
            &["convert", "walk.abp", "a.mp4", "--with", "video.mp4"],
            "video.mp4: no track",
        ),
        (
            2,
            &[
                "convert", "walk.abp", "walk.mp4", "--with", "walk.mp4", "--force",
            ],
            "is an input",
        ),
        (
            2,
            &["convert", "walk.abp", "a.mp4", "--stream", "profile=afp1"],
            "requires an .afp output",
        ),
    ] {
        let why = fault(&here, status, words);
        assert!(why.contains(expected), "{words:?}: {why}");
        assert!(
            !here.join("a.mp4").exists() && !here.join("a.glb").exists(),
            "{words:?}"
        );
    }
    // A video among the files of a folder is no motion, and no fault either.
    let inputs = here.join("in");
    fs::create_dir(&inputs).unwrap();
    fs::rename(here.join("video.mp4"), inputs.join("video.mp4")).unwrap();
    fs::write(inputs.join("nod.bvh"), BVH).unwrap();
    let report = json(&here, &["convert", "in", "out/", "--to", "mp4"]);
    assert_eq!(report["files"].as_array().unwrap().len(), 1);
    assert!(here.join("out/nod.mp4").exists());
}

/// Bytes and frames of the access units of a stream, and the bytes before them.
fn access_units(stream: &[u8]) -> (Vec<u8>, Vec<Vec<u8>>) {
    let limits = StreamLimits::default();
    let map = match &stream[..4] {
        b"ABPF" => abp1::unit(stream, &limits),
        b"AFPF" => afp1::unit(stream, &limits),
        _ => abp2::motion_map(stream, &limits),
    };
    let map = map.unwrap();
    let bytes =
        |unit: &Unit| stream[unit.bits.start as usize / 8..unit.bits.end as usize / 8].to_vec();
    let units = map.children[1..].iter().map(bytes);
    (bytes(&map.children[0]), units.collect())
}

/// A file and the streams in it.
type Boxed = (&'static str, [&'static str; 2]);

/// Two files of two streams each, of all profiles, and their streams.
fn boxes(name: &str) -> Option<(PathBuf, [Boxed; 2])> {
    let (here, _) = made(name)?;
    let walk = real::file("bvh/cmu_12_01_walk.bvh")?;
    json(
        &here,
        &[
            "convert",
            word(&walk),
            "bones.abp",
            "--stream",
            "profile=abp1",
        ],
    );
    json(
        &here,
        &["convert", "talk.afp", "old.afp", "--stream", "profile=afp1"],
    );
    json(
        &here,
        &["convert", "walk.abp", "new.mp4", "--with", "talk.afp"],
    );
    json(
        &here,
        &["convert", "bones.abp", "old.mp4", "--with", "old.afp"],
    );
    Some((
        here,
        [
            ("new.mp4", ["walk.abp", "talk.afp"]),
            ("old.mp4", ["bones.abp", "old.afp"]),
        ],
    ))
}

#[test]
fn an_independent_walker_finds_every_access_unit() {
    if !node_is_here() {
        return;
    }
    let Some((here, files)) = boxes("mp4-walker") else {
        return;
    };
    for (file, streams) in files {
        let path = word(&here.join(file)).to_owned();
        let (answer, good) = ask("mp4_samples.mjs", &[path]);
        assert!(good, "{file}: {answer}");
        let found: Value = serde_json::from_str(&answer).unwrap();
        let told = json(&here, &["inspect", file]);
        for (i, stream) in streams.into_iter().enumerate() {
            let bytes = fs::read(here.join(stream)).unwrap();
            let (head, units) = access_units(&bytes);
            let track = &found["tracks"][i];
            assert_eq!(
                (&track["handler"], &track["entry"]),
                (&"meta".into(), &"urim".into())
            );
            assert_eq!(track["uri"], told["tracks"][i]["form"]);
            assert!(hex(&track["init"]) == head, "{stream}: head");
            let samples = track["samples"].as_array().unwrap();
            let samples: Vec<Vec<u8>> = samples.iter().map(|s| hex(&s["bytes"])).collect();
            assert!(samples == units, "{stream}: access units");
            // Every frame takes its time, also the last.
            let one = json(&here, &["inspect", stream]);
            let (frames, fps) = match &one["clips"][0] {
                Value::Null => (&one["frames"], &one["fps"]),
                clip => (&clip["frames"], &clip["fps"]),
            };
            let secs = frames.as_f64().unwrap() / fps.as_f64().unwrap();
            let difference = track["duration_secs"].as_f64().unwrap() - secs;
            assert!(difference.abs() < 1e-3, "{stream}: {track}");
        }
    }
}

fn hex(digits: &Value) -> Vec<u8> {
    let digit = |d: u8| char::from(d).to_digit(16).unwrap() as u8;
    let (pairs, _) = digits.as_str().unwrap().as_bytes().as_chunks::<2>();
    pairs
        .iter()
        .map(|[a, b]| digit(*a) << 4 | digit(*b))
        .collect()
}

#[test]
fn ffprobe_finds_every_access_unit() {
    if !is_here("ffprobe", "-version") {
        return;
    }
    let Some((here, files)) = boxes("mp4-ffprobe") else {
        return;
    };
    for (file, streams) in files {
        let output = Command::new("ffprobe")
            .args([
                "-v",
                "error",
                "-show_packets",
                "-show_streams",
                "-of",
                "json",
                file,
            ])
            .current_dir(&here)
            .output()
            .unwrap();
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        let whole = fs::read(here.join(file)).unwrap();
        for (i, stream) in streams.into_iter().enumerate() {
            assert_eq!(found["streams"][i]["codec_type"], "data");
            assert_eq!(found["streams"][i]["codec_tag_string"], "urim");
            let packets = found["packets"].as_array().unwrap();
            let of_stream = packets.iter().filter(|p| p["stream_index"] == i);
            let number = |value: &Value| value.as_str().unwrap().parse::<usize>().unwrap();
            let packet = |packet: &Value| {
                assert!(
                    packet["flags"].as_str().unwrap().starts_with('K'),
                    "{packet}"
                );
                let start = number(&packet["pos"]);
                whole[start..start + number(&packet["size"])].to_vec()
            };
            let found: Vec<Vec<u8>> = of_stream.map(packet).collect();
            let (_, units) = access_units(&fs::read(here.join(stream)).unwrap());
            assert!(found == units, "{stream}");
        }
    }
}
