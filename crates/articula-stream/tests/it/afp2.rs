//! AFP-2: tolerances, levels and cuts, prefixes, hostile bytes.

use crate::cut_streams::{as_version_1, bits_of, check_golden, cut_checked};
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion};
use articula_core::fap_table::{FAP_COUNT, FapUnit, LOW_FAP_COUNT, TABLE, unit_mm};
use articula_mutate::{Edit, Mutations, cut_off};
use articula_stream::abp2::{UnitOrder, motion_map};
use articula_stream::afp2::{Afp2Options, FaceReceiver, read, write};
use articula_stream::{
    CutRule, DecodedFace, FaceClip, FaceFrame, FaceReadOptions, FrameRate, StreamLimits, Unit,
};
use proptest::prelude::*;

const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};
const NO_FADE: FaceReadOptions = FaceReadOptions { fade_secs: 0.0 };

/// Every low-level parameter moves, each in its own way, and both fields of visemes and expressions.
fn clip(frames: usize) -> FaceClip {
    let frame = |f: usize| {
        let value = |i: usize| {
            let phase = 0.13 * (f * (1 + i % 4)) as f32 + i as f32;
            (f32::from(TABLE[i + 2].step) * 100.0 * phase.sin()) as i32
        };
        FaceFrame {
            viseme: [
                (f / 5 % 15) as u8,
                3,
                (f % 64) as u8,
                u8::from(f.is_multiple_of(7)),
            ],
            expression: [(f / 9 % 7) as u8, 63, 2, (2 * f % 64) as u8, 0, 1],
            low: std::array::from_fn(value),
        }
    };
    FaceClip {
        name: "face".into(),
        bridge: Some("names".into()),
        rate: FrameRate::nearest(25.0).unwrap(),
        frames: (0..frames).map(frame).collect(),
    }
}

fn decoded(bytes: &[u8]) -> DecodedFace {
    read(bytes, &NO_FADE, &LIMITS).unwrap()
}

fn map_of(bytes: &[u8]) -> Unit {
    motion_map(bytes, &LIMITS).unwrap()
}

/// What a receiver shows of frames at some levels.
fn expanded(frames: &[FaceFrame], levels: &FaceLevels) -> Vec<FaceFrame> {
    let roles = levels.roles();
    let mut frames = frames.to_vec();
    frames
        .iter_mut()
        .for_each(|frame| roles.expand(&mut frame.low));
    frames
}

/// Error of a FAP (3 to 68) in metres on an average face; heads turn ten times as far from their
/// centre as eyes.
fn metres(fap: usize, units: i32) -> f64 {
    let lever = if (48..=50).contains(&fap) { 10.0 } else { 1.0 };
    1e-3 * lever * f64::from(unit_mm(fap)) * f64::from(units.abs())
}

/// Checks that frames are within a tolerance, and FAP 1 and 2 are equal.
fn check_within(found: &[FaceFrame], expected: &[FaceFrame], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert_eq!((a.viseme, a.expression), (b.viseme, b.expression));
        for i in 0..LOW_FAP_COUNT {
            let error = metres(i + 3, a.low[i] - b.low[i]);
            let rounded = 0.5 * metres(i + 3, 1);
            assert!(
                error <= 1.001 * tolerance + rounded,
                "FAP {}: {error} m",
                i + 3
            );
        }
    }
}

#[test]
fn every_tier_keeps_its_tolerance() {
    let clip = clip(70);
    for (tolerance, tiers) in [(1e-4, 3), (1e-5, 1), (2e-3, 5)] {
        let options = Afp2Options {
            tolerance_metres: tolerance,
            tiers,
            ..Afp2Options::default()
        };
        let coded = write(&clip, &options).unwrap();
        let whole = decoded(&coded.bytes);
        assert_eq!(whole.coded, [true; FAP_COUNT]);
        assert_eq!(
            (&whole.clip.name, &whole.clip.bridge, whole.clip.rate),
            (&clip.name, &clip.bridge, clip.rate)
        );
        let mut bytes = usize::MAX;
        for tier in 0..tiers {
            let rule = CutRule::default().at_least("tier", tier as u32);
            let cut = cut_checked(&coded.bytes, &coded.unit, &rule);
            // At the last tier, 162 mm, only FAP 1 and 2 are left, as at the one before.
            assert!(cut.bytes.len() < bytes || tier == 4);
            bytes = cut.bytes.len();
            let allowed = tolerance * 3_f64.powi(tier as i32);
            check_within(&decoded(&cut.bytes).clip.frames, &clip.frames, allowed);
        }
    }
}

