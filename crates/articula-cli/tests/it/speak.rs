//! Recordings as the motion of faces, by the program.

use crate::program::{fault, folder, json};
use articula::formats::{Limits, live_link};

/// A file of the repository.
fn asset(name: &str) -> String {
    format!("{}/../../assets/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A recording, or its phones.
fn voice(extension: &str) -> String {
    asset(&format!("speech/librivox_austen_0880.{extension}"))
}

#[test]
fn a_voice_is_written_in_every_form_and_a_head_speaks() {
    let here = folder("speak");
    let (voice, phones) = (voice("wav"), voice("lab"));
    let heard = json(&here, &["speak", &voice, "a.csv"]);
    assert_eq!(
        (&heard["from"], &heard["phones"]),
        (&"sound".into(), &0.into())
    );
    let known = json(
        &here,
        &[
            "speak",
            &voice,
            "b.csv",
            "--phones",
            &phones,
            "--mouth-only",
        ],
    );
    assert_eq!(known["from"], "phones");
    // "young man" and "disposed": m and p.
    assert_eq!(known["closures"], 2);
    let read = |name: &str| {
        let bytes = std::fs::read(here.join(name)).unwrap();
        live_link::read(&bytes, &Limits::default()).unwrap().value
    };
    let (heard, known) = (read("a.csv"), read("b.csv"));
    assert_eq!(heard.frames.len(), known.frames.len());
    assert!(heard.frames.iter().any(|f| f.angles[0] != 0.0));
    assert!(known.frames.iter().all(|f| f.angles[0] == 0.0));

    let low = json(&here, &["speak", &voice, "a.afp"]);
    let visemes = json(&here, &["speak", &voice, "b.afp", "--visemes"]);
    let bytes = |report: &serde_json::Value| report["bytes"].as_u64().unwrap();
    assert!(bytes(&visemes) < bytes(&low));

    let head = asset("glb/ict_head_talk_554.glb");
    let made = json(&here, &["speak", &voice, "c.glb", "--onto", &head]);
    assert!(
        made["face"]["controls_moved"].as_u64().unwrap() >= 8,
        "{made}"
    );
    let clips = json(&here, &["inspect", "c.glb"])["clips"].clone();
    assert_eq!(clips.as_array().unwrap().len(), 1);
    assert_eq!(clips[0]["name"], "librivox_austen_0880");
}

#[test]
fn faults_name_the_file_and_the_mend() {
    let here = folder("speak-faults");
    let voice = voice("wav");
    std::fs::write(here.join("times.lab"), "0.1 0.2 P\n0.15 what\n").unwrap();
    let said = |status, arguments: &[&str]| fault(&here, status, arguments);
    assert!(said(2, &["speak", &voice, "a.glb"]).contains("--onto HEAD.glb"));
    assert!(said(2, &["speak", &voice, "a.bvh"]).contains(".fap, .afp or .csv"));
    let why = said(1, &["speak", &voice, "a.fap", "--phones", "times.lab"]);
    assert!(why.contains("times.lab: line 2"), "{why}");
    let why = said(1, &["speak", "times.lab", "a.fap"]);
    assert!(why.contains("times.lab: not a WAV file"), "{why}");
}
