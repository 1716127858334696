//! What a face does besides the mouth while it speaks: it blinks, lifts its brows where the voice is
//! loud, and its head is never quite still.

use articula_build::SplitMix;
use articula_build::face::arkit_shape;
use articula_core::Libm;
use articula_core::arkit_table::BLEND_SHAPE_COUNT;
use articula_formats::live_link::ANGLE_COUNT;
use articula_speech::VisemeTrack;
use std::f32::consts::TAU;

/// Times between blinks, in seconds.
const BLINK_EVERY: [f32; 2] = [2.0, 5.5];
/// Times over which lids close, stay closed and open.
const BLINK: [f32; 3] = [0.06, 0.03, 0.13];
/// Time over which the emphasis of the voice comes and goes.
const EMPHASIS_SECS: f32 = 0.18;
/// Decibels above the mean of the speech around that are full emphasis.
const FULL_EMPHASIS_DB: f32 = 8.0;
/// Time over which the mean of the speech is taken.
const MEAN_SECS: f32 = 2.0;
/// Level below which there is no speech.
const QUIET_DB: f32 = -30.0;
/// Weight of the brows at full emphasis.
const BROW: f32 = 0.35;
/// Nod at full emphasis, downwards.
const NOD: f32 = 0.045;
/// Greatest drift of yaw, pitch and roll of the head.
const DRIFT: [f32; 3] = [0.03, 0.018, 0.014];
/// Cycles a second of the two waves of a drift.
const WAVES_HZ: [f32; 2] = [0.11, 0.29];

/// The gestures of a track, by a seed.
#[derive(Debug)]
pub(super) struct Gestures {
    blinks_secs: Vec<f32>,
    /// Emphasis of each frame of the track, 0 to 1.
    emphasis: Vec<f32>,
    /// Phases of the waves of yaw, pitch and roll.
    phases: [[f32; 2]; 3],
    frame_secs: f32,
    lids: [usize; 2],
    brows: [usize; 3],
}

impl Gestures {
    pub(super) fn new(track: &VisemeTrack, seed: u64) -> Self {
        let mut random = SplitMix(seed);
        let phases = std::array::from_fn(|_| std::array::from_fn(|_| TAU * random.unit()));
        let mut blinks_secs = Vec::new();
        let mut at = 0.4 + random.unit();
        while at < track.duration_secs() {
            blinks_secs.push(at);
            at += BLINK_EVERY[0] + (BLINK_EVERY[1] - BLINK_EVERY[0]) * random.unit();
        }
        let shape = |name| arkit_shape(name).unwrap_or_default();
        Self {
            blinks_secs,
            emphasis: emphasis(track),
            phases,
            frame_secs: track.duration_secs() / track.frames.len().max(1) as f32,
            lids: ["eyeBlinkLeft", "eyeBlinkRight"].map(shape),
            brows: ["browInnerUp", "browOuterUpLeft", "browOuterUpRight"].map(shape),
        }
    }

    /// Adds the gestures of a moment to weights of blend shapes and to angles of the head.
    pub(super) fn add(
        &self,
        secs: f32,
        shapes: &mut [f32; BLEND_SHAPE_COUNT],
        angles: &mut [f32; ANGLE_COUNT],
    ) {
        let emphasis = self.emphasis_at(secs);
        for lid in self.lids {
            shapes[lid] = shapes[lid].max(self.lids_at(secs));
        }
        for brow in self.brows {
            shapes[brow] = shapes[brow].max(BROW * emphasis);
        }
        let waves = self.phases.iter().zip(DRIFT).zip(angles.iter_mut());
        for ((phases, most), angle) in waves {
            let wave = WAVES_HZ.iter().zip(phases);
            let sum: f32 = wave
                .map(|(hz, phase)| (TAU * hz * secs + phase).libm_sin())
                .sum();
            *angle += most * 0.5 * sum;
        }
        // The second angle is the pitch.
        angles[1] += NOD * emphasis;
    }