#[test]
fn a_cut_by_level_shows_that_level() {
    let coded = write(&clip(60), &Afp2Options::default()).unwrap();
    let whole = decoded(&coded.bytes).clip.frames;
    for (loa, level) in FaceLevel::ALL.into_iter().rev().enumerate() {
        let rule = CutRule::default().at_most("face_loa", loa as u32);
        let cut = cut_checked(&coded.bytes, &coded.unit, &rule);
        assert_eq!(map_of(&cut.bytes), cut.unit);
        let shown = decoded(&cut.bytes);
        let levels = FaceLevels::all(level);
        assert_eq!(shown.clip.frames, expanded(&whole, &levels));
        let kept = |fap: usize| levels.roles().keeps(fap);
        assert!((1..=FAP_COUNT).all(|fap| shown.coded[fap - 1] == kept(fap)));
        // Units that are kept are kept bit by bit.
        let all = bits_of(&coded.bytes, &coded.unit, "unit");
        let left = bits_of(&cut.bytes, &cut.unit, "unit");
        assert!(!left.is_empty() && left.iter().all(|unit| all.contains(unit)));
    }
}

#[test]
fn what_is_written_at_a_level_is_shown_at_it() {
    let clip = clip(60);
    let levels: FaceLevels = "low, jaw=high, cheeks=very-low".parse().unwrap();
    let options = Afp2Options {
        levels,
        ..Afp2Options::default()
    };
    let shown = decoded(&write(&clip, &options).unwrap().bytes);
    let expected = expanded(&clip.frames, &levels);
    // A follower has the unit of its leader, so its error is that of the leader.
    for (a, b) in shown.clip.frames.iter().zip(&expected) {
        for i in 0..LOW_FAP_COUNT {
            let error = f64::from((a.low[i] - b.low[i]).abs());
            let longest = 1e-4 / metres(i + 3, 1);
            assert!(error <= 1.001 * longest + 0.5, "FAP {}", i + 3);
        }
    }
    let roles = levels.roles();
    assert!((1..=FAP_COUNT).all(|fap| shown.coded[fap - 1] == roles.keeps(fap)));
}

#[test]
fn regions_can_be_cut() {
    let coded = write(&clip(20), &Afp2Options::default()).unwrap();
    let whole = decoded(&coded.bytes).clip.frames;
    for region in FaceRegion::ALL {
        let rule = CutRule::default().among("face_region", vec![region as u32]);
        let cut = cut_checked(&coded.bytes, &coded.unit, &rule);
        for (a, b) in decoded(&cut.bytes).clip.frames.iter().zip(&whole) {
            let mut expected = FaceFrame::NEUTRAL;
            if region == FaceRegion::HighLevel {
                (expected.viseme, expected.expression) = (b.viseme, b.expression);
            }
            for fap in (3..=FAP_COUNT).filter(|fap| FaceRegion::of(*fap) == Some(region)) {
                expected.low[fap - 3] = b.low[fap - 3];
            }
            assert_eq!(*a, expected, "{region}");
        }
    }
}

#[test]
fn what_is_still_does_not_copy_what_moves() {
    // A wink: FAP 20 moves, FAP 19, which copies it at very low, does not. Of the cheeks, nothing.
    let mut wink = clip(60);
    for (f, frame) in wink.frames.iter_mut().enumerate() {
        *frame = FaceFrame::NEUTRAL;
        frame.low[20 - 3] = 15 * f as i32;
    }
    let coded = write(&wink, &Afp2Options::default()).unwrap();
    let whole = decoded(&coded.bytes);
    check_within(&whole.clip.frames, &wink.frames, 1e-4);
    assert!(whole.clip.frames.iter().all(|frame| frame.low[19 - 3] == 0));
    for fap in 1..=FAP_COUNT {
        let of_eyes = FaceRegion::of(fap) == Some(FaceRegion::Eyeballs);
        assert_eq!(whole.coded[fap - 1], of_eyes, "FAP {fap}");
    }
    let rule = CutRule::default().at_most("face_loa", 0);
    let cut = cut_checked(&coded.bytes, &coded.unit, &rule);
    let shown = decoded(&cut.bytes).clip.frames;
    assert!(shown.iter().all(|f| f.low[19 - 3] == f.low[20 - 3]));
    assert!(shown[59].low[19 - 3] > 800);
}

