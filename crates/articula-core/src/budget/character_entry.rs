//! State of one character in the budget allocator: its request, its chosen option and its ageing.
//!
//! Source: `docs/methods/motion-lod.md` part 7 (updates of an entry, ageing).

use super::lod_options::{LodOptionSet, LodOptionSetId, Point, Step};

/// A change of pixels per metre by less than this factor does not update an entry.
const SCALE_HYSTERESIS: f32 = 1.1;
/// The same for weights, which vary with the third power of the pixels per metre (pixels per metre
/// times covered pixels).
const WEIGHT_HYSTERESIS: f32 = 1.331;
/// Bounds that keep every product of weight, ageing and gain a normal number.
const WEIGHTS: (f32, f32) = (1e-12, 1e15);
const MAX_AGEING: f32 = 1e12;
const MAX_PIXELS_PER_METRE: f32 = 1e9;
/// Marks upgrades of a character that is above the cap: they come before all others.
const URGENT: u32 = 1 << 31;

/// Goals of a budget allocator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetPolicy {
    /// Error that no character should exceed, pixels. Upgrades of those above it come first.
    /// Infinity: no cap.
    pub cap_px: f32,
    /// Error below which a character is not improved further, pixels; 0 spends the whole budget,
    /// `cap_px` only what the cap requires.
    pub target_px: f32,
    /// Interval in frames at which a character above the cap gains weight: after waiting `w` frames
    /// its weight is multiplied by `(1 + w / patience_frames)³`. 0 disables ageing.
    pub patience_frames: u32,
    /// Number of frames for which a character keeps the gained weight after it was served.
    pub hold_frames: u32,
}

impl Default for BudgetPolicy {
    /// A cap of one pixel, the whole budget spent, patience and hold of 16 frames each.
    fn default() -> Self {
        Self {
            cap_px: 1.0,
            target_px: 0.0,
            patience_frames: 16,
            hold_frames: 16,
        }
    }
}

/// Option set, weight and size on screen of a visible character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LodRequest {
    /// LOD option set of the character.
    pub option_set: LodOptionSetId,
    /// Weight of one metre of its error: importance × pixels per metre × covered pixels. Negative
    /// and NaN count as 0: such a character is improved up to the cap only.
    pub weight: f32,
    /// Pixels that one metre spans at its nearest depth, the maximum over views.
    pub pixels_per_metre: f32,
}

/// State of one character as of its last update.
#[derive(Debug, Clone, Copy)]
pub(super) struct CharacterEntry {
    pub(super) option_set: u32,
    pub(super) weight: f32,
    pub(super) pixels_per_metre: f32,
    /// Factor of the weight while it is above the cap.
    pub(super) ageing: f32,
    /// Frame since which it waits, and frame at which its turn began.
    pub(super) waits_since: u32,
    pub(super) turn_since: u32,
    /// Points up to this one are needed for the cap, those up to `last` within the policy.
    pub(super) target: u8,
    pub(super) last: u8,
    pub(super) chosen: u8,
    pub(super) visible: bool,
    /// Above the cap for lack of budget.
    pub(super) starved: bool,
    /// It waited, and was served less than `hold_frames` ago.
    pub(super) turn: bool,
}

/// Entry of a hidden character.
pub(super) const EMPTY: CharacterEntry = CharacterEntry {
    option_set: 0,
    weight: 0.0,
    pixels_per_metre: 0.0,
    ageing: 1.0,
    waits_since: 0,
    turn_since: 0,
    target: 0,
    last: 0,
    chosen: 0,
    visible: false,
    starved: false,
    turn: false,
};

impl CharacterEntry {
    /// Key of an upgrade from point `i`.
    pub(super) fn key(&self, i: u8, step: &Step) -> u32 {
        let urgent = i < self.target;
        let ageing = if urgent { self.ageing } else { 1.0 };
        let key = (self.weight * ageing * step.gain_per_cost).to_bits().max(1);
        key | if urgent { URGENT } else { 0 }
    }

