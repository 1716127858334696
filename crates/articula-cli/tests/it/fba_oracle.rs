//! Real face animations as FBA, judged by an independent reader and writer in node
//! (`oracle/fba.mjs`): ours to it, its to ours, and the bytes of both for the same decisions.

use crate::judges::{ask, node_is_here};
use crate::program::{folder, word};
use crate::real;
use articula::clip_streams::fba;
use articula::core::fap_table::{FAP_COUNT, TABLE};
use articula::formats::Limits;
use articula::formats::mpeg4::fap::{self, AbsentPolicy, FapClip};
use articula::stream::StreamLimits;
use articula::stream::fba::FbaOptions;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Faces, and the quantisers with which they are written; a fine and a coarse one for each kind.
const FACES: [(&str, u8); 8] = [
    ("fap/xface_anger.fap", 1),
    ("fap/xface_beg.fap", 4),
    ("fap/xface_disgust.fap", 1),
    ("fap/xface_joy.fap", 4),
    ("fap/speech_synthetic.fap", 1),
    ("fap/speech_synthetic.fap", 4),
    ("fap/expressions_synthetic.fap", 1),
    ("fap/expressions_synthetic.fap", 4),
];

/// Coded low-level parameters of a clip.
fn coded(clip: &FapClip) -> impl Iterator<Item = usize> {
    (3..=FAP_COUNT).filter(|fap| clip.coded[fap - 1])
}

/// The values of a frame as the oracle has them.
fn values(clip: &FapClip, frame: usize) -> Value {
    let pairs = coded(clip).map(|fap| {
        let value = clip.frames[frame].low[fap - 3];
        (fap.to_string(), Value::from(value))
    });
    Value::Object(pairs.collect::<Map<_, _>>())
}

/// The largest difference of two clips in steps of the quantiser.
fn steps_off(a: &FapClip, b: &FapClip, quant: u8) -> f64 {
    assert_eq!(a.frames.len(), b.frames.len());
    let mut most = 0.0_f64;
    for (a, b) in a.frames.iter().zip(&b.frames) {
        assert_eq!(a.number, b.number);
        for (i, (a, b)) in a.low.iter().zip(&b.low).enumerate() {
            let step = f64::from(TABLE[i + 2].step) * f64::from(quant);
            most = most.max(f64::from((a - b).abs()) / step);
        }
    }
    most
}

/// The bytes that the oracle writes for planes.
fn encoded(here: &Path, planes: &Value) -> Vec<u8> {
    let [plan, out] = ["plan.json", "theirs.fba"].map(|name| here.join(name));
    std::fs::write(&plan, planes.to_string()).unwrap();
    let (answer, good) = ask(
        "fba.mjs",
        &["encode".into(), word(&plan).into(), word(&out).into()],
    );
    assert!(good, "{answer}");
    std::fs::read(out).unwrap()
}

#[test]
fn real_faces_are_the_same_in_fba_for_both() {
    if !node_is_here() {
        return;
    }
    let here = folder("fba_oracle");
    for (name, quant) in FACES {
        let Some(bytes) = real::bytes(name) else {
            return;
        };
        let read = fap::read(&bytes, AbsentPolicy::Hold, &Limits::default()).unwrap();
        let clip = read.value;
        let options = FbaOptions {
            quant,
            intra_every: None,
        };
        let ours = fba::write(&clip, &options).unwrap();
        let own = fba::read(&ours, &clip.name, &StreamLimits::default()).unwrap();
        assert!(steps_off(&own, &clip, quant) <= 0.5, "{name}");

        // Ours, read by the oracle: the same values.
        let file = here.join("ours.fba");
        std::fs::write(&file, &ours).unwrap();
        let (answer, good) = ask("fba.mjs", &["decode".into(), word(&file).into()]);
        assert!(good, "{answer}");
        let mut planes: Value = serde_json::from_str(&answer).unwrap();
        let list = planes.as_array_mut().unwrap();
        assert_eq!(list.len(), clip.frames.len());
        for (f, plane) in list.iter_mut().enumerate() {
            assert_eq!(plane["values"], values(&own, f), "{name}, frame {f}");
            // The oracle quantises the values of the file itself.
            plane["values"] = values(&clip, f);
        }
        assert!(encoded(&here, &planes) == ours, "{name}: other bytes");

        // The oracle's decisions: one intra frame, the widest ranges, a mask of type 1.
        let count = coded(&clip).count();
        let groups: Value = planes[0]["masks"].clone();
        let mut plain: Vec<Value> = (0..clip.frames.len())
            .map(|f| json!({"intra": f == 0, "values": values(&clip, f)}))
            .collect();
        plain[0]["masks"] = groups;
        plain[0]["frameRate"] = json!([25, 0, 0]);
        plain[0]["quantiser"] = json!(quant);
        plain[0]["ranges"] = json!(vec![vec![31; count]; 4]);
        let theirs = encoded(&here, &Value::Array(plain));
        let found = fba::read(&theirs, &clip.name, &StreamLimits::default()).unwrap();
        assert!(steps_off(&found, &clip, quant) <= 0.5, "{name}");
        assert_eq!((found.rate_hz, found.coded), (clip.rate_hz, clip.coded));
    }
}
