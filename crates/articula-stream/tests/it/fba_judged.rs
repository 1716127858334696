//! FBA against an independent reader and writer, `oracle/fba.mjs`: its streams with the frames that it
//! recorded beside them, and a stream of ours with the frames that `oracle/fba.test.mjs` reads in it.

use crate::cut_streams::check_golden;
use articula_core::fap_table::{FAP_COUNT, TABLE};
use articula_stream::fba::{FbaClip, FbaFrame, FbaOptions, TimeCode, read, write};
use articula_stream::{FaceFrame, FrameRate, StreamLimits};
use std::fmt::Write;
use std::path::Path;

fn golden(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    std::fs::read(folder.join(name)).unwrap()
}

/// The frames as the oracle writes them; of parameters that were not coded so far there is nothing,
/// so they must be neutral.
fn text(clip: &FbaClip, like: &str) -> String {
    let mut text = format!("rate {}\n", clip.rate.hz());
    for (frame, line) in clip.frames.iter().zip(like.lines().skip(1)) {
        let named = |fap: usize| line.contains(&format!(" {fap}="));
        write!(text, "{}", frame.number).unwrap();
        for fap in 1..=FAP_COUNT {
            let values = match fap {
                1 => frame.face.viseme.map(i32::from).to_vec(),
                2 => frame.face.expression.map(i32::from).to_vec(),
                _ => vec![frame.face.low[fap - 3]],
            };
            let values: Vec<String> = values.iter().map(ToString::to_string).collect();
            if named(fap) {
                write!(text, " {fap}={}", values.join(",")).unwrap();
            } else {
                assert!(
                    values.iter().all(|v| v == "0"),
                    "FAP {fap} at {}",
                    frame.number
                );
            }
        }
        text.push('\n');
    }
    assert_eq!(clip.frames.len() + 1, like.lines().count());
    text
}

#[test]
fn the_frames_are_those_that_the_oracle_recorded() {
    for (name, intra_frames, quantizer) in [
        // Ranges that a later quantiser does not change, a blend beyond 63, skips, mask type 2.
        ("fba-speech", 3, 2),
        // Runs without a symbol, runs that end in 22 zeros, inserted 1s, no rate.
        ("fba-zeros", 5, 1),
        // Values that saturate, coarse steps.
        ("fba-wild", 2, 31),
    ] {
        let found = read(&golden(&format!("{name}.fba")), &StreamLimits::default()).unwrap();
        let recorded = String::from_utf8(golden(&format!("{name}.txt"))).unwrap();
        assert_eq!(text(&found.clip, &recorded), recorded, "{name}");
        assert_eq!(
            (found.intra_frames, found.quantizer),
            (intra_frames, quantizer)
        );
    }
}

#[test]
fn old_start_codes_are_read() {
    let bytes = golden("fba-speech.fba");
    let mut old = bytes.clone();
    // The object, and the plane that follows after a byte of stuffing.
    (old[3], old[8]) = (0x01, 0x03);
    let [new, old] = [bytes, old].map(|bytes| read(&bytes, &StreamLimits::default()).unwrap());
    assert_eq!(new, old);
}

/// A stream of ours, and what we read in it; the oracle's test reads the same.
#[test]
fn a_stream_of_ours_is_kept_for_the_oracle() {
    let coded: [bool; FAP_COUNT] = std::array::from_fn(|i| i + 1 != 2 && i % 11 != 7);
    let frame = |f: i32| {
        let mut face = FaceFrame::NEUTRAL;
        face.viseme = [(f % 15) as u8, 4, (f * 5 % 64) as u8, u8::from(f == 3)];
        face.low = std::array::from_fn(|i| {
            let step = i32::from(TABLE[i + 2].step);
            let value = step * ((f * f * (i as i32 + 3)) % 301 - 150);
            if coded[i + 2] { value } else { 0 }
        });
        let number = (f + 20 * (f / 6)) as u32;
        FbaFrame { number, face }
    };
    let clip = FbaClip {
        rate: FrameRate::nearest(29.97).unwrap(),
        time_code: Some(TimeCode {
            hours: 1,
            minutes: 59,
            seconds: 7,
        }),
        coded,
        frames: (0..17).map(frame).collect(),
    };
    let options = FbaOptions {
        quant: 1,
        intra_every: Some(7),
    };
    let bytes = write(&clip, &options).unwrap();
    let found = read(&bytes, &StreamLimits::default()).unwrap().clip;
    assert_eq!(found, clip);
    let coded = (1..=FAP_COUNT).filter(|fap| coded[fap - 1]);
    let line: String = coded.map(|fap| format!(" {fap}=")).collect();
    let like = format!("rate\n{}", format!("{line}\n").repeat(clip.frames.len()));
    check_golden("fba-own.fba", &bytes);
    check_golden("fba-own.txt", text(&found, &like).as_bytes());
}
