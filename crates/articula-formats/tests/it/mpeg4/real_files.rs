//! The real files, compared with the statements of their makers and of the data's manifest.

use crate::real::bytes;
use articula_formats::Limits;
use articula_formats::mpeg4::{fap, fdp};

/// Name, frames, and number of low-level FAPs in the masks.
const FACES: [(&str, usize, usize); 6] = [
    ("fap/xface_anger.fap", 108, 48),
    ("fap/xface_joy.fap", 108, 42),
    ("fap/xface_disgust.fap", 107, 50),
    ("fap/xface_beg.fap", 107, 48),
    ("fap/speech_synthetic.fap", 250, 26),
    ("fap/expressions_synthetic.fap", 250, 66),
];

#[test]
fn faces_have_the_frames_and_parameters_that_are_said_of_them() {
    for (name, frames, coded) in FACES {
        let Some(bytes) = bytes(name) else {
            println!("skipped: no data");
            return;
        };
        let read = fap::read(&bytes, fap::AbsentPolicy::Hold, &Limits::default()).unwrap();
        let clip = read.value;
        assert_eq!(clip.frames.len(), frames, "{name}");
        assert_eq!(clip.coded.iter().filter(|c| **c).count(), coded, "{name}");
        assert!(
            !clip.coded[0] && !clip.coded[1],
            "{name}: no viseme or expression"
        );
        assert_eq!(clip.rate_hz, 25.0);
        let back = fap::read(
            &fap::write(&clip),
            fap::AbsentPolicy::Zero,
            &Limits::default(),
        );
        assert_eq!(back.unwrap().value.frames, clip.frames, "{name}");
    }
}

#[test]
fn the_loudest_syllable_and_the_widest_blink_are_as_said() {
    let names = ["fap/speech_synthetic.fap", "fap/expressions_synthetic.fap"];
    let [Some(speech), Some(expressions)] = names.map(bytes) else {
        println!("skipped: no data");
        return;
    };
    let read = |bytes: &[u8]| fap::read(bytes, fap::AbsentPolicy::Hold, &Limits::default());
    let speech = read(&speech).unwrap().value;
    assert_eq!(speech.range(3).unwrap().1, 493, "open_jaw");
    let expressions = read(&expressions).unwrap().value;
    assert_eq!(expressions.range(19).unwrap().1, 980, "close_t_l_eyelid");
    let (low, high) = expressions.range(49).unwrap();
    assert!(low.abs().max(high) <= 10_000, "head_yaw within 0.10 rad");
}

#[test]
fn alice_has_her_units() {
    let Some(bytes) = bytes("fap/xface_alice.fdp") else {
        println!("skipped: no data");
        return;
    };
    let read = fdp::read(&bytes, &Limits::default()).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    let alice = read.value;
    let units = alice.fapu;
    let found = [units.ens0, units.es0, units.irisd0, units.mns0, units.mw0];
    assert_eq!(found, [51.0, 69.0, 16.0, 30.0, 50.0]);
    let influences: usize = alice.points.iter().map(|p| p.influences.len()).sum();
    assert_eq!(
        (alice.points.len(), influences, alice.sources.len()),
        (35, 43, 29)
    );
    // Each FAP moves a point of the group that the standard assigns to it.
    for point in &alice.points {
        for influence in &point.influences {
            let action = articula_core::fap_table::TABLE[influence.fap - 1]
                .action
                .unwrap();
            assert_eq!(action.point.0, point.point.0, "FAP {}", influence.fap);
        }
    }
}
