//! Phones as weights of visemes: each shape begins before its phone and goes on after it.
//!
//! Dominance functions in the manner of Cohen and Massaro (1993), *Modeling coarticulation in synthetic
//! visual speech*; strengths and times are engineering defaults (`docs/methods/speech.md`).

use crate::phone::{Phone, phones_of_arpabet, phones_of_ipa};
use crate::{FRAME_RATE_HZ, TimedPhone};
use articula_core::Libm;
use articula_core::viseme::{VISEME_COUNT, Viseme};

/// How a shape competes with its neighbours: its strength, and the times over which it comes and goes.
struct Dominance {
    strength: f32,
    lead_secs: f32,
    lag_secs: f32,
}

const fn dominance(strength: f32, lead_ms: f32, lag_ms: f32) -> Dominance {
    Dominance {
        strength,
        lead_secs: lead_ms / 1_000.0,
        lag_secs: lag_ms / 1_000.0,
    }
}

const DOMINANCE: [Dominance; VISEME_COUNT] = [
    dominance(0.8, 60.0, 80.0),
    dominance(1.5, 40.0, 30.0),
    dominance(1.5, 50.0, 40.0),
    dominance(1.1, 40.0, 40.0),
    dominance(0.8, 30.0, 30.0),
    dominance(0.7, 30.0, 30.0),
    dominance(1.3, 70.0, 50.0),
    dominance(1.0, 40.0, 40.0),
    dominance(0.8, 30.0, 30.0),
    dominance(1.0, 60.0, 50.0),
    dominance(1.2, 60.0, 60.0),
    dominance(1.0, 60.0, 60.0),
    dominance(1.0, 60.0, 60.0),
    dominance(1.3, 80.0, 70.0),
    dominance(1.5, 90.0, 70.0),
];
/// Beyond this many leads or lags a shape has gone.
const REACH: f32 = 3.0;
/// Lips that must touch do so for this share of their phone, and at least this long.
const CONTACT: (f32, f32) = (0.7, 0.03);

/// One shape of the mouth and when it is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Begin in seconds.
    pub start_secs: f32,
    /// End in seconds.
    pub end_secs: f32,
    /// The shape.
    pub viseme: Viseme,
}

/// The shapes of phones; h has that of the next sound, and what is not known that of the one before.
pub fn segments(phones: &[TimedPhone]) -> Vec<Segment> {
    let all_arpabet = phones
        .iter()
        .all(|p| p.symbol.is_empty() || phones_of_arpabet(&p.symbol).is_some());
    let parts_of = |symbol: &str| -> Vec<Phone> {
        let pause = vec![Phone {
            viseme: Some(Viseme::Silence),
            share: 1.0,
        }];
        match symbol {
            "" => pause,
            symbol if all_arpabet => phones_of_arpabet(symbol).unwrap_or(pause),
            symbol => phones_of_ipa(symbol).unwrap_or(pause),
        }
    };
    let mut made: Vec<(f32, f32, Option<Viseme>)> = Vec::new();
    for phone in phones {
        let mut start = phone.start_secs;
        for part in parts_of(&phone.symbol) {
            let end = start + part.share * (phone.end_secs - phone.start_secs);
            made.push((start, end, part.viseme));
            start = end;
        }
    }
    let next = |at: usize| {
        let next = made.get(at + 1).and_then(|(.., viseme)| *viseme);
        next.filter(|v| *v != Viseme::Silence).unwrap_or(Viseme::E)
    };
    let segments = made.iter().enumerate();
    segments
        .map(|(at, (start_secs, end_secs, viseme))| Segment {
            start_secs: *start_secs,
            end_secs: *end_secs,
            viseme: viseme.unwrap_or_else(|| next(at)),
        })
        .collect()
}