    /// How far the lids are closed, 0 to 1.
    fn lids_at(&self, secs: f32) -> f32 {
        let closed = |begin: &f32| {
            let since = secs - begin;
            let [close, stay, open] = BLINK;
            let closing = since / close;
            let opening = (close + stay + open - since) / open;
            closing.min(opening).clamp(0.0, 1.0)
        };
        self.blinks_secs.iter().map(closed).fold(0.0, f32::max)
    }

    fn emphasis_at(&self, secs: f32) -> f32 {
        let frame = (secs / self.frame_secs.max(1e-6)) as usize;
        let frame = frame.min(self.emphasis.len().saturating_sub(1));
        self.emphasis.get(frame).copied().unwrap_or(0.0)
    }
}

/// How far each frame is above the mean of the speech before it, eased.
fn emphasis(track: &VisemeTrack) -> Vec<f32> {
    let frame_secs = track.duration_secs() / track.frames.len().max(1) as f32;
    let (mut mean, mut eased, mut smooth) = (None, 0.0f32, 0.0f32);
    let frames = track.frames.iter().map(|frame| {
        if frame.level_db > QUIET_DB {
            let before = mean.unwrap_or(frame.level_db);
            mean = Some(before + (frame.level_db - before) * frame_secs / MEAN_SECS);
        }
        let above = mean.map_or(0.0, |mean| (frame.level_db - mean) / FULL_EMPHASIS_DB);
        // Eased twice, so that brows neither start nor stop at once.
        let share = frame_secs / EMPHASIS_SECS;
        eased += (above.clamp(0.0, 1.0) - eased) * share;
        smooth += (eased - smooth) * share;
        smooth
    });
    frames.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_speech::VisemeFrame;

    fn track(levels_db: impl Iterator<Item = f32>) -> VisemeTrack {
        let frames = levels_db.map(|level_db| VisemeFrame {
            weights: [1.0 / 15.0; 15],
            level_db,
        });
        VisemeTrack {
            frames: frames.collect(),
        }
    }

    fn at(gestures: &Gestures, secs: f32) -> ([f32; BLEND_SHAPE_COUNT], [f32; ANGLE_COUNT]) {
        let (mut shapes, mut angles) = ([0.0; BLEND_SHAPE_COUNT], [0.0; ANGLE_COUNT]);
        gestures.add(secs, &mut shapes, &mut angles);
        (shapes, angles)
    }

    #[test]
    fn lids_close_wholly_now_and_then_and_heads_stay_near_the_middle() {
        let gestures = Gestures::new(&track((0..6_000).map(|_| -10.0)), 7);
        let lid = arkit_shape("eyeBlinkLeft").unwrap();
        let closed: Vec<f32> = (0..3_600)
            .map(|f| at(&gestures, f as f32 / 60.0).0[lid])
            .collect();
        let blinks = closed
            .windows(2)
            .filter(|w| w[0] < 0.5 && w[1] >= 0.5)
            .count();
        assert!((10..=28).contains(&blinks), "{blinks} in a minute");
        assert!(closed.contains(&1.0));
        let open = closed.iter().filter(|c| **c == 0.0).count();
        assert!(open > 3_000);
        for frame in 0..3_600 {
            let (_, angles) = at(&gestures, frame as f32 / 60.0);
            assert!(angles.iter().all(|a| a.abs() < 0.1));
        }
    }

    #[test]
    fn brows_rise_where_the_voice_is_louder_than_before() {
        let levels = (0..600).map(|f| if (300..340).contains(&f) { -2.0 } else { -16.0 });
        let gestures = Gestures::new(&track(levels), 1);
        let brow = arkit_shape("browInnerUp").unwrap();
        let brow_at = |secs| at(&gestures, secs).0[brow];
        assert!(brow_at(2.0) < 0.01 && brow_at(3.35) > 0.1 && brow_at(5.5) < 0.01);
    }

    #[test]
    fn a_seed_is_a_performance() {
        let track = track((0..1_000).map(|f| -((f % 30) as f32)));
        let of = |seed| at(&Gestures::new(&track, seed), 4.0);
        assert_eq!(of(3), of(3));
        assert_ne!(of(3), of(4));
    }
}
