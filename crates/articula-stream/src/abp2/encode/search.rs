//! The steps of all tracks within a tolerance, and the planes that coarser tiers drop.
//!
//! Form: `docs/methods/motion-stream.md`, parts 5 and 6.

use super::levers::{Mover, Rest, levers, shares};
use super::near_points::NearPoints;
use super::plan::PlannedTrack;
use super::quantise::{Coding, Levels};
use super::shown_planes::ShownPlanes;
use super::skin_points::{Measure, SkinError, SkinPoints};
use super::truth::Truth;
use crate::abp2::pose_unit::{MOST_PLANES, TrackForm};
use articula_core::Libm;
use articula_core::{Mismatch, Rig};
use glam::{Affine3A, Vec3};
use std::cell::{Cell, OnceCell};
use std::ops::Range;

/// Halvings of the interval of a factor.
const HALVINGS: usize = 9;
/// Factors of all steps that are tried, in tolerances.
const FACTORS: [f64; 2] = [0.05, 8.0];
/// Factors of the planes of a tier, by its tolerance.
const TIER_FACTORS: [f64; 2] = [0.02, 4.0];
/// Most places of points that are kept, 192 MB.
const MOST_PLACES: usize = 1 << 24;
/// Most matrices that are kept, 64 MB.
const MOST_MATRICES: usize = 1 << 20;
/// Frames that are measured at a time, until one is beyond a limit.
const FRAMES: usize = 16;
/// Rounds in which the worst vertices join the points of the search.
const ROUNDS: usize = 3;
/// What a factor falls by where the points of the search miss the worst vertex.
pub(super) const BACK: f64 = 0.985;

/// Shares of the tolerance: of tier 0, where children take back errors of their parents, and of
/// coarser ones, where they do not.
pub(super) struct Shares {
    pub(super) fine: Vec<f64>,
    pub(super) coarse: Vec<f64>,
}

impl Shares {
    pub(super) fn new(
        rig: &Rig,
        points: &SkinPoints,
        rest: &Rest,
        planned: &[PlannedTrack],
        compensates: &[bool],
    ) -> Self {
        let mut turns = vec![false; rig.len()];
        for track in planned.iter().filter(|track| track.moves) {
            if let Mover::Rotation(joint) = track.mover() {
                turns[joint] = compensates[joint];
            }
        }
        Self {
            fine: shares_of(rig, points, rest, planned, &turns, true),
            coarse: shares_of(rig, points, rest, planned, &vec![false; rig.len()], false),
        }
    }
}

/// Shares of each track; rotations, vectors and morph targets each have the whole tolerance, since
/// the factor of all steps is measured.
fn shares_of(
    rig: &Rig,
    points: &SkinPoints,
    rest: &Rest,
    planned: &[PlannedTrack],
    turns: &[bool],
    compensated: bool,
) -> Vec<f64> {
    let mut found: Vec<f64> = planned.iter().map(|track| 1.0 / track.lever).collect();
    let class = |mover: Mover| match mover {
        Mover::Rotation(_) | Mover::AloneRotation(_) => 0,
        Mover::Translation(_) | Mover::Scale(_) => 1,
        Mover::Morph(_) => 2,
    };
    for wanted in 0..3 {
        let of_class = |track: &PlannedTrack| track.moves && class(track.mover()) == wanted;
        let tracks: Vec<usize> = (0..planned.len())
            .filter(|t| of_class(&planned[*t]))
            .collect();
        let movers: Vec<Mover> = tracks
            .iter()
            .map(|track| match planned[*track].mover() {
                Mover::Rotation(joint) if !compensated => Mover::AloneRotation(joint),
                other => other,
            })
            .collect();
        let of_points = levers(rig, points, rest, &movers, turns);
        for (track, share) in tracks.iter().zip(shares(&of_points, points.len())) {
            found[*track] = share;
        }
    }
    found
}

/// Points with their neighbours.
pub(super) struct Near {
    pub(super) points: SkinPoints,
    blocks: NearPoints,
}

impl Near {
    pub(super) fn of(points: SkinPoints) -> Self {
        Self {
            blocks: NearPoints::of(&points),
            points,
        }
    }
}

/// The points of the search, and all points.
pub(super) struct Judge<'a> {
    pub(super) rig: &'a Rig,
    pub(super) truth: &'a Truth,
    pub(super) all: &'a Near,
    pub(super) some: Near,
    /// The true places of the points of the search and of all, frame by frame, once they were measured; empty if
    /// they are too many.
    pub(super) some_shown: OnceCell<Vec<Vec3>>,
    pub(super) all_shown: OnceCell<Vec<Vec3>>,
    /// What [`Self::true_palettes`] returns, once it was asked for.
    pub(super) palettes: OnceCell<Vec<Affine3A>>,
    /// Whether the errors of tiers are measured at all points.
    pub(super) states_errors: bool,
    /// The first of the frames in which a motion was beyond its limit.
    pub(super) worst_frame: Cell<usize>,
}

