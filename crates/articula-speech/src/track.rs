//! The frames of a recording.

use crate::coarticulation::{segments, weights};
use crate::{FRAME_RATE_HZ, Recogniser, Sound, TimedPhone, VisemeFrame};
use articula_core::viseme::{VISEME_COUNT, Viseme};

/// Share of a frame's own weights after smoothing.
const OWN: f32 = 0.6;
/// Frames over which lips come together and part.
const CLOSING: f32 = 4.0;
/// The shapes that are made for a moment: they are not smoothed away.
const CONTACTS: [Viseme; 2] = [Viseme::Pp, Viseme::Ff];

/// Frames at [`FRAME_RATE_HZ`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VisemeTrack {
    /// The frames; the first one is from 0 to 1 hundredth of a second.
    pub frames: Vec<VisemeFrame>,
}

impl VisemeTrack {
    /// What the [`Recogniser`] hears in a recording, frame by frame.
    pub fn recognised(sound: &Sound) -> Self {
        let mut recogniser = Recogniser::new();
        let mut frames = recogniser.push(&sound.samples);
        frames.extend(recogniser.finish());
        Self { frames }
    }

    /// The shapes of known phones, with the levels of their recording.
    ///
    /// Each p, b, m, f and v reaches its whole weight in its own time.
    pub fn of_phones(phones: &[TimedPhone], sound: &Sound) -> Self {
        let mut track = Self::recognised(sound);
        let made = weights(&segments(phones), track.frames.len());
        for (frame, weights) in track.frames.iter_mut().zip(made) {
            frame.weights = weights;
        }
        track
    }

    /// Duration in seconds.
    pub fn duration_secs(&self) -> f32 {
        self.frames.len() as f32 / FRAME_RATE_HZ as f32
    }

    /// The same without flicker: shapes flow into one another, but lips that meet still do.
    #[must_use]
    pub fn smoothed(&self) -> Self {
        let mut before = self
            .frames
            .first()
            .map_or([0.0; VISEME_COUNT], |f| f.weights);
        let smoothed = self.frames.iter().map(|frame| {
            for (before, own) in before.iter_mut().zip(frame.weights) {
                *before += OWN * (own - *before);
            }
            let mut weights = before;
            for contact in CONTACTS {
                weights[contact.number()] = frame.weights[contact.number()];
            }
            VisemeFrame {
                weights: shares(weights, &[]),
                ..*frame
            }
        });
        Self {
            frames: smoothed.collect(),
        }
    }

    /// The same with lips that come together before they touch and part after it, in place of
    /// contacts that begin and end within a frame.
    #[must_use]
    pub fn eased(&self) -> Self {
        let mut eased = self.clone();
        for contact in CONTACTS.map(Viseme::number) {
            ease(eased.frames.iter_mut(), contact);
            ease(eased.frames.iter_mut().rev(), contact);
        }
        for frame in &mut eased.frames {
            frame.weights = shares(frame.weights, &CONTACTS);
        }
        eased
    }

    /// The weights at a time in seconds; between the middles of frames they are mixed.
    pub fn at(&self, secs: f32) -> VisemeFrame {
        let Some(last) = self.frames.len().checked_sub(1) else {
            return VisemeFrame {
                weights: std::array::from_fn(|v| f32::from(u8::from(v == 0))),
                level_db: 0.0,
            };
        };
        let at = (secs * FRAME_RATE_HZ as f32 - 0.5).clamp(0.0, last as f32);
        let (a, b) = (
            self.frames[at as usize],
            self.frames[(at as usize + 1).min(last)],
        );
        let mix = |a: f32, b: f32| a + (b - a) * at.fract();
        VisemeFrame {
            weights: std::array::from_fn(|v| mix(a.weights[v], b.weights[v])),
            level_db: mix(a.level_db, b.level_db),
        }
    }
}

/// Lets a contact fade over the frames after it, in the order of the frames.
fn ease<'a>(frames: impl Iterator<Item = &'a mut VisemeFrame>, contact: usize) {
    let mut least = 0.0f32;
    for frame in frames {
        least = frame.weights[contact].max(least - 1.0 / CLOSING);
        frame.weights[contact] = least;
    }
}

/// Weights whose sum is 1; those of `kept` stay, if they leave room.
fn shares(mut weights: [f32; VISEME_COUNT], kept: &[Viseme]) -> [f32; VISEME_COUNT] {
    let is_kept = |v: usize| kept.iter().any(|k| k.number() == v);
    let sum = |weights: &[f32; VISEME_COUNT], of_kept: bool| -> f32 {
        let of = (0..VISEME_COUNT).filter(|v| is_kept(*v) == of_kept);
        of.map(|v| weights[v]).sum()
    };
    let (held, others) = (sum(&weights, true), sum(&weights, false));
    let (held_scale, other_scale) = if held > 1.0 {
        (1.0 / held, 0.0)
    } else if others > 0.0 {
        (1.0, (1.0 - held) / others)
    } else {
        (if held > 0.0 { 1.0 / held } else { 0.0 }, 0.0)
    };
    for (v, weight) in weights.iter_mut().enumerate() {
        *weight *= if is_kept(v) { held_scale } else { other_scale };
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn track(strongest: &[usize]) -> VisemeTrack {
        let frames = strongest.iter().map(|s| VisemeFrame {
            weights: std::array::from_fn(|v| f32::from(u8::from(v == *s))),
            level_db: 0.0,
        });
        VisemeTrack {
            frames: frames.collect(),
        }
    }

    proptest! {
        #[test]
        fn contacts_stay_and_weights_stay_shares(classes in prop::collection::vec(0usize..VISEME_COUNT, 1..80)) {
            let raw = track(&classes);
            for made in [raw.smoothed(), raw.eased(), raw.smoothed().eased()] {
                for (frame, class) in made.frames.iter().zip(&classes) {
                    prop_assert!((frame.weights.iter().sum::<f32>() - 1.0).abs() < 1e-4);
                    prop_assert!(frame.weights.iter().all(|w| (0.0..=1.0001).contains(w)));
                    let alone = !classes.contains(&(3 - class.clamp(&1, &2)));
                    if *class == 1 && alone {
                        prop_assert!(frame.weights[1] > 0.5);
                    }
                }
            }
        }
    }

    #[test]
    fn lips_close_in_forty_milliseconds_and_not_in_one_frame() {
        let mut classes = vec![10; 20];
        classes[10] = 1;
        let eased = track(&classes).eased();
        let closed: Vec<f32> = eased.frames.iter().map(|f| f.weights[1]).collect();
        assert_eq!(
            closed[6..=14],
            [0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0]
        );
    }

    #[test]
    fn a_moment_between_frames_is_a_mix() {
        let track = track(&[10, 14]);
        let between = track.at(0.01);
        assert!(
            (between.weights[10] - 0.5).abs() < 1e-5 && (between.weights[14] - 0.5).abs() < 1e-5
        );
        assert_eq!(track.at(-1.0), track.frames[0]);
        assert_eq!(track.at(9.0), track.frames[1]);
        assert_eq!(VisemeTrack::default().at(0.0).strongest(), Viseme::Silence);
    }
}
