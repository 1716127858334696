//! Tests of the writer of animated SVG files.

use super::super::smil_sampler::AnimatedSvg;
use super::*;
use proptest::prelude::*;

fn clip(frames: u32, shapes: Vec<KeyedShape>) -> KeyedClip {
    KeyedClip {
        width: 100,
        height: 50,
        fps: 25.0,
        frames,
        lines: LineUnits::Grid,
        ramps: vec![[255, 0, 0]],
        motions: vec![],
        shapes,
    }
}

#[test]
fn shapes_of_one_motion_are_in_one_group() {
    let outline = KeyedTrack::still(vec![0, 0, 8, 0, 0, 8]);
    let follows = |motion| KeyedShape {
        motion,
        ..triangle(outline.clone(), 5)
    };
    let motion = KeyedMotion {
        translation: KeyedTrack {
            frames: vec![0, 2, 4],
            values: vec![105, -20, 0, 0, -7, 300],
            width: 2,
        },
        rotation: KeyedTrack::still(vec![-4550]),
        skew: KeyedTrack::still(vec![0]),
        scale: KeyedTrack {
            frames: vec![0, 1, 4],
            values: vec![10_000, 9500, 12_000, 10_000, 10_000, 10_000],
            width: 2,
        },
    };
    let mut clip = clip(5, [None, Some(0), Some(0), None].map(follows).to_vec());
    clip.motions.push(motion.clone());
    let text = smil(&clip, "").unwrap();
    assert_eq!(text.matches("<g ").count(), 1);
    let group = concat!(
        r#"<g transform="translate(10.5-2)rotate(-45.5)scale(1 .95)">"#,
        r#"<animateTransform attributeName="transform" type="translate" dur="0.16" "#,
        r#"repeatCount="indefinite" values="10.5-2;0 0;-.7 30"/>"#,
        r#"<animateTransform attributeName="transform" type="rotate" additive="sum" dur="0.16" "#,
        r#"repeatCount="indefinite" values="-45.5;-45.5"/>"#,
        r#"<animateTransform attributeName="transform" type="scale" additive="sum" dur="0.16" "#,
        r#"repeatCount="indefinite" values="1 .95;1.2 1;1 1" keyTimes="0;.25;1"/><path"#,
    );
    assert!(text.contains(group), "{text}");
    // The reader composes them in that sequence, between keys too.
    let still = AnimatedSvg::read(&text).unwrap().at(0.06).unwrap();
    let transform = still.split(r#"transform=""#).nth(1).unwrap();
    assert!(
        transform.starts_with(r#"translate(2.625-0.5)rotate(-45.5)scale(1.1667 1)""#),
        "{transform}"
    );
    let wrong = KeyedShape {
        motion: Some(1),
        ..follows(None)
    };
    clip.shapes.push(wrong);
    assert!(smil(&clip, "").is_err());
}

fn triangle(outline: KeyedTrack, frames: u32) -> KeyedShape {
    KeyedShape {
        motion: None,
        outline,
        further_outlines: vec![],
        paint: KeyedPaint::Flat([0x11, 0x22, 0x33]),
        shown: KeyedShape::shown_in(std::slice::from_ref(&(0..frames as usize)), frames),
    }
}

fn keys(frames: &[u32], rows: &[[i32; 6]]) -> KeyedTrack {
    KeyedTrack {
        frames: frames.to_vec(),
        values: rows.as_flattened().to_vec(),
        width: 6,
    }
}

fn spans(half_frames: &[[u32; 2]]) -> Vec<Range<u32>> {
    half_frames.iter().map(|[from, to]| *from..*to).collect()
}

#[test]
fn one_still_triangle_to_the_byte() {
    let shape = triangle(KeyedTrack::still(vec![8, 4, 4, 20, 40, 8]), 3);
    let text = smil(&clip(3, vec![shape]), "a&b").unwrap();
    let expected = concat!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="100" height="50" viewBox="0 0 400 200">"#,
        "<title>a&amp;b</title>",
        r#"<linearGradient id="a" gradientUnits="userSpaceOnUse"><stop/>"#,
        r##"<stop offset="1" stop-color="#f00"/></linearGradient>"##,
        r##"<path fill="#123" d="m8 4-4 16 36-12"/></svg>"##,
    );
    assert_eq!(text, expected);
}

#[test]
fn a_straight_move_has_two_keys_and_no_times() {
    let rows = [[8, 4, 4, 20, 40, 8], [9, 4, 5, 20, 41, 8]];
    let shape = triangle(keys(&[0, 2], &rows), 3);
    let text = smil(&clip(3, vec![shape]), "").unwrap();
    let expected = concat!(
        r##"<path fill="#123" d="m8 4-4 16 36-12"><animate attributeName="d" dur="0.08" "##,
        r#"repeatCount="indefinite" values="m8 4-4 16 36-12;m9 4-4 16 36-12"/></path></svg>"#,
    );
    assert!(text.ends_with(expected), "{text}");
}

#[test]
fn what_is_hidden_first_has_no_outline_at_first() {
    let rows = [[8, 4, 4, 20, 40, 8], [48, 4, 44, 20, 80, 8]];
    let mut moving = triangle(keys(&[0, 10], &rows), 11);
    moving.shown = spans(&[[5, 15]]);
    let mut still = triangle(KeyedTrack::still(vec![8, 4, 4, 20, 40, 8]), 11);
    still.shown = spans(&[[5, 15]]);
    let text = smil(&clip(11, vec![moving, still]), "").unwrap();
    let expected = concat!(
        r##"<path fill="#123"><animate attributeName="d" dur="0.4" repeatCount="indefinite" "##,
        r#"values="m0 0 0 0 0 0;m0 0 0 0 0 0;m50 8-32-4-4 16;m70 8-32-4-4 16;"#,
        r#"m0 0 0 0 0 0;m0 0 0 0 0 0" keyTimes="0;.25;.25;.75;.75;1"/></path>"#,
        r##"<path fill="#123" d="m8 4-4 16 36-12" display="none"><animate "##,
        r#"attributeName="display" dur="0.4" repeatCount="indefinite" calcMode="discrete" "#,
        r#"values="none;inline;none" keyTimes="0;.25;.75"/></path>"#,
    );
    assert!(text.contains(expected), "{text}");
}

#[test]
fn gradients_share_ramps_and_keep_what_does_not_move_still() {
    let line = KeyedTrack {
        frames: vec![0, 5, 10],
        values: vec![0, 5, 100, 5, 0, 5, 110, 5, 0, 5, 120, 5],
        width: 4,
    };
    let mut shape = triangle(KeyedTrack::still(vec![8, 4, 4, 20, 40, 8]), 11);
    shape.paint = KeyedPaint::Ramp { ramp: 0, line };
    let text = smil(&clip(11, vec![shape.clone(), shape]), "").unwrap();
    let expected = concat!(
        r##"<linearGradient id="b" href="#a" y1="5" x2="100" y2="5"><animate "##,
        r#"attributeName="x2" dur="0.4" repeatCount="indefinite" values="100;120"/>"#,
        r##"</linearGradient><path fill="url(#b)" d="m8 4-4 16 36-12"/>"##,
        r##"<path fill="url(#b)" d="m8 4-4 16 36-12"/></svg>"##,
    );
    assert!(text.ends_with(expected), "{text}");
}

#[test]
fn a_colour_that_changes_is_animated_on_the_shape() {
    let color = KeyedTrack {
        frames: vec![0, 5, 10],
        values: vec![255, 0, 0, 102, 51, 0, 0, 0, 1],
        width: 3,
    };
    let mut shape = triangle(KeyedTrack::still(vec![8, 4, 4, 20, 40, 8]), 11);
    shape.paint = KeyedPaint::Changing(color);
    let text = smil(&clip(11, vec![shape]), "").unwrap();
    let expected = concat!(
        r##"<path fill="#f00" d="m8 4-4 16 36-12"><animate attributeName="fill" dur="0.4" "##,
        r##"repeatCount="indefinite" values="#f00;#630;#000001"/></path></svg>"##,
    );
    assert!(text.ends_with(expected), "{text}");
    let read = AnimatedSvg::read(&text).unwrap();
    let still = |secs| read.at(secs).unwrap();
    assert!(still(0.1).contains(r##"fill="#b31a00""##), "{}", still(0.1));
    assert!(still(0.2).contains(r##"fill="#630""##), "{}", still(0.2));
}

#[test]
fn unsound_clips_are_refused() {
    let good = triangle(KeyedTrack::still(vec![0; 6]), 3);
    let refused = |change: fn(&mut KeyedClip)| {
        let mut clip = clip(3, vec![good.clone()]);
        change(&mut clip);
        smil(&clip, "").unwrap_err()
    };
    assert_eq!(refused(|c| c.frames = 0), PlanarError::NoFrames);
    for change in [
        (|c: &mut KeyedClip| c.fps = f32::NAN) as fn(&mut KeyedClip),
        |c| c.shapes[0].shown = spans(&[[0, 9]]),
        |c| c.shapes[0].shown = spans(&[[0, 2], [2, 4]]),
        |c| c.shapes[0].outline.frames = vec![1],
        |c| c.shapes[0].outline.values = vec![0; 5],
        |c| c.shapes[0].outline.values[2] = i32::MIN,
        |c| c.shapes[0].further_outlines = vec![3],
        |c| c.shapes[0].paint = KeyedPaint::Changing(KeyedTrack::still(vec![0, 0, 256])),
        |c| c.shapes[0].paint = KeyedPaint::Changing(KeyedTrack::still(vec![0; 4])),
        |c| {
            c.shapes[0].paint = KeyedPaint::Ramp {
                ramp: 1,
                line: KeyedTrack::still(vec![0; 4]),
            };
        },
    ] {
        assert!(matches!(refused(change), PlanarError::Mismatch { .. }));
    }
}

/// Points of every path of a still SVG, sorted within a path; lines of the gradients.
fn seen(svg: &str) -> Vec<Vec<[f64; 2]>> {
    let document = resvg::usvg::roxmltree::Document::parse(svg).unwrap();
    let paths = document
        .descendants()
        .filter(|n| n.tag_name().name() == "path" && n.attribute("display") != Some("none"));
    paths
        .map(|n| {
            let d = n.attribute("d").unwrap_or("").replace('m', " ");
            let d = d.replace('-', " -");
            let numbers: Vec<f64> = d.split_whitespace().map(|w| w.parse().unwrap()).collect();
            let mut at = [0.0, 0.0];
            let mut points: Vec<[f64; 2]> = Vec::new();
            for step in numbers.chunks(2) {
                at = [at[0] + step[0], at[1] + step[1]];
                points.push(at);
            }
            points.sort_by(|a, b| a.partial_cmp(b).unwrap());
            points
        })
        .collect()
}

fn track(frames: u32, inner: Vec<u32>, values: Vec<i32>) -> KeyedTrack {
    let mut frames_of: Vec<u32> = inner.into_iter().map(|f| f % frames).collect();
    frames_of.extend([0, frames - 1]);
    frames_of.sort_unstable();
    frames_of.dedup();
    let count = frames_of.len() * 6;
    KeyedTrack {
        frames: frames_of,
        values: values.into_iter().cycle().take(count).collect(),
        width: 6,
    }
}

/// Twice the area of a triangle.
fn area(p: &[[f64; 2]]) -> f64 {
    let (u, v) = (
        [p[1][0] - p[0][0], p[1][1] - p[0][1]],
        [p[2][0] - p[0][0], p[2][1] - p[0][1]],
    );
    (u[0] * v[1] - u[1] * v[0]).abs()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    // Clip lengths at which three digits identify a frame exactly.
    #[test]
    fn the_sampler_reads_what_the_tracks_say(
        steps in prop::sample::select(vec![1u32, 2, 4, 10, 20, 50, 100, 250, 500]),
        inner in prop::collection::vec(0u32..1000, 0..6),
        values in prop::collection::vec(-900i32..900, 30),
        moments in prop::collection::vec(0.0f64..1.0, 8),
    ) {
        let frames = steps + 1;
        let outline = track(frames, inner, values);
        let text = smil(&clip(frames, vec![triangle(outline.clone(), frames)]), "n").unwrap();
        let moving = AnimatedSvg::read(&text).unwrap();
        prop_assert!((moving.duration_secs - f64::from(steps) / 25.0).abs() < 1e-9);
        for share in moments {
            let svg = moving.at(share * moving.duration_secs).unwrap();
            let mut expected: Vec<[f64; 2]> = outline
                .at(share * f64::from(steps))
                .chunks(2)
                .map(|p| [p[0], p[1]])
                .collect();
            expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let found = &seen(&svg)[0];
            for (a, b) in found.iter().zip(&expected) {
                for i in 0..2 {
                    prop_assert!((a[i] - b[i]).abs() < 1e-3, "{found:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn shown_is_what_the_spans_say(
        steps in prop::sample::select(vec![4u32, 10, 20, 50, 100, 250]),
        inner in prop::collection::vec(0u32..1000, 0..6),
        borders in prop::collection::btree_set(0usize..250, 2..9),
        is_still: bool,
    ) {
        let frames = steps + 1;
        let borders: Vec<usize> =
            borders.into_iter().filter(|f| *f <= frames as usize).collect();
        let spans: Vec<Range<usize>> =
            borders.chunks_exact(2).map(|b| b[0]..b[1]).collect();
        let mut shape = triangle(track(frames, inner, vec![40, 0, 3, 100, 77, 51, 9]), frames);
        if is_still {
            shape.outline = KeyedTrack::still(vec![0, 0, 90, 0, 0, 90]);
        }
        shape.shown = KeyedShape::shown_in(&spans, frames);
        let text = smil(&clip(frames, vec![shape.clone()]), "").unwrap();
        let moving = AnimatedSvg::read(&text).unwrap();
        for half in 0..2 * steps {
            // A little after each half frame: boundaries themselves depend on the digits.
            let frame = f64::from(half) / 2.0 + 0.01;
            let svg = moving.at(frame / 25.0).unwrap();
            let outline = shape.outline.at(frame);
            let own: Vec<[f64; 2]> = outline.chunks(2).map(|p| [p[0], p[1]]).collect();
            // A triangle that turns over has little area to be seen by; corners at borders are rounded.
            if area(&own) < 300.0 {
                continue;
            }
            let is_seen = seen(&svg).iter().any(|p| p.len() == 3 && area(p) > 1.0);
            prop_assert_eq!(is_seen, shape.is_shown_at(frame), "{} {}", half, text);
        }
    }
}
