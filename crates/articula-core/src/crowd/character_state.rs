//! Playback state of one character: a clip, or a cross-fade of two, each with its own speed and
//! phase.

use super::clip_times::ClipTimes;
use super::events::{ClipEvent, Step, for_events};
use super::root_path::RootDelta;
use crate::batch::BatchPose;
use crate::clip_set::ClipSet;
use crate::sample::Wrap;

/// Maximum magnitude of the playback speed; larger ones are clamped.
pub(crate) const MAX_SPEED: f32 = 1000.0;

/// Maximum time step in seconds; longer ones count as this, so that events of a pause do not pile
/// up.
pub(crate) const MAX_STEP_SECS: f32 = 60.0;

/// Playback state of one clip: time, speed and wrap mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipState {
    /// Time within the clip in seconds, 0 to its duration.
    pub(crate) secs: f32,
    /// Seconds of the clip per second of the crowd; negative plays backwards.
    pub(crate) speed: f32,
    /// Index of the clip.
    pub(crate) clip: u16,
    /// Behaviour at the end of the clip.
    pub(crate) wrap: Wrap,
}

impl ClipState {
    /// Plays a clip in a loop, from its first frame, at speed 1.
    ///
    /// # Panics
    /// If there is no such clip.
    pub fn new(clips: &impl ClipTimes, clip: usize) -> Self {
        assert!(
            clip < clips.clip_count(),
            "clip {clip} is out of range: the model has {} clips",
            clips.clip_count()
        );
        Self {
            secs: 0.0,
            speed: 1.0,
            clip: clip as u16,
            wrap: Wrap::Loop,
        }
    }

    /// Returns the state with another speed, clamped to ±1000; NaN counts as 0.
    #[must_use]
    pub fn at_speed(self, speed: f32) -> Self {
        let speed = if speed.is_nan() { 0.0 } else { speed };
        Self {
            speed: speed.clamp(-MAX_SPEED, MAX_SPEED),
            ..self
        }
    }

    /// Returns the state at another time of its clip, in seconds: wrapped if it loops, clamped if
    /// not. A time that is not finite counts as 0.
    #[must_use]
    pub fn at_secs(self, clips: &impl ClipTimes, secs: f32) -> Self {
        let duration = clips.clip_secs(self.clip());
        let secs = if secs.is_finite() { secs } else { 0.0 };
        let secs = match self.wrap {
            Wrap::Loop if duration > 0.0 => secs.rem_euclid(duration).min(duration),
            _ => secs.clamp(0.0, duration),
        };
        Self { secs, ..self }
    }

    /// Returns the state with the last frame held at the end instead of looping.
    #[must_use]
    pub fn once(self) -> Self {
        Self {
            wrap: Wrap::Clamp,
            ..self
        }
    }

    /// Index of the clip.
    pub fn clip(&self) -> usize {
        usize::from(self.clip)
    }

    /// Time within the clip in seconds.
    pub fn secs(&self) -> f32 {
        self.secs
    }

    /// Behaviour at the end of the clip.
    pub fn wrap(&self) -> Wrap {
        self.wrap
    }

    /// Advances the time and reports the events passed; returns how often the clip's end was passed
    /// forwards, less how often backwards.
    #[inline]
    pub(crate) fn advance(
        &mut self,
        duration: f32,
        dt_secs: f32,
        events: &[ClipEvent],
        tell: &mut dyn FnMut(&ClipEvent),
    ) -> i32 {
        let way = self.speed * dt_secs;
        let to = self.secs + way;
        let (laps, landed) = if (0.0..duration).contains(&to) {
            // By far the most frequent case: the step stays within the clip.
            (0, to)
        } else if self.wrap == Wrap::Clamp {
            (0, to.clamp(0.0, duration))
        } else if duration > 0.0 {
            let laps = (to / duration).floor();
            // Rounding may leave the time at the end itself.
            (laps as i32, (to - laps * duration).clamp(0.0, duration))
        } else {
            (0, 0.0)
        };
        if !events.is_empty() && way != 0.0 && (laps != 0 || landed != self.secs) {
            let step = Step {
                from_secs: self.secs,
                to_secs: landed,
                laps,
                forwards: way > 0.0,
                stopped: self.wrap == Wrap::Clamp && (landed == 0.0 || landed == duration),
            };
            for_events(events, step, tell);
        }
        self.secs = landed;
        laps
    }
}