#[test]
fn a_level_that_changes_at_an_access_unit_fades() {
    let mut held = clip(150);
    for frame in &mut held.frames {
        *frame = FaceFrame::NEUTRAL;
        (frame.low[19 - 3], frame.low[20 - 3]) = (600, 200);
    }
    // Three access units of 50 frames.
    let options = Afp2Options {
        access_unit_secs: 2.0,
        ..Afp2Options::default()
    };
    let coded = write(&held, &options).unwrap();
    let bits = |unit: &Unit| (unit.bits.start / 8) as usize..(unit.bits.end / 8) as usize;
    let cut = cut_checked(
        &coded.bytes,
        &coded.unit,
        &CutRule::default().at_most("face_loa", 0),
    );
    let part = |bytes: &[u8], map: &Unit, i: usize| bytes[bits(&map.children[i])].to_vec();
    let mixed = [
        part(&coded.bytes, &coded.unit, 0),
        part(&coded.bytes, &coded.unit, 1),
        part(&cut.bytes, &cut.unit, 2),
        part(&coded.bytes, &coded.unit, 3),
    ]
    .concat();
    let left = |options: &FaceReadOptions| -> Vec<i32> {
        let read = read(&mixed, options, &LIMITS).unwrap().clip;
        read.frames.iter().map(|frame| frame.low[19 - 3]).collect()
    };
    let steps = left(&NO_FADE);
    let (own, copied) = (steps[0], steps[50]);
    assert!((own - 600).abs() <= 13 && (copied - 200).abs() <= 13);
    assert_eq!(
        steps,
        [vec![own; 50], vec![copied; 50], vec![own; 50]].concat()
    );
    // 0.2 s are 5 frames: the sixth is there.
    let faded = left(&FaceReadOptions::default());
    assert!(faded[49..56].is_sorted_by(|a, b| a > b));
    assert_eq!(
        (faded[49], faded[55], faded[99], faded[105]),
        (own, copied, copied, own)
    );
}

#[test]
fn every_prefix_decodes_to_frames_of_the_whole() {
    for order in [UnitOrder::Tier, UnitOrder::Value] {
        let options = Afp2Options {
            order,
            access_unit_secs: 0.5,
            ..Afp2Options::default()
        };
        let bytes = write(&clip(36), &options).unwrap().bytes;
        let whole = decoded(&bytes).clip.frames;
        let mut receiver = FaceReceiver::new(&NO_FADE, &LIMITS).unwrap();
        let mut known = 0;
        for end in 0..bytes.len() {
            receiver.receive(&bytes[end..=end]).unwrap();
            let Ok(shown) = receiver.decoded() else {
                assert_eq!(receiver.frames(), 0);
                continue;
            };
            assert_eq!(shown.clip.frames.len(), receiver.frames());
            assert!(receiver.frames() >= known);
            known = receiver.frames();
            // Access units before the last one that has begun are whole: two of 12 frames.
            let sure = known.saturating_sub(12);
            assert_eq!(shown.clip.frames[..sure], whole[..sure]);
            if end.is_multiple_of(97) {
                assert_eq!(decoded(&bytes[..=end]), shown);
            }
        }
        assert!(receiver.is_whole());
        assert_eq!(receiver.decoded().unwrap().clip.frames, whole);
    }
}

#[test]
fn one_frame_and_no_motion() {
    let one = clip(1);
    let shown = decoded(&write(&one, &Afp2Options::default()).unwrap().bytes);
    check_within(&shown.clip.frames, &one.frames, 1e-4);
    let mut still = clip(30);
    still.frames.fill(FaceFrame::NEUTRAL);
    let shown = decoded(&write(&still, &Afp2Options::default()).unwrap().bytes);
    assert_eq!((shown.clip, shown.coded), (still, [false; FAP_COUNT]));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let with = |tolerance_metres| Afp2Options {
        tolerance_metres,
        ..Afp2Options::default()
    };
    let at = |clip: &FaceClip, options: &Afp2Options| write(clip, options).unwrap_err().at;
    assert_eq!(at(&clip(3), &with(9e-6)), "tolerance_metres");
    assert_eq!(at(&clip(3), &with(f64::NAN)), "tolerance_metres");
    assert_eq!(at(&clip(0), &with(1e-4)), "frames");
    let mut wrong = clip(3);
    wrong.frames[2].viseme[0] = 15;
    assert_eq!(at(&wrong, &with(1e-4)), "frames[2]");
    let mut wrong = clip(3);
    wrong.frames[1].low[11] = i32::MIN;
    assert!(write(&wrong, &with(1e-4)).is_err());
}

