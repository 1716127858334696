//! ABP-1: the layout of the thesis, round trips, cuts and hostile bytes.

use crate::cut_streams::{bits_of, cut_checked};
use articula_mutate::{Dice, Edit, Mutations, cut_off};
use articula_stream::abp1::{
    Abp1Clip, Abp1Options, AbsentBone, Bone, BoneTracks, Track, TrackKind, read, read_text, unit,
    write, write_text,
};
use articula_stream::{CodingType, CutRule, FrameRate, StreamLimits, Unit};
use proptest::prelude::*;

/// Levels of the first 35 joints of H-Anim's levels 0 to 3: 5, 10, 24 and 35 up to each.
const LEVELS: [usize; 4] = [5, 10, 24, 35];
const LIMITS: StreamLimits = StreamLimits {
    bytes: 1 << 20,
    elements: 1 << 20,
};

fn loa_of(bone: usize) -> u8 {
    LEVELS.iter().position(|count| bone < *count).unwrap_or(4) as u8
}

fn bone(b: usize) -> Bone {
    Bone {
        name: format!("bone {b}"),
        parent: b.checked_sub(1).map(|p| (p / 2) as u16),
        center: [0.1 * b as f32, 1.0, -0.5],
        loa: loa_of(b),
        region: (b % 7) as u8 + 1,
    }
}

/// A smooth track with a frequency and a size of its own.
fn track(seed: usize, frames: usize) -> Track {
    let value = |frame: usize, axis: usize| {
        let phase = 0.11 * (frame * (1 + seed % 5)) as f32 + axis as f32;
        (0.1 + 0.05 * (seed % 7) as f32) * phase.sin()
    };
    (0..frames)
        .map(|frame| std::array::from_fn(|axis| value(frame, axis)))
        .collect()
}

/// The shape of the thesis's sample: rotations, and translation of the root.
fn sample(bones: usize, frames: usize) -> Abp1Clip {
    let turned = |b| BoneTracks::default().with(TrackKind::Rotation, track(b, frames));
    let mut tracks: Vec<_> = (0..bones).map(turned).collect();
    if let Some(root) = tracks.first_mut() {
        *root = root.clone().with(TrackKind::Translation, track(99, frames));
    }
    Abp1Clip {
        name: "sample".into(),
        bones: (0..bones).map(bone).collect(),
        rate: FrameRate::nearest(25.0).unwrap(),
        frames,
        tracks,
    }
}