impl Judge<'_> {
    /// Measures at the points of the search.
    pub(super) fn quick(&self) -> Measure<'_> {
        self.measure(&self.some, &self.some_shown)
    }

    fn measure<'s>(&'s self, near: &'s Near, shown: &'s OnceCell<Vec<Vec3>>) -> Measure<'s> {
        let points = &near.points;
        let places = points.len().saturating_mul(self.truth.frames);
        let shown = shown.get_or_init(|| match places {
            0..=MOST_PLACES => points.shown(self.rig, self.truth),
            _ => Vec::new(),
        });
        Measure {
            rig: self.rig,
            points,
            truth: self.truth,
            shown: (!shown.is_empty()).then_some(shown),
        }
    }

    /// The matrices of the bindings in the true pose of each frame; empty if they are too many. All points have
    /// the same bindings.
    fn true_palettes(&self) -> &[Affine3A] {
        self.palettes.get_or_init(|| {
            let points = &self.all.points;
            let mut posed = points.posed(self.rig);
            let matrices = posed.palette.len().saturating_mul(self.truth.frames);
            if matrices > MOST_MATRICES {
                return Vec::new();
            }
            let mut palettes = Vec::with_capacity(matrices);
            for frame in 0..self.truth.frames {
                self.truth.pose(frame, &mut posed.local);
                points.turn(self.rig, &mut posed);
                palettes.extend_from_slice(&posed.palette);
            }
            palettes
        })
    }

    /// Sets the points of the search.
    fn search_at(&mut self, points: SkinPoints) {
        self.some = Near::of(points);
        self.some_shown = OnceCell::new();
    }

    /// Whether `beyond` finds nothing in all frames. It returns the first of some frames in which a motion is
    /// beyond a limit.
    fn seems_within(&self, beyond: impl FnMut(Range<usize>) -> Option<usize>) -> bool {
        let count = self.truth.frames;
        // Where the last motion was beyond its limit, this one is too if it is anywhere, as a rule.
        let last = self.worst_frame.get();
        let starts = (0..count).step_by(FRAMES);
        let all = starts.map(|start| start..count.min(start + FRAMES));
        let found = std::iter::once(last..count.min(last + 1))
            .chain(all)
            .find_map(beyond);
        self.worst_frame.set(found.unwrap_or(last));
        found.is_none()
    }

    /// The first of some frames in which a point of the search is farther than `limit` from its place.
    pub(super) fn some_beyond(
        &self,
        motion: &Truth,
        frames: Range<usize>,
        limit: f64,
    ) -> Option<usize> {
        let mut found = self.farthest(&self.some, motion, frames, limit);
        found.next().map(|(frame, _)| frame)
    }

    /// The farthest point of each frame in which one of all points is farther than `limit` from its place.
    fn beyond(&self, motion: &Truth, limit: f64) -> impl Iterator<Item = usize> {
        let found = self.farthest(self.all, motion, 0..self.truth.frames, limit);
        found.map(|(_, point)| point)
    }

    /// The frames in which a point is farther than `limit` from its place, with the farthest.
    fn farthest(
        &self,
        near: &Near,
        motion: &Truth,
        mut frames: Range<usize>,
        limit: f64,
    ) -> impl Iterator<Item = (usize, usize)> {
        let points = &near.points;
        let known = self.true_palettes();
        let (mut right, mut found) = (points.posed(self.rig), points.posed(self.rig));
        std::iter::from_fn(move || {
            frames.find_map(|frame| {
                motion.pose(frame, &mut found.local);
                points.turn(self.rig, &mut found);
                let count = found.palette.len();
                let right = match known.get(frame * count..(frame + 1) * count) {
                    Some(palette) => palette,
                    None => {
                        self.truth.pose(frame, &mut right.local);
                        points.turn(self.rig, &mut right);
                        &right.palette
                    }
                };
                let right = (right, self.truth.weights(frame));
                let found = (&found.palette[..], motion.weights(frame));
                let point = near.blocks.farthest(points, right, found, limit)?;
                Some((frame, point))
            })
        })
    }

    /// Error at all points; `None` if it is not asked for.
    fn stated(&self, motion: &Truth) -> Option<SkinError> {
        if !self.states_errors {
            return None;
        }
        let measure = self.measure(self.all, &self.all_shown);
        Some(measure.error(motion))
    }
}

