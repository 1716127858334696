//! Clocks of all characters: the playback states, laid out so that eight advance at a time.
//!
//! Most steps stay within one clip and pass no event. Each character therefore has a limit up to
//! which its time advances by an addition; only who passes it, begins or ends a fade, or fades with root
//! motion is advanced one by one, by [`CharacterState::advance`], which is the plain version. Who stands still, in
//! a clip of one pose or at the end of one that does not loop, has no limit and stays as it is.

use super::character_state::{CharacterState, ClipState};
use super::clip_times::ClipTimes;
use super::model::CrowdModel;
use crate::sample::Wrap;
use crate::simd::{Backend, Kernel, LANES, Lanes, Tile, dispatch};

/// No cross-fade.
const NONE: u32 = u32::MAX;
/// Limit of a clock that has to be advanced one by one.
const STOP: f32 = f32::NEG_INFINITY;
/// Limit of a clock that no step changes.
const REST: f32 = f32::INFINITY;

/// Second clip of a character, and its weight.
#[derive(Debug, Clone, Copy)]
struct Fade {
    character: u32,
    to: ClipState,
    /// Limit of the second clip.
    limit: f32,
    fade: f32,
    fade_per_sec: f32,
}

impl Fade {
    /// Advances the second clip and the weight, if nothing else happens in this step; returns
    /// whether it did.
    #[inline]
    fn advance(&mut self, dt_secs: f32) -> bool {
        let secs = match self.limit == REST {
            true => self.to.secs,
            false => self.to.secs + self.to.speed * dt_secs,
        };
        let fade = self.fade + self.fade_per_sec * dt_secs;
        let goes_on = self.fade_per_sec == 0.0 || (self.fade > 0.0 && fade < 1.0);
        let within = goes_on && secs * 1f32.copysign(self.to.speed) < self.limit;
        if within {
            self.to.secs = secs;
            self.fade = fade;
        }
        within
    }
}

/// Playback states of all characters.
#[derive(Debug, Clone)]
pub(crate) struct Clocks {
    /// Time within the first clip of each character, its speed, and the time in the direction of
    /// the speed up to which nothing happens.
    secs: Vec<Tile>,
    /// That time before the last step; empty without root motion, which follows from both.
    before: Vec<Tile>,
    speeds: Vec<Tile>,
    limits: Vec<Tile>,
    clips: Vec<(u16, Wrap)>,
    /// Index into the fades.
    fade_of: Vec<u32>,
    fades: Vec<Fade>,
    /// Who has to be advanced one by one in this frame, one bit each.
    slow: Vec<u8>,
}

impl Clocks {
    /// Bytes of each character, without those that fade.
    pub(crate) const BYTES: usize =
        3 * size_of::<f32>() + size_of::<(u16, Wrap)>() + size_of::<u32>();

    /// So many characters, all in the same state, which is not a fade; with times before the last step if clips
    /// have root motion.
    pub(crate) fn new(characters: usize, state: ClipState, has_paths: bool) -> Self {
        let tiles = characters.div_ceil(LANES);
        let secs = vec![Tile([state.secs; LANES]); tiles];
        Self {
            before: if has_paths { secs.clone() } else { Vec::new() },
            secs,
            speeds: vec![Tile([state.speed; LANES]); tiles],
            // Computed in the first frame.
            limits: vec![Tile([STOP; LANES]); tiles],
            clips: vec![(state.clip, state.wrap); characters],
            fade_of: vec![NONE; characters],
            // Space for a fade of every character, so that none allocates in a frame.
            fades: Vec::with_capacity(characters),
            slow: vec![0; tiles],
        }
    }

    /// Number of characters.
    pub(crate) fn len(&self) -> usize {
        self.clips.len()
    }

    /// Number of tiles.
    pub(crate) fn tiles(&self) -> usize {
        self.secs.len()
    }

