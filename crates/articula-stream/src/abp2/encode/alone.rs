//! Steps and planes where each track moves one point and each point has one track, as in a face
//! stream: each is searched for itself, all at the same time.
//!
//! Form: `docs/formats/afp2.md`, part 5.

use super::quantise::{Coding, Levels};
use super::search::{BACK, Judge};
use super::skin_points::{SkinError, Sums};
use super::truth::Truth;
use crate::abp2::pose_unit::{MOST_PLANES, MOST_TIERS, TrackForm};
use articula_core::Libm;
use articula_core::Mismatch;

/// Halvings of the interval of a step.
const HALVINGS: usize = 10;
/// Steps that are tried, as factors of the one that alone moves the point by the tolerance.
const FACTORS: [f64; 2] = [0.05, 8.0];
/// Attempts to take back what halving missed; each makes steps a little smaller.
const ATTEMPTS: usize = 600;

/// Greatest error of each planned track at its point, and of all.
struct Errors {
    of_track: Vec<f64>,
    all: SkinError,
}

fn errors(coding: &Coding<'_>, judge: &Judge<'_>, shown: &Truth) -> Errors {
    let mut of_point = vec![0.0_f64; judge.some.points.len()];
    let mut sums = Sums::default();
    let frames = 0..judge.truth.frames;
    judge.quick().distances(shown, frames, |point, distance| {
        of_point[point] = of_point[point].max(distance);
        sums.add(distance);
    });
    let targets = coding.planned.iter();
    Errors {
        of_track: targets.map(|t| of_point[usize::from(t.target)]).collect(),
        all: sums.error(),
    }
}

/// Searches the greatest step of each track with an error within the tolerance.
///
/// # Errors
/// If a value is too large for the form, or cannot be coded within the tolerance.
pub(super) fn finest(
    coding: &Coding<'_>,
    tolerance: f64,
    judge: &Judge<'_>,
) -> Result<(Levels, Truth, SkinError), Mismatch> {
    let levers = coding.planned.iter().map(|track| track.lever);
    let alone: Vec<f64> = levers.map(|lever| tolerance / lever).collect();
    let quantise = |factors: &[f64]| {
        let steps = alone.iter().zip(factors);
        coding.quantise(
            &steps
                .map(|(step, factor)| step * factor)
                .collect::<Vec<_>>(),
        )
    };
    let [low, high] = FACTORS.map(Libm::libm_ln);
    let mut bounds = vec![(low, high); alone.len()];
    for _ in 0..HALVINGS {
        let middle: Vec<f64> = bounds.iter().map(|(l, h)| (l + h) / 2.0).collect();
        let factors: Vec<f64> = middle.iter().map(|m| m.libm_exp()).collect();
        let (_, shown) = quantise(&factors)?;
        let found = errors(coding, judge, &shown).of_track;
        for ((bounds, error), middle) in bounds.iter_mut().zip(found).zip(middle) {
            if error <= tolerance {
                bounds.0 = middle;
            } else {
                bounds.1 = middle;
            }
        }
    }
    let mut factors: Vec<f64> = bounds.iter().map(|(low, _)| low.libm_exp()).collect();
    for _ in 0..ATTEMPTS {
        let (levels, shown) = quantise(&factors)?;
        let found = errors(coding, judge, &shown);
        if found.all.max_metres <= tolerance {
            return Ok((levels, shown, found.all));
        }
        let pairs = factors.iter_mut().zip(found.of_track);
        for (factor, _) in pairs.filter(|(_, error)| *error > tolerance) {
            *factor *= BACK;
        }
    }
    let what = format!("cannot be coded within {tolerance} m; give a greater tolerance");
    Err(Mismatch::new("the motion", what))
}

/// Searches the most planes that each track can drop at each tier, and writes them into the tracks.
/// Returns the error of each tier.
pub(super) fn tiers(
    coding: &Coding<'_>,
    levels: &mut Levels,
    (start, error): (&Truth, SkinError),
    judge: &Judge<'_>,
    tolerance: f64,
) -> Vec<SkinError> {
    let mut of_tiers = vec![error];
    let mut dropped = vec![0_u8; levels.tracks.len()];
    for tier in 1..coding.head.tiers {
        let limit = tolerance * 3_f64.powi(tier as i32);
        let may_drop = |track| !coding.head.is_exact(track);
        let mut open: Vec<bool> = levels.tracks.iter().map(may_drop).collect();
        while open.contains(&true) {
            for (planes, open) in dropped.iter_mut().zip(&mut open) {
                *open &= *planes < MOST_PLANES;
                *planes += u8::from(*open);
            }
            let shown = coding.shown(levels, &dropped, start);
            let found = errors(coding, judge, &shown).of_track;
            for ((planes, open), error) in dropped.iter_mut().zip(&mut open).zip(found) {
                if *open && error > limit {
                    *planes -= 1;
                    *open = false;
                }
            }
        }
        let shown = coding.shown(levels, &dropped, start);
        of_tiers.push(errors(coding, judge, &shown).all);
        for (track, dropped) in levels.tracks.iter_mut().zip(&dropped) {
            if let TrackForm::Moving { planes, .. } = &mut track.form {
                planes[tier..MOST_TIERS.min(coding.head.tiers)].fill(*dropped);
            }
        }
    }
    of_tiers
}
