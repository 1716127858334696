//! A voice as a capture of blend shapes, and as facial animation parameters.

use super::gestures::Gestures;
use super::mouth::{MouthShapes, fap_values, strongest_two};
use crate::face::{CaptureBridge, file_name, rounded, row_values};
use articula_build::face::FapValues;
use articula_core::arkit_table::BLEND_SHAPE_COUNT;
use articula_core::fap_table::FAP_COUNT;
use articula_formats::live_link::{ANGLE_COUNT, LiveLinkClip, LiveLinkFrame};
use articula_formats::mpeg4::fap::{FapClip, FapFrame, Viseme};
use articula_speech::{VisemeFrame, VisemeTrack};

/// Options of a face that speaks.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeechOptions {
    /// Frames a second, between 10 and 240.
    pub rate_hz: f32,
    /// Whether lids, brows and head move besides the mouth.
    pub gestures: bool,
    /// Seed of the gestures.
    pub seed: u64,
    /// Of parameters: whether the mouth is written as the two strongest visemes of a frame (FAP 1),
    /// which takes a third of the bytes, and not as low-level parameters.
    pub as_visemes: bool,
}

impl Default for SpeechOptions {
    fn default() -> Self {
        Self {
            rate_hz: 60.0,
            gestures: true,
            seed: 1,
            as_visemes: false,
        }
    }
}

impl SpeechOptions {
    /// Frames of a recording, and the time of each.
    pub(super) fn times(&self, duration_secs: f32) -> impl Iterator<Item = f64> {
        let rate_hz = f64::from(self.rate_hz.clamp(10.0, 240.0).round());
        let count = (f64::from(duration_secs) * rate_hz).floor() as usize + 1;
        (0..count).map(move |frame| frame as f64 / rate_hz)
    }

    /// Frames a second as they are used: a whole number.
    pub(super) fn rate_hz(&self) -> f32 {
        self.rate_hz.clamp(10.0, 240.0).round()
    }
}

/// A voice as ARKit's blend shapes and the turn of the head, as Live Link Face captures them.
///
/// `track` is one as it was recognised or made from phones; it is smoothed here.
pub fn speech_to_capture(track: &VisemeTrack, options: &SpeechOptions) -> LiveLinkClip {
    let mouth = MouthShapes::new();
    let frames = spoken(track, options);
    let frames = frames.map(|moment| {
        let mut shapes = moment.shapes;
        for (shape, weight) in shapes.iter_mut().zip(mouth.weights(&moment.frame)) {
            *shape = shape.max(weight);
        }
        LiveLinkFrame {
            secs: moment.secs,
            shapes,
            angles: moment.angles,
        }
    });
    LiveLinkClip {
        rate_hz: f64::from(options.rate_hz()),
        has_shapes: [true; BLEND_SHAPE_COUNT],
        frames: frames.collect(),
    }
}

/// A voice as facial animation parameters: the visemes of MPEG-4 as low-level parameters, or as
/// FAP 1 ([`SpeechOptions::as_visemes`]).
pub fn speech_to_faps(track: &VisemeTrack, name: &str, options: &SpeechOptions) -> FapClip {
    let generic = CaptureBridge::generic();
    let frames = spoken(track, options).enumerate().map(|(number, moment)| {
        let gestures = LiveLinkFrame {
            secs: moment.secs,
            shapes: moment.shapes,
            angles: moment.angles,
        };
        let mut values = row_values(&generic, &gestures);
        let mut viseme = Viseme::default();
        if options.as_visemes {
            let ([select1, select2], blend) = strongest_two(&moment.frame);
            viseme = Viseme {
                select1,
                select2,
                blend,
                defines: false,
            };
        } else {
            let mouth = fap_values(&moment.frame);
            values = FapValues(std::array::from_fn(|i| values.0[i] + mouth.0[i]));
        }
        FapFrame {
            number: number as u32,
            viseme,
            low: rounded(&values),
            ..FapFrame::default()
        }
    });
    let mut clip = FapClip {
        name: file_name(name),
        rate_hz: options.rate_hz(),
        coded: [false; FAP_COUNT],
        frames: frames.collect(),
        bridge: None,
    };
    clip.coded = clip.moving();
    clip
}

/// A moment of a voice: the mouth's frame, and shapes and angles of the gestures.
pub(super) struct Moment {
    pub(super) secs: f64,
    pub(super) frame: VisemeFrame,
    pub(super) shapes: [f32; BLEND_SHAPE_COUNT],
    pub(super) angles: [f32; ANGLE_COUNT],
}

/// The moments of a voice.
pub(super) fn spoken(track: &VisemeTrack, options: &SpeechOptions) -> impl Iterator<Item = Moment> {
    let gestures = options.gestures.then(|| Gestures::new(track, options.seed));
    let eased = track.smoothed().eased();
    options.times(track.duration_secs()).map(move |secs| {
        let mut moment = Moment {
            secs,
            frame: eased.at(secs as f32),
            shapes: [0.0; BLEND_SHAPE_COUNT],
            angles: [0.0; ANGLE_COUNT],
        };
        if let Some(gestures) = &gestures {
            gestures.add(secs as f32, &mut moment.shapes, &mut moment.angles);
        }
        moment
    })
}