/// Clip states of one character and the cross-fade between them. 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CharacterState {
    pub(crate) from: ClipState,
    pub(crate) to: ClipState,
    /// 0 shows `from`, 1 shows `to`.
    pub(crate) fade: f32,
    /// Growth of `fade` per second; 0 if the caller sets it.
    pub(crate) fade_per_sec: f32,
}

impl From<ClipState> for CharacterState {
    fn from(clip_state: ClipState) -> Self {
        Self {
            from: clip_state,
            to: clip_state,
            fade: 0.0,
            fade_per_sec: 0.0,
        }
    }
}

impl CharacterState {
    /// Blends two clips by a weight that the caller sets: 0 shows `from`, 1 shows `to`. The weight
    /// is clamped; NaN counts as 0.
    pub fn blend(from: ClipState, to: ClipState, weight: f32) -> Self {
        let fade = if weight.is_nan() { 0.0 } else { weight };
        Self {
            from,
            to,
            fade: fade.clamp(0.0, 1.0),
            fade_per_sec: 0.0,
        }
    }

    /// A cross-fade in progress: `share` is the current weight of `to`, `secs` the duration of the
    /// whole fade. A duration of 0 or less, or NaN, shows `to` at once.
    pub fn fading(from: ClipState, to: ClipState, share: f32, secs: f32) -> Self {
        let mut player = Self::from(from);
        player.fade_to(to, secs);
        if player.is_fading() {
            player.fade = Self::blend(from, to, share).fade;
        }
        player
    }

    /// Starts a cross-fade to another clip over `secs` seconds. It replaces a fade in progress and
    /// starts from the clip with the larger weight. A duration of 0 or less, or NaN, switches at
    /// once.
    pub fn fade_to(&mut self, clip_state: ClipState, secs: f32) {
        if self.fade >= 0.5 {
            self.from = self.to;
        }
        if secs > 0.0 {
            self.to = clip_state;
            self.fade = 0.0;
            self.fade_per_sec = 1.0 / secs;
        } else {
            *self = Self::from(clip_state);
        }
    }

    /// State of the current clip, or of the clip faded from.
    pub fn clip_state(&self) -> &ClipState {
        &self.from
    }

    /// State of the clip faded to; `None` if only one clip is played.
    pub fn next(&self) -> Option<&ClipState> {
        self.is_fading().then_some(&self.to)
    }

    /// Weight of the clip faded to, 0 to 1.
    pub fn fade(&self) -> f32 {
        self.fade
    }

    /// Whether two clips have a weight, now or as soon as time advances.
    #[inline]
    pub(crate) fn is_fading(&self) -> bool {
        self.fade != 0.0 || self.fade_per_sec != 0.0
    }

    /// Indices of the two clips that are blended; the same twice if there is no fade.
    #[inline]
    pub(crate) fn clips(&self) -> (usize, usize) {
        let to = if self.is_fading() {
            self.to.clip
        } else {
            self.from.clip
        };
        (self.from.clip(), usize::from(to))
    }

    /// Advances both clips and the fade, reports the events passed as (clip, event, weight of the
    /// clip), and returns the root motion and whether a clip passed its end.
    #[inline]
    pub(crate) fn advance(
        &mut self,
        clips: &impl ClipTimes,
        dt_secs: f32,
        tell: &mut dyn FnMut(usize, &ClipEvent, f32),
    ) -> (RootDelta, bool) {
        let before = *self;
        let weights = [1.0 - self.fade, self.fade];
        let count = if before.is_fading() { 2 } else { 1 };
        let mut laps = [0; 2];
        let clip_states = [&mut self.from, &mut self.to];
        for (v, clip_state) in clip_states.into_iter().enumerate().take(count) {
            let clip = clip_state.clip();
            let events = clips.clip_events(clip);
            laps[v] = clip_state.advance(clips.clip_secs(clip), dt_secs, events, &mut |event| {
                tell(clip, event, weights[v]);
            });
        }
        let way = self.root_delta(&before, clips, laps);
        self.advance_fade(dt_secs);
        (way, laps != [0; 2])
    }

    /// Root motion since an earlier state of the same clips.
    fn root_delta(&self, before: &Self, clips: &impl ClipTimes, laps: [i32; 2]) -> RootDelta {
        let step = |from: &ClipState, to: &ClipState, laps| {
            let path = clips.clip_path(from.clip());
            path.map_or(RootDelta::default(), |p| p.step(from.secs, to.secs, laps))
        };
        let own = step(&before.from, &self.from, laps[0]);
        if before.fade == 0.0 {
            return own;
        }
        own.lerp(step(&before.to, &self.to, laps[1]), before.fade)
    }

