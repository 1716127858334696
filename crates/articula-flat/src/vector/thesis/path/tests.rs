//! Static sequences and hidden faces, computed by hand.

use super::*;
use crate::planar::clip::fixture;
use crate::vector::thesis::{ThesisForm, thesis};
use glam::Vec2;

const CORNERS: [[f32; 3]; 3] = [[2.0, 2.0, 0.5], [2.0, 9.0, 0.5], [9.0, 2.0, 0.5]];

/// A triangle that moves a pixel to the right in the given frames of 100.
fn stepping(steps: &[usize]) -> PlanarClip {
    let mut clip = fixture::loose(&[(CORNERS, [10, 20, 30])], 100);
    for step in steps {
        for frame in &mut clip.frames[*step..] {
            for xy in &mut frame.xy {
                xy.x += 1.0;
            }
        }
    }
    clip
}

fn written(clip: &PlanarClip, optimised: [bool; 2]) -> String {
    let [optimise_hidden, optimise_static] = optimised;
    let options = ThesisSvgOptions {
        form: ThesisForm::Path,
        optimise_hidden,
        optimise_static,
        neutral_frame: 0,
    };
    thesis(clip, &options).unwrap().text
}

fn animates(text: &str) -> Vec<&str> {
    let lines = text.lines();
    lines.filter(|l| l.starts_with("<animate")).collect()
}

#[test]
fn tags_are_chosen_above_200_thirteenths_frames_to_a_static_sequence() {
    // 200 / 13 = 15.38.
    assert!(merges_by_tags(16, 1) && !merges_by_tags(15, 1));
    assert!(merges_by_tags(77, 5) && !merges_by_tags(76, 5));
    assert!(!merges_by_tags(200, 13) && merges_by_tags(201, 13));
    assert!(merges_by_tags(1, 0));
}

#[test]
fn few_static_sequences_are_merged_by_tags() {
    // Still in 0..=39, moving up to 60, still in 60..=99.
    let steps: Vec<usize> = (40..=60).collect();
    let text = written(&stepping(&steps), [false, true]);
    let tags = animates(&text);
    let starts = [
        "0.000s\" dur=\"1.560s",
        "1.560s\" dur=\"0.840s",
        "2.400s\" dur=\"1.560s",
    ];
    assert_eq!(tags.len(), starts.len());
    for (tag, start) in tags.iter().zip(starts) {
        assert!(tag.contains(start), "{tag}");
        assert!(!tag.contains("keyTimes"));
    }
    let keys: Vec<usize> = tags.iter().map(|t| t.matches("M ").count()).collect();
    // The moving one has the frames 39 to 60, both ends included.
    assert_eq!(keys, [1, 22, 1]);
}

#[test]
fn many_static_sequences_are_merged_by_key_times() {
    // Ten static sequences of ten frames: 10 frames to one.
    let steps: Vec<usize> = (1..10).map(|k| 10 * k).collect();
    let text = written(&stepping(&steps), [false, true]);
    let tags = animates(&text);
    assert_eq!(tags.len(), 1);
    assert_eq!(tags[0].matches("M ").count(), 20);
    let times = tags[0].split("keyTimes=\"").nth(1).unwrap();
    // Frames 0, 9, 10, 19, … of 99; a separator and a time are 13 bytes.
    assert!(times.starts_with("0.0000000000;0.0909090909;0.1010101010;0.1919191919;"));
    assert!(times.ends_with(";1.0000000000\"/>"));
    assert_eq!(times.len(), 20 * 13 - 1 + "\"/>".len());
}

#[test]
fn two_frames_at_one_place_are_no_static_sequence() {
    let steps: Vec<usize> = (0..100).step_by(2).collect();
    let clip = stepping(&steps);
    assert_eq!(
        written(&clip, [false, true]),
        written(&clip, [false, false])
    );
}

#[test]
fn a_hidden_face_has_no_coordinates() {
    // Turned away in the frames 30 to 69 and in 99.
    let steps: Vec<usize> = (0..100).collect();
    let mut clip = stepping(&steps);
    for f in (30..70).chain([99]) {
        clip.frames[f].xy.swap(0, 1);
    }
    for xy in clip.frames.iter_mut().flat_map(|frame| &mut frame.xy) {
        xy.x -= 70.0;
    }
    let raw = written(&clip, [false, false]);
    assert_eq!(animates(&raw)[0].matches("M ").count(), 100);
    // In view only from x > -9: frame 61 on, of which 61 to 69 are turned away.
    let text = written(&clip, [true, false]);
    let tags = animates(&text);
    assert_eq!(tags.len(), 1);
    assert_eq!(tags[0].matches("M ").count(), 29);
    assert!(tags[0].contains("begin=\"2.800s\" dur=\"1.120s\""));
    let sets: Vec<&str> = text.lines().filter(|l| l.starts_with("<set")).collect();
    assert_eq!(sets.len(), 3);
    assert!(sets[0].contains("to=\"hidden\" begin=\"0.000s\" dur=\"2.800s\""));
    assert!(sets[1].contains("to=\"visible\" begin=\"2.800s\" dur=\"1.160s\""));
    assert!(sets[2].contains("to=\"hidden\" begin=\"3.960s\" dur=\"0.040s\""));
    assert!(text.contains("visibility=\"hidden\">"));
}

#[test]
fn a_face_in_view_for_one_frame_is_held_for_it() {
    let mut clip = stepping(&[]);
    for (f, frame) in clip.frames.iter_mut().enumerate() {
        if f != 50 {
            frame.xy = vec![Vec2::splat(-5.0); 3];
        }
    }
    for optimise_static in [false, true] {
        let text = written(&clip, [true, optimise_static]);
        let tags = animates(&text);
        assert_eq!(tags.len(), 1);
        assert!(tags[0].contains("begin=\"2.000s\" dur=\"0.040s\""));
        assert_eq!(tags[0].matches("M ").count(), 1);
        assert!(text.contains(" d=\"M 2.000 2.000 "));
    }
}