#[test]
fn a_face_is_no_motion_of_a_body() {
    let bytes = write(&clip(20), &Afp2Options::default()).unwrap().bytes;
    assert_eq!(&bytes[..4], b"AFP2");
    let mut body = bytes.clone();
    body[..4].copy_from_slice(b"ABP2");
    assert!(read(&body, &NO_FADE, &LIMITS).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn clips_come_back_within_the_tolerance(
        seed in 0_u64..1 << 40,
        frames in 1_usize..70,
        tolerance in 2e-5_f64..1e-3,
    ) {
        let mut random = seed;
        let mut dice = || {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (random >> 33) as i32
        };
        let mut clip = clip(frames);
        for frame in &mut clip.frames {
            for (i, value) in frame.low.iter_mut().enumerate() {
                let is_angle = TABLE[i + 2].action.unwrap().unit == FapUnit::Angle;
                *value = if is_angle { dice() % 60_000 } else { dice() % 800 };
            }
            frame.viseme = [dice() % 15, dice() % 15, dice() % 64, dice() % 2].map(|v| v as u8);
        }
        let options = Afp2Options { tolerance_metres: tolerance, ..Afp2Options::default() };
        let coded = write(&clip, &options).unwrap();
        coded.unit.check_values(&coded.bytes).unwrap();
        let tolerance = (tolerance * 1e6).round() * 1e-6;
        check_within(&decoded(&coded.bytes).clip.frames, &clip.frames, tolerance);
    }
}

#[test]
fn no_mutation_panics() {
    let bytes = write(&clip(40), &Afp2Options::default()).unwrap().bytes;
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::SetByte,
            Edit::Truncate,
            Edit::Repeat(40),
        ],
        most: 3,
    };
    let whole = |bytes: &[u8]| {
        if let Ok(map) = motion_map(bytes, &LIMITS) {
            let rule = CutRule::default()
                .at_most("face_loa", 1)
                .at_least("tier", 1);
            let cut = cut_checked(bytes, &map, &rule);
            assert_eq!(map_of(&cut.bytes), cut.unit);
        }
        let used = allocation_counter::measure(|| {
            if let Ok(read) = read(bytes, &FaceReadOptions::default(), &LIMITS) {
                read.clip.check().unwrap();
            }
        });
        // The limit allows 2^20 values of four bytes, and frames of them.
        assert!(used.bytes_max < 16 << 20, "{} bytes", used.bytes_max);
        read(bytes, &NO_FADE, &LIMITS).is_ok()
    };
    mutations.read_of(&bytes, 500, whole);
    // Without checksums more of the decoder sees damage.
    let read = mutations.read_of(&as_version_1(&bytes), 2000, whole);
    assert!(read > 100, "only {read} mutants were read");
    for bytes in cut_off(&bytes) {
        whole(bytes);
    }
}

#[test]
fn a_stream_that_would_need_much_memory_is_refused() {
    let bytes = write(&clip(40), &Afp2Options::default()).unwrap().bytes;
    let within = |elements| {
        let limits = StreamLimits { elements, ..LIMITS };
        read(&bytes, &NO_FADE, &limits)
    };
    // 68 parameters, of which two have several fields: 76 values a frame.
    assert!(within(40 * 76).is_ok());
    assert!(within(40 * 68 - 1).is_err());
}

#[test]
fn the_bytes_decode_as_before() {
    let mut wave = clip(20);
    for (f, frame) in wave.frames.iter_mut().enumerate() {
        // Triangular waves, the same on every platform.
        let at = |i: usize| ((f * (1 + i % 5) + i) % 32) as i32;
        frame.low = std::array::from_fn(|i| 20 * at(i).min(32 - at(i)) - 90);
    }
    let bytes = write(&wave, &Afp2Options::default()).unwrap().bytes;
    check_golden("wave2.afp", &bytes);
    check_within(&decoded(&bytes).clip.frames, &wave.frames, 1e-4);
    // Written before there were checksums, of the same motion.
    let before = include_bytes!("../golden/wave2-1.afp");
    assert_eq!(decoded(before), decoded(&bytes));
    assert_eq!(as_version_1(&bytes), before);
}
