//! The file within a bound, which is written and measured until it holds.

use super::OptimizeOptions;
use super::Optimized;
use super::clip::Subject;
use super::errors::Errors;
use super::optimized_clip::OptimizedClip;
use super::report::OptimizeReport;
use super::shared_constants::share_constants;
use super::source::{MeshPrecision, Shares, Source};
use crate::error::{Error, Result};
use crate::work::Executor;

/// Number of times that a file is written more exactly where its error exceeds the bound.
const ROUNDS: usize = 8;
/// Number of times that meshes are rounded more finely.
const ROUNDS_OF_MESHES: usize = 4;
/// Rounds after which clips that still exceed it keep all their keys, and the share of the bound below
/// which they do at once.
const ROUNDS_OF_CLIPS: usize = 5;
const LEAST_SHARE: f32 = 1e-3;

/// Share of the bound that is asked for at the times that are measured: between them a vertex may be a little
/// farther off, as the judge of `docs/results/optimize.md` measures.
const MEASURED: f32 = 0.985;

/// Bytes of a vertex that positions with a step twice as long save, and that weights of 8 bits save; the share of a file
/// above which they are tried.
const COARSER: f64 = 0.375;
const OF_WEIGHTS: f64 = 1.0;
const WORTH: f64 = 0.015;
/// Steps within which held values become equal, in turn, in clips that are not within the bound.
const STEPS_OF_SHARING: [f32; 4] = [2.0, 1.0, 0.5, 0.0];

/// A file, and whether its mesh is more exact than its share of the error asks.
struct Attempt {
    made: Optimized,
    is_finer: bool,
}

/// The file in which no vertex is farther than a bound in metres from where it is in the source. Where the mesh is a large
/// part of it, with a smaller or a larger share of the error for the mesh, whichever needs fewer bytes.
pub(super) fn within(
    source: &Source,
    bound: f32,
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<Optimized> {
    let shares = Shares::of(&source.character);
    let first = attempt(source, (bound, shares), options, work)?;
    let each = COARSER + if first.is_finer { OF_WEIGHTS } else { 0.0 };
    let saved = each * source.vertices() as f64;
    if shares != Shares::OF_MOTION || saved < WORTH * first.made.glb.len() as f64 {
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
    let mut precision = MeshPrecision::chosen(source, bound, shares, options.compression)?;
    let mut mesh = source.with_rounded_mesh(&precision)?;
    for _ in 0..ROUNDS_OF_MESHES {
        if Errors::measured(source, &mesh, options, work)?.greatest() <= shares.motion * bound {
            break;
        }
        precision = precision.finer();
        mesh = source.with_rounded_mesh(&precision)?;
    }
    let mut clips: Vec<Option<OptimizedClip>> = vec![None; source.character.clips.len()];
    let mut allowed = vec![MEASURED * bound; clips.len()];
    for round in 0..ROUNDS {
        let in_motion = if round + 1 < ROUNDS {
            MEASURED * bound
        } else {
            bound
        };
        let open: Vec<usize> = (0..clips.len()).filter(|c| clips[*c].is_none()).collect();
        let subject = Subject::new(source, &mesh)?;
        let made = work.map("reducing keys", open, |c| {
            let is_reduced = round < ROUNDS_OF_CLIPS && allowed[c] > LEAST_SHARE * bound;
            let made = match is_reduced && !source.keeps_arrays() {
                true => subject.optimized(c, allowed[c], options)?,
                false => subject.unchanged(c),
            };
            Ok((c, made))
        })?;
        for (c, clip) in made {
            clips[c] = Some(clip);
        }
        let written: Vec<OptimizedClip> = clips.iter().flatten().cloned().collect();
        let glb = source.written(&written, &precision, options)?;
        let shown = source.read_again(&glb)?;
        let errors = Errors::measured(source, &shown, options, work)?;
        if errors.rest <= bound && errors.clips.iter().all(|clip| *clip <= in_motion) {
            let keys = Keys {
                source,
                clips: written,
                precision: &precision,
                most: in_motion,
            };
            let shared = keys.with_shared_constants(glb.len(), options, work)?;
            let (glb, report) = shared.unwrap_or_else(|| {
                let report = OptimizeReport::new(source, &keys.clips, &errors, &glb);
                (glb, report)
            });
            return Ok(Attempt {
                made: Optimized { glb, report },
                is_finer: precision.is_finer(),
            });
        }
        if errors.rest > bound || round >= 2 {
            precision = precision.finer();
            mesh = source.with_rounded_mesh(&precision)?;
        }
        for (c, error) in errors.clips.iter().enumerate() {
            if *error > in_motion {
                allowed[c] *= 0.95 * in_motion / error;
                clips[c] = None;
            }
        }
    }
    let what = format!("error: {} mm is finer than the file can keep", 1e3 * bound);
    Err(Error::unsuited(what))
}

/// Keys within a bound, and the mesh that they move.
struct Keys<'a> {
    source: &'a Source,
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
        let mut turns = vec![0; self.clips.len()];
        for _ in STEPS_OF_SHARING {
            let mut clips = self.clips.clone();
            let steps: Vec<f32> = turns.iter().map(|turn| STEPS_OF_SHARING[*turn]).collect();
            if share_constants(&mut clips, &steps) == 0 {
                return Ok(None);
            }
            let glb = self.source.written(&clips, self.precision, options)?;
            if glb.len() >= bytes {
                return Ok(None);
            }
            let shown = self.source.read_again(&glb)?;
            let errors = Errors::measured(self.source, &shown, options, work)?;
            if errors.clips.iter().all(|clip| *clip <= self.most) {
                let report = OptimizeReport::new(self.source, &clips, &errors, &glb);
                return Ok(Some((glb, report)));
            }
            for (turn, error) in turns.iter_mut().zip(&errors.clips) {
                *turn += usize::from(*error > self.most);
            }
        }
        Ok(None)
    }
}