    /// State of the first clip of a character.
    #[inline]
    pub(crate) fn from(&self, character: usize) -> ClipState {
        let (tile, lane) = (character / LANES, character % LANES);
        let (clip, wrap) = self.clips[character];
        ClipState {
            secs: self.secs[tile].0[lane],
            speed: self.speeds[tile].0[lane],
            clip,
            wrap,
        }
    }

    /// Time within the first clip of a character before the last step, if clips have root motion; the time
    /// now if it was advanced one by one.
    #[inline]
    pub(crate) fn secs_before(&self, character: usize) -> Option<f32> {
        let tile = self.before.get(character / LANES)?;
        Some(tile.0[character % LANES])
    }

    /// Whether a character has two clips.
    #[inline]
    pub(crate) fn is_fading(&self, character: usize) -> bool {
        self.fade_of[character] != NONE
    }

    /// Clip of a character, and the one that it fades to.
    #[inline]
    pub(crate) fn clips(&self, character: usize) -> (usize, Option<usize>) {
        let fade = self.fades.get(self.fade_of[character] as usize);
        let to = fade.map(|fade| usize::from(fade.to.clip));
        (usize::from(self.clips[character].0), to)
    }

    /// State of a character.
    #[inline]
    pub(crate) fn state(&self, character: usize) -> CharacterState {
        let from = self.from(character);
        match self.fades.get(self.fade_of[character] as usize) {
            None => from.into(),
            Some(fade) => CharacterState {
                from,
                to: fade.to,
                fade: fade.fade,
                fade_per_sec: fade.fade_per_sec,
            },
        }
    }

    /// Replaces the state of a character. It is advanced one by one in the next frame.
    pub(crate) fn set(&mut self, character: usize, state: &CharacterState) {
        self.store(character, state, [STOP; 2]);
    }

    /// Replaces the state of a character and computes its limit.
    #[inline]
    pub(crate) fn settle(&mut self, model: &CrowdModel, character: usize, state: &CharacterState) {
        let limits = if !state.is_fading() {
            [limit(model, &state.from), STOP]
        } else if [&state.from, &state.to].map(|s| model.clip_path(s.clip()).is_some())
            == [false; 2]
        {
            [limit(model, &state.from), limit(model, &state.to)]
        } else {
            [STOP; 2]
        };
        self.store(character, state, limits);
    }

    fn store(&mut self, character: usize, state: &CharacterState, limits: [f32; 2]) {
        let (tile, lane) = (character / LANES, character % LANES);
        self.secs[tile].0[lane] = state.from.secs;
        if let Some(before) = self.before.get_mut(tile) {
            before.0[lane] = state.from.secs;
        }
        self.speeds[tile].0[lane] = state.from.speed;
        self.limits[tile].0[lane] = limits[0];
        self.clips[character] = (state.from.clip, state.from.wrap);
        let at = self.fade_of[character];
        if state.is_fading() {
            let fade = Fade {
                character: character as u32,
                to: state.to,
                limit: limits[1],
                fade: state.fade,
                fade_per_sec: state.fade_per_sec,
            };
            match self.fades.get_mut(at as usize) {
                Some(known) => *known = fade,
                None => {
                    self.fade_of[character] = self.fades.len() as u32;
                    self.fades.push(fade);
                }
            }
        } else if at != NONE {
            self.fade_of[character] = NONE;
            self.fades.swap_remove(at as usize);
            if let Some(moved) = self.fades.get(at as usize) {
                self.fade_of[moved.character as usize] = at;
            }
        }
    }