/// Searches the greatest steps with an error within the tolerance at all points. `refine` returns the
/// points of the search with further ones.
pub(super) fn finest<'a>(
    coding: &Coding<'_>,
    shares: &[f64],
    tolerance: f64,
    judge: &mut Judge<'a>,
    refine: impl Fn(&[usize]) -> SkinPoints,
) -> Result<(Levels, Truth), Mismatch> {
    let quantise = |factor: f64| {
        let steps: Vec<f64> = shares
            .iter()
            .map(|share| share * factor * tolerance)
            .collect();
        coding.quantise(&steps)
    };
    let mut added: Vec<usize> = Vec::new();
    let mut factor = FACTORS[0];
    for round in 0..ROUNDS {
        let [mut low, mut high] = FACTORS.map(Libm::libm_ln);
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            let (_, shown) = quantise(middle.libm_exp())?;
            if judge.seems_within(|frames| judge.some_beyond(&shown, frames, tolerance)) {
                low = middle;
            } else {
                high = middle;
            }
        }
        factor = low.libm_exp();
        let (levels, shown) = quantise(factor)?;
        let worst: Vec<usize> = judge.beyond(&shown, tolerance).collect();
        if worst.is_empty() {
            return Ok((levels, shown));
        }
        if round + 1 < ROUNDS {
            added.extend(worst);
            judge.search_at(refine(&added));
        }
    }
    // Steps are eighths of an octave: this ends, at the latest when each is the smallest there is.
    for _ in 0..600 {
        factor *= BACK;
        let (levels, shown) = quantise(factor)?;
        if judge.beyond(&shown, tolerance).next().is_none() {
            return Ok((levels, shown));
        }
    }
    let what = format!("cannot be coded within {tolerance} m; give a greater tolerance");
    Err(Mismatch::new("the motion", what))
}

/// Searches the planes that each tier drops, and writes them into the tracks. Returns the error of
/// each tier, if it is asked for.
pub(super) fn tiers(
    coding: &Coding<'_>,
    levels: &mut Levels,
    start: &Truth,
    shares: &Shares,
    judge: &Judge<'_>,
    tolerance: f64,
) -> Vec<SkinError> {
    let mut errors: Vec<SkinError> = judge.stated(start).into_iter().collect();
    let mut of_tiers: Vec<Vec<u8>> = Vec::new();
    let mut shown = ShownPlanes::new(coding, levels, start);
    let all = 0..judge.truth.frames;
    let mut above = vec![0_u8; levels.tracks.len()];
    for tier in 1..coding.head.tiers {
        let limit = tolerance * 3_f64.powi(tier as i32);
        let planes = |factor: f64| -> Vec<u8> {
            let ratio = shares.coarse.iter().zip(&shares.fine).map(|(c, f)| c / f);
            let wanted = ratio.map(|r| ((factor * r).libm_ln() / 3.0_f64.libm_ln()).round());
            let wanted = wanted.zip(&above);
            wanted
                .map(|(w, a)| w.clamp(f64::from(*a), f64::from(MOST_PLANES)) as u8)
                .collect()
        };
        let whole = 3_f64.powi(tier as i32);
        let [mut low, mut high] = TIER_FACTORS.map(|factor| (whole * factor).libm_ln());
        // Near factors often drop the same planes.
        let (mut within, mut beyond) = (None, None);
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            let dropped = planes(middle.libm_exp());
            let was = |last: &Option<Vec<u8>>| last.as_ref() == Some(&dropped);
            let is_within = was(&within)
                || !was(&beyond)
                    && judge.seems_within(|frames| {
                        let motion = shown.in_frames(&dropped, frames.clone());
                        judge.some_beyond(motion, frames, limit)
                    });
            let (end, last) = match is_within {
                true => (&mut low, &mut within),
                false => (&mut high, &mut beyond),
            };
            (*end, *last) = (middle, Some(dropped));
        }
        let mut best = within.unwrap_or_else(|| above.clone());
        let mut factor = low.libm_exp();
        let mut is_within = |dropped: &[u8]| {
            let motion = shown.in_frames(dropped, all.clone());
            judge.beyond(motion, limit).next().is_none()
        };
        let mut is_found = is_within(&best);
        while !is_found && best != above {
            factor *= 0.9;
            let dropped = planes(factor);
            if dropped != best {
                is_found = is_within(&dropped);
                best = dropped;
            }
        }
        errors.extend(judge.stated(shown.in_frames(&best, all.clone())));
        of_tiers.push(best.clone());
        above = best;
    }
    for (tier, dropped) in (1..).zip(&of_tiers) {
        for (track, dropped) in levels.tracks.iter_mut().zip(dropped) {
            if let TrackForm::Moving { planes, .. } = &mut track.form {
                planes[tier] = *dropped;
            }
        }
    }
    errors
}