/// Weights of each of a number of frames; the sum of a frame's is 1.
pub(crate) fn weights(segments: &[Segment], frames: usize) -> Vec<[f32; VISEME_COUNT]> {
    let middle = |frame: usize| (frame as f32 + 0.5) / FRAME_RATE_HZ as f32;
    let frame_at = |secs: f32| ((secs * FRAME_RATE_HZ as f32).max(0.0) as usize).min(frames);
    let mut made = vec![[0.0f32; VISEME_COUNT]; frames];
    for segment in segments {
        let shape = &DOMINANCE[segment.viseme.number()];
        let from = frame_at(segment.start_secs - REACH * shape.lead_secs);
        let to = frame_at(segment.end_secs + REACH * shape.lag_secs);
        for (frame, weights) in made.iter_mut().enumerate().take(to).skip(from) {
            let secs = middle(frame);
            let before = (segment.start_secs - secs).max(0.0) / shape.lead_secs;
            let after = (secs - segment.end_secs).max(0.0) / shape.lag_secs;
            let away = before.max(after);
            let weight = &mut weights[segment.viseme.number()];
            *weight = weight.max(shape.strength * (-2.0 * away * away).libm_exp());
        }
    }
    for weights in &mut made {
        let sum: f32 = weights.iter().sum();
        match sum > 1e-6 {
            true => weights.iter_mut().for_each(|w| *w /= sum),
            false => weights[0] = 1.0,
        }
    }
    for segment in segments {
        contact(segment, &mut made);
    }
    made
}

/// Lips that close, or touch the teeth, do so wholly in their own time.
fn contact(segment: &Segment, frames: &mut [[f32; VISEME_COUNT]]) {
    if !matches!(segment.viseme, Viseme::Pp | Viseme::Ff) || frames.is_empty() {
        return;
    }
    let secs = segment.end_secs - segment.start_secs;
    let (share, least) = CONTACT;
    let until = segment.start_secs + (share * secs).max(least);
    let rate = FRAME_RATE_HZ as f32;
    let last = frames.len() - 1;
    let first = ((segment.start_secs * rate - 0.5).ceil().max(0.0) as usize).min(last);
    let end = (until.min(segment.end_secs) * rate - 0.5).floor().max(0.0) as usize;
    for weights in &mut frames[first..=end.clamp(first, last)] {
        *weights = [0.0; VISEME_COUNT];
        weights[segment.viseme.number()] = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn phone(symbol: &str, start_secs: f32, end_secs: f32) -> TimedPhone {
        TimedPhone {
            start_secs,
            end_secs,
            symbol: symbol.to_owned(),
        }
    }

    #[test]
    fn a_shape_is_there_before_its_phone_and_h_takes_the_next() {
        let phones = [phone("HH", 0.1, 0.2), phone("UW1", 0.2, 0.4)];
        let segments = segments(&phones);
        assert!(segments.iter().all(|s| s.viseme == Viseme::U));
        let weights = weights(&segments, 60);
        assert!(weights[5][Viseme::U.number()] > 0.5);
        assert!(weights[59][Viseme::U.number()] < 0.1);
    }

    #[test]
    fn symbols_mean_what_their_alphabet_says() {
        // "sh" is one phone of ARPAbet; in the IPA it would be an s and an h.
        let one = segments(&[phone("sh", 0.0, 0.1), phone("iy", 0.1, 0.2)]);
        assert_eq!(one[0].viseme, Viseme::Ch);
        let diphthong = segments(&[phone("aʊ", 0.0, 1.0), phone("tʃ", 1.0, 1.2)]);
        assert_eq!(diphthong.len(), 3);
        assert!((diphthong[0].end_secs - 0.6).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn weights_are_shares_and_every_contact_is_made(
            lengths in prop::collection::vec((0usize..8, 0.02f32..0.3), 1..30),
        ) {
            const SYMBOLS: [&str; 8] = ["p", "f", "ɑ", "u", "s", "h", "t", ""];
            let mut at = 0.0;
            let phones: Vec<TimedPhone> = lengths
                .iter()
                .map(|(symbol, secs)| {
                    at += secs;
                    phone(SYMBOLS[*symbol], at - secs, at)
                })
                .collect();
            let segments = segments(&phones);
            let made = weights(&segments, (at * 100.0) as usize + 2);
            for weights in &made {
                prop_assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-4);
            }
            for segment in segments.iter().filter(|s| matches!(s.viseme, Viseme::Pp | Viseme::Ff)) {
                let frames = (segment.start_secs * 100.0) as usize..=(segment.end_secs * 100.0) as usize;
                let most = made[frames].iter().map(|w| w[segment.viseme.number()]).fold(0.0, f32::max);
                prop_assert!(most == 1.0, "{segment:?} reaches {most}");
            }
        }
    }
}
