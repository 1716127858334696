//! FAP text by hand: irregularities, faults, and round trips.

use super::texts::{self, mask};
use articula_core::fap_table::FAP_COUNT;
use articula_formats::mpeg4::fap::{self, AbsentPolicy, FapClip, FapExpression, FapFrame, Viseme};
use articula_formats::{Limits, Parsed, ReadError};
use proptest::prelude::*;

fn read(text: &str) -> Result<Parsed<FapClip>, ReadError> {
    fap::read(text.as_bytes(), AbsentPolicy::Hold, &Limits::default())
}

#[test]
fn two_frames_by_hand() {
    let read = read(&texts::fap()).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    let clip = read.value;
    assert_eq!((clip.name.as_str(), clip.rate_hz), ("talk", 25.0));
    let coded: Vec<usize> = (1..=68).filter(|n| clip.coded[n - 1]).collect();
    assert_eq!(coded, [1, 2, 3, 48]);
    let [a, b] = &clip.frames[..] else {
        panic!("{} frames", clip.frames.len())
    };
    let viseme = Viseme {
        select1: 10,
        select2: 0,
        blend: 40,
        defines: true,
    };
    let expression = FapExpression {
        select1: 1,
        intensity1: 63,
        select2: 0,
        intensity2: 0,
        init_face: false,
        defines: true,
    };
    assert_eq!((a.number, a.viseme, a.expression), (0, viseme, expression));
    // FAP 3 comes first, FAP 48 is at 45.
    assert_eq!((a.low[0], a.low[45]), (120, -4000));
    assert_eq!(
        (b.number, b.viseme),
        (3, viseme),
        "what a mask leaves out holds"
    );
    assert_eq!((b.low[0], b.low[45]), (120, -2500));
    assert_eq!(clip.range(48), Some((-4000, -2500)));
    let ends = [clip.frames.first(), clip.frames.last()].map(|f| f.unwrap().number);
    assert_eq!((ends[1] - ends[0], clip.rate_hz), (3, 25.0));
}

#[test]
fn what_a_mask_leaves_out_may_be_neutral() {
    let clip = fap::read(
        texts::fap().as_bytes(),
        AbsentPolicy::Zero,
        &Limits::default(),
    );
    let second = clip.unwrap().value.frames[1].clone();
    assert_eq!((second.viseme, second.low[0]), (Viseme::default(), 0));
    assert_eq!(second.low[45], -2500);
}

#[test]
fn odd_spelling_is_read_alike() {
    let plain = read(&texts::fap()).unwrap().value;
    let odd = format!(
        "\u{feff}{}",
        texts::fap().replace('\n', "\r\n").replace(' ', "\t  ")
    );
    assert_eq!(read(&odd).unwrap().value, plain);
    let path = texts::fap().replace("talk", r"C:\My Files\talk");
    assert_eq!(read(&path).unwrap().value.name, r"C:\My Files\talk");
    let old = [texts::fap().as_bytes(), b"# \xe9\n"].concat();
    assert!(fap::read(&old, AbsentPolicy::Hold, &Limits::default()).is_ok());
}

#[test]
fn oddities_are_said() {
    let jaw = mask(68, &[3]);
    let cases = [
        ("3.0 a 25 1", "0 5", "version \"3.0\" is read as"),
        (
            "2.2 a 25 10000",
            "0 5",
            "10000 frames declared, but the file has 1",
        ),
        ("2.1 a 25 many", "0 5", "number of frames \"many\" found"),
        ("2.1 a 25 1", "0 -5", "negative values"),
        (
            "2.1 a 25 1",
            "0 5.4",
            "\"5.4\" found, a whole number expected",
        ),
    ];
    for (head, values, wanted) in cases {
        let read = read(&format!("{head}\n{jaw}\n{values}\n")).unwrap();
        assert_eq!(read.warnings.len(), 1, "{:?}", read.warnings);
        assert!(
            read.warnings[0].what.contains(wanted),
            "{:?}",
            read.warnings
        );
        assert_eq!(read.value.frames[0].low[0].abs(), 5);
    }
    let back = format!("2.1 a 25 3\n{jaw}\n7 1\n{jaw}\n7 2\n{jaw}\n0 3\n");
    let back = read(&back).unwrap();
    let numbers: Vec<u32> = back.value.frames.iter().map(|f| f.number).collect();
    assert_eq!((numbers, back.warnings.len()), (vec![7, 8, 9], 1));
    let cut = read(&format!("2.1 a 25 1\n{jaw}\n0 1\n{jaw}\n")).unwrap();
    assert_eq!((cut.value.frames.len(), cut.warnings.len()), (1, 1));
    assert!(
        cut.warnings[0]
            .what
            .contains("the file ends between a mask")
    );
    let empty = read("2.1 a 25 0\n").unwrap();
    assert!(empty.value.frames.is_empty() && empty.warnings.is_empty());
}

