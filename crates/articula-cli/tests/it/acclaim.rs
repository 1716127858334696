//! AMC motions find their ASF skeleton, and both files of a pair are written.

use crate::program::{BVH, fault, folder, json};
use std::path::Path;

const ASF: &str = ":version 1.10\n:name two\n:units\n length 1.0\n angle deg\n:root\n order TX TY TZ RX RY RZ\n \
    axis XYZ\n position 0 0 0\n orientation 0 0 0\n:bonedata\nbegin\nname spine\ndirection 0 1 0\nlength 1.0\n\
    axis 0 0 0 XYZ\ndof rx ry rz\nend\nbegin\nname head\ndirection 0 1 0\nlength 0.5\naxis 0 0 0 XYZ\ndof rx\nend\n\
    :hierarchy\nbegin\nroot spine\nspine head\nend\n";

const AMC: &str = ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 1 0 0 0 0\nspine 0 0 0\nhead 0\n2\n\
    root 0 1 1 0 0 0\nspine 0 0 20\nhead 10\n3\nroot 0 1 2 0 0 0\nspine 0 0 30\nhead 20\n4\n";

fn put(here: &Path, files: &[&str]) {
    for name in files {
        let text = if name.ends_with(".asf") { ASF } else { AMC };
        std::fs::write(here.join(name), text).unwrap();
    }
}

fn warned(found: &serde_json::Value) -> String {
    found["warnings"].to_string()
}

#[test]
fn a_motion_finds_its_skeleton() {
    let here = folder("finds");
    put(&here, &["walk.amc", "walk.asf", "wa.asf", "run_01.amc"]);
    let found = json(&here, &["inspect", "walk.amc"]);
    assert_eq!(
        (&found["format"], &found["name"]),
        (&"amc".into(), &"two".into())
    );
    assert_eq!(found["skeletons"][0]["joints"], 3);
    // The fourth frame has a number and no row.
    assert_eq!(found["clips"][0]["frames"], 3);
    assert!(
        !warned(&found).contains("is used:"),
        "a name of its own is no guess"
    );

    let why = fault(&here, 1, &["inspect", "run_01.amc"]);
    assert!(
        why.contains("no .asf file in the folder has a name that matches")
            && why.contains("--read skeleton=F.asf")
    );
    assert!(why.contains("wa.asf, walk.asf"), "{why}");
    put(&here, &["run.asf", "r.asf"]);
    let found = json(&here, &["inspect", "run_01.amc"]);
    assert!(warned(&found).contains("run.asf is used: the name of the motion begins"));
    let found = json(
        &here,
        &["inspect", "run_01.amc", "--read", "skeleton=walk.asf"],
    );
    assert!(
        !warned(&found).contains("is used:"),
        "what is asked for is no guess"
    );

    let alone = folder("acclaim-alone");
    put(&alone, &["walk.amc"]);
    let why = fault(&alone, 1, &["inspect", "walk.amc"]);
    assert!(
        why.contains("is not in the same folder") && why.contains("--read skeleton"),
        "{why}"
    );
    put(&alone, &["man.asf"]);
    let found = json(&alone, &["inspect", "walk.amc"]);
    assert!(warned(&found).contains("man.asf is used: it is the only"));
    std::fs::write(alone.join("man.asf"), ASF.replace("name head", "name tail")).unwrap();
    let why = fault(&alone, 1, &["inspect", "walk.amc"]);
    assert!(
        why.starts_with("error: walk.amc: with the skeleton man.asf: asf line "),
        "{why}"
    );
}

#[test]
fn unit_and_rate_can_be_given() {
    let here = folder("given");
    put(&here, &["walk.amc", "walk.asf"]);
    let told = json(
        &here,
        &[
            "inspect",
            "walk.amc",
            "--read",
            "unit-metres=2,amc-rate-hz=60",
        ],
    );
    assert_eq!(
        (&told["clips"][0]["fps"], &told["height_m"]),
        (&60.0.into(), &2.0.into())
    );
    let told = told["warnings"].as_array().unwrap();
    let of_rows: Vec<_> = told.iter().filter(|w| w["at"] == "amc").collect();
    assert_eq!(of_rows.len(), 1, "the rate was given");
    assert!(of_rows[0]["what"].as_str().unwrap().contains("0 rows of 3"));
    let found = json(&here, &["inspect", "walk.asf"]);
    assert_eq!(
        (
            &found["clips"].as_array().unwrap().len(),
            &found["height_m"]
        ),
        (&0, &1.0.into())
    );
}

#[test]
fn a_pair_is_written_and_read_back() {
    let here = folder("pair");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let wanted = json(&here, &["inspect", "a.bvh"]);
    let report = json(&here, &["convert", "a.bvh", "b.amc"]);
    assert_eq!(
        (&report["out"], &report["beside"][0]),
        (&"b.amc".into(), &"b.asf".into())
    );
    let other = json(&here, &["convert", "a.bvh", "c.asf"]);
    assert_eq!(
        (&other["out"], &other["beside"][0]),
        (&"c.asf".into(), &"c.amc".into())
    );
    for name in ["b.amc", "c.amc"] {
        let found = json(&here, &["inspect", name]);
        assert_eq!(found["clips"][0]["frames"], wanted["clips"][0]["frames"]);
        let bound = |v: &serde_json::Value, corner: &str, axis: usize| {
            v["clips"][0]["bounds"][corner][axis].as_f64().unwrap()
        };
        for corner in ["min_m", "max_m"] {
            for axis in 0..3 {
                let apart = bound(&found, corner, axis) - bound(&wanted, corner, axis);
                assert!(apart.abs() < 1e-5, "{name} {corner}[{axis}]: {apart}");
            }
        }
    }
    // Round trip: the same joints with the same names, the root included.
    json(&here, &["convert", "b.amc", "d.bvh"]);
    let text = std::fs::read_to_string(here.join("d.bvh")).unwrap();
    for name in [
        "ROOT Hips",
        "JOINT Spine",
        "JOINT Head",
        "JOINT LeftForeArm",
    ] {
        assert!(text.contains(name), "{name}");
    }
    // Without a clip a skeleton can be written, but no motion.
    json(&here, &["convert", "b.asf", "e.asf"]);
    assert!(here.join("e.asf").exists() && !here.join("e.amc").exists());
    assert!(
        fault(&here, 1, &["convert", "b.asf", "e.amc"]).contains("the file has no clip to write")
    );
}

#[test]
fn a_folder_of_motions_shares_its_skeleton() {
    let here = folder("shared");
    std::fs::create_dir(here.join("in")).unwrap();
    put(&here.join("in"), &["man.asf", "man_01.amc", "man_02.amc"]);
    let report = json(&here, &["convert", "in", "out/", "--to", "bvh"]);
    let files = report["files"].as_array().unwrap();
    assert_eq!(
        (files.len(), report["failed"].as_array().unwrap().len()),
        (2, 0)
    );
    assert!(here.join("out/man_01.bvh").exists() && !here.join("out/man.bvh").exists());
}
