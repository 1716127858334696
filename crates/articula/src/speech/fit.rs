//! A voice on a character.

use super::mouth::{amounts, fap_values};
use super::spoken::{Moment, SpeechOptions, speech_to_capture, speech_to_faps, spoken};
use crate::error::{Context, Error, Result};
use crate::face::{
    CaptureBridge, FittedFace, NamedMotion, NamedTarget, fit_capture, fit_face, fit_named,
    named_controls, row_values,
};
use crate::open::CharacterFile;
use articula_build::face::{FapValues, arkit_shape};
use articula_core::arkit_table::BLEND_SHAPE_COUNT;
use articula_core::face_control::FaceControl;
use articula_core::viseme::{VISEME_COUNT, Viseme};
use articula_formats::live_link::LiveLinkFrame;
use articula_speech::VisemeTrack;

/// Visemes of a head from which on it shows all of them by its own; those without some consonants are
/// taken to have the vowels alone.
const MOST_VISEMES: usize = 12;
/// Blend shapes without which a mouth does not speak.
const MOUTH: [&str; 2] = ["jawOpen", "mouthPucker"];

/// The vowel that stands for each viseme on a head that has no others, and its weight.
const VOWELS: [(Viseme, f32); VISEME_COUNT] = [
    (Viseme::Aa, 0.0),
    (Viseme::Aa, 0.0),
    (Viseme::I, 0.1),
    (Viseme::I, 0.3),
    (Viseme::I, 0.25),
    (Viseme::I, 0.3),
    (Viseme::U, 0.35),
    (Viseme::I, 0.25),
    (Viseme::I, 0.25),
    (Viseme::U, 0.3),
    (Viseme::Aa, 1.0),
    (Viseme::E, 1.0),
    (Viseme::I, 1.0),
    (Viseme::O, 1.0),
    (Viseme::U, 1.0),
];

/// Makes a face speak: a clip of a character, which is not changed.
///
/// A head with morph targets of visemes, with blend shapes of ARKit or with VRM's vowels gets their weights
/// directly; a face animation table, joints and other expressions get the parameters of MPEG-4. `file` names
/// the recording, and the clip.
///
/// # Errors
/// As [`fit_face`]; [`Error::Unsupported`] if the recording is shorter than a frame.
pub fn fit_speech(
    track: &VisemeTrack,
    file: &str,
    character: &CharacterFile,
    options: &SpeechOptions,
) -> Result<FittedFace> {
    if track.frames.is_empty() {
        let what = "the recording is shorter than a hundredth of a second";
        return Err(Error::unsuited(what)).context(file);
    }
    let named = named_controls(character.character());
    match Mouth::of(&named) {
        Some(Mouth::Shapes) => fit_capture(&speech_to_capture(track, options), file, character),
        Some(mouth) => {
            let named = mouth.chosen(named);
            let motion = driven(track, &mouth, &named, options);
            fit_named(motion, &named, file, character)
        }
        None => fit_face(&speech_to_faps(track, file, options), file, character),
    }
}

/// What a mouth is driven by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mouth {
    /// A control for each viseme: expressions, or morph targets.
    Visemes { expressions: bool },
    /// Blend shapes of ARKit.
    Shapes,
    /// Controls for the vowels.
    Vowels { expressions: bool },
}

impl Mouth {
    /// What drives the mouth of a face with these controls best.
    fn of(named: &[NamedTarget]) -> Option<Self> {
        let count = |expressions: bool, wanted: &dyn Fn(FaceControl) -> bool| {
            let of_kind = named
                .iter()
                .filter(|n| n.expression.is_some() == expressions);
            of_kind.filter(|n| wanted(n.control)).count()
        };
        let visemes = |expressions| count(expressions, &|c| matches!(c, FaceControl::Viseme(_)));
        let is_mouth = |control| {
            let FaceControl::Shapes(set, part) = control else {
                return false;
            };
            let shapes = MOUTH.iter().filter_map(|name| arkit_shape(name));
            part == Default::default()
                && set
                    .only()
                    .is_some_and(|s| shapes.into_iter().any(|m| m == s))
        };
        for expressions in [false, true] {
            if visemes(expressions) >= MOST_VISEMES {
                return Some(Self::Visemes { expressions });
            }
        }
        if count(false, &is_mouth).max(count(true, &is_mouth)) >= MOUTH.len() {
            return Some(Self::Shapes);
        }
        // Expressions are the author's own binding.
        [true, false]
            .into_iter()
            .find(|expressions| visemes(*expressions) >= 3)
            .map(|expressions| Self::Vowels { expressions })
    }

    fn expressions(self) -> bool {
        match self {
            Self::Visemes { expressions } | Self::Vowels { expressions } => expressions,
            Self::Shapes => false,
        }
    }

    /// The controls that move: visemes, and blend shapes for the gestures.
    fn chosen(self, named: Vec<NamedTarget>) -> Vec<NamedTarget> {
        let kept = |target: &NamedTarget| match target.control {
            FaceControl::Viseme(viseme) => viseme != Viseme::Silence,
            FaceControl::Shapes(..) => true,
            FaceControl::Emotion(_) => false,
        };
        let of_kind = |target: &NamedTarget| target.expression.is_some() == self.expressions();
        let chosen = named.into_iter().filter(|t| kept(t) && of_kind(t));
        chosen.collect()
    }

    /// Weights of the visemes of a head in a moment.
    fn weights(self, moment: &Moment) -> [f32; VISEME_COUNT] {
        let amounts = amounts(&moment.frame);
        if matches!(self, Self::Visemes { .. }) {
            return amounts;
        }
        let mut weights = [0.0; VISEME_COUNT];
        for (amount, (vowel, share)) in amounts.into_iter().zip(VOWELS) {
            weights[vowel.number()] += amount * share;
        }
        weights
    }
}

/// The weights of each control over time.
fn driven(
    track: &VisemeTrack,
    mouth: &Mouth,
    named: &[NamedTarget],
    options: &SpeechOptions,
) -> NamedMotion {
    let generic = CaptureBridge::generic();
    let mut motion = NamedMotion {
        times_secs: Vec::new(),
        values: Vec::new(),
        weights: Vec::new(),
    };
    for moment in spoken(track, options) {
        let visemes = mouth.weights(&moment);
        let weights = named.iter().map(|target| match target.control {
            FaceControl::Viseme(viseme) => visemes[viseme.number()].clamp(0.0, 1.0),
            FaceControl::Shapes(set, _) => gesture(set.iter(), &moment.shapes),
            FaceControl::Emotion(_) => 0.0,
        });
        motion.weights.push(weights.collect());
        let gestures = LiveLinkFrame {
            secs: moment.secs,
            shapes: moment.shapes,
            angles: moment.angles,
        };
        let (face, lips) = (row_values(&generic, &gestures), fap_values(&moment.frame));
        let sum = FapValues(std::array::from_fn(|i| face.0[i] + lips.0[i]));
        motion.values.push(sum);
        motion.times_secs.push(moment.secs as f32);
    }
    motion
}

/// The weight of a control that shows some shapes together: as far as all of them are wanted.
fn gesture(shapes: impl Iterator<Item = usize>, wanted: &[f32; BLEND_SHAPE_COUNT]) -> f32 {
    let least = shapes
        .map(|shape| wanted[shape])
        .fold(f32::INFINITY, f32::min);
    if least.is_finite() { least } else { 0.0 }
}
