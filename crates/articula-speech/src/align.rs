//! When known phones are spoken: the path through them that the recogniser finds most likely.

use crate::coarticulation::segments;
use crate::{FRAME_RATE_HZ, TimedPhone, VisemeTrack};
use articula_core::Libm;
use articula_core::viseme::{VISEME_COUNT, Viseme};

/// Share of each weight that is spread over all: a phone that is not heard costs much, not all.
const DOUBT: f32 = 0.1;
/// Most steps of the search: half an hour of speech in pieces of a minute, or ten minutes in one.
const MAX_STEPS: usize = 400_000_000;

/// Error of [`align`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum AlignError {
    /// The recording is too short for the phones.
    #[error(
        "{phones} phones do not fit into {frames} hundredths of a second; is it the text of this recording?"
    )]
    Short {
        /// Phones without pauses.
        phones: usize,
        /// Frames of the recording.
        frames: usize,
    },
    /// The recording is too long.
    #[error(
        "the recording and its text are too long to be aligned at once; cut them into parts of some minutes"
    )]
    Long,
}

/// Finds when each of a sequence of phones is spoken in a recording, from the track of the recogniser as
/// it is (not smoothed). Symbols are those of the IPA or of ARPAbet; an empty one is a place where a
/// pause may be. A pause at the begin and at the end is always possible.
///
/// # Errors
/// An [`AlignError`].
pub fn align(track: &VisemeTrack, symbols: &[String]) -> Result<Vec<TimedPhone>, AlignError> {
    let states = states(symbols);
    let frames = track.frames.len();
    let phones = symbols.iter().filter(|s| !s.is_empty()).count();
    let least = states.iter().filter(|state| state.phone.is_some()).count();
    if least > frames || phones == 0 {
        return Err(AlignError::Short { phones, frames });
    }
    if states.len().saturating_mul(frames) > MAX_STEPS {
        return Err(AlignError::Long);
    }
    let path = best_path(track, &states);
    Ok(timed(&path, &states, symbols))
}

/// A shape that the path goes through. Each of a phone is there twice, and the first one takes one frame:
/// a shape is heard for two frames at least.
#[derive(Debug, Clone, Copy)]
struct State {
    viseme: Viseme,
    /// Index of its phone; a pause has none and may be left out.
    phone: Option<usize>,
    /// Whether it may take more than one frame.
    stays: bool,
}

fn states(symbols: &[String]) -> Vec<State> {
    let pause = State {
        viseme: Viseme::Silence,
        phone: None,
        stays: true,
    };
    let numbered = symbols.iter().enumerate().map(|(at, symbol)| TimedPhone {
        start_secs: at as f32,
        end_secs: at as f32 + 1.0,
        symbol: symbol.clone(),
    });
    let numbered: Vec<TimedPhone> = numbered.collect();
    let mut all = vec![pause];
    for segment in segments(&numbered) {
        // The middle of a part lies within its phone.
        let phone = ((segment.start_secs + segment.end_secs) / 2.0) as usize;
        if symbols[phone].is_empty() {
            all.push(pause);
            continue;
        }
        all.extend([false, true].map(|stays| State {
            viseme: segment.viseme,
            phone: Some(phone),
            stays,
        }));
    }
    all.push(pause);
    all.dedup_by(|b, a| a.phone.is_none() && b.phone.is_none());
    all
}

/// The state of each frame.
fn best_path(track: &VisemeTrack, states: &[State]) -> Vec<usize> {
    let count = states.len();
    let is_pause = |state: usize| states[state].phone.is_none();
    let mut scores = vec![f32::NEG_INFINITY; count];
    // Steps from the state before: 0 stays, 1 comes from the one before, 2 passes a pause.
    let mut steps = vec![0u8; count * track.frames.len()];
    for (frame, weights) in track.frames.iter().enumerate() {
        let logs = logs(&weights.weights);
        // From the last state on, so that those before it are still of the frame before.
        for state in (0..count).rev() {
            let mut best = match states[state].stays {
                true => (scores[state], 0u8),
                false => (f32::NEG_INFINITY, 0),
            };
            for back in 1..=2usize.min(state) {
                let may = back == 1 || is_pause(state - 1);
                if may && scores[state - back] > best.0 {
                    best = (scores[state - back], back as u8);
                }
            }
            if frame == 0 {
                let begins = state == 0 || state == 1 && is_pause(0);
                best = (if begins { 0.0 } else { f32::NEG_INFINITY }, 0);
            }
            scores[state] = best.0 + logs[states[state].viseme.number()];
            steps[frame * count + state] = best.1;
        }
    }
    let ends = [count - 1, count.saturating_sub(2)];
    let mut state = match scores[ends[1]] > scores[ends[0]] {
        true => ends[1],
        false => ends[0],
    };
    let mut path = vec![0; track.frames.len()];
    for frame in (0..path.len()).rev() {
        path[frame] = state;
        state -= usize::from(steps[frame * count + state]);
    }
    path
}

