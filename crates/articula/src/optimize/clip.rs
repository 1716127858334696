//! Fewer keys and rounded values for one clip, at an error that is measured.

use super::OptimizeOptions;
use super::optimized_clip::OptimizedClip;
use super::source::Source;
use crate::error::{Context, Result};
use articula_build::clip_edit::{
    EditSubject, ReduceOptions, Timelines, reduce_keys, value_tolerances,
};
use articula_build::{PosedVertices, greatest_vertex_error};
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

/// The character whose clips are made smaller, and its mesh as it will be stored.
pub(super) struct Subject<'a> {
    source: &'a Source,
    wanted: PosedVertices<'a>,
    stored: PosedVertices<'a>,
    /// The vertices of both that refuse most trials.
    wanted_outermost: PosedVertices<'a>,
    stored_outermost: PosedVertices<'a>,
    subject: EditSubject<'a>,
}

impl<'a> Subject<'a> {
    pub(super) fn new(source: &'a Source, stored: &'a Source) -> Result<Self> {
        let character = source.body();
        let joints = Articulation::unmapped(character.skeleton.joints.len());
        let (wanted, stored) = (source.posed()?, stored.posed()?);
        let outermost = wanted.outermost();
        Ok(Self {
            source,
            wanted_outermost: wanted.of_vertices(&outermost),
            stored_outermost: stored.of_vertices(&outermost),
            wanted,
            stored,
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
        let clip = &self.source.character.clips[index];
        let kinds = match options.reduce_keys {
            true => &[Timelines::Shared, Timelines::Own][..],
            false => &[Timelines::Own],
        };
        let times_secs = self.time_step(clip, bound, options);
        let mut least = self.unchanged(index);
        let mut bytes = usize::MAX;
        for timelines in kinds {
            let found = self.within(clip, (bound, times_secs), *timelines, options);
            let found = found.with_context(|| format!("clip \"{}\"", clip.name))?;
            let needs =
                |c: &OptimizedClip| compressed_clip_bytes(&c.clip, &c.steps, options.compression);
            if let Some(found) = found.filter(|found| needs(found) < bytes) {
                (bytes, least) = (needs(&found), found);
            }
        }
        Ok(least)
    }

    /// The clip with all its keys, to the bit.
    pub(super) fn unchanged(&self, index: usize) -> OptimizedClip {
        OptimizedClip {
            clip: self.source.character.clips[index].clone(),
            steps: Vec::new(),
        }
    }

    /// The step of the times of keys by which the fastest motion of a clip errs by a share of the bound.
    fn time_step(&self, clip: &RawClip, bound: f32, options: &OptimizeOptions) -> f32 {
        let (mut from, mut to) = (self.wanted.clone(), self.wanted.clone());
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
            let wanted = (&mut from, Some(clip));
            let error = greatest_vertex_error(wanted, (&mut to, Some(&shown)), options.seed);
            if error <= TIME_SHARE * bound {
                break;
            }
            times_secs *= FINER;
        }
        times_secs
    }

    /// A clip whose error is within the bound and near it, if one was found.
    fn within(
        &self,
        clip: &RawClip,
        (bound, times_secs): (f32, f32),
        timelines: Timelines,
        options: &OptimizeOptions,
    ) -> Result<Option<OptimizedClip>> {
        let (mut from, mut to) = (self.wanted.clone(), self.stored.clone());
        let mut outermost = (self.wanted_outermost.clone(), self.stored_outermost.clone());
        let (mut scale, mut over) = (1.0f32, f32::INFINITY);
        let mut best: Option<(f32, OptimizedClip)> = None;
        let mut failures = 0;
        for turn in 0..TRIES + MORE_TRIES {
            if turn >= TRIES && best.is_some() {
                break;
            }
            let tried = self.tried(clip, (scale * bound, times_secs), timelines, options)?;
            let shown = rounded_clip(&tried.clip, &tried.steps);
            let wanted = (&mut outermost.0, Some(clip));
            let found = (&mut outermost.1, Some(&shown));
            let mut error = greatest_vertex_error(wanted, found, options.seed);
            if error <= bound {
                let wanted = (&mut from, Some(clip));
                error = greatest_vertex_error(wanted, (&mut to, Some(&shown)), options.seed);
            }
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
        Ok(best.map(|(_, best)| best))
    }

    fn tried(
        &self,
        clip: &RawClip,
        (bound, times_secs): (f32, f32),
        timelines: Timelines,
        options: &OptimizeOptions,
    ) -> Result<OptimizedClip> {
        let clip = if options.reduce_keys {
            let reduce = ReduceOptions {
                bound_metres: KEY_SHARE * bound,
                drop_rest: true,
                timelines,
            };
            reduce_keys(&self.subject, clip, &reduce)?.clip
        } else {
            clip.clone()
        };
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