#[test]
fn faults_name_their_line() {
    let jaw = mask(68, &[3]);
    let both = mask(68, &[1, 2]);
    let cases = [
        (String::new(), "line 1: no header found"),
        (
            "2.1 25\n".into(),
            "line 1: 2 words found; the header of a FAP file is",
        ),
        ("2.1 a fast 3\n".into(), "line 1: frame rate \"fast\" found"),
        ("2.1 a NaN 3\n".into(), "line 1: frame rate \"NaN\" found"),
        ("2.1 a 0 3\n".into(), "line 1: frame rate \"0\" found"),
        (
            format!("2.1 a 25 1\n{}\n0\n", mask(186, &[])),
            "line 2: 186 words found, expected a FAP mask of 68",
        ),
        (
            format!("2.1 a 25 1\n{}\n0\n", "0 ".repeat(67) + "2"),
            "line 2: \"2\" found in a mask",
        ),
        (
            format!("2.1 a 25 1\n#\n{jaw}\n0 1 2\n"),
            "line 4: 3 numbers found, the mask expects the frame number and 1 values",
        ),
        (
            format!("2.1 a 25 1\n{jaw}\n0\n"),
            "line 3: 1 numbers found, the mask expects the frame number and 1 values",
        ),
        (
            format!("2.1 a 25 1\n{jaw}\n-1 2\n"),
            "line 3: frame number \"-1\" found",
        ),
        (
            format!("2.1 a 25 1\n{jaw}\n0 x\n"),
            "line 3: \"x\" found, a whole number",
        ),
        (
            format!("2.1 a 25 1\n{jaw}\n0 1e99\n"),
            "line 3: \"1e99\" found",
        ),
        (
            format!("2.1 a 25 1\n{both}\n0 15 0 0 0 0 0 0 0 0 0\n"),
            "line 3: viseme 15 found, 0 to 14",
        ),
        (
            format!("2.1 a 25 1\n{both}\n0 0 0 64 0 0 0 0 0 0 0\n"),
            "line 3: viseme blend 64 found",
        ),
        (
            format!("2.1 a 25 1\n{both}\n0 0 0 0 0 -1 0 0 0 0 0\n"),
            "line 3: expression -1 found",
        ),
        (
            format!("2.1 a 25 1\n{both}\n0 0 0 0 0 0 0 0 0 2 0\n"),
            "line 3: init_face 2 found",
        ),
    ];
    for (text, wanted) in cases {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{text:?}: {error}");
    }
}

#[test]
fn what_a_file_may_ask_for_is_bounded() {
    let text = texts::fap();
    let all = Limits::default();
    for limits in [
        Limits { bytes: 10, ..all },
        Limits { frames: 1, ..all },
        Limits {
            elements: 67,
            ..all
        },
    ] {
        let error = fap::read(text.as_bytes(), AbsentPolicy::Hold, &limits).unwrap_err();
        assert!(matches!(error, ReadError::LimitExceeded { .. }), "{error}");
    }
    // One frame, but hours away.
    let far = format!("2.1 a 25 1\n{}\n4000000000 1\n", mask(68, &[3]));
    let error = read(&far).unwrap_err();
    assert!(matches!(error, ReadError::LimitExceeded { .. }), "{error}");
}

#[test]
fn masks_are_shrunk_to_what_moves() {
    let mut clip = read(&texts::fap()).unwrap().value;
    clip.name = " two words ".into();
    let text = String::from_utf8(fap::write(&clip)).unwrap();
    let wanted = format!(
        "2.1 two_words 25 2\n{0}\n0 10 0 40 1 1 63 0 0 0 1 120 -4000\n{0}\n3 10 0 40 1 1 63 0 0 0 1 120 -2500\n",
        mask(68, &[1, 2, 3, 48])
    );
    assert_eq!(text, wanted);
    for frame in &mut clip.frames {
        *frame = FapFrame {
            number: frame.number,
            ..FapFrame::default()
        };
    }
    let still = String::from_utf8(fap::write(&clip)).unwrap();
    assert!(still.ends_with(&format!("{0}\n0\n{0}\n3\n", mask(68, &[]))));
}

fn frames() -> impl Strategy<Value = Vec<FapFrame>> {
    let viseme = (0..15u8, 0..15u8, 0..64u8, any::<bool>());
    let expression = ((0..7u8, 0..64u8, 0..7u8, 0..64u8), any::<(bool, bool)>());
    let low =
        prop::array::uniform::<_, { FAP_COUNT - 2 }>(prop_oneof![3 => Just(0), 1 => any::<i32>()]);
    let frame =
        (1..9u32, viseme, expression, low).prop_map(|(step, v, (e, flags), low)| FapFrame {
            number: step,
            viseme: Viseme {
                select1: v.0,
                select2: v.1,
                blend: v.2,
                defines: v.3,
            },
            expression: FapExpression {
                select1: e.0,
                intensity1: e.1,
                select2: e.2,
                intensity2: e.3,
                init_face: flags.0,
                defines: flags.1,
            },
            low,
        });
    prop::collection::vec(frame, 0..6).prop_map(|mut frames| {
        let mut number = 0;
        for frame in &mut frames {
            number += frame.number;
            frame.number = number;
        }
        frames
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn there_and_back_all_values_are_the_same(frames in frames(), rate in 1..240u16, zero: bool) {
        let mut clip = FapClip {
            name: "clip".into(),
            rate_hz: f32::from(rate) / 4.0,
            coded: [false; 68],
            frames,
            bridge: zero.then(|| "9d2b-generic".to_owned()),
        };
        clip.coded = clip.moving();
        let absent = if zero { AbsentPolicy::Zero } else { AbsentPolicy::Hold };
        let read = fap::read(&fap::write(&clip), absent, &Limits::default()).unwrap();
        prop_assert_eq!(read.value, clip);
    }
}
