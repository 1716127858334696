//! Fewer keys and rounded values for one clip, at an error that is measured.

use super::OptimizeOptions;
use super::optimized_clip::OptimizedClip;
use super::references::References;
use crate::error::{Context, Result};
use articula_build::ReferenceClip;
use articula_build::clip_edit::{
    EditSubject, KeyReduction, ReduceOptions, Timelines, value_tolerances,
};
use articula_core::Articulation;
use articula_core::source::RawClip;
use articula_formats::gltf::{KeySteps, compressed_clip_bytes, rounded_clip};

/// Parts of the error for keys and for the rounding of each value. Errors of a chain of joints add up, in
/// part; the sum is measured, and the parts are scaled until it is near the bound.
const KEY_SHARE: f32 = 0.8;
const VALUE_SHARE: f32 = 0.5;
/// Number of scales that are tried, the share of the bound that each aims at, and what is near enough.
const TRIES: usize = 6;
/// Further tries where no scale was within the bound, and the scale after two that were not: what rounded meshes have of the
/// bound is left when keys become more exact, so in proportion to the error it would fall too slowly.
const MORE_TRIES: usize = 4;
const FALL: f32 = 0.5;
const AIM: f32 = 0.96;
const NEAR: f32 = 0.92;
/// The first step of the times of keys, in seconds; the share of the bound that rounding them may take;
/// the factor by which the step becomes finer, and how often it may.
const TIME_STEP: f32 = 1.0 / 8192.0;
const TIME_SHARE: f32 = 0.1;
const FINER: f32 = 0.25;
const FINEST: usize = 8;

/// How a clip is made within a bound.
struct Tries<'a> {
    bound: f32,
    times_secs: f32,
    timelines: Timelines,
    /// `None` where it has all its keys.
    keys: Option<&'a KeyReduction<'a>>,
}

/// The character whose clips are made smaller, and its clips as its stored mesh shows them.
pub(super) struct Subject<'a> {
    references: &'a References<'a>,
    subject: EditSubject<'a>,
}

impl<'a> Subject<'a> {
    pub(super) fn new(references: &'a References<'a>) -> Result<Self> {
        let character = references.source.body();
        let joints = Articulation::unmapped(character.skeleton.joints.len());
        Ok(Self {
            references,
            subject: EditSubject::new(character, joints, &[])?,
        })
    }

    /// The clip with the fewest bytes that was found within a bound in metres.
    pub(super) fn optimized(
        &self,
        index: usize,
        bound: f32,
        options: &OptimizeOptions,
    ) -> Result<OptimizedClip> {
        let clip = self.references.clip(index);
        let kinds = match options.reduce_keys {
            true => &[Timelines::Shared, Timelines::Own][..],
            false => &[Timelines::Own],
        };
        let times_secs = self.time_step(index, bound);
        let mut least = self.unchanged(index);
        let (mut bytes, mut scale) = (usize::MAX, 1.0);
        let keys = options.reduce_keys;
        let keys = keys.then(|| KeyReduction::new(&self.subject, clip));
        let keys = keys.transpose()?;
        for timelines in kinds {
            let tries = Tries {
                bound,
                times_secs,
                timelines: *timelines,
                keys: keys.as_ref(),
            };
            let within = |clip: &ReferenceClip<'_>| self.within(clip, &tries, scale);
            let found = self.references.measured(index, within);
            let found = found.with_context(|| format!("clip \"{}\"", clip.name))?;
            let needs =
                |c: &OptimizedClip| compressed_clip_bytes(&c.clip, &c.steps, options.compression);
            if let Some((found_at, found)) = found {
                scale = found_at;
                if needs(&found) < bytes {
                    (bytes, least) = (needs(&found), found);
                }
            }
        }
        Ok(least)
    }

    /// The clip with all its keys, to the bit.
    pub(super) fn unchanged(&self, index: usize) -> OptimizedClip {
        OptimizedClip {
            clip: self.references.clip(index).clone(),
            steps: Vec::new(),
        }
    }

    /// The step of the times of keys by which the fastest motion of a clip errs by a share of the bound.
    fn time_step(&self, index: usize, bound: f32) -> f32 {
        let clip = self.references.clip(index);
        let reference = self.references.measured(index, ReferenceClip::on_source);
        let mut times_secs = TIME_STEP;
        for _ in 0..FINEST {
            let steps = KeySteps {
                values: 0.0,
                times_secs,
            };
            let mut shown = rounded_clip(clip, &vec![steps; clip.channels.len()]);
            for (shown, channel) in shown.channels.iter_mut().zip(&clip.channels) {
                shown.values.clone_from(&channel.values);
            }
            if reference.greatest_error(&shown) <= TIME_SHARE * bound {
                break;
            }
            times_secs *= FINER;
        }
        times_secs
    }

    /// A clip whose error is within the bound and near it, if one was found, and the scale of its parts of the bound, which
    /// is sought from one that was found before.
    fn within(
        &self,
        reference: &ReferenceClip<'_>,
        tries: &Tries<'_>,
        mut scale: f32,
    ) -> Result<Option<(f32, OptimizedClip)>> {
        let bound = tries.bound;
        let mut over = f32::INFINITY;
        let mut best: Option<(f32, OptimizedClip)> = None;
        let mut failures = 0;
        for turn in 0..TRIES + MORE_TRIES {
            if turn >= TRIES && best.is_some() {
                break;
            }
            let tried = self.tried(reference.clip(), tries, scale * bound)?;
            let error = reference.greatest_error(&rounded_clip(&tried.clip, &tried.steps));
            let ratio = (AIM * bound / error.max(1e-3 * bound)).clamp(0.25, 2.0);
            if error > bound {
                over = over.min(scale);
                failures += 1;
            } else {
                best = Some((scale, tried));
                if error >= NEAR * bound {
                    break;
                }
            }
            scale = match &best {
                None if failures > 1 => scale * ratio.min(FALL),
                None => scale * ratio,
                Some((under, _)) if over.is_finite() => 0.5 * (under + over),
                Some((under, _)) => under * ratio,
            };
        }
        Ok(best)
    }

    fn tried(&self, clip: &RawClip, tries: &Tries<'_>, bound: f32) -> Result<OptimizedClip> {
        let reduce = ReduceOptions {
            bound_metres: KEY_SHARE * bound,
            drop_rest: true,
            timelines: tries.timelines,
        };
        let clip = match tries.keys {
            Some(keys) => keys.reduced(&reduce)?.clip,
            None => clip.clone(),
        };
        let times_secs = tries.times_secs;
        let values = value_tolerances(&self.subject, &clip, VALUE_SHARE * bound)?;
        let steps = values
            .into_iter()
            .map(|values| KeySteps { values, times_secs });
        Ok(OptimizedClip {
            steps: steps.collect(),
            clip,
        })
    }
}
