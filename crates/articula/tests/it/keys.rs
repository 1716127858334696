//! Clips whose keys are not regular keep their motion in every format.
//!
//! Expected angles are those at which the files were keyed: the upper arm turns about z, by -70 degrees
//! at its low keys and by 60 at its high ones, linearly between them.

use crate::real::real_data;
use articula::convert::{AddClipsOptions, ClipEdits, ConvertOptions, fit_clips};
use articula::{CharacterFile, Executor, Figure, Format, OpenOptions, convert, fs, open};
use articula_core::source::evaluate;
use articula_core::{LocalPose, ModelPose, Rig, local_to_model};
use glam::Vec3;
use std::path::Path;

fn file(name: &str) -> CharacterFile {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/keys");
    fs::open(folder.join(name)).unwrap()
}

/// A file written and read again.
fn through(opened: CharacterFile, format: Format, options: &ConvertOptions) -> CharacterFile {
    let made = convert(opened, format, options, &Executor::default()).unwrap();
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    let name = format!("written.{}", format.name());
    open(&made.written.bytes, &name, &OpenOptions::default(), nothing).unwrap()
}

/// Angle of the left upper arm in degrees at a time, as keyed at 0, 0.4, 0.6, 2.6 and 3.0 s.
fn waved_deg(secs: f64) -> f64 {
    let keys = [(0.0, -70.0), (0.4, 60.0), (2.6, 60.0), (3.0, -70.0)];
    let next = keys.iter().position(|k| k.0 > secs).unwrap_or(3).max(1);
    let ((from, a), (to, b)) = (keys[next - 1], keys[next]);
    a + (b - a) * ((secs - from) / (to - from)).clamp(0.0, 1.0)
}

/// Direction of the left upper arm in the first clip, by the H-Anim names of its joints.
fn upper_arm(opened: &CharacterFile, secs: f32) -> Vec3 {
    let rig = Rig::new(&opened.character().skeleton, opened.articulation()).unwrap();
    let mut local: LocalPose = rig.rest_pose().clone();
    let clip = &opened.character().clips[0];
    evaluate::pose(clip, &opened.character().skeleton, secs, &mut local);
    let mut model = ModelPose::new(rig.len());
    local_to_model(&rig, &local, &mut model);
    let at = |name| model.position(rig.articulation().find(name).unwrap());
    (at("l_elbow") - at("l_shoulder")).normalize()
}

/// The greatest angle between an upper arm and where its keys have it, against the direction at 0.6 s;
/// every 7 ms, which is on no grid of the keys.
fn worst_deg(opened: &CharacterFile) -> f64 {
    let raised = upper_arm(opened, 0.6);
    let apart = |i: i32| {
        let secs = 0.007 * f64::from(i);
        let turned = upper_arm(opened, secs as f32).angle_between(raised);
        (f64::from(turned).to_degrees() - (60.0 - waved_deg(secs))).abs()
    };
    (0..=428).map(apart).fold(0.0, f64::max)
}

#[test]
fn hand_set_keys_are_kept_in_frames() {
    assert!(
        worst_deg(&file("hand_keyed_wave.glb")) < 0.02,
        "the file itself"
    );
    for format in [Format::Bvh, Format::Abp, Format::X3d] {
        let written = file("hand_keyed_wave.glb");
        let options = ConvertOptions::default();
        let made = convert(written, format, &options, &Executor::default()).unwrap();
        let [resampling] = &made.resampling[..] else {
            panic!("one clip");
        };
        assert!(resampling.resampling_mm < 0.1, "{resampling:?}");
        assert_eq!(resampling.warning(), None);
        if format == Format::Abp {
            // Such a stream has no skeleton.
            continue;
        }
        let back = through(file("hand_keyed_wave.glb"), format, &options);
        // An arm of 0.6 m turned by 0.1 degrees moves by 1 mm.
        let worst = worst_deg(&back);
        assert!(worst < 0.1, "{format:?}: {worst} degrees");
    }
}

#[test]
fn hand_set_keys_are_kept_on_another_figure() {
    let (wave, other) = (
        file("hand_keyed_wave.glb"),
        file("../../../articula-formats/tests/cases/rigt_cc.glb"),
    );
    let options = AddClipsOptions {
        keep_own: false,
        ..AddClipsOptions::default()
    };
    let fitted = fit_clips(&wave, &other, &options).unwrap();
    let told = fitted[0].fit.resampling.as_ref().unwrap();
    assert!(told.resampling_mm < 0.1, "{told:?}");
    let mut onto = other;
    onto.put_clips(fitted, false);
    let worst = worst_deg(&onto);
    assert!(worst < 0.5, "{worst} degrees");
}

#[test]
fn two_keys_at_one_time_stay_a_jump() {
    let at = |opened: &CharacterFile, secs: f32| {
        let (before, now) = (upper_arm(opened, 0.25), upper_arm(opened, secs));
        before.angle_between(now).to_degrees()
    };
    let rate = |rate_hz| ConvertOptions {
        edits: ClipEdits {
            rate_hz,
            ..ClipEdits::default()
        },
        ..ConvertOptions::default()
    };
    let file_itself = file("dup_jump.glb");
    for rate_hz in [None, Some(100.0), Some(30.0)] {
        let out = through(file("dup_jump.glb"), Format::Glb, &rate(rate_hz));
        for opened in [&file_itself, &out] {
            // From -70 to 60 degrees.
            assert!(at(opened, 0.4995) < 0.05, "{rate_hz:?}");
            assert!((at(opened, 0.5) - 130.0).abs() < 0.05, "{rate_hz:?}");
            assert!((at(opened, 0.75) - 130.0).abs() < 0.05, "{rate_hz:?}");
        }
    }
    // Frames of a format without keys: the jump takes one of at least 120 Hz.
    let frames = through(file("dup_jump.glb"), Format::Bvh, &rate(None));
    assert!(at(&frames, 0.5 - 1.0 / 119.0) < 0.05);
    assert!((at(&frames, 0.5) - 130.0).abs() < 0.05);
}

#[test]
fn clips_that_begin_late_or_pause_hit_all_of_their_keys() {
    let Some(data) = real_data() else { return };
    // Keys 1/30 s late at 24 Hz, and keys at 24 Hz with one gap of 0.2 s; the fox is 79 m tall.
    let clips = [
        ("mannequiny", "air_land_root.001", 0.1),
        ("Fox", "Run", 4.0),
    ];
    for (name, clip, most_mm) in clips {
        let opened = fs::open(data.join(format!("glb/{name}.glb"))).unwrap();
        let figure = Figure::new(opened).unwrap();
        let all = figure.resampling();
        let found = all.iter().find(|c| c.clip == clip).unwrap();
        assert!(found.resampling_mm < most_mm, "{found:?}");
        assert_eq!(found.rate_hz, Some(120.0), "the grid of all keys");
    }
}
