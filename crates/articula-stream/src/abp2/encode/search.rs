//! The steps of all tracks within a tolerance, and the planes that coarser tiers drop.
//!
//! Form: `docs/methods/motion-stream.md`, parts 5 and 6.

use super::levers::{Mover, Rest, levers, shares};
use super::near_points::NearPoints;
use super::plan::PlannedTrack;
use super::quantise::{Coding, Levels};
use super::skin_points::{Measure, SkinError, SkinPoints};
use super::truth::Truth;
use crate::abp2::pose_unit::{MOST_PLANES, MOST_TIERS, TrackForm};
use articula_core::Libm;
use articula_core::{Mismatch, Rig};
use glam::Vec3;
use std::cell::{Cell, OnceCell};

/// Halvings of the interval of a factor.
const HALVINGS: usize = 9;
/// Factors of all steps that are tried, in tolerances.
const FACTORS: [f64; 2] = [0.05, 8.0];
/// Factors of the planes of a tier, by its tolerance.
const TIER_FACTORS: [f64; 2] = [0.02, 4.0];
/// Most places of points that are kept, 192 MB.
const MOST_PLACES: usize = 1 << 24;
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

/// The points of the search with their true places, and all points.
pub(super) struct Judge<'a> {
    pub(super) rig: &'a Rig,
    pub(super) truth: &'a Truth,
    pub(super) all: &'a SkinPoints,
    pub(super) some: SkinPoints,
    pub(super) shown: Vec<Vec3>,
    /// The true places of all points, frame by frame, once they were measured; empty if they are too many.
    pub(super) all_shown: OnceCell<Vec<Vec3>>,
    /// All points by their neighbours.
    pub(super) near: NearPoints,
    /// Whether the errors of tiers are measured at all points.
    pub(super) states_errors: bool,
    /// The first of the frames in which a motion was beyond its limit.
    pub(super) worst_frame: Cell<usize>,
}

impl Judge<'_> {
    /// Measures at the points of the search.
    pub(super) fn quick(&self) -> Measure<'_> {
        Measure {
            rig: self.rig,
            points: &self.some,
            truth: self.truth,
            shown: Some(&self.shown),
        }
    }

    /// Whether no point of the search is farther than `limit` from its place.
    fn seems_within(&self, motion: &Truth, limit: f64) -> bool {
        let measure = self.quick();
        let some = |start: usize| start..self.truth.frames.min(start + FRAMES);
        let is_within = |start| measure.error_in(motion, some(start)).max_metres <= limit;
        // Where the last motion was beyond its limit, this one is too if it is anywhere, as a rule.
        let starts = (0..self.truth.frames).step_by(FRAMES);
        let first = starts
            .clone()
            .find(|start| *start == self.worst_frame.get());
        let mut starts = first.into_iter().chain(starts);
        match starts.find(|start| !is_within(*start)) {
            Some(start) => {
                self.worst_frame.set(start);
                false
            }
            None => true,
        }
    }

    /// The farthest point of each frame in which one of all points is farther than `limit` from its place.
    fn beyond(&self, motion: &Truth, limit: f64) -> impl Iterator<Item = usize> {
        let (mut right, mut found) = (self.all.posed(self.rig), self.all.posed(self.rig));
        (0..self.truth.frames).filter_map(move |frame| {
            self.truth.pose(frame, &mut right.local);
            motion.pose(frame, &mut found.local);
            self.all.turn(self.rig, &mut right);
            self.all.turn(self.rig, &mut found);
            let right = (&right, self.truth.weights(frame));
            let found = (&found, motion.weights(frame));
            self.near.farthest(self.all, right, found, limit)
        })
    }

    /// Error at all points; `None` if it is not asked for.
    fn stated(&self, motion: &Truth) -> Option<SkinError> {
        if !self.states_errors {
            return None;
        }
        let places = self.all.len().saturating_mul(self.truth.frames);
        let shown = self.all_shown.get_or_init(|| match places {
            0..=MOST_PLACES => self.all.shown(self.rig, self.truth),
            _ => Vec::new(),
        });
        let measure = Measure {
            rig: self.rig,
            points: self.all,
            truth: self.truth,
            shown: (!shown.is_empty()).then_some(shown),
        };
        Some(measure.error(motion))
    }
}

/// Searches the greatest steps with an error within the tolerance at all points. `refine` makes a
/// judge whose search includes further points.
pub(super) fn finest<'a>(
    coding: &Coding<'_>,
    shares: &[f64],
    tolerance: f64,
    judge: &mut Judge<'a>,
    refine: impl Fn(&[usize]) -> (SkinPoints, Vec<Vec3>),
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
            if judge.seems_within(&shown, tolerance) {
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
            (judge.some, judge.shown) = refine(&added);
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
        let mut best = above.clone();
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            let dropped = planes(middle.libm_exp());
            let shown = coding.shown(levels, &dropped, start);
            if judge.seems_within(&shown, limit) {
                (low, best) = (middle, dropped);
            } else {
                high = middle;
            }
        }
        let mut factor = low.libm_exp();
        let mut shown = coding.shown(levels, &best, start);
        let mut is_within = judge.beyond(&shown, limit).next().is_none();
        while !is_within && best != above {
            factor *= 0.9;
            let dropped = planes(factor);
            if dropped != best {
                best = dropped;
                shown = coding.shown(levels, &best, start);
                is_within = judge.beyond(&shown, limit).next().is_none();
            }
        }
        for (track, dropped) in levels.tracks.iter_mut().zip(&best) {
            if let TrackForm::Moving { planes, .. } = &mut track.form {
                planes[tier..MOST_TIERS.min(coding.head.tiers)].fill(*dropped);
            }
        }
        errors.extend(judge.stated(&shown));
        above = best;
    }
    errors
}
