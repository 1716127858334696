//! What plays when: the motions of an item one after the other, each in whole rounds.

use super::options::TraceOptions;
use crate::error::{Context, Error, Result};
use crate::item::files::Item;
use articula_stream::StreamLimits;
use articula_stream::abp2::MotionHead;
use std::ops::Range;

/// Most plays of a timeline.
const MOST_PLAYS: usize = 1 << 16;

/// A motion of the item.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    /// Index of its part.
    pub(super) part: usize,
    pub(super) rate_hz: f64,
    /// Frames of each access unit; all frames of a motion that has none.
    pub(super) units: Vec<Range<usize>>,
}

/// An access unit of a motion at its time in the presentation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Play {
    /// Index of the motion.
    pub(super) motion: usize,
    /// Number of the access unit.
    pub(super) unit: usize,
    pub(super) start_secs: f64,
    pub(super) end_secs: f64,
}

impl Play {
    pub(super) fn secs(&self) -> f64 {
        self.end_secs - self.start_secs
    }
}

/// A frame of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct FrameOf {
    pub(super) motion: usize,
    pub(super) frame: usize,
}

/// All plays in order, without gaps, from 0 s on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timeline {
    pub(super) motions: Vec<Motion>,
    pub(super) plays: Vec<Play>,
}

impl Timeline {
    /// Plays each motion of the item for as long as the options say, and all of them anew until their time
    /// is over.
    pub(super) fn of(item: &Item, options: &TraceOptions) -> Result<Self> {
        let mut motions = Vec::new();
        for (index, part) in item.manifest.parts.iter().enumerate() {
            let stream = part.file.as_deref().and_then(|file| item.file(file));
            if let (true, Some(stream)) = (part.kind.is_motion(), stream) {
                let head = MotionHead::open(stream, &StreamLimits::default());
                let head = head.with_context(|| part.file.clone().unwrap_or_default())?;
                let all = std::iter::once(0..head.frames);
                motions.push(Motion {
                    part: index,
                    rate_hz: f64::from(head.rate_hz).max(1e-3),
                    units: match head.access_units {
                        0 => all.collect(),
                        count => (0..count).map(|unit| head.frames_of(unit)).collect(),
                    },
                });
            }
        }
        if motions.is_empty() {
            let what = "the item has no motion to play; package a character with clips";
            return Err(Error::unsuited(what));
        }
        let plays = plays(&motions, options);
        Ok(Self { motions, plays })
    }

    /// The play at a time; the last one after all.
    pub(super) fn play_at(&self, secs: f64) -> usize {
        let after = self.plays.partition_point(|play| play.start_secs <= secs);
        after.max(1) - 1
    }

    /// The frame that is shown at a time.
    pub(super) fn frame_at(&self, secs: f64) -> FrameOf {
        self.frame_of(self.play_at(secs), secs)
    }

    /// The frame of a play that is shown at a time: its last one if the play is over.
    pub(super) fn frame_of(&self, play: usize, secs: f64) -> FrameOf {
        let Play {
            motion,
            unit,
            start_secs,
            ..
        } = self.plays[play];
        let frames = &self.motions[motion].units[unit];
        // A time that is a frame's, but for rounding, is its time.
        let since = ((secs - start_secs) * self.motions[motion].rate_hz + 1e-6).max(0.0) as usize;
        let last = frames.end.saturating_sub(1);
        FrameOf {
            motion,
            frame: (frames.start + since).min(last),
        }
    }
}

fn plays(motions: &[Motion], options: &TraceOptions) -> Vec<Play> {
    let mut plays: Vec<Play> = Vec::new();
    let mut at = 0.0;
    while at < options.secs {
        for (index, motion) in motions.iter().enumerate() {
            let frames = motion.units.last().map_or(0, |last| last.end);
            let begin = at;
            while at < begin + options.clip_secs && at < options.secs {
                for (unit, own) in motion.units.iter().enumerate() {
                    // A still lasts as long as any motion.
                    let secs = match frames {
                        0 | 1 => options.clip_secs,
                        _ => own.len() as f64 / motion.rate_hz,
                    };
                    plays.push(Play {
                        motion: index,
                        unit,
                        start_secs: at,
                        end_secs: at + secs,
                    });
                    at += secs;
                }
                if plays.len() >= MOST_PLAYS {
                    return plays;
                }
            }
        }
    }
    plays
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timeline(units: Vec<Vec<Range<usize>>>, secs: f64) -> Timeline {
        let motion = |(part, units)| Motion {
            part,
            rate_hz: 10.0,
            units,
        };
        let motions: Vec<Motion> = units.into_iter().enumerate().map(motion).collect();
        let options = TraceOptions {
            secs,
            clip_secs: 2.5,
            ..TraceOptions::default()
        };
        let plays = plays(&motions, &options);
        Timeline { motions, plays }
    }

    #[test]
    fn each_motion_plays_in_whole_rounds() {
        // 1.5 s in two access units, and a still.
        let made = timeline(
            vec![vec![0..10, 10..15], std::iter::once(0..1).collect()],
            6.0,
        );
        let found: Vec<(usize, usize, f64)> = made
            .plays
            .iter()
            .map(|play| (play.motion, play.unit, play.start_secs))
            .collect();
        let rounds = [(0, 0, 0.0), (0, 1, 1.0), (0, 0, 1.5), (0, 1, 2.5)];
        let rest = [(1, 0, 3.0), (0, 0, 5.5), (0, 1, 6.5)];
        assert_eq!(found, [&rounds[..], &rest[..]].concat());
        let at = |secs| (made.play_at(secs), made.frame_at(secs).frame);
        assert_eq!(at(0.0), (0, 0));
        assert_eq!(at(0.95), (0, 9));
        assert_eq!(at(1.2), (1, 12));
        assert_eq!(at(2.6), (3, 11));
        assert_eq!(at(4.0), (4, 0));
        // After its end a play holds its last frame.
        assert_eq!(made.frame_of(1, 9.0).frame, 14);
    }

    #[test]
    fn a_motion_of_one_frame_after_another_has_a_bound() {
        let made = timeline(vec![std::iter::once(0..2).collect()], 1e9);
        assert!(made.plays.len() <= MOST_PLAYS);
    }
}