    /// Key and cost of every upgrade from point `from` to point `last`; keys fall.
    pub(super) fn upgrades<'a>(
        &'a self,
        option_set: &'a LodOptionSet,
        from: u8,
    ) -> impl Iterator<Item = (u32, u32)> + 'a {
        let steps = &option_set.steps()[usize::from(from)..usize::from(self.last)];
        let numbered = (from..).zip(steps);
        numbered.map(|(i, step)| (self.key(i, step), step.cost))
    }

    /// Key of its next upgrade, 0 if there is none.
    pub(super) fn next_key(&self, option_set: &LodOptionSet) -> u32 {
        let mut upgrades = self.upgrades(option_set, self.chosen);
        upgrades.next().map_or(0, |u| u.0)
    }

    /// Updates the entry from a request, and finds the points needed for the cap and those within
    /// the policy.
    pub(super) fn judge(
        &mut self,
        option_set: &LodOptionSet,
        request: &LodRequest,
        policy: &BudgetPolicy,
    ) {
        *self = Self {
            option_set: request.option_set.0,
            weight: request.weight,
            pixels_per_metre: request.pixels_per_metre,
            visible: true,
            ..*self
        };
        let within = |limit| first_within(option_set.points(), request.pixels_per_metre, limit);
        self.target = within(policy.cap_px);
        self.last = self.target;
        if request.weight > WEIGHTS.0 {
            self.last = within(policy.target_px).max(self.target);
        }
    }

    /// Factor of the weight by the time waited.
    pub(super) fn aged(&mut self, frame: u32, policy: &BudgetPolicy) -> f32 {
        if self.turn && frame.wrapping_sub(self.turn_since) >= policy.hold_frames {
            self.turn = false;
            self.waits_since = frame;
        }
        if !(self.turn || self.starved) {
            return 1.0;
        }
        let waited = frame.wrapping_sub(self.waits_since) as f32 / policy.patience_frames as f32;
        // Others are visited up to one patience earlier or later; a lead of two keeps the turn.
        let lead = if self.turn { 2.0 } else { 0.0 };
        (1.0 + waited + lead).powi(3).min(MAX_AGEING)
    }
}

impl LodRequest {
    /// Clamped to ranges that keep sums and products finite.
    pub(super) fn tamed(self) -> Self {
        Self {
            option_set: self.option_set,
            weight: tamed(self.weight, WEIGHTS.0, WEIGHTS.1),
            pixels_per_metre: tamed(self.pixels_per_metre, 0.0, MAX_PIXELS_PER_METRE),
        }
    }
}

/// Clamps to `least` and `most`; NaN gives `least`.
fn tamed(x: f32, least: f32, most: f32) -> f32 {
    if x >= least { x.min(most) } else { least }
}

/// Ranges of a request within which the entry of its character is not updated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watch {
    option_set: u32,
    scale: (f32, f32),
    weight: (f32, f32),
}

/// Contains no request.
pub(super) const ALARM: Watch = Watch {
    option_set: 0,
    scale: (f32::NAN, f32::NAN),
    weight: (f32::NAN, f32::NAN),
};

impl Watch {
    /// Ranges of the hysteresis around an entry.
    pub(super) fn around(entry: &CharacterEntry) -> Self {
        let least = match entry.weight > WEIGHTS.0 {
            true => entry.weight / WEIGHT_HYSTERESIS,
            // Any weight that counts as 0.
            false => 0.0,
        };
        let scale = entry.pixels_per_metre;
        Self {
            option_set: entry.option_set,
            scale: (scale / SCALE_HYSTERESIS, scale * SCALE_HYSTERESIS),
            weight: (least, entry.weight * WEIGHT_HYSTERESIS),
        }
    }

    /// Whether a request is within the ranges. Without branches: nearly all requests are.
    pub(super) fn is_quiet(&self, request: &LodRequest) -> bool {
        let (scale, weight) = (request.pixels_per_metre, request.weight);
        (self.option_set == request.option_set.0)
            & (scale >= self.scale.0)
            & (scale <= self.scale.1)
            & (weight >= self.weight.0)
            & (weight <= self.weight.1)
    }
}

/// Index of the first point whose error is within a limit, or of the last one.
fn first_within(points: &[Point], pixels_per_metre: f32, limit_px: f32) -> u8 {
    let outside = points
        .iter()
        .filter(|p| p.error_metres * pixels_per_metre > limit_px);
    outside.count().min(points.len() - 1) as u8
}
