//! BAP text: both widths, extensions, and round trips.

use super::texts::{self, mask};
use articula_formats::mpeg4::bap::{self, AbsentPolicy, BapClip, BapFrame};
use articula_formats::{Limits, Parsed, ReadError};
use proptest::prelude::*;

fn read(text: &str) -> Result<Parsed<BapClip>, ReadError> {
    bap::read(text.as_bytes(), AbsentPolicy::Hold, &Limits::default())
}

#[test]
fn two_frames_by_hand() {
    let read = read(&texts::bap()).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    let clip = read.value;
    let numbers: Vec<u32> = clip.frames.iter().map(|f| f.number).collect();
    assert_eq!((clip.rate_hz, numbers), (25.0, vec![0, 5]));
    let last = &clip.frames[1].values;
    assert_eq!((last.len(), last[31], last[180]), (186, 157_080, 100));
    assert_eq!(clip.coded.iter().filter(|c| **c).count(), 2);
}

#[test]
fn the_mask_tells_the_width_not_the_version() {
    // Recorded files of version 3.2 have 186 or 296 masks.
    for (version, width) in [("3.1", 186), ("3.2", 186), ("3.2", 296)] {
        let text = format!("{version} a 10 1\n{}\n0 7\n", mask(width, &[4]));
        let read = read(&text).unwrap();
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        assert_eq!(read.value.frames[0].values.len(), width);
        assert_eq!(read.value.frames[0].values[3], 7);
    }
    let both = format!("3.2 a 10 2\n{}\n0\n{}\n1\n", mask(296, &[]), mask(186, &[]));
    let error = read(&both).unwrap_err().to_string();
    assert!(
        error.contains("line 4: 186 words found, expected a BAP mask of 296 as before"),
        "{error}"
    );
    let draft = read(&format!("3.1 a 10 1\n{}\n0\n", mask(169, &[]))).unwrap_err();
    assert!(draft.to_string().contains("of 186 or 296"), "{draft}");
}

#[test]
fn extensions_are_kept_and_counted() {
    let text = format!("3.2 a 10 1\n{}\n0 5 -6 0\n", mask(296, &[4, 187, 296]));
    let read = read(&text).unwrap();
    assert_eq!(read.warnings.len(), 1);
    assert!(
        read.warnings[0].what.starts_with("1 of the extension"),
        "{:?}",
        read.warnings
    );
    let back = String::from_utf8(bap::write(&read.value)).unwrap();
    assert_eq!(
        back,
        format!("3.2 a 10 1\n{}\n0 5 -6\n", mask(296, &[4, 187]))
    );
}

fn clips() -> impl Strategy<Value = BapClip> {
    let value = prop_oneof![9 => Just(0), 1 => any::<i32>()];
    let width = prop_oneof![Just(186usize), Just(296)];
    let frames = width.prop_flat_map(move |width| {
        let values = prop::collection::vec(value.clone(), width);
        (Just(width), prop::collection::vec((1..5u32, values), 1..4))
    });
    frames.prop_map(|(width, raw)| {
        let mut number = 0;
        let frames = raw.into_iter().map(|(step, values)| {
            number += step;
            BapFrame { number, values }
        });
        let mut clip = BapClip {
            name: "clip".into(),
            rate_hz: 30.0,
            coded: vec![false; width],
            frames: frames.collect(),
        };
        let moves = |index: usize| clip.frames.iter().any(|f| f.values[index] != 0);
        clip.coded = (0..width).map(moves).collect();
        clip
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn there_and_back_all_values_are_the_same(clip in clips()) {
        let mut back = read(std::str::from_utf8(&bap::write(&clip)).unwrap()).unwrap().value;
        // A file with extensions that never move is written without them.
        back.coded.resize(clip.coded.len(), false);
        for frame in &mut back.frames {
            frame.values.resize(clip.coded.len(), 0);
        }
        prop_assert_eq!(back, clip);
    }
}
