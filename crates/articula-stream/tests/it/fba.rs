//! FBA: bits by hand, round trips, hostile bytes.

use articula_core::fap_table::{FAP_COUNT, TABLE};
use articula_mutate::{Edit, Mutations, cut_off};
use articula_stream::fba::{FbaClip, FbaFrame, FbaOptions, TimeCode, read, write};
use articula_stream::{FaceFrame, FrameRate, StreamError, StreamLimits};
use proptest::prelude::*;

const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};

/// The parameters of a mask move, each in its own way; every ninth number is skipped.
fn clip(frames: usize, is_coded: impl Fn(usize) -> bool) -> FbaClip {
    let coded: [bool; FAP_COUNT] = std::array::from_fn(|i| is_coded(i + 1));
    let frame = |f: usize| {
        let value = |i: usize| {
            let phase = 0.13 * (f * (1 + i % 4)) as f32 + i as f32;
            let value = (f32::from(TABLE[i + 2].step) * 300.0 * phase.sin()) as i32;
            if coded[i + 2] { value } else { 0 }
        };
        let mut face = FaceFrame::NEUTRAL;
        if coded[0] {
            let defines = u8::from(f.is_multiple_of(7));
            face.viseme = [(f / 5 % 15) as u8, 3, (f % 64) as u8, defines];
        }
        if coded[1] {
            face.expression = [(f / 9 % 7) as u8, 63, 2, (2 * f % 64) as u8, 0, 1];
        }
        face.low = std::array::from_fn(value);
        let number = (f + f / 8 * 40) as u32;
        FbaFrame { number, face }
    };
    FbaClip {
        rate: FrameRate::nearest(29.97).unwrap(),
        time_code: Some(TimeCode {
            hours: 23,
            minutes: 59,
            seconds: 58,
        }),
        coded,
        frames: (0..frames).map(frame).collect(),
    }
}

#[test]
fn bits_of_a_small_stream_by_hand() {
    let mut coded = [false; FAP_COUNT];
    coded[48 - 1] = true;
    let clip = FbaClip {
        rate: FrameRate::nearest(25.0).unwrap(),
        time_code: None,
        coded,
        frames: vec![FbaFrame {
            number: 0,
            face: FaceFrame::NEUTRAL,
        }],
    };
    let bits: String = [
        "00000000000000000000000110111010", // fba_object_start_code
        "01111111",                         // stuffing of a whole byte
        "00000000000000000000000110111011", // fba_object_plane_start_code
        "1",                                // is_intra
        "01",                               // a face
        "1",                                // is_frame_rate
        "00011001",                         // 25
        "0000",                             // no sixteenths
        "0",                                // not times 1000/1001
        "0",                                // no time code
        "0",                                // no frames are skipped
        "00001",                            // fap_quant
        "100",                              // groups 1 to 6: a marker, type 0
        "100",
        "100",
        "100",
        "100",
        "100",
        "101100", // group 7: type 1, FAP 48 of three
        "100",    // groups 8 to 10
        "100",
        "100",
        "0",    // gender
        "0",    // predictive
        "0000", // no new ranges
        // Symbol 1860 of 3721: C[s] = 1861, C[s + 1] = 1860. low = 65536 * 1860 / 3721 = 32759, high
        // = 65536 * 1861 / 3721 - 1 = 32775. The middle half, eleven times: 32759 becomes 2^11 *
        // (32759 - 32768) + 32768 = 14336, 32775 becomes 2^11 * (32776 - 32768) + 32768 - 1 =
        // 49151. The quarter is not below low: stop. Then 0 and twelve times 1.
        "0111111111111",
    ]
    .concat();
    let stuffing = 8 - bits.len() % 8;
    let bits = bits + &"01111111"[..stuffing] + "00000000000000000000000110110001";
    let expected: Vec<u8> = bits
        .as_bytes()
        .chunks(8)
        .map(|byte| byte.iter().fold(0, |value, bit| 2 * value + (bit - b'0')))
        .collect();
    let found = read(&expected, &LIMITS).unwrap();
    assert_eq!(found.clip, clip);
    assert_eq!((found.intra_frames, found.quantizer), (1, 1));
}

#[test]
fn numbers_begin_at_0() {
    let mut clip = clip(2, |fap| fap == 3);
    clip.frames[0].number = 1;
    clip.frames[1].number = 4;
    let error = write(&clip, &FbaOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "frames[0]: number 1, expected 0 to 0");
}

#[test]
fn what_is_not_supported_is_named() {
    let bytes = write(&clip(3, |fap| fap == 3), &FbaOptions::default()).unwrap();
    // After both start codes and the stuffing: is_intra, then the mask.
    let mut body = bytes.clone();
    body[9] |= 0b0100_0000;
    let error = read(&body, &LIMITS).unwrap_err();
    assert!(matches!(error, StreamError::Unsupported { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("byte 9, fba_object_mask") && text.contains("body"),
        "{text}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn clips_come_back_within_half_a_step(
        frames in 0usize..70,
        quant in 0u8..=31,
        intra_every in prop::option::of(1u32..40),
        mask: u128,
        is_high: bool,
    ) {
        let clip = clip(frames, |fap| mask >> fap & 1 == 1 && (is_high || fap > 2));
        // Without quantisation, angles are out of range.
        let quant = if quant == 0 { 1 } else { quant };
        let bytes = write(&clip, &FbaOptions { quant, intra_every }).unwrap();
        let read = read(&bytes, &LIMITS).unwrap().clip;
        prop_assert_eq!(read.frames.len(), frames);
        if frames > 0 {
            prop_assert_eq!((read.rate, read.time_code, read.coded), (clip.rate, clip.time_code, clip.coded));
        }
        let quant = if clip.coded[0] || clip.coded[1] { 1 } else { quant };
        for (a, b) in read.frames.iter().zip(&clip.frames) {
            prop_assert_eq!(a.number, b.number);
            prop_assert_eq!((a.face.viseme, a.face.expression), (b.face.viseme, b.face.expression));
            for (i, (a, b)) in a.face.low.iter().zip(&b.face.low).enumerate() {
                let step = i32::from(TABLE[i + 2].step) * i32::from(quant);
                prop_assert!(2 * (a - b).abs() <= step, "FAP {}: {} {}", i + 3, a, b);
            }
        }
    }
}

#[test]
fn values_beyond_all_ranges_are_refused() {
    let mut clip = clip(2, |fap| fap == 3);
    clip.frames[1].face.low[0] = 4 * 1860;
    assert!(write(&clip, &FbaOptions::default()).is_ok());
    clip.frames[1].face.low[0] += 3;
    let error = write(&clip, &FbaOptions::default()).unwrap_err();
    assert_eq!(error.at, "frames[1], FAP 3");
}

#[test]
fn no_mutation_panics() {
    let bytes = write(&clip(40, |_| true), &FbaOptions::default()).unwrap();
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::SetByte,
            Edit::Truncate,
            Edit::Repeat(40),
        ],
        most: 3,
    };
    let whole = |bytes: &[u8]| match read(bytes, &LIMITS) {
        Ok(_) => true,
        Err(error) => {
            assert!(error.to_string().starts_with("byte "), "{error}");
            false
        }
    };
    mutations.read_of(&bytes, 3000, whole);
    for bytes in cut_off(&bytes) {
        assert!(!whole(bytes));
    }
}
