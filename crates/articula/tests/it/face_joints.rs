//! Faces whose joints show parameters, and parameters read off moving faces.

use crate::bare::bare;
use crate::real;
use crate::short::shortened;
use articula::face::{FaceColumns, FaceKind, fit_face, measure_faps};
use articula::{Figure, fs};
use articula_core::fap_table::FAP_COUNT;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};

/// A clip of frames at 25 Hz, a second each way to the values and back.
fn clip(values: &[(usize, i32)]) -> FapClip {
    let frame = |number: u32| {
        let mut frame = FapFrame {
            number,
            ..FapFrame::default()
        };
        let share = 1.0 - (f64::from(number) / 25.0 - 1.0).abs();
        for (fap, value) in values {
            frame.low[fap - 3] = (share * f64::from(*value)).round() as i32;
        }
        frame
    };
    FapClip {
        name: "hand made".to_owned(),
        rate_hz: 25.0,
        coded: [true; FAP_COUNT],
        frames: (0..=50).map(frame).collect(),
        bridge: None,
    }
}

/// A woman whose rig has joints for lips, lids and brows.
const HEAD: &str = "glb/mh_female_default163_arkit52.glb";

/// The greatest value of a parameter in a clip, with its sign.
fn peak(clip: &FapClip, fap: usize) -> f32 {
    let values = clip.frames.iter().map(|f| f.low[fap - 3]);
    values.max_by_key(|v| v.abs()).unwrap() as f32
}

#[test]
fn joints_move_a_face_as_far_as_its_parameters_say() {
    let Some(mut head) = bare(HEAD) else {
        return;
    };
    // The jaw opens, lids close, a brow rises, the head turns, both eyes look left; the tongue, which
    // the figure lacks, is to come out.
    let wanted = [
        (3, 350, 0.2),
        (19, 700, 0.4),
        (20, 700, 0.4),
        (31, 300, 0.7),
        (48, 9_000, 1e-3),
        (49, -20_000, 1e-3),
        (23, 15_000, 1e-3),
        (24, 15_000, 1e-3),
    ];
    let mut values: Vec<(usize, i32)> = wanted.iter().map(|(fap, v, _)| (*fap, *v)).collect();
    values.push((45, 400));
    let made = fit_face(&clip(&values), "face.fap", &head).unwrap();
    let report = &made.report;
    assert_eq!(report.kind, FaceKind::Joints);
    assert_eq!(report.columns, FaceColumns::Table);
    let not_driven: Vec<usize> = report.not_driven.iter().map(|n| n.fap).collect();
    assert_eq!(not_driven, [45]);
    let shown: Vec<usize> = report.shown.iter().map(|s| s.fap).collect();
    assert_eq!(shown, [3, 19, 20, 31]);
    assert!(
        report
            .shown
            .iter()
            .all(|s| (25.0..=100.0).contains(&s.percent))
    );
    // The weights of the clip's parts are exact.
    assert_eq!(report.error_mm_max, 0.0);

    head.put_clips(vec![made.fitted], false);
    let figure = Figure::new(head).unwrap();
    let read = measure_faps(&figure, 0, "read back").unwrap();
    assert_eq!((read.frames.len(), read.rate_hz), (51, 25.0));
    assert_eq!(read.name, "read_back");
    for (fap, value, off) in wanted {
        let (found, value) = (peak(&read, fap), value as f32);
        assert!(
            (found / value - 1.0).abs() <= off,
            "FAP {fap}: {found}, not {value}"
        );
    }
    // What was to rest moves far less.
    for still in [4, 5, 12, 13, 35, 37, 61] {
        let found = peak(&read, still);
        assert!(found.abs() < 80.0, "FAP {still}: {found}");
    }
    assert_eq!(peak(&read, 45), 0.0);
}

#[test]
fn a_clip_that_moves_no_face_has_no_parameters() {
    let Some(path) = real::file("glb/mh_female_dance.glb") else {
        return;
    };
    let mut opened = shortened(fs::open(&path).unwrap(), 1.0);
    for clip in opened.clips_mut() {
        clip.channels.clear();
    }
    let still = Figure::new(opened).unwrap();
    let error = measure_faps(&still, 0, "still").unwrap_err();
    assert!(
        error.to_string().contains("moves nothing of the face"),
        "{error}"
    );
}
