//! `adapt` and `gbsd`: one item in several contexts, by both engines.

use crate::judges::{is_here, is_required};
use crate::program::{articula, fault, folder, json, small, word};
use crate::real;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

/// Writes an item of a walking robot without forms in 2D, packaged once for all tests.
fn item(here: &Path) -> bool {
    static MADE: OnceLock<Option<BTreeMap<String, Vec<u8>>>> = OnceLock::new();
    let made = MADE.get_or_init(|| {
        let robot = real::file("glb/RobotExpressive.glb")?;
        let here = folder("adaptation-item");
        let words = ["package", word(&robot), "robot", "--clip", "Robot_Walking"];
        json(&here, &[&words[..], &["--levels", "3", "--no-2d"]].concat());
        Some(files(&here))
    });
    let Some(made) = made else { return false };
    for (name, bytes) in made {
        let path = here.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    true
}

/// All files below a folder with their bytes, without the report of the decision, which has times.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.file_name().unwrap() != "decision.json" {
                let name = path.strip_prefix(folder).unwrap();
                found.insert(name.display().to_string(), std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn an_item_is_cut_to_its_context_by_both_engines() {
    let here = folder("adaptation");
    if !item(&here) {
        return;
    }
    let whole = json(&here, &["adapt", "robot"]);
    assert_eq!(whole["bytes_in"], whole["bytes_out"]);
    assert_eq!(whole["decision"]["modality"], "3d");
    let bytes = whole["bytes_in"].as_f64().unwrap();
    // Two seconds at this bandwidth carry nine tenths.
    let kbps = format!("{:.3}", 0.9 * bytes * 8.0 / 2.0 / 1000.0);
    let less = ["adapt", "robot", "less", "--bandwidth-kbps", &kbps];
    let cut = json(&here, &less);
    let sent = cut["bytes_out"].as_f64().unwrap();
    assert!(sent <= 0.9 * bytes && sent < bytes, "{sent} of {bytes}");
    assert!((cut["decision"]["network_ratio"].as_f64().unwrap() - 0.9).abs() < 1e-3);
    let error = |report: &serde_json::Value| report["decision"]["error_px"].as_f64().unwrap();
    assert!(error(&cut) > error(&whole));
    let words = cut["decision"]["explanation"].as_str().unwrap();
    assert!(words.contains("limited by: the bytes"), "{words}");
    json(&here, &["convert", "less", "less.glb"]);
    let shown = json(&here, &["inspect", "less.glb"]);
    assert_eq!(shown["clips"][0]["name"], "Robot_Walking");
    // An adapted item is an item.
    let again = json(&here, &["inspect", "less"]);
    assert_eq!(again["bytes_sent"], cut["bytes_out"]);
    let upper = ["--loa", "2", "--zones", "upper"];
    let native = json(&here, &[&["adapt", "robot", "upper"][..], &upper].concat());
    assert_eq!(native["decision"]["loa"], 2);
    let zones = native["decision"]["zones"].as_array().unwrap();
    assert!(
        !zones.is_empty() && !zones.iter().any(|zone| zone == "legs"),
        "{zones:?}"
    );
    let words = native["decision"]["explanation"].as_str().unwrap();
    assert!(words.contains("without pelvis, legs: as asked"), "{words}");
    assert!(error(&native) > error(&whole) + 10.0);
    let one = json(&here, &["adapt", "robot", "one", "--clip", "Robot_Walking"]);
    assert_eq!(one["bytes_out"], whole["bytes_out"]);
    let why = fault(&here, 2, &["adapt", "robot", "--clip", "fly"]);
    assert!(why.contains("Robot_Walking"), "{why}");
    if !is_here("xsltproc", "--version") {
        assert!(!is_required("ARTICULA_REQUIRE_TOOLS"), "no xsltproc");
        return;
    }
    let xslt = [
        &["adapt", "robot", "upper-xslt", "--engine", "xslt"][..],
        &upper,
    ]
    .concat();
    assert_eq!(json(&here, &xslt)["engine"], "xslt");
    assert_eq!(files(&here.join("upper")), files(&here.join("upper-xslt")));
    let xslt = [
        &["adapt", "robot", "less-xslt", "--engine", "xslt"][..],
        &less[3..],
    ]
    .concat();
    json(&here, &xslt);
    assert_eq!(files(&here.join("less")), files(&here.join("less-xslt")));
    // A stylesheet of somebody else is not run.
    std::fs::write(here.join("robot/adapt.xslt"), b"<x/>").unwrap();
    let why = fault(&here, 1, &["adapt", "robot", "x", "--engine", "xslt"]);
    assert!(
        why.contains("adapt.xslt") && why.contains("gbsd stylesheet"),
        "{why}"
    );
}

#[test]
fn contexts_tables_and_descriptions_are_read_and_written() {
    let here = folder("adaptation-documents");
    if !item(&here) {
        return;
    }
    let context = r#"{"network": {"available_bps": 1e9}, "view": {"distance_m": 40}}"#;
    std::fs::write(here.join("far.json"), context).unwrap();
    let far = json(&here, &["adapt", "robot", "--context", "far.json"]);
    let near = json(
        &here,
        &[
            "adapt",
            "robot",
            "--context",
            "far.json",
            "--distance-m",
            "1",
        ],
    );
    assert!(far["bytes_out"].as_u64() < near["bytes_out"].as_u64());
    assert!(far["decision"]["error_px"].as_f64().unwrap() <= 1.0);
    let table = [
        "adapt",
        "robot",
        "--aqos",
        "robot/aqos.xml",
        "--bandwidth-kbps",
    ];
    let slow = json(&here, &[&table[..], &["30"]].concat());
    let fast = json(&here, &[&table[..], &["100000"]].concat());
    assert_eq!(fast["decision"]["by"], "aqos");
    assert!(slow["bytes_out"].as_u64() < fast["bytes_out"].as_u64());
    let why = fault(&here, 1, &["adapt", "robot", "--aqos", "robot/aqos.xml"]);
    assert!(
        why.contains("aqos.xml") && why.contains("BANDWIDTH"),
        "{why}"
    );

    // The description of a stream is that beside it in the item.
    let xml = articula(&here, &["gbsd", "robot", "clips/Robot_Walking.abp"]).out;
    let stored = std::fs::read(here.join("robot/clips/Robot_Walking.gbsd.xml")).unwrap();
    assert_eq!(xml.as_bytes(), stored);
    let alone = articula(&here, &["gbsd", "robot/mesh.ams"]).out;
    assert!(
        alone.contains("bitstreamURI=\"mesh.ams\""),
        "{}",
        &alone[..300]
    );
    let sheet = articula(&here, &["gbsd", "stylesheet"]).out;
    assert_eq!(
        sheet.as_bytes(),
        std::fs::read(here.join("robot/adapt.xslt")).unwrap()
    );
    let all = json(&here, &["gbsd", "robot", "--out", "documents"]);
    assert_eq!(all["written"].as_array().unwrap().len(), 5);

    let why = fault(&here, 2, &["gbsd", "robot"]);
    assert!(why.contains("clips/Robot_Walking.abp"), "{why}");
    let why = fault(&here, 2, &["gbsd", "robot", "clips/fly.abp"]);
    assert!(why.contains("is no stream of the item"), "{why}");
    let why = fault(&here, 1, &["gbsd", word(small())]);
    assert!(why.contains("no stream with units"), "{why}");
    let why = fault(&here, 2, &["adapt", word(small()), "out"]);
    assert!(why.contains("no digital item"), "{why}");
    let why = fault(&here, 2, &["adapt", "robot", "robot"]);
    assert!(why.contains("the item itself"), "{why}");
    let why = fault(&here, 1, &["adapt", "robot", "out", "--max-bytes", "10"]);
    assert!(why.contains("allow more bytes"), "{why}");
    assert!(why.contains("the least is "), "{why}");
    let slow = ["adapt", "robot", "--bandwidth-kbps", "1"];
    let why = fault(&here, 1, &slow);
    assert!(why.contains(" s at this bandwidth"), "{why}");
    std::fs::write(here.join("bad.xml"), b"<!DOCTYPE x><DIA/>").unwrap();
    let why = fault(&here, 1, &["adapt", "robot", "--context", "bad.xml"]);
    assert!(why.contains("bad.xml"), "{why}");
}

#[test]
fn an_item_is_played_over_a_trace() {
    let here = folder("adaptation-trace");
    if !item(&here) {
        return;
    }
    std::fs::write(here.join("slow.csv"), "# s, bit/s\n0 24000\n5 96000\n").unwrap();
    let words = [
        "adapt",
        "robot",
        "--trace",
        "slow.csv",
        "--play",
        "secs=10,clip=2,sample=0.5",
    ];
    let played = json(&here, &[&words[..], &["--plot", "slow.svg"]].concat());
    let playbacks = played["playbacks"].as_array().unwrap();
    let names: Vec<&str> = playbacks
        .iter()
        .map(|p| p["policy"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["joint", "thesis", "rate", "buffer"]);
    let number = |p: &serde_json::Value, key: &str| p[key].as_f64().unwrap();
    let (ours, thesis) = (&playbacks[0], &playbacks[1]);
    assert!(number(ours, "stalls") <= number(thesis, "stalls"));
    assert!(number(ours, "mean_error_px") < number(thesis, "mean_error_px"));
    assert_eq!(ours["samples"].as_array().unwrap().len(), 21);
    let svg = std::fs::read_to_string(here.join("slow.svg")).unwrap();
    assert!(svg.contains("ratio of the thesis") && svg.matches("<svg ").count() == 5);
    let text = articula(&here, &words).out;
    assert!(
        text.contains("joint choice, over time") && text.contains("nothing yet"),
        "{text}"
    );
    // What cannot be.
    std::fs::write(here.join("bad.csv"), "0 1\n0 2\n").unwrap();
    let why = fault(&here, 1, &["adapt", "robot", "--trace", "bad.csv"]);
    assert!(
        why.contains("bad.csv: line 2: 0 s does not come after"),
        "{why}"
    );
    let ran = articula(&here, &["adapt", "robot", "out", "--trace", "slow.csv"]);
    assert!(
        ran.status == 2 && ran.err.contains("--trace"),
        "{}",
        ran.err
    );
    let why = fault(
        &here,
        2,
        &["adapt", "robot", "--trace", "slow.csv", "--plot", "x.png"],
    );
    assert!(why.contains("name a .svg file"), "{why}");
}

#[test]
fn a_device_gets_what_it_bears() {
    let here = folder("adaptation-device");
    if !item(&here) {
        return;
    }
    let with = |score: &str| json(&here, &["adapt", "robot", "--device-score", score]);
    let error = |report: &serde_json::Value| report["decision"]["error_px"].as_f64().unwrap();
    let (fast, slow) = (with("100"), with("60"));
    assert!(fast["decision"]["device_ratio"].is_null());
    assert_eq!(slow["decision"]["device_ratio"], 0.6);
    assert!(error(&slow) > error(&fast) && slow["bytes_out"].as_u64() < fast["bytes_out"].as_u64());
    let words = slow["decision"]["explanation"].as_str().unwrap();
    let told = "60.0 % of that of everything, by the device";
    assert!(
        words.contains(told) && words.contains("limited by: the device"),
        "{words}"
    );
    // The same by what client and server know.
    let client = r#"{"terminal": {"benchmarks": [{"name": "b", "score": 54}]}}"#;
    let server = "<DIA><Description><vh:Benchmark xmlns:vh='urn:articula:vh:1' name='b' \
                  referenceScore='90'/></Description></DIA>";
    std::fs::write(here.join("client.json"), client).unwrap();
    std::fs::write(here.join("server.xml"), server).unwrap();
    let files = ["--context", "client.json", "--context", "server.xml"];
    let both = json(&here, &[&["adapt", "robot"][..], &files].concat());
    assert_eq!(both["decision"]["parts"], slow["decision"]["parts"]);
    // And by a benchmark: the full grade of crowds at 36 of 60 frames per second.
    let report = r#"{"device": {"cpu": "a", "cores": 1, "os": "b", "arch": "c", "program": "d",
        "backend": "e", "threads": 1}, "results": [{"application": "crowd",
        "grades": [{"grade": 9, "fps": 36, "runs": 6}]}]}"#;
    std::fs::write(here.join("device.json"), report).unwrap();
    let measured = with("device.json");
    let ratio = measured["decision"]["device_ratio"].as_f64().unwrap();
    assert!((ratio - 0.6).abs() < 1e-9, "{ratio}");
    assert_eq!(measured["decision"]["parts"], slow["decision"]["parts"]);
    std::fs::write(here.join("wrong.json"), report.replace("36", "-36")).unwrap();
    let why = fault(
        &here,
        1,
        &["adapt", "robot", "--device-score", "wrong.json"],
    );
    assert!(
        why.contains("wrong.json: results[0].grades[0]: fps"),
        "{why}"
    );
    let why = fault(&here, 1, &["adapt", "robot", "--device-score", "0"]);
    assert!(why.contains("nothing of the item fits"), "{why}");
}