    /// Advances the weight; a finished fade leaves only the clip faded to.
    pub(crate) fn advance_fade(&mut self, dt_secs: f32) {
        if self.fade_per_sec != 0.0 {
            self.fade += self.fade_per_sec * dt_secs;
            if self.fade >= 1.0 {
                *self = Self::from(self.to);
            }
        }
    }

    /// Pose at the current times: cursors of the clips and the blend between them.
    #[inline]
    pub(crate) fn shown(&self, clips: &ClipSet) -> BatchPose {
        let from = clips.cursor(self.from.clip(), self.from.secs);
        if self.fade == 0.0 {
            return from.into();
        }
        BatchPose {
            from,
            to: clips.cursor(self.to.clip(), self.to.secs),
            fade: self.fade,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::RootTrajectory;
    use glam::Vec3;

    /// Clips of 2, 1 and 0 seconds; each lap of the first two leads 1 and 4 m ahead.
    struct Clips {
        events: Vec<Vec<ClipEvent>>,
        paths: Vec<Option<RootTrajectory>>,
    }

    impl Clips {
        fn new() -> Self {
            let event = |secs, id| vec![ClipEvent { secs, id }];
            let path = |rate_hz, z| {
                let ahead = RootDelta {
                    offset: Vec3::Z * z,
                    yaw_radians: 0.0,
                };
                RootTrajectory::new(rate_hz, vec![RootDelta::default(), ahead]).ok()
            };
            Self {
                events: vec![event(0.5, 7), event(0.75, 8), Vec::new()],
                paths: vec![path(0.5, 1.0), path(1.0, 4.0), None],
            }
        }
    }

    impl ClipTimes for Clips {
        fn clip_count(&self) -> usize {
            3
        }

        fn clip_secs(&self, clip: usize) -> f32 {
            [2.0, 1.0, 0.0][clip]
        }

        fn clip_events(&self, clip: usize) -> &[ClipEvent] {
            &self.events[clip]
        }

        fn clip_path(&self, clip: usize) -> Option<&RootTrajectory> {
            self.paths[clip].as_ref()
        }
    }

    fn of_clip(clip: usize) -> ClipState {
        ClipState::new(&Clips::new(), clip)
    }

    #[test]
    fn speeds_are_clamped() {
        for (speed, expected) in [
            (2.5, 2.5),
            (-0.5, -0.5),
            (2000.0, 1000.0),
            (-2000.0, -1000.0),
            (f32::NAN, 0.0),
        ] {
            let state = of_clip(1).at_speed(speed);
            assert_eq!(
                state,
                ClipState {
                    speed: expected,
                    ..of_clip(1)
                }
            );
        }
    }

    #[test]
    fn times_are_wrapped_in_a_loop_and_clamped_otherwise() {
        let clips = Clips::new();
        for (clip, secs, looped, once) in [
            (0, 0.5, 0.5, 0.5),
            (0, 5.0, 1.0, 2.0),
            (0, -0.5, 1.5, 0.0),
            (0, f32::NAN, 0.0, 0.0),
            (0, f32::INFINITY, 0.0, 0.0),
            (2, 3.0, 0.0, 0.0),
        ] {
            let state = of_clip(clip);
            assert_eq!(state.at_secs(&clips, secs).secs(), looped);
            let state = state.once();
            assert_eq!(state.at_secs(&clips, secs).secs(), once);
            assert_eq!((state.clip(), state.wrap()), (clip, Wrap::Clamp));
        }
        assert_eq!(of_clip(0).wrap(), Wrap::Loop);
    }

    #[test]
    fn a_step_over_the_end_by_hand() {
        let advanced = |mut state: ClipState, duration, dt| {
            let laps = state.advance(duration, dt, &[], &mut |_| {});
            (laps, state.secs)
        };
        let at = |secs, speed| ClipState {
            secs,
            ..of_clip(0).at_speed(speed)
        };
        assert_eq!(advanced(at(0.5, 2.0), 2.0, 0.5), (0, 1.5));
        // The end is the start of the next lap.
        assert_eq!(advanced(at(0.5, 1.0), 2.0, 1.5), (1, 0.0));
        assert_eq!(advanced(at(1.5, 2.0), 2.0, 3.0), (3, 1.5));
        assert_eq!(advanced(at(0.5, -1.0), 2.0, 1.0), (-1, 1.5));
        assert_eq!(advanced(at(0.5, -1.0), 2.0, 4.75), (-3, 1.75));
        assert_eq!(advanced(at(0.5, 1.0).once(), 2.0, 9.0), (0, 2.0));
        assert_eq!(advanced(at(0.5, -1.0).once(), 2.0, 9.0), (0, 0.0));
        // A single pose has no laps.
        assert_eq!(advanced(at(0.0, 1.0), 0.0, 9.0), (0, 0.0));
    }

    #[test]
    fn an_end_at_which_a_clip_stops_is_told_in_either_direction() {
        let events = [0.0, 2.0].map(|secs| ClipEvent {
            secs,
            id: secs as u32,
        });
        for (speed, id) in [(1.0, 2), (-1.0, 0)] {
            let mut state = ClipState {
                secs: 1.0,
                ..of_clip(0).at_speed(speed).once()
            };
            let mut told = Vec::new();
            for _ in 0..4 {
                state.advance(2.0, 0.5, &events, &mut |e| told.push(e.id));
            }
            assert_eq!(told, [id], "speed {speed}");
        }
    }

    #[test]
    fn a_blend_weighs_events_and_root_motion() {
        let clips = Clips::new();
        let mut told = Vec::new();
        let mut state = CharacterState::blend(of_clip(0), of_clip(1), 0.25);
        assert_eq!(state.next(), Some(&of_clip(1)));
        let mut tell = |clip, event: &ClipEvent, weight| told.push((clip, event.id, weight));
        // In 0.8 s the first clip leads 0.4 m ahead, the second 3.2 m.
        let (way, lapped) = state.advance(&clips, 0.8, &mut tell);
        assert!((way.offset.z - (0.75 * 0.4 + 0.25 * 3.2)).abs() < 1e-6);
        assert!(!lapped);
        // In 0.4 s more the second one begins again.
        let (way, lapped) = state.advance(&clips, 0.4, &mut tell);
        assert!((way.offset.z - (0.75 * 0.2 + 0.25 * 1.6)).abs() < 1e-6);
        assert!(lapped);
        assert_eq!(told, [(0, 7, 0.75), (1, 8, 0.25)]);
        assert!((state.clip_state().secs() - 1.2).abs() < 1e-6);
        assert!((state.to.secs - 0.2).abs() < 1e-6);
        assert_eq!(state.fade(), 0.25, "the caller sets it");
        // One clip alone.
        let mut state = CharacterState::from(of_clip(0));
        let (way, lapped) = state.advance(&clips, 3.0, &mut |_, _, _| {});
        assert!((way.offset.z - 1.5).abs() < 1e-6 && lapped);
        assert_eq!((state.next(), state.clips()), (None, (0, 0)));
        assert_eq!(state.to.secs, 0.0, "not played");
    }

    #[test]
    fn a_new_fade_starts_from_the_larger_weight() {
        for (weight, from) in [(0.25, 0), (0.5, 1), (0.75, 1)] {
            let mut state = CharacterState::blend(of_clip(0), of_clip(1), weight);
            state.fade_to(of_clip(2), 2.0);
            assert_eq!((state.clips(), state.fade()), ((from, 2), 0.0));
            state.advance_fade(0.5);
            assert_eq!(state.fade(), 0.25);
        }
        for (weight, expected) in [(-1.0, 0.0), (9.0, 1.0), (f32::NAN, 0.0)] {
            let state = CharacterState::blend(of_clip(0), of_clip(1), weight);
            assert_eq!(state.fade(), expected);
        }
        for secs in [0.0, -1.0, f32::NAN] {
            let mut state = CharacterState::blend(of_clip(0), of_clip(1), 0.5);
            state.fade_to(of_clip(2), secs);
            assert_eq!(state, CharacterState::from(of_clip(2)));
        }
    }

    #[test]
    fn a_fade_under_way_arrives_when_its_time_is_over() {
        let clip_state = |clip| ClipState {
            secs: 0.0,
            speed: 1.0,
            clip,
            wrap: Wrap::Loop,
        };
        let mut player = CharacterState::fading(clip_state(0), clip_state(1), 0.25, 2.0);
        assert_eq!((player.fade(), player.clips()), (0.25, (0, 1)));
        player.advance_fade(1.0);
        assert_eq!(player.fade(), 0.75);
        player.advance_fade(0.5);
        assert_eq!(player, CharacterState::from(clip_state(1)));
        // A fade at weight 0 is a fade too; without a duration there is none.
        assert!(CharacterState::fading(clip_state(0), clip_state(1), f32::NAN, 1.0).is_fading());
        let at_once = CharacterState::fading(clip_state(0), clip_state(1), 0.5, 0.0);
        assert_eq!(at_once, CharacterState::from(clip_state(1)));
    }
}
