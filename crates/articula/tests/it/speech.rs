//! Faces that speak: heads with visemes, blend shapes, vowels or none of these.

use articula::CharacterFile;
use articula::core::Transform;
use articula::core::source::{
    Character, Expression, Joint, MorphBinding, Property, RawClip, RawMesh, Skeleton, evaluate,
};
use articula::face::faps_to_capture;
use articula::speech::{
    SpeechOptions, TimedPhone, Viseme, VisemeFrame, VisemeTrack, fit_speech, speech_to_capture,
    speech_to_faps,
};

/// Half a second of each of some visemes, at full loudness but 2.4 dB: amounts are 1.
fn track(visemes: &[Viseme]) -> VisemeTrack {
    let frames = visemes.iter().flat_map(|viseme| {
        let weights = std::array::from_fn(|v| f32::from(u8::from(v == viseme.number())));
        let frame = VisemeFrame {
            weights,
            level_db: -2.4,
        };
        std::iter::repeat_n(frame, 50)
    });
    VisemeTrack {
        frames: frames.collect(),
    }
}

fn head(names: &[&str], expressions: &[(&str, usize)]) -> CharacterFile {
    let expression = |(name, target): &(&str, usize)| Expression {
        name: (*name).to_owned(),
        morphs: vec![MorphBinding {
            mesh: 0,
            target: *target,
            weight: 1.0,
        }],
        ..Expression::default()
    };
    let joint = Joint {
        name: "Head".to_owned(),
        parent: None,
        rest: Transform::IDENTITY,
        in_skin: true,
    };
    let character = Character {
        skeleton: Skeleton {
            joints: vec![joint],
        },
        meshes: vec![RawMesh {
            morph_names: names.iter().map(|n| (*n).to_owned()).collect(),
            morph_weights: vec![0.0; names.len()],
            ..RawMesh::default()
        }],
        expressions: expressions.iter().map(expression).collect(),
        ..Character::default()
    };
    CharacterFile::from_character("head.glb", character)
}

/// Weights of the morph targets of the mesh at a time.
fn weights(clip: &RawClip, count: usize, secs: f32) -> Vec<f32> {
    let mut values = vec![0.0; count];
    let mut channels = clip.channels.iter();
    let channel = channels.find(|c| c.property == Property::Weights).unwrap();
    evaluate::channel(channel, secs, &mut values);
    values
}

fn spoken(track: &VisemeTrack, head: &CharacterFile, secs: f32) -> Vec<f32> {
    let options = SpeechOptions {
        gestures: false,
        ..SpeechOptions::default()
    };
    let made = fit_speech(track, "a/hello.wav", head, &options).unwrap();
    assert_eq!(made.fitted.clip.name, "hello");
    let count = head.character().meshes[0].morph_names.len();
    weights(&made.fitted.clip, count, secs)
}

#[test]
fn morph_targets_of_visemes_get_their_weights() {
    let names: Vec<String> = Viseme::ALL
        .iter()
        .map(|v| format!("viseme_{}", v.name()))
        .collect();
    let names: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .chain(["browInnerUp"])
        .collect();
    let head = head(&names, &[]);
    let said = track(&[Viseme::Aa, Viseme::Pp, Viseme::U]);
    for (secs, viseme) in [(0.25, Viseme::Aa), (0.75, Viseme::Pp), (1.25, Viseme::U)] {
        for (at, weight) in spoken(&said, &head, secs).into_iter().enumerate() {
            let expected = f32::from(u8::from(at == viseme.number()));
            assert!(
                (weight - expected).abs() < 0.01,
                "{secs}: {} is {weight}",
                names[at]
            );
        }
    }
}

#[test]
fn blend_shapes_get_the_weights_of_the_table_and_lips_close_before_the_jaw_does() {
    let names = [
        "jawOpen",
        "mouthPucker",
        "mouthPressLeft",
        "mouthPressRight",
        "mouthClose",
    ];
    let head = head(&names, &[]);
    let said = track(&[Viseme::Aa, Viseme::Pp, Viseme::U]);
    let near = |weights: Vec<f32>, expected: [f32; 5]| {
        for (weight, expected) in weights.iter().zip(expected) {
            assert!((weight - expected).abs() < 0.01, "{weights:?}");
        }
    };
    near(spoken(&said, &head, 0.25), [0.48, 0.0, 0.0, 0.0, 0.0]);
    near(spoken(&said, &head, 0.75), [0.0, 0.0, 0.5, 0.5, 0.0]);
    near(spoken(&said, &head, 1.25), [0.12, 0.6, 0.0, 0.0, 0.0]);
}

#[test]
fn vowels_of_vrm_stand_for_all_sounds() {
    let vowels = [("aa", 0), ("ih", 1), ("ou", 2), ("ee", 3), ("oh", 4)];
    let head = head(&["a", "b", "c", "d", "e"], &vowels);
    let said = track(&[Viseme::Aa, Viseme::Ch, Viseme::Pp]);
    let near = |secs, expected: [f32; 5]| {
        let weights = spoken(&said, &head, secs);
        for (weight, expected) in weights.iter().zip(expected) {
            assert!((weight - expected).abs() < 0.01, "{weights:?}");
        }
    };
    near(0.25, [1.0, 0.0, 0.0, 0.0, 0.0]);
    near(0.75, [0.0, 0.0, 0.35, 0.0, 0.0]);
    near(1.25, [0.0; 5]);
}

#[test]
fn parameters_open_the_jaw_as_the_shapes_do() {
    let said = track(&[Viseme::Silence, Viseme::Aa, Viseme::Pp, Viseme::O]);
    for as_visemes in [false, true] {
        let options = SpeechOptions {
            as_visemes,
            ..SpeechOptions::default()
        };
        let faps = speech_to_faps(&said, "hello there", &options);
        assert_eq!((faps.name.as_str(), faps.rate_hz), ("hello_there", 60.0));
        assert_eq!(faps.moving()[0], as_visemes);
        // FAP 3 in the file, or through FAP 1.
        let (back, _) = faps_to_capture(&faps).unwrap();
        let shapes = speech_to_capture(&said, &options);
        assert_eq!(back.frames.len(), shapes.frames.len());
        for (secs, open) in [(0.25, false), (0.75, true), (1.25, false), (1.75, true)] {
            let frame = (secs * 60.0) as usize;
            for capture in [&back, &shapes] {
                let jaw = capture.frames[frame].shapes[17];
                assert_eq!(jaw > 0.2, open, "{secs}: jaw {jaw}, FAP 1: {as_visemes}");
            }
        }
    }
}

#[test]
fn a_face_with_nothing_to_drive_and_no_sound_are_refused() {
    let options = SpeechOptions::default();
    let refused = |track: &VisemeTrack, head: &CharacterFile| {
        fit_speech(track, "a.wav", head, &options)
            .unwrap_err()
            .to_string()
    };
    let why = refused(&track(&[Viseme::Aa]), &head(&["grin"], &[]));
    assert!(why.starts_with("head.glb: face:"), "{why}");
    let why = refused(
        &VisemeTrack::default(),
        &head(&["jawOpen", "mouthPucker"], &[]),
    );
    assert!(why.starts_with("a.wav: the recording"), "{why}");
    // Phones that begin after the recording has ended change nothing.
    let late = TimedPhone {
        start_secs: 9.0,
        end_secs: 9.1,
        symbol: "p".to_owned(),
    };
    assert!(
        VisemeTrack::of_phones(&[late], &Default::default())
            .frames
            .is_empty()
    );
}