    /// Advances the clocks that stay within their limits; [`slow`](Self::slow) has the others.
    pub(crate) fn advance(&mut self, backend: Backend, dt_secs: f32) {
        for fade in &mut self.fades {
            let (tile, lane) = (
                fade.character as usize / LANES,
                fade.character as usize % LANES,
            );
            let (secs, speed) = (self.secs[tile].0[lane], self.speeds[tile].0[lane]);
            // The test of the kernel: both clips advance by an addition, or neither.
            let after = (secs + speed * dt_secs) * 1f32.copysign(speed);
            let limit = &mut self.limits[tile].0[lane];
            if !(after < *limit && fade.advance(dt_secs)) {
                *limit = STOP;
            }
        }
        if !self.before.is_empty() {
            self.before.copy_from_slice(&self.secs);
        }
        let kernel = Advance {
            dt_secs,
            clocks: self,
        };
        dispatch(backend, kernel);
        // The lanes behind the last character belong to nobody.
        let last = self.len() % LANES;
        if let (Some(slow), 1..) = (self.slow.last_mut(), last) {
            *slow &= (1 << last) - 1;
        }
    }

    /// Who has to be advanced one by one in this frame, one bit for each character of a tile.
    pub(crate) fn slow(&self) -> &[u8] {
        &self.slow
    }
}

struct Advance<'a> {
    dt_secs: f32,
    clocks: &'a mut Clocks,
}

impl Kernel for Advance<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (dt, rest) = (L::splat(self.dt_secs), L::splat(REST));
        let clocks = self.clocks;
        let times = clocks.secs.iter_mut().zip(&clocks.speeds);
        let limits = clocks.limits.iter().zip(&mut clocks.slow);
        for ((secs, speed), (limit, slow)) in times.zip(limits) {
            let speed = L::load(&speed.0);
            let before = L::load(&secs.0);
            let after = before.add(speed.mul(dt));
            let limit = L::load(&limit.0);
            let within = after.mul(speed.sign()).less(limit);
            let moves = L::both(within, limit.less(rest));
            L::select(moves, after, before).store(secs);
            *slow = !L::bits(within);
        }
    }
}

/// Time in the direction of the speed before which a step of a clip only adds to its time.
fn limit(model: &CrowdModel, state: &ClipState) -> f32 {
    let ClipState { secs, speed, .. } = *state;
    let clip = state.clip();
    let duration = model.durations()[clip];
    if stands_still(state, duration) {
        return REST;
    }
    if !(0.0..duration).contains(&secs) {
        return STOP;
    }
    let events = &model.parts().events[clip];
    if speed.is_sign_positive() {
        let next = events.iter().find(|e| e.secs >= secs);
        next.map_or(duration, |e| e.secs.min(duration))
    } else {
        let last = events.iter().rfind(|e| e.secs <= secs);
        -last.map_or(0.0, |e| e.secs)
    }
}

/// Whether no step changes the time of a clip, so that it passes no event either: it has one pose, or is at the
/// end at which it stops.
fn stands_still(state: &ClipState, duration: f32) -> bool {
    let ClipState { secs, speed, .. } = *state;
    let at_end = match speed.is_sign_positive() {
        true => secs == duration,
        false => secs == 0.0,
    };
    match state.wrap {
        Wrap::Clamp => at_end,
        Wrap::Loop => duration == 0.0 && secs == 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fades_are_found_again_when_others_end() {
        let of = |clip| ClipState {
            secs: 0.25 * f32::from(clip),
            speed: 1.0,
            clip,
            wrap: Wrap::Loop,
        };
        let mut clocks = Clocks::new(11, of(0), false);
        let mut expected = vec![CharacterState::from(of(0)); 11];
        let fade = |clip, weight| CharacterState::fading(of(clip), of(clip + 1), weight, 2.0);
        let steps = [
            (3, fade(1, 0.25)),
            (10, fade(2, 0.5)),
            (0, fade(3, 0.75)),
            (3, of(4).into()),
            (0, fade(5, 0.125)),
            (10, of(6).into()),
            (0, of(7).into()),
            (9, of(8).into()),
        ];
        for (character, state) in steps {
            clocks.set(character, &state);
            expected[character] = state;
            for (character, expected) in expected.iter().enumerate() {
                assert_eq!(clocks.state(character), *expected);
                assert_eq!(clocks.is_fading(character), expected.is_fading());
            }
        }
        assert!(clocks.fades.is_empty());
    }
}
