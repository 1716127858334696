//! AFP-1: layout, round trips, levels and cuts, hostile bytes.

use crate::cut_streams::{bits_of, check_golden, cut_checked};
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion, FapRole};
use articula_core::fap_table::{FAP_COUNT, TABLE};
use articula_mutate::{Dice, Edit, Mutations, cut_off};
use articula_stream::afp1::{Afp1Options, read, unit, write};
use articula_stream::{
    CodingType, CutRule, DecodedFace, FaceClip, FaceFrame, FaceReadOptions, FrameRate,
    StreamLimits, Unit,
};
use proptest::prelude::*;

const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};
const NO_FADE: FaceReadOptions = FaceReadOptions { fade_secs: 0.0 };

/// Every low-level parameter moves, each in its own way; so do FAP 1 and 2.
fn clip(frames: usize) -> FaceClip {
    let frame = |f: usize| {
        let value = |i: usize| {
            let phase = 0.13 * (f * (1 + i % 4)) as f32 + i as f32;
            (f32::from(TABLE[i + 2].step) * 300.0 * phase.sin()) as i32
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

fn found<'a>(map: &'a Unit, label: &str) -> Vec<&'a Unit> {
    let mut found = Vec::new();
    map.visit(&mut |unit| {
        if unit.label == label {
            found.push(unit);
        }
    });
    found
}

/// What a receiver shows of a clip at some levels.
fn expanded(clip: &FaceClip, levels: &FaceLevels) -> Vec<FaceFrame> {
    let roles = levels.roles();
    let mut frames = clip.frames.clone();
    frames
        .iter_mut()
        .for_each(|frame| roles.expand(&mut frame.low));
    frames
}

#[test]
fn units_lie_where_the_form_says() {
    let bytes = write(&clip(16), &Afp1Options::default()).unwrap();
    let map = unit(&bytes, &LIMITS).unwrap();
    let access_unit = found(&map, "AccessUnit")[0];
    let start = access_unit.bits.start + 32;
    let place = |unit: &Unit| (unit.bits.start - start, unit.bits.end - unit.bits.start);
    let one = |label: &str| place(found(&map, label)[0]);
    assert_eq!(one("AFPPlane"), (0, 46));
    assert_eq!(one("MainHeader"), (46, 16));
    for (i, mask) in found(&map, "FapMask").into_iter().enumerate() {
        assert_eq!(place(mask), (62 + 7 * i as u64, 7));
        assert_eq!(mask.marker("parameter"), Some(i as u32 + 1));
    }
    assert_eq!(one("FapCodingType"), (62 + 7 * 68, 1));
    assert_eq!(one("FapValue").0, 62 + 7 * 68 + 1);
    let field = &access_unit.fields[1];
    let at = field.bits.start - start..field.bits.end - start;
    assert_eq!(
        (field.name.as_ref(), at, field.value),
        ("fap_count", 55..62, 68)
    );
    let marks = |fap: usize| {
        let mask = found(&map, "FapMask")[fap - 1];
        (mask.marker("loa"), mask.marker("region"))
    };
    assert_eq!(marks(1), (Some(0), Some(0)));
    assert_eq!(marks(3), (Some(0), Some(1)));
    assert_eq!(marks(6), (Some(1), Some(1)));
    assert_eq!(marks(9), (Some(2), Some(1)));
    assert_eq!(marks(51), (Some(3), Some(1)));
    assert_eq!(marks(68), (Some(2), Some(7)));
}

#[test]
fn every_padding_is_its_own_length() {
    let mut seen = [false; 8];
    for frames in 1..60 {
        let bytes = write(&clip(frames), &Afp1Options::default()).unwrap();
        let map = unit(&bytes, &LIMITS).unwrap();
        for (_, bits) in bits_of(&bytes, &map, "Padding") {
            let value = u64::from_str_radix(&bits, 2).unwrap_or(0);
            assert_eq!(value, bits.len() as u64);
            seen[bits.len()] = true;
        }
    }
    assert_eq!(seen, [true; 8]);
}

#[test]
fn a_cut_by_level_is_what_would_have_been_written_at_that_level() {
    let clip = clip(40);
    for coding in [CodingType::Predictive, CodingType::Dct] {
        let options = |levels| Afp1Options {
            coding: Some(coding),
            levels,
            ..Afp1Options::default()
        };
        let all = FaceLevels::all(FaceLevel::High);
        let bytes = write(&clip, &options(all)).unwrap();
        let map = unit(&bytes, &LIMITS).unwrap();
        let high = decoded(&bytes).clip;
        for (loa, (level, count)) in [
            (FaceLevel::VeryLow, 14),
            (FaceLevel::Low, 26),
            (FaceLevel::Medium, 44),
            (FaceLevel::High, 68),
        ]
        .into_iter()
        .enumerate()
        {
            let rule = CutRule::default().at_most("loa", loa as u32);
            let cut = cut_checked(&bytes, &map, &rule);
            let levels = FaceLevels::all(level);
            assert_eq!(cut.bytes, write(&clip, &options(levels)).unwrap());
            assert_eq!(unit(&cut.bytes, &LIMITS).unwrap(), cut.unit);
            // Three access units.
            assert_eq!(found(&cut.unit, "FapMask").len(), 3 * count);
            let shown = decoded(&cut.bytes).clip.frames;
            assert_eq!(shown, expanded(&high, &levels));
        }
    }
}

#[test]
fn regions_and_parameters_can_be_cut() {
    let bytes = write(&clip(20), &Afp1Options::default()).unwrap();
    let map = unit(&bytes, &LIMITS).unwrap();
    let whole = decoded(&bytes).clip;
    for region in FaceRegion::ALL {
        let rule = CutRule::default().among("region", vec![region as u32]);
        let cut = cut_checked(&bytes, &map, &rule);
        let shown = decoded(&cut.bytes);
        for fap in 1..=FAP_COUNT {
            let is_there = FaceRegion::of(fap) == Some(region);
            assert_eq!(shown.coded[fap - 1], is_there, "FAP {fap}");
        }
        for (a, b) in shown.clip.frames.iter().zip(&whole.frames) {
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
    // Without FAP 19 the level of the region is still high, by the others.
    let cut = cut_checked(
        &bytes,
        &map,
        &CutRule::default().within("parameter", 20..=30),
    );
    let shown = decoded(&cut.bytes).clip.frames;
    for (a, b) in shown.iter().zip(&whole.frames) {
        assert_eq!((a.low[16], a.low[17]), (0, b.low[17]));
    }
    let rule = CutRule::default().at_most("access_unit", 0);
    let cut = cut_checked(&bytes, &map, &rule);
    assert_eq!(decoded(&cut.bytes).clip.frames, whole.frames[..16]);
}

#[test]
fn a_level_that_changes_at_an_access_unit_fades() {
    let mut clip = clip(48);
    for frame in &mut clip.frames {
        *frame = FaceFrame::NEUTRAL;
        // FAP 19 and 20: at very low, 19 copies 20.
        (frame.low[16], frame.low[17]) = (600, 200);
    }
    let bytes = write(&clip, &Afp1Options::default()).unwrap();
    let map = unit(&bytes, &LIMITS).unwrap();
    let cut = cut_checked(&bytes, &map, &CutRule::default().at_most("loa", 0));
    let part = |bytes: &[u8], map: &Unit, i: usize| {
        let bits = &map.children[i].bits;
        bytes[(bits.start / 8) as usize..(bits.end / 8) as usize].to_vec()
    };
    let mixed = [
        part(&bytes, &map, 0),
        part(&bytes, &map, 1),
        part(&cut.bytes, &cut.unit, 2),
        part(&bytes, &map, 3),
    ]
    .concat();
    let left = |options: &FaceReadOptions| {
        let read = read(&mixed, options, &LIMITS).unwrap().clip;
        assert!(read.frames.iter().all(|frame| frame.low[17] == 200));
        read.frames.iter().map(|f| f.low[16]).collect::<Vec<_>>()
    };
    let steps = left(&NO_FADE);
    assert_eq!(
        (&steps[..16], &steps[16..32]),
        (&[600; 16][..], &[200; 16][..])
    );
    assert_eq!(steps[32..], [600; 16]);
    // 0.2 s are 5 frames: the sixth is there.
    let faded = left(&FaceReadOptions::default());
    assert_eq!(faded[15..23], [600, 533, 467, 400, 333, 267, 200, 200]);
    assert_eq!(faded[31..39], [200, 267, 333, 400, 467, 533, 600, 600]);
    let whole = read(&bytes, &FaceReadOptions::default(), &LIMITS).unwrap();
    assert_eq!(whole.clip, clip);
}

#[test]
fn what_does_not_move_is_not_written() {
    let mut clip = clip(16);
    for frame in &mut clip.frames {
        let jaw = frame.low[0];
        *frame = FaceFrame::NEUTRAL;
        frame.low[0] = jaw;
    }
    let bytes = write(&clip, &Afp1Options::default()).unwrap();
    let read = decoded(&bytes);
    for fap in 1..=FAP_COUNT {
        let in_jaw = FaceRegion::of(fap) == Some(FaceRegion::Jaw);
        assert_eq!(read.coded[fap - 1], in_jaw);
    }
    clip.frames.iter_mut().for_each(|f| f.low[0] = 0);
    let none = write(&clip, &Afp1Options::default()).unwrap();
    assert_eq!(decoded(&none).coded, [false; FAP_COUNT]);
    assert_eq!(decoded(&none).clip, clip);
}

#[test]
fn what_cannot_be_written_is_refused() {
    let quantizer = Afp1Options {
        quantizer: 32,
        ..Afp1Options::default()
    };
    assert_eq!(write(&clip(3), &quantizer).unwrap_err().at, "quantizer");
    let mut wrong = clip(3);
    wrong.frames[2].viseme[0] = 15;
    let error = write(&wrong, &Afp1Options::default()).unwrap_err();
    assert_eq!(error.at, "frames[2]");
    let mut wrong = clip(3);
    wrong.frames[1].low[11] = i32::MIN;
    let error = write(&wrong, &Afp1Options::default()).unwrap_err();
    assert_eq!(error.at, "FAP 14");
}

/// Levels of all regions from two bits each.
fn levels(bits: u16) -> FaceLevels {
    let all = FaceLevels::all(FaceLevel::High);
    FaceRegion::ALL.into_iter().fold(all, |levels, region| {
        let level = FaceLevel::ALL[usize::from(bits >> (2 * region as u16) & 3)];
        levels.with(region, level)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn clips_come_back_within_half_a_step(
        frames in 0usize..40,
        quantizer in 0u8..=31,
        form in 0usize..3,
        of_regions: u16,
    ) {
        let clip = clip(frames);
        let coding = [Some(CodingType::Predictive), Some(CodingType::Dct), None][form];
        let levels = levels(of_regions);
        let options = Afp1Options { quantizer, coding, levels };
        let bytes = write(&clip, &options).unwrap();
        let map = unit(&bytes, &LIMITS).unwrap();
        map.check_values(&bytes).unwrap();
        let read = decoded(&bytes).clip;
        prop_assert_eq!((&read.name, &read.bridge, read.rate), (&clip.name, &clip.bridge, clip.rate));
        let expected = expanded(&clip, &levels);
        prop_assert_eq!(read.frames.len(), frames);
        let roles = levels.roles();
        for (a, b) in read.frames.iter().zip(&expected) {
            prop_assert_eq!((a.viseme, a.expression), (b.viseme, b.expression));
            for fap in 3..=FAP_COUNT {
                let own = match roles.role(fap) {
                    FapRole::Copied(leader) => usize::from(leader),
                    _ => fap,
                };
                let bound = if coding == Some(CodingType::Predictive) { 0.5 } else { 2.0 };
                let error = f64::from((a.low[fap - 3] - b.low[fap - 3]).abs());
                // Half a unit more where the transform is rounded.
                prop_assert!(error <= bound * options.step(own) + 0.5, "FAP {} by {}", fap, error);
            }
        }
    }
}

#[test]
fn no_mutation_panics() {
    let bytes = write(&clip(40), &Afp1Options::default()).unwrap();
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
        let Ok(map) = unit(bytes, &LIMITS) else {
            return false;
        };
        map.check().unwrap();
        map.check_values(bytes).unwrap();
        let cut = cut_checked(bytes, &map, &CutRule::default().at_most("loa", 1));
        unit(&cut.bytes, &LIMITS).unwrap();
        if let Ok(read) = read(bytes, &FaceReadOptions::default(), &LIMITS) {
            read.clip.check().unwrap();
        }
        true
    };
    let read = mutations.read_of(&bytes, 3000, whole);
    assert!(read > 100, "only {read} mutants were read");
    for bytes in cut_off(&bytes) {
        whole(bytes);
    }
}

#[test]
fn random_bits_need_little_memory() {
    let good = write(&clip(16), &Afp1Options::default()).unwrap();
    let map = unit(&good, &LIMITS).unwrap();
    let start = (map.children[1].bits.start / 8) as usize + 4 + 62 / 8;
    let mut dice = Dice::new(9);
    for _ in 0..2000 {
        let mut bytes = good.clone();
        for byte in &mut bytes[start..] {
            *byte = dice.roll(256) as u8;
        }
        let used = allocation_counter::measure(|| {
            let _ = read(&bytes, &NO_FADE, &LIMITS);
        });
        assert!(used.bytes_max < 64 * 1024, "{} bytes", used.bytes_max);
    }
}

#[test]
fn a_stream_that_would_need_much_memory_is_refused() {
    let bytes = write(&clip(40), &Afp1Options::default()).unwrap();
    let within = |elements| {
        let limits = StreamLimits { elements, ..LIMITS };
        read(&bytes, &NO_FADE, &limits)
    };
    assert!(within(40 * 68).is_ok());
    assert!(within(40 * 68 - 1).is_err());
}

#[test]
fn the_bytes_are_those_of_before() {
    let mut clip = clip(20);
    for (f, frame) in clip.frames.iter_mut().enumerate() {
        // Triangular waves, the same on every platform.
        let at = |i: usize| ((f * (1 + i % 5) + i) % 32) as i32;
        frame.low = std::array::from_fn(|i| 20 * at(i).min(32 - at(i)) - 90);
    }
    let bytes = write(&clip, &Afp1Options::default()).unwrap();
    check_golden("wave.afp", &bytes);
}
