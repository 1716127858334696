//! The file within a bound, which is written and measured until it holds.

use super::OptimizeOptions;
use super::Optimized;
use super::clip::Subject;
use super::errors::Errors;
use super::optimized_clip::OptimizedClip;
use super::references::References;
use super::report::OptimizeReport;
use super::sample::Sample;
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
    if let (Some(sample), Shares::OF_MOTION) = (Sample::of(source), shares) {
        let (_, shares) = sample.least(source, bound, options, work)?;
        return Ok(attempt(source, (bound, shares), options, work)?.made);
    }
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

/// Whether a larger share of the error for the mesh may save what is worth a try, of a file of some bytes.
pub(super) fn may_save(source: &Source, is_finer: bool, bytes: f64) -> bool {
    let each = COARSER + if is_finer { OF_WEIGHTS } else { 0.0 };
    each * source.vertices() as f64 >= WORTH * bytes
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
            let made = clips.file(references, precision, options, work)?;
            let is_finer = precision.is_finer();
            Ok(made.map(|made| Attempt { made, is_finer }))
        },
    )?;
    made.ok_or_else(|| {
        let what = format!("error: {} mm is finer than the file can keep", 1e3 * bound);
        Error::unsuited(what)
    })
}

/// Makes something of the mesh that is rounded as its share of a bound allows in some clips; of a more exact one where
/// nothing is made. `None` if nothing is made of the most exact one.
pub(super) fn with_rounded_mesh<T>(
    source: &Source,
    clips: &[usize],
    (bound, shares): (f32, Shares),
    options: &OptimizeOptions,
    work: &Executor<'_>,
    mut make: impl FnMut(&References<'_>, &MeshPrecision) -> Result<Option<T>>,
) -> Result<Option<T>> {
    let mut precision = MeshPrecision::chosen(source, bound, shares, options.compression)?;
    let mut checks = 0;
    for _ in 0..ROUNDS + ROUNDS_OF_MESHES {
        let mesh = source.with_rounded_mesh(&precision)?;
        let references = References::new(source, &mesh, clips, options, work)?;
        let is_within = references.greatest() <= shares.motion * bound;
        if is_within || checks == ROUNDS_OF_MESHES {
            checks = ROUNDS_OF_MESHES;
            if let Some(made) = make(&references, &precision)? {
                return Ok(Some(made));
            }
        } else {
            checks += 1;
        }
        precision = precision.finer();
    }
    Ok(None)
}

/// The clips of a file, made again where their error exceeds what is allowed.
pub(super) struct Clips {
    bound: f32,
    pub(super) made: Vec<Option<OptimizedClip>>,
    /// Those that are to be made.
    open: Vec<usize>,
    /// What each clip may err by.
    allowed: Vec<f32>,
    round: usize,
}

impl Clips {
    /// Those with these indices.
    pub(super) fn new(source: &Source, bound: f32, open: Vec<usize>) -> Self {
        let count = source.character.clips.len();
        Self {
            bound,
            made: vec![None; count],
            open,
            allowed: vec![MEASURED * bound; count],
            round: 0,
        }
    }

    /// The file with a stored mesh, made until its error is within the bound; `None` where the mesh must be more exact.
    fn file(
        &mut self,
        references: &References<'_>,
        precision: &MeshPrecision,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Option<Optimized>> {
        let source = references.source;
        while self.round < ROUNDS {
            self.make(references, options, work)?;
            let most = match self.round + 1 < ROUNDS {
                true => MEASURED * self.bound,
                false => self.bound,
            };
            let written: Vec<OptimizedClip> = self.made.iter().flatten().cloned().collect();
            let glb = source.written(&written, precision, options)?;
            let errors = references.errors_of(&source.read_again(&glb)?, options, work)?;
            if errors.rest <= self.bound && errors.clips.iter().all(|clip| *clip <= most) {
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
            self.allow_less(&errors, most);
            self.round += 1;
            if errors.rest > self.bound || self.round > 2 {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Makes the clips that are open.
    pub(super) fn make(
        &mut self,
        references: &References<'_>,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<()> {
        let subject = Subject::new(references)?;
        let is_reducible = self.round < ROUNDS_OF_CLIPS && !references.source.keeps_arrays();
        let open = std::mem::take(&mut self.open);
        let made = work.map("reducing keys", open, |c| {
            let is_reduced = is_reducible && self.allowed[c] > LEAST_SHARE * self.bound;
            let made = match is_reduced {
                true => subject.optimized(c, self.allowed[c], options)?,
                false => subject.unchanged(c),
            };
            Ok((c, made))
        })?;
        for (c, clip) in made {
            self.made[c] = Some(clip);
        }
        Ok(())
    }

    /// Opens the clips whose error is above the greatest that is allowed.
    fn allow_less(&mut self, errors: &Errors, most: f32) {
        for (c, error) in errors.clips.iter().enumerate() {
            if *error > most {
                self.allowed[c] *= 0.95 * most / error;
                self.open.push(c);
            }
        }
    }
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