fn decoded(bytes: &[u8]) -> Abp1Clip {
    read(bytes, AbsentBone::Rest, &LIMITS).unwrap()
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

#[test]
fn units_lie_as_in_the_annex_of_the_thesis() {
    let bytes = write(&sample(35, 16), &Abp1Options::default()).unwrap();
    let map = unit(&bytes, &LIMITS).unwrap();
    // The length in front is no part of the access unit in the annex.
    let access_unit = found(&map, "AccessUnit")[0];
    let start = access_unit.bits.start + 32;
    let place = |unit: &Unit| (unit.bits.start - start, unit.bits.end - unit.bits.start);
    let one = |label: &str| place(found(&map, label)[0]);
    assert_eq!(one("BBAPlane"), (0, 49));
    assert_eq!(one("MainHeader"), (49, 33));
    assert_eq!(one("BoneSegment").0, 82);
    let masks: Vec<_> = found(&map, "BoneMask").into_iter().map(place).collect();
    assert_eq!((masks.len(), masks[0]), (35, (82, 28)));
    for (i, mask) in masks.iter().enumerate().skip(1) {
        assert_eq!(*mask, (110 + 25 * (i as u64 - 1), 25));
    }
    assert_eq!(one("BBACodingType"), (960, 1));
    let values = found(&map, "BoneValue");
    assert_eq!(place(values[0]).0, 961);
    let end = place(values[34]).0 + place(values[34]).1;
    let padding = (8 - end % 8) % 8;
    assert_eq!(one("Padding"), (end, padding));
    assert_eq!(one("BBAPlaneEnd"), (end + padding, 32));
    let field = &access_unit.fields[1];
    let at = field.bits.start - start..field.bits.end - start;
    assert_eq!(
        (field.name.as_ref(), at, field.value),
        ("NoOfBones", 62..72, 35)
    );
    assert_eq!(found(&map, "BoneMask")[7].marker("loa"), Some(1));
    assert_eq!(found(&map, "BoneValue")[7].marker("joint"), Some(7));
}

#[test]
fn every_padding_is_its_own_length() {
    let mut seen = [false; 8];
    for bones in 1..60 {
        let bytes = write(&sample(bones, 16), &Abp1Options::default()).unwrap();
        let map = unit(&bytes, &LIMITS).unwrap();
        let (_, bits) = &bits_of(&bytes, &map, "Padding")[0];
        let value = u64::from_str_radix(bits, 2).unwrap_or(0);
        assert_eq!(value, bits.len() as u64);
        seen[bits.len()] = true;
    }
    assert_eq!(seen, [true; 8]);
}

/// The same clip, in which only the bones of a rule move.
fn only(clip: &Abp1Clip, keeps: impl Fn(usize, &Bone) -> bool) -> Abp1Clip {
    let mut fewer = clip.clone();
    for (b, tracks) in fewer.tracks.iter_mut().enumerate() {
        if !keeps(b, &clip.bones[b]) {
            *tracks = BoneTracks::default();
        }
    }
    fewer
}

#[test]
fn a_cut_is_what_would_have_been_written_of_fewer_bones() {
    let clip = sample(40, 37);
    for coding in [CodingType::Predictive, CodingType::Dct] {
        let options = Abp1Options {
            coding: Some(coding),
            ..Abp1Options::default()
        };
        let bytes = write(&clip, &options).unwrap();
        let map = unit(&bytes, &LIMITS).unwrap();
        let check = |rule: CutRule, keeps: &dyn Fn(usize, &Bone) -> bool| {
            let cut = cut_checked(&bytes, &map, &rule);
            assert_eq!(cut.bytes, write(&only(&clip, keeps), &options).unwrap());
            assert_eq!(unit(&cut.bytes, &LIMITS).unwrap(), cut.unit);
            let (all, fewer) = (decoded(&bytes), decoded(&cut.bytes));
            for (b, tracks) in fewer.tracks.iter().enumerate() {
                let kept = keeps(b, &clip.bones[b]);
                let expected = if kept {
                    all.tracks[b].clone()
                } else {
                    BoneTracks::default()
                };
                assert_eq!(*tracks, expected, "bone {b}");
            }
            found(&cut.unit, "BoneMask").len()
        };
        for (loa, count) in (0..).zip(LEVELS) {
            let rule = CutRule::default().at_most("loa", loa);
            // Three access units.
            assert_eq!(
                check(rule, &|_, bone| u32::from(bone.loa) <= loa),
                3 * count
            );
        }
        for region in 1..8 {
            let rule = CutRule::default().in_mask("region", 1 << region);
            check(rule, &|_, bone| bone.region == region);
        }
        let rule = CutRule::default().among("joint", vec![3, 17, 39]);
        assert_eq!(check(rule, &|b, _| [3, 17, 39].contains(&b)), 9);
        let none = CutRule::default().among("joint", vec![]);
        assert_eq!(check(none, &|_, _| false), 0);
    }
}

#[test]
fn access_units_at_the_end_can_be_cut() {
    let bytes = write(&sample(3, 40), &Abp1Options::default()).unwrap();
    let map = unit(&bytes, &LIMITS).unwrap();
    let rule = CutRule::default().at_most("access_unit", 1);
    let cut = cut_checked(&bytes, &map, &rule);
    let (all, fewer) = (decoded(&bytes), decoded(&cut.bytes));
    assert_eq!((all.frames, fewer.frames), (40, 32));
    let turned = |clip: &Abp1Clip| clip.tracks[2].get(TrackKind::Rotation).unwrap().clone();
    assert_eq!(turned(&all)[..32], turned(&fewer));
}

#[test]
fn bones_that_an_access_unit_lacks_rest_or_stay() {
    let clip = sample(2, 48);
    let whole = write(&clip, &Abp1Options::default()).unwrap();
    let fewer = write(&only(&clip, |b, _| b == 0), &Abp1Options::default()).unwrap();
    // The second access unit without the second bone.
    let [whole_map, fewer_map] = [&whole, &fewer].map(|bytes| unit(bytes, &LIMITS).unwrap());
    let part = |bytes: &[u8], map: &Unit, i: usize| {
        let bits = &map.children[i].bits;
        bytes[(bits.start / 8) as usize..(bits.end / 8) as usize].to_vec()
    };
    let mixed = [
        part(&whole, &whole_map, 0),
        part(&whole, &whole_map, 1),
        part(&fewer, &fewer_map, 2),
        part(&whole, &whole_map, 3),
    ]
    .concat();
    let turned = |bytes: &[u8], absent| {
        let clip = read(bytes, absent, &LIMITS).unwrap();
        clip.tracks[1].get(TrackKind::Rotation).unwrap().clone()
    };
    let all = turned(&whole, AbsentBone::Rest);
    for (absent, value) in [(AbsentBone::Rest, [0.0; 3]), (AbsentBone::Last, all[15])] {
        let found = turned(&mixed, absent);
        assert_eq!(found[..16], all[..16]);
        assert_eq!(found[16..32], [value; 16]);
        assert_eq!(found[32..], all[32..]);
    }
}

#[test]
fn frames_between_coded_ones_are_interpolated() {
    let mut clip = sample(1, 12);
    let line: Track = (0..12).map(|f| [0.01 * f as f32, -0.5, 0.0]).collect();
    clip.tracks[0] = BoneTracks::default().with(TrackKind::Translation, line.clone());
    for interpolated in [0, 1, 2, 4, 7, 31] {
        let options = Abp1Options {
            interpolated,
            coding: Some(CodingType::Predictive),
            ..Abp1Options::default()
        };
        let read = decoded(&write(&clip, &options).unwrap());
        assert_eq!(read.frames, 12);
        let found = read.tracks[0].get(TrackKind::Translation).unwrap();
        for (a, b) in line.iter().flatten().zip(found.iter().flatten()) {
            assert!((a - b).abs() <= 0.000_051, "{a} {b} with {interpolated}");
        }
    }
}

#[test]
fn what_cannot_be_written_is_refused() {
    let good = sample(3, 5);
    let wrong = |edit: &dyn Fn(&mut Abp1Clip, &mut Abp1Options)| {
        let (mut clip, mut options) = (good.clone(), Abp1Options::default());
        edit(&mut clip, &mut options);
        write(&clip, &options).unwrap_err().at
    };
    assert_eq!(wrong(&|_, options| options.quantizer = 0), "quantizer");
    assert_eq!(wrong(&|_, options| options.quantizer = 32), "quantizer");
    assert_eq!(wrong(&|_, options| options.power = 8), "power");
    assert_eq!(
        wrong(&|_, options| options.interpolated = 32),
        "interpolated"
    );
    assert_eq!(wrong(&|clip, _| clip.frames = 4), "tracks[0]");
    assert_eq!(
        wrong(&|clip, _| clip.bones[1].parent = Some(1)),
        "bones[1].parent"
    );
    assert_eq!(
        wrong(&|clip, _| clip.bones[1].center[0] = f32::NAN),
        "bones[1].center"
    );
    assert_eq!(wrong(&|clip, _| drop(clip.tracks.pop())), "tracks");
    assert_eq!(wrong(&|clip, _| *clip = sample(1024, 1)), "bones");
    let infinite = |clip: &mut Abp1Clip, _: &mut Abp1Options| {
        let tracks = clip.tracks[2].clone();
        let track = vec![[f32::INFINITY; 3]; 5];
        clip.tracks[2] = tracks.with(TrackKind::Rotation, track);
    };
    assert_eq!(wrong(&infinite), "tracks[2].Rotation");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn clips_come_back_within_half_a_step(
        frames in 0usize..40,
        kinds in prop::collection::vec((0usize..32, any::<u8>()), 0..6),
        quantizer in 1u8..=31,
        power in 0u8..=7,
        form in 0usize..3,
    ) {
        let clip = Abp1Clip {
            tracks: kinds.iter().map(|(kinds, seed)| {
                let track = |kind: usize| {
                    (kinds >> kind & 1 == 1).then(|| track(usize::from(*seed) + kind, frames))
                };
                BoneTracks(std::array::from_fn(track))
            }).collect(),
            bones: (0..kinds.len()).map(bone).collect(),
            ..sample(0, frames)
        };
        let coding = [Some(CodingType::Predictive), Some(CodingType::Dct), None][form];
        let options = Abp1Options { quantizer, power, coding, interpolated: 0 };
        let bytes = write(&clip, &options).unwrap();
        let read = decoded(&bytes);
        prop_assert_eq!((&read.bones, read.frames, read.rate), (&clip.bones, frames, clip.rate));
        for (expected, found) in clip.tracks.iter().zip(&read.tracks) {
            for kind in TrackKind::ALL {
                // Without frames there is no access unit that could tell.
                let expected = expected.get(kind).filter(|_| frames > 0);
                prop_assert_eq!(expected.is_some(), found.get(kind).is_some());
                let (Some(expected), Some(found)) = (expected, found.get(kind)) else { continue };
                let step = options.step(kind);
                // The transform: 16 errors of half a step in one value at most.
                let bound = if coding == Some(CodingType::Predictive) { 0.5 } else { 2.0 };
                for (a, b) in expected.iter().flatten().zip(found.iter().flatten()) {
                    let error = f64::from((a - b).abs());
                    prop_assert!(error <= bound * step * 1.001 + 1e-6, "{} of {}", error, step);
                }
            }
        }
        let text = write_text(&read).unwrap();
        let again = read_text(text.as_bytes(), &LIMITS).unwrap();
        if frames > 0 {
            prop_assert_eq!(&again, &read);
        }
        // Levels do not move when they are written again.
        if coding == Some(CodingType::Predictive) {
            prop_assert_eq!(decoded(&write(&again, &options).unwrap()), read);
        }
    }
}

#[test]
fn the_smaller_form_is_taken() {
    let clip = sample(10, 16);
    let size = |coding| {
        let options = Abp1Options {
            coding,
            ..Abp1Options::default()
        };
        write(&clip, &options).unwrap().len()
    };
    let both = [CodingType::Predictive, CodingType::Dct].map(|coding| size(Some(coding)));
    assert_eq!(size(None), both[0].min(both[1]));
    assert_ne!(both[0], both[1]);
}

#[test]
fn text_by_hand() {
    let text = "\
abpt 1
name a walk

# Of two bones.
frame_rate 29.97002997002997
frames 2
bones 2
0 TR - 0 1 0 0 4 the root
1 - 0 0 1.5 -0.25 2 3 spine
frame 0
0 0 0 0 0 0.5 0
frame 1
0 0.25 0 0 0 1 0
";
    let clip = read_text(text.as_bytes(), &LIMITS).unwrap();
    assert_eq!(clip.name, "a walk");
    assert_eq!(clip.rate, FrameRate::nearest(29.97).unwrap());
    assert_eq!(clip.bones[0].name, "the root");
    assert_eq!(
        (clip.bones[1].parent, clip.bones[1].center),
        (Some(0), [0.0, 1.5, -0.25])
    );
    assert_eq!((clip.bones[1].loa, clip.bones[1].region), (2, 3));
    let rotation = vec![[0.0, 0.5, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(clip.tracks[0].get(TrackKind::Rotation), Some(&rotation));
    let expected: String = text
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(write_text(&clip), Ok(expected));
    let error = |from: &str, to: &str| {
        let edited = text.replacen(from, to, 1);
        read_text(edited.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
    };
    assert!(error("abpt 1", "abpt 2").starts_with("line 1: expected version 1"));
    assert!(error("29.97002997002997", "no").starts_with("line 5: a frame rate of no"));
    assert!(error("bones 2", "bones 2000").starts_with("line 7: 2000 bones"));
    assert!(error("TR", "TQ").starts_with("line 8: found \"TQ\""));
    assert!(error("- 0 0 1.5", "- 1 0 1.5").starts_with("line 9: found \"1\""));
    assert!(error("0.5 0\n", "0.5\n").starts_with("line 11: found \"the end of the line\""));
    assert!(error("0.5 0\n", "0.5 0 7\n").starts_with("line 11: too many values"));
    assert!(error("frame 1", "frame 2").starts_with("line 12: frame 2, expected 1"));
    assert!(error("0 0.25", "1 0.25").starts_with("line 13: found \"1 0.25"));
    assert!(error("1 0\n", "1 0\nmore\n").starts_with("line 14: found \"more\""));
    assert!(error("frames 2", "frames 3").starts_with("line 13: unexpected end"));
}

#[test]
fn no_mutation_panics() {
    let bytes = write(&sample(12, 40), &Abp1Options::default()).unwrap();
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
        let rule = CutRule::default().at_most("loa", 0);
        let cut = cut_checked(bytes, &map, &rule);
        unit(&cut.bytes, &LIMITS).unwrap();
        if let Ok(clip) = read(bytes, AbsentBone::Last, &LIMITS) {
            clip.check().unwrap();
        }
        true
    };
    let read = mutations.read_of(&bytes, 3000, whole);
    assert!(read > 100, "only {read} mutants were read");
    for bytes in cut_off(&bytes) {
        whole(bytes);
    }
    let text = write_text(&sample(3, 4)).unwrap();
    let mutations = Mutations {
        edits: &[
            Edit::SetByte,
            Edit::Delete(5),
            Edit::Number(&["-1", "1e40", "NaN", "18446744073709551615"]),
        ],
        most: 2,
    };
    let read = mutations.read_of(text.as_bytes(), 3000, |bytes| {
        let read = read_text(bytes, &LIMITS);
        read.is_ok_and(|clip| clip.check().is_ok())
    });
    assert!(read > 100, "only {read} mutants were read");
}

#[test]
fn random_bits_need_little_memory() {
    let bones = 20;
    let good = write(&sample(bones, 16), &Abp1Options::default()).unwrap();
    let map = unit(&good, &LIMITS).unwrap();
    let access_unit = (map.children[1].bits.start / 8) as usize;
    let header = access_unit + 4 + 82 / 8;
    let mut dice = Dice::new(7);
    let of_head = allocation_counter::measure(|| {
        let _ = read(&good[..access_unit], AbsentBone::Rest, &LIMITS);
    });
    for _ in 0..2000 {
        let mut bytes = good.clone();
        for byte in &mut bytes[header..] {
            *byte = dice.roll(256) as u8;
        }
        let used = allocation_counter::measure(|| {
            let _ = read(&bytes, AbsentBone::Rest, &LIMITS);
        });
        let more = used.bytes_max.saturating_sub(of_head.bytes_max);
        assert!(more < 64 * 1024 * bones as u64, "{more} bytes");
    }
}

#[test]
fn a_stream_that_would_need_much_memory_is_refused() {
    let bytes = write(&sample(12, 40), &Abp1Options::default()).unwrap();
    // 13 tracks of 48 coded frames.
    let within = |elements| {
        let limits = StreamLimits { elements, ..LIMITS };
        read(&bytes, AbsentBone::Rest, &limits)
    };
    assert!(within(3 * 13 * 48).is_ok());
    let error = within(3 * 13 * 48 - 1).unwrap_err();
    assert!(error.to_string().contains("elements"), "{error}");
    let limits = StreamLimits {
        bytes: 99,
        ..LIMITS
    };
    assert!(unit(&bytes, &limits).is_err());
}
