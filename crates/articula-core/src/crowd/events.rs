//! Events of a clip, which are reported whatever the level and visibility of the character.

use crate::Mismatch;

/// An event at a time of a clip, such as a footstep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipEvent {
    /// Time within the clip in seconds.
    pub secs: f32,
    /// Identifier given by the caller.
    pub id: u32,
}

/// Sorts the events of a clip by time.
///
/// # Errors
/// A [`Mismatch`] if a time lies outside the clip or is NaN.
pub(crate) fn sorted(events: &[ClipEvent], duration_secs: f32) -> Result<Vec<ClipEvent>, Mismatch> {
    for (i, event) in events.iter().enumerate() {
        if !(0.0..=duration_secs).contains(&event.secs) {
            let what = format!(
                "{} s is outside the clip (0 to {duration_secs} s)",
                event.secs
            );
            return Err(Mismatch::new(format!("[{i}].secs"), what));
        }
    }
    let mut events = events.to_vec();
    events.sort_by(|a, b| a.secs.total_cmp(&b.secs));
    Ok(events)
}

/// A time step within a clip.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) from_secs: f32,
    pub(crate) to_secs: f32,
    /// How often the end was passed; negative if backwards.
    pub(crate) laps: i32,
    pub(crate) forwards: bool,
    /// Whether it reached an end at which the clip stops.
    pub(crate) stopped: bool,
}

/// Reports every event passed by a step, in the order passed, those of whole laps once for each
/// lap.
///
/// A step reports the events from its start, included, to its end, excluded, so that consecutive
/// steps report every event once. An end at which the clip stops is reported by the step that
/// reaches it.
pub(crate) fn for_events(events: &[ClipEvent], step: Step, tell: &mut dyn FnMut(&ClipEvent)) {
    // Beyond every event, at both ends.
    let (start, end) = (f32::NEG_INFINITY, f32::INFINITY);
    let (from, to) = (step.from_secs, step.to_secs);
    if step.forwards {
        let mut segment = |low: f32, high: f32| {
            let passed = events.iter().filter(|e| e.secs >= low && e.secs < high);
            passed.for_each(&mut *tell);
        };
        if step.laps == 0 {
            segment(from, if step.stopped { end } else { to });
            return;
        }
        segment(from, end);
        for _ in 1..step.laps {
            segment(start, end);
        }
        segment(start, to);
    } else {
        let mut segment = |low: f32, high: f32| {
            let passed = events
                .iter()
                .rev()
                .filter(|e| e.secs > low && e.secs <= high);
            passed.for_each(&mut *tell);
        };
        if step.laps == 0 {
            segment(if step.stopped { start } else { to }, from);
            return;
        }
        segment(start, from);
        for _ in step.laps + 1..0 {
            segment(start, end);
        }
        segment(to, end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::character_state::ClipState;
    use crate::sample::Wrap;
    use proptest::prelude::*;

    fn told(clip_state: &mut ClipState, duration: f32, dt: f32, times: &[f32]) -> Vec<u32> {
        let events: Vec<ClipEvent> = times
            .iter()
            .zip(0..)
            .map(|(secs, id)| ClipEvent { secs: *secs, id })
            .collect();
        let mut heard = Vec::new();
        clip_state.advance(duration, dt, &events, &mut |e| heard.push(e.id));
        heard
    }

    fn clip_state(secs: f32, speed: f32, wrap: Wrap) -> ClipState {
        ClipState {
            secs,
            speed,
            clip: 0,
            wrap,
        }
    }

    #[test]
    fn by_hand() {
        let marks = [0.0, 0.5, 1.0];
        let mut v = clip_state(0.0, 1.0, Wrap::Loop);
        assert_eq!(told(&mut v, 1.0, 0.5, &marks), [0]);
        assert_eq!(told(&mut v, 1.0, 0.25, &marks), [1]);
        // Over the end: the event of the end, then that of the start.
        assert_eq!(told(&mut v, 1.0, 0.5, &marks), [2, 0]);
        // Two and a half laps.
        let mut v = clip_state(0.25, 1.0, Wrap::Loop);
        assert_eq!(told(&mut v, 1.0, 2.0, &marks), [1, 2, 0, 1, 2, 0]);
        // Backwards.
        let mut v = clip_state(0.25, -1.0, Wrap::Loop);
        assert_eq!(told(&mut v, 1.0, 0.5, &marks), [0, 2]);
        // A clip that stops reports its end once.
        let mut v = clip_state(0.75, 1.0, Wrap::Clamp);
        assert_eq!(told(&mut v, 1.0, 0.5, &marks), [2]);
        assert!(told(&mut v, 1.0, 0.5, &marks).is_empty());
    }

    proptest! {
        /// However time is divided into steps, every event is reported equally often.
        #[test]
        fn nothing_is_skipped_or_told_twice(
            times in prop::collection::vec(0.01f32..0.99, 1..6),
            steps in prop::collection::vec(0.001f32..1.7, 1..40),
            start in 0.0f32..0.99,
        ) {
            let mut v = clip_state(start, 1.0, Wrap::Loop);
            let mut heard = 0usize;
            let mut laps = 0;
            for dt in &steps {
                let events: Vec<ClipEvent> =
                    times.iter().map(|secs| ClipEvent { secs: *secs, id: 0 }).collect();
                let events = sorted(&events, 1.0).unwrap();
                laps += v.advance(1.0, *dt, &events, &mut |_| heard += 1);
            }
            // Events between the start and the time reached, laps included.
            let passed = |to: f32| times.iter().filter(|t| **t < to).count() as i64;
            let expected = i64::from(laps) * times.len() as i64 + passed(v.secs) - passed(start);
            prop_assert_eq!(heard as i64, expected);
        }
    }

    #[test]
    fn events_outside_their_clip_are_refused() {
        let at = |secs| sorted(&[ClipEvent { secs, id: 0 }], 1.0).unwrap_err().at;
        assert_eq!(at(-0.1), "[0].secs");
        assert_eq!(at(f32::NAN), "[0].secs");
    }
}