fn logs(weights: &[f32; VISEME_COUNT]) -> [f32; VISEME_COUNT] {
    weights.map(|w| ((1.0 - DOUBT) * w + DOUBT / VISEME_COUNT as f32).libm_ln())
}

/// The frames of each phone, and the pauses between them.
fn timed(path: &[usize], states: &[State], symbols: &[String]) -> Vec<TimedPhone> {
    let secs = |frame: usize| frame as f32 / FRAME_RATE_HZ as f32;
    let mut phones: Vec<(Option<usize>, TimedPhone)> = Vec::new();
    for (frame, state) in path.iter().enumerate() {
        let phone = states[*state].phone;
        match phones.last_mut() {
            Some((last, timed)) if *last == phone => timed.end_secs = secs(frame + 1),
            _ => phones.push((
                phone,
                TimedPhone {
                    start_secs: secs(frame),
                    end_secs: secs(frame + 1),
                    symbol: phone.map(|at| symbols[at].clone()).unwrap_or_default(),
                },
            )),
        }
    }
    phones.into_iter().map(|(_, timed)| timed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VisemeFrame;
    use proptest::prelude::*;

    fn heard(runs: &[(usize, usize)]) -> VisemeTrack {
        let frames = runs.iter().flat_map(|(class, count)| {
            let weight = |v: usize| if v == *class { 0.72 } else { 0.02 };
            std::iter::repeat_n(std::array::from_fn(weight), *count)
        });
        VisemeTrack {
            frames: frames
                .map(|weights| VisemeFrame {
                    weights,
                    level_db: 0.0,
                })
                .collect(),
        }
    }

    fn symbols(text: &str) -> Vec<String> {
        text.split(' ')
            .map(|s| s.trim_matches('_').to_owned())
            .collect()
    }

    #[test]
    fn phones_are_found_where_they_are_heard_and_pauses_where_there_are_some() {
        let track = heard(&[(0, 12), (1, 6), (10, 20), (0, 9), (14, 15), (0, 4)]);
        let phones = align(&track, &symbols("b ɑ _ u")).unwrap();
        let said: Vec<(&str, f32)> = phones
            .iter()
            .map(|p| (p.symbol.as_str(), p.start_secs))
            .collect();
        assert_eq!(
            said,
            [
                ("", 0.0),
                ("b", 0.12),
                ("ɑ", 0.18),
                ("", 0.38),
                ("u", 0.47),
                ("", 0.62)
            ]
        );
        // Without the pause between the words none is found.
        let track = heard(&[(1, 6), (10, 20), (14, 15)]);
        let phones = align(&track, &symbols("b ɑ _ u")).unwrap();
        assert_eq!(phones.len(), 3);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let short = align(&heard(&[(1, 3)]), &symbols("b ɑ u"));
        assert_eq!(
            short,
            Err(AlignError::Short {
                phones: 3,
                frames: 3
            })
        );
        assert!(align(&heard(&[(1, 3)]), &symbols("_")).is_err());
    }

    proptest! {
        #[test]
        fn every_phone_is_found_once_and_in_order(
            runs in prop::collection::vec((0usize..15, 1usize..12), 4..30),
            said in prop::collection::vec(prop::sample::select(vec!["p", "ɑ", "u", "aɪ", "h", ""]), 1..12),
        ) {
            let track = heard(&runs);
            let said: Vec<String> = said.into_iter().map(str::to_owned).collect();
            if let Ok(phones) = align(&track, &said) {
                let found: Vec<&str> = phones.iter().map(|p| p.symbol.as_str()).filter(|s| !s.is_empty()).collect();
                let expected: Vec<&str> = said.iter().map(String::as_str).filter(|s| !s.is_empty()).collect();
                // Equal neighbours are told apart by their index.
                prop_assert_eq!(found, expected);
                prop_assert_eq!(phones.last().unwrap().end_secs, track.duration_secs());
                prop_assert!(phones.windows(2).all(|w| w[0].end_secs == w[1].start_secs));
            }
        }
    }
}
