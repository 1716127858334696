//! The file within a bound, which is written and measured until it holds.

use super::OptimizeOptions;
use super::Optimized;
use super::optimized_clip::OptimizedClip;
use super::references::References;
use super::report::OptimizeReport;
use super::rounds::{Clips, MEASURED, ROUNDS, with_rounded_mesh};
use super::sample::{Sample, may_save};
use super::shared_constants::share_constants;
use super::source::{MeshPrecision, Shares, Source};
use crate::error::{Error, Result};
use crate::work::Executor;

/// Steps within which held values become equal, in turn, in clips that are not within the bound.
const STEPS_OF_SHARING: [f32; 4] = [2.0, 1.0, 0.5, 0.0];

/// A file, and whether its mesh is more exact than its share of the error asks.
struct Attempt {
    made: Optimized,
    is_finer: bool,
}

/// The file in which no vertex is farther than a bound in metres from where it is in the source. Unless the shares of the
/// error are known, and where the mesh is a large part of the file, with a smaller or a larger share for the mesh,
/// whichever needs fewer bytes.
pub(super) fn within(
    source: &Source,
    (bound, known): (f32, Option<Shares>),
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<Optimized> {
    let sampled = match (known, Sample::of(source)) {
        (None, Some(sample)) => Some(sample.least(source, bound, options, work)?.1),
        _ => known,
    };
    if let Some(shares) = sampled {
        return Ok(attempt(source, (bound, shares), options, work)?.made);
    }
    let shares = Shares::of(&source.character);
    let first = attempt(source, (bound, shares), options, work)?;
    let bytes = first.made.glb.len() as f64;
    if shares != Shares::OF_MOTION || !may_save(source, first.is_finer, bytes) {
        return Ok(first.made);
    }
    let other = attempt(source, (bound, Shares::OF_FEW_KEYS), options, work)?.made;
    Ok(match other.glb.len() < first.made.glb.len() {
        true => other,
        false => first.made,
    })
}

/// The same with shares of the error for the mesh.
fn attempt(
    source: &Source,
    (bound, shares): (f32, Shares),
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<Attempt> {
    let all: Vec<usize> = (0..source.character.clips.len()).collect();
    let mut clips = Clips::new(source, bound, all.clone());
    let made = with_rounded_mesh(
        source,
        &all,
        (bound, shares),
        options,
        work,
        |references, precision| {
            let made = file(&mut clips, references, precision, options, work)?;
            let is_finer = precision.is_finer();
            Ok(made.map(|made| Attempt { made, is_finer }))
        },
    )?;
    made.ok_or_else(|| {
        let what = format!("error: {} mm is finer than the file can keep", 1e3 * bound);
        Error::unsuited(what)
    })
}

/// The file with a stored mesh, made until its error is within the bound; `None` where the mesh must be more exact.
fn file(
    clips: &mut Clips,
    references: &References<'_>,
    precision: &MeshPrecision,
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<Option<Optimized>> {
    let source = references.source;
    while clips.round < ROUNDS {
        clips.make(references, options, work)?;
        let most = match clips.round + 1 < ROUNDS {
            true => MEASURED * clips.bound,
            false => clips.bound,
        };
        let written: Vec<OptimizedClip> = clips.made.iter().flatten().cloned().collect();
        let glb = source.written(&written, precision, options)?;
        let errors = references.errors_of(&source.read_again(&glb)?, options, work)?;
        if errors.rest <= clips.bound && errors.clips.iter().all(|clip| *clip <= most) {
            let keys = Keys {
                references,
                clips: written,
                precision,
                most,
            };
            let shared = keys.with_shared_constants(glb.len(), options, work)?;
            let (glb, report) = shared.unwrap_or_else(|| {
                let report = OptimizeReport::new(source, &keys.clips, &errors, &glb);
                (glb, report)
            });
            return Ok(Some(Optimized { glb, report }));
        }
        clips.allow_less(&errors, most);
        clips.round += 1;
        if errors.rest > clips.bound || clips.round > 2 {
            return Ok(None);
        }
    }
    Ok(None)
}

/// Keys within a bound, and the mesh that they move.
struct Keys<'a> {
    references: &'a References<'a>,
    clips: Vec<OptimizedClip>,
    precision: &'a MeshPrecision,
    /// The greatest error of a clip.
    most: f32,
}

impl Keys<'_> {
    /// The file with values that several clips hold, if it is within the bound and has fewer bytes than `bytes`. Clips
    /// that are not within it keep theirs.
    fn with_shared_constants(
        &self,
        bytes: usize,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Option<(Vec<u8>, OptimizeReport)>> {
        let source = self.references.source;
        let mut turns = vec![0; self.clips.len()];
        for _ in STEPS_OF_SHARING {
            let mut clips = self.clips.clone();
            let steps: Vec<f32> = turns.iter().map(|turn| STEPS_OF_SHARING[*turn]).collect();
            if share_constants(&mut clips, &steps) == 0 {
                return Ok(None);
            }
            let glb = source.written(&clips, self.precision, options)?;
            if glb.len() >= bytes {
                return Ok(None);
            }
            let errors = self
                .references
                .errors_of(&source.read_again(&glb)?, options, work)?;
            if errors.clips.iter().all(|clip| *clip <= self.most) {
                let report = OptimizeReport::new(source, &clips, &errors, &glb);
                return Ok(Some((glb, report)));
            }
            for (turn, error) in turns.iter_mut().zip(&errors.clips) {
                *turn += usize::from(*error > self.most);
            }
        }
        Ok(None)
    }
}
