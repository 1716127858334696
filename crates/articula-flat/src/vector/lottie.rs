//! Writes a clip as Lottie JSON.
//!
//! Source: Lottie specification 1.0.1 (lottie.github.io); `docs/methods/vector.md` 8.4. Members
//! that the specification makes optional but players need are written too (`v`, the layer's `st`,
//! complete transforms, easing handles of linear keys); `docs/formats/lottie.md` lists which player
//! needs what.
//!
//! One shape layer contains a group for each shape. The layer's scale converts the grid to pixels,
//! so that coordinates are integers.

#[cfg(test)]
mod players;

use crate::planar::PlanarError;
use crate::planar::keyed_clip::{GRID, KeyedClip, KeyedPaint, KeyedShape, KeyedTrack, LineUnits};
use crate::planar::keyed_motion::{ANGLE, KeyedMotion, SCALE, TRANSLATION};
use std::fmt::Write;
use std::ops::Range;

/// Writes a clip as a Lottie document; `name` is the name that editors show.
///
/// The clip lasts `frames - 1` frames and then repeats; a clip of one frame lasts one. Shapes that
/// are never shown are left out.
///
/// # Errors
/// [`PlanarError::Mismatch`] if the clip is invalid, or has lines in bounding-box units, which
/// Lottie does not have.
pub(crate) fn lottie(clip: &KeyedClip, name: &str) -> Result<String, PlanarError> {
    clip.check()?;
    if clip.lines != LineUnits::Grid {
        return Err(PlanarError::Mismatch {
            at: "keyed clip",
            what: "gradients are relative to bounding boxes; reduce the keys with gradient lines \
                   on the grid"
                .into(),
        });
    }
    let length = last_frame(clip).max(1);
    let mut text = String::new();
    let _ = write!(
        text,
        r#"{{"v":"5.7.0","ver":10001,"fr":{},"ip":0,"op":{length},"w":{},"h":{},"nm":"#,
        clip.fps, clip.width, clip.height,
    );
    push_string(&mut text, name);
    let _ = write!(
        text,
        r#","ddd":0,"assets":[],"layers":[{{"ty":4,"ind":1,"ip":0,"op":{length},"st":0,"ks":{{"#,
    );
    push_transform(&mut text, 100.0 / f64::from(GRID), r#"{"a":0,"k":100}"#);
    text.push_str(r#"},"shapes":["#);
    let shown: Vec<&KeyedShape> = clip.shapes.iter().filter(|s| !s.shown.is_empty()).collect();
    // The first group is on top.
    let runs = shown.chunk_by(|a, b| a.motion == b.motion).rev();
    push_list(&mut text, runs, |text, run| push_run(text, clip, run));
    text.push_str("]}]}");
    Ok(text)
}

/// Shapes that follow one motion, in a group, or that follow none.
fn push_run(text: &mut String, clip: &KeyedClip, run: &[&KeyedShape]) {
    let motion = run.first().and_then(|shape| shape.motion);
    if motion.is_some() {
        text.push_str(r#"{"ty":"gr","it":["#);
    }
    push_list(text, run.iter().rev(), |text, shape| {
        push_shape(text, clip, shape)
    });
    if let Some(motion) = motion {
        text.push_str(r#",{"ty":"tr","#);
        push_motion(text, &clip.motions[motion as usize]);
        text.push_str("}]}");
    }
}

/// Members of a transform that moves, without braces. A positive skew leans the other way than that of a
/// motion.
fn push_motion(text: &mut String, motion: &KeyedMotion) {
    let parts = [
        ("p", &motion.translation, TRANSLATION),
        ("r", &motion.rotation, ANGLE),
        ("sk", &motion.skew, -ANGLE),
        ("s", &motion.scale, SCALE / 100.0),
    ];
    for (name, track, unit) in parts {
        let _ = write!(text, r#""{name}":"#);
        push_track(text, track, 0..track.width, Form::Numbers(unit));
        text.push(',');
    }
    text.push_str(r#""a":{"a":0,"k":[0,0]},"o":{"a":0,"k":100},"sa":{"a":0,"k":0}"#);
}

/// Frame that ends a clip.
fn last_frame(clip: &KeyedClip) -> u32 {
    clip.frames.saturating_sub(1)
}

fn push_shape(text: &mut String, clip: &KeyedClip, shape: &KeyedShape) {
    text.push_str(r#"{"ty":"gr","it":["#);
    let points = (shape.outline.width / 2) as u32;
    let further = shape.further_outlines.iter().copied();
    for (first, end) in std::iter::once(0)
        .chain(further.clone())
        .zip(further.chain([points]))
    {
        text.push_str(r#"{"ty":"sh","ks":"#);
        let part = 2 * first as usize..2 * end as usize;
        push_track(text, &shape.outline, part, Form::Outline);
        text.push_str("},");
    }
    match &shape.paint {
        KeyedPaint::Flat(color) => {
            let [r, g, b] = color.map(share);
            let _ = write!(
                text,
                r#"{{"ty":"fl","o":{{"a":0,"k":100}},"r":1,"c":{{"a":0,"k":[{r},{g},{b}]}}}}"#,
            );
        }
        KeyedPaint::Changing(color) => {
            text.push_str(r#"{"ty":"fl","o":{"a":0,"k":100},"r":1,"c":"#);
            push_track(text, color, 0..3, Form::Color);
            text.push('}');
        }
        KeyedPaint::Ramp { ramp, line } => {
            push_gradient(text, [[0; 3], clip.ramps[*ramp as usize]], line);
        }
        KeyedPaint::Own { stops, line } => push_gradient(text, *stops, line),
    }
    text.push_str(r#",{"ty":"tr","#);
    push_transform(text, 100.0, &opacity(&shape.shown, last_frame(clip)));
    text.push_str("}]}");
}

/// A linear gradient between two colours.
fn push_gradient(text: &mut String, stops: [[u8; 3]; 2], line: &KeyedTrack) {
    text.push_str(r#"{"ty":"gf","o":{"a":0,"k":100},"r":1,"t":1,"g":{"p":2,"k":{"a":0,"k":["#);
    let [from, to] = stops.map(|stop| stop.map(share).join(","));
    let _ = write!(text, r#"0,{from},1,{to}]}}}},"s":"#);
    push_track(text, line, 0..2, Form::Point);
    text.push_str(r#","e":"#);
    push_track(text, line, 2..4, Form::Point);
    text.push('}');
}

/// Opacity of a group that is shown in these spans of half frames, with hold keys.
fn opacity(shown: &[Range<u32>], last_frame: u32) -> String {
    let end = 2 * last_frame + 1;
    if let [only] = shown
        && *only == (0..end)
    {
        return r#"{"a":0,"k":100}"#.to_owned();
    }
    let mut keys = Vec::new();
    if shown.first().is_some_and(|first| first.start > 0) {
        keys.push((0, 0));
    }
    for span in shown {
        keys.push((span.start, 100));
        if span.end < end {
            keys.push((span.end, 0));
        }
    }
    let mut text = String::from(r#"{"a":1,"k":["#);
    push_list(&mut text, keys, |text, (half, percent)| {
        let frame = f64::from(half) / 2.0;
        let _ = write!(text, r#"{{"t":{frame},"s":[{percent}],"h":1}}"#);
    });
    text.push_str("]}");
    text
}

/// Members of a transform that scales, without braces.
fn push_transform(text: &mut String, percent: f64, opacity: &str) {
    const NOWHERE: &str = r#"{"a":0,"k":[0,0]}"#;
    let _ = write!(
        text,
        r#""a":{NOWHERE},"p":{NOWHERE},"s":{{"a":0,"k":[{percent},{percent}]}},"r":{{"a":0,"k":0}},"o":{opacity}"#,
    );
}

/// Meaning of the numbers of a track.
#[derive(Debug, Clone, Copy)]
enum Form {
    /// x, y, x, y, … of a closed outline.
    Outline,
    /// x, y.
    Point,
    /// Numbers in a fraction of their unit.
    Numbers(f64),
    /// Levels of red, green and blue.
    Color,
}

/// Writes a property: a range of the numbers of each key of a track.
fn push_track(text: &mut String, track: &KeyedTrack, part: Range<usize>, form: Form) {
    let of = |key: usize| &track.key(key)[part.clone()];
    if (1..track.len()).all(|key| of(key) == of(0)) {
        text.push_str(r#"{"a":0,"k":"#);
        match (form, of(0)) {
            (Form::Numbers(unit), [only]) => {
                let _ = write!(text, "{}", f64::from(*only) / unit);
            }
            (_, values) => push_value(text, values, form),
        }
        text.push('}');
        return;
    }
    text.push_str(r#"{"a":1,"k":["#);
    let keys = (0..track.len()).zip(&track.frames);
    push_list(text, keys, |text, (key, frame)| {
        let _ = write!(text, r#"{{"t":{frame},"s":"#);
        match form {
            Form::Outline => {
                text.push('[');
                push_value(text, of(key), form);
                text.push(']');
            }
            Form::Point | Form::Numbers(_) | Form::Color => push_value(text, of(key), form),
        }
        if key + 1 < track.len() {
            text.push_str(r#","i":{"x":1,"y":1},"o":{"x":0,"y":0}"#);
        }
        text.push('}');
    });
    text.push_str("]}");
}

fn push_value(text: &mut String, numbers: &[i32], form: Form) {
    match form {
        Form::Point => {
            let _ = write!(text, "[{},{}]", numbers[0], numbers[1]);
        }
        Form::Numbers(unit) => {
            text.push('[');
            push_list(text, numbers, |text, number| {
                let _ = write!(text, "{}", f64::from(*number) / unit);
            });
            text.push(']');
        }
        Form::Color => {
            text.push('[');
            push_list(text, numbers, |text, level| {
                text.push_str(&share(*level as u8))
            });
            text.push(']');
        }
        Form::Outline => {
            let points = numbers.chunks_exact(2);
            let straight = vec!["[0,0]"; points.len()].join(",");
            let _ = write!(
                text,
                r#"{{"c":true,"i":[{straight}],"o":[{straight}],"v":["#
            );
            push_list(text, points, |text, point| {
                push_value(text, point, Form::Point)
            });
            text.push_str("]}");
        }
    }
}

/// A level as a fraction of 255, just large enough that truncation gives the level back as well as
/// rounding does: lottie-web truncates the colours of fills.
fn share(level: u8) -> String {
    let thousandths = (u32::from(level) * 1000).div_ceil(255);
    (f64::from(thousandths) / 1000.0).to_string()
}

fn push_list<T>(
    text: &mut String,
    items: impl IntoIterator<Item = T>,
    mut push: impl FnMut(&mut String, T),
) {
    for (i, item) in items.into_iter().enumerate() {
        if i > 0 {
            text.push(',');
        }
        push(text, item);
    }
}

/// A JSON string (RFC 8259, 7).
fn push_string(text: &mut String, string: &str) {
    text.push('"');
    for c in string.chars() {
        match c {
            '"' | '\\' => text.extend(['\\', c]),
            c if c < ' ' => {
                let _ = write!(text, "\\u{:04x}", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text.push('"');
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::{Value, json};
    use std::iter::once;

    fn track(frames: &[u32], values: &[i32]) -> KeyedTrack {
        KeyedTrack {
            frames: frames.to_vec(),
            values: values.to_vec(),
            width: values.len() / frames.len(),
        }
    }

    fn clip(shapes: Vec<KeyedShape>) -> KeyedClip {
        KeyedClip {
            width: 40,
            height: 30,
            fps: 12.5,
            frames: 5,
            lines: LineUnits::Grid,
            ramps: vec![[255, 51, 1]],
            motions: vec![],
            shapes,
        }
    }

    fn shape(outline: KeyedTrack, paint: KeyedPaint) -> KeyedShape {
        KeyedShape {
            motion: None,
            outline,
            further_outlines: vec![],
            paint,
            shown: once(0..9).collect(),
        }
    }

    fn read(clip: &KeyedClip) -> Value {
        serde_json::from_str(&lottie(clip, "a").unwrap()).unwrap()
    }

    /// Elements of the `i`th group.
    fn group(document: &Value, i: usize) -> &Vec<Value> {
        document["layers"][0]["shapes"][i]["it"].as_array().unwrap()
    }

    #[test]
    fn a_moving_triangle_before_a_still_one() {
        let back = shape(
            KeyedTrack::still(vec![0, 0, 8, 0, 0, 8]),
            KeyedPaint::Flat([0, 128, 255]),
        );
        let moving = track(&[0, 4], &[0, 0, 4, 0, 0, 4, -2, 0, 4, 0, 0, 4]);
        let front = shape(moving, KeyedPaint::Flat([51; 3]));
        let document = read(&clip(vec![back, front]));
        assert_eq!(
            [
                &document["fr"],
                &document["ip"],
                &document["op"],
                &document["w"],
                &document["h"]
            ],
            [&json!(12.5), &json!(0), &json!(4), &json!(40), &json!(30)]
        );
        let layer = &document["layers"][0];
        assert_eq!([&layer["ty"], &layer["op"]], [&json!(4), &json!(4)]);
        assert_eq!(layer["ks"]["s"], json!({"a": 0, "k": [25, 25]}));
        // The front shape comes first.
        let key = |x: i32| {
            let zero = [[0, 0]; 3];
            json!([{"c": true, "i": zero, "o": zero, "v": [[x, 0], [4, 0], [0, 4]]}])
        };
        let [path, fill, transform] = &group(&document, 0)[..] else {
            panic!("{document}");
        };
        let straight = json!([{"x": 1, "y": 1}, {"x": 0, "y": 0}]);
        assert_eq!(
            *path,
            json!({"ty": "sh", "ks": {"a": 1, "k": [
                {"t": 0, "s": key(0), "i": straight[0], "o": straight[1]},
                {"t": 4, "s": key(-2)},
            ]}})
        );
        assert_eq!(fill["c"], json!({"a": 0, "k": [0.2, 0.2, 0.2]}));
        assert_eq!(transform["ty"], "tr");
        assert_eq!(transform["o"], json!({"a": 0, "k": 100}));
        assert_eq!(transform["s"], json!({"a": 0, "k": [100, 100]}));
        let behind = group(&document, 1);
        assert_eq!(behind[0]["ks"]["a"], 0);
        // 128 / 255 is 0.50196: a thousandth more gives 128 whether truncated or rounded.
        assert_eq!(behind[1]["c"]["k"], json!([0, 0.502, 1]));
    }

    #[test]
    fn a_colour_that_changes_has_keys() {
        let color = track(&[0, 4], &[255, 128, 0, 51, 0, 0]);
        let outline = KeyedTrack::still(vec![0; 6]);
        let document = read(&clip(vec![shape(outline, KeyedPaint::Changing(color))]));
        let fill = &group(&document, 0)[1];
        let straight = json!([{"x": 1, "y": 1}, {"x": 0, "y": 0}]);
        assert_eq!(fill["ty"], "fl");
        assert_eq!(
            fill["c"],
            json!({"a": 1, "k": [
                {"t": 0, "s": [1, 0.502, 0], "i": straight[0], "o": straight[1]},
                {"t": 4, "s": [0.2, 0, 0]},
            ]})
        );
    }

    #[test]
    fn spans_are_held_keys_of_the_opacity() {
        let mut blinking = shape(KeyedTrack::still(vec![0; 6]), KeyedPaint::Flat([0; 3]));
        blinking.shown = vec![3..5, 7..9];
        let mut never = blinking.clone();
        never.shown.clear();
        let mut early = blinking.clone();
        early.shown = once(0..3).collect();
        let document = read(&clip(vec![never, early, blinking]));
        assert_eq!(document["layers"][0]["shapes"].as_array().unwrap().len(), 2);
        let key = |t: f64, s: i32| {
            let whole = json!(t as i32);
            json!({"t": if t.fract() == 0.0 { whole } else { json!(t) }, "s": [s], "h": 1})
        };
        let keys = [key(0.0, 0), key(1.5, 100), key(2.5, 0), key(3.5, 100)];
        assert_eq!(group(&document, 0)[2]["o"], json!({"a": 1, "k": keys}));
        let keys = [key(0.0, 100), key(1.5, 0)];
        assert_eq!(group(&document, 1)[2]["o"], json!({"a": 1, "k": keys}));
    }

    #[test]
    fn a_gradient_runs_from_its_start_to_its_end() {
        let line = track(&[0, 2, 4], &[0, 0, 8, 0, 0, 0, 8, 4, 0, 0, 8, 0]);
        let outline = KeyedTrack::still(vec![0, 0, 12, 0, 0, 12]);
        let ramp = shape(
            outline.clone(),
            KeyedPaint::Ramp {
                ramp: 0,
                line: line.clone(),
            },
        );
        let stops = [[10, 20, 30], [110, 120, 130]];
        let own = shape(outline, KeyedPaint::Own { stops, line });
        let clip = clip(vec![ramp, own]);
        let document = read(&clip);
        let ramp = &group(&document, 1)[1];
        assert_eq!([&ramp["ty"], &ramp["t"]], [&json!("gf"), &json!(1)]);
        assert_eq!(
            ramp["g"],
            json!({"p": 2, "k": {"a": 0, "k": [0, 0, 0, 0, 1, 1, 0.2, 0.004]}})
        );
        // The start is constant.
        assert_eq!(ramp["s"], json!({"a": 0, "k": [0, 0]}));
        let ends: Vec<&Value> = ramp["e"]["k"]
            .as_array()
            .unwrap()
            .iter()
            .map(|k| &k["s"])
            .collect();
        assert_eq!(ends, [&json!([8, 0]), &json!([8, 4]), &json!([8, 0])]);
        let own = &group(&document, 0)[1]["g"]["k"]["k"];
        assert_eq!(*own, json!([0, 0.04, 0.079, 0.118, 1, 0.432, 0.471, 0.51]));
    }

    #[test]
    fn a_hole_is_an_outline_of_its_own() {
        let mut ring = shape(
            KeyedTrack::still(vec![0, 0, 90, 0, 0, 90, 9, 9, 9, 18, 18, 9]),
            KeyedPaint::Flat([0; 3]),
        );
        ring.further_outlines = vec![3];
        let document = read(&clip(vec![ring]));
        let [outer, hole, _, _] = &group(&document, 0)[..] else {
            panic!("{document}");
        };
        assert_eq!(outer["ks"]["k"]["v"], json!([[0, 0], [90, 0], [0, 90]]));
        assert_eq!(hole["ks"]["k"]["v"], json!([[9, 9], [9, 18], [18, 9]]));
    }

    #[test]
    fn names_are_escaped_and_faults_are_told() {
        let name = "a \"b\" \\ \n </script> é";
        let text = lottie(&clip(vec![]), name).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["nm"], name);
        assert_eq!(document["layers"][0]["shapes"], json!([]));
        let none = KeyedClip {
            frames: 0,
            ..clip(vec![])
        };
        assert_eq!(lottie(&none, ""), Err(PlanarError::NoFrames));
        let one = KeyedClip {
            frames: 1,
            ..clip(vec![])
        };
        assert_eq!(read(&one)["op"], 1);
    }

    proptest! {
        #[test]
        fn every_level_comes_back_whether_cut_or_rounded(level in any::<u8>()) {
            let share: f64 = share(level).parse().unwrap();
            prop_assert!((0.0..=1.0).contains(&share));
            prop_assert_eq!((share * 255.0) as u8, level);
            prop_assert_eq!((share * 255.0).round() as u8, level);
            prop_assert_eq!((share as f32 * 255.0) as u8, level);
        }

        #[test]
        fn every_number_of_a_track_is_written(values in prop::collection::vec(-9000i32..9000, 24)) {
            let outline = track(&[0, 1, 3, 4], &values);
            let document = read(&clip(vec![shape(outline.clone(), KeyedPaint::Flat([1; 3]))]));
            let keys = group(&document, 0)[0]["ks"]["k"].as_array().unwrap();
            for (i, key) in keys.iter().enumerate() {
                prop_assert_eq!(&key["t"], &json!(outline.frames[i]));
                let points = outline.key(i).chunks(2).map(|p| json!(p));
                prop_assert_eq!(&key["s"][0]["v"], &Value::Array(points.collect()));
            }
        }
    }
}
