//! A mesh that is rounded, and clips that are made with it, again where they err too much.

use super::OptimizeOptions;
use super::clip::Subject;
use super::errors::Errors;
use super::optimized_clip::OptimizedClip;
use super::references::References;
use super::source::{MeshPrecision, Shares, Source};
use crate::error::Result;
use crate::work::Executor;

/// Number of times that a file is written more exactly where its error exceeds the bound.
pub(super) const ROUNDS: usize = 8;
/// Number of times that meshes are rounded more finely.
const ROUNDS_OF_MESHES: usize = 4;
/// Rounds after which clips that still exceed it keep all their keys, and the share of the bound below
/// which they do at once.
const ROUNDS_OF_CLIPS: usize = 5;
const LEAST_SHARE: f32 = 1e-3;

/// Share of the bound that is asked for at the times that are measured: between them a vertex may be a little
/// farther off, as the judge of `docs/results/optimize.md` measures.
pub(super) const MEASURED: f32 = 0.985;

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
    pub(super) bound: f32,
    pub(super) made: Vec<Option<OptimizedClip>>,
    /// Those that are to be made.
    open: Vec<usize>,
    /// What each clip may err by.
    allowed: Vec<f32>,
    pub(super) round: usize,
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
    pub(super) fn allow_less(&mut self, errors: &Errors, most: f32) {
        for (c, error) in errors.clips.iter().enumerate() {
            if *error > most {
                self.allowed[c] *= 0.95 * most / error;
                self.open.push(c);
            }
        }
    }
}
