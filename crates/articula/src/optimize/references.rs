//! The clips of a source as a stored mesh shows them, beside which their versions are measured.

use super::OptimizeOptions;
use super::errors::Errors;
use super::source::Source;
use crate::error::Result;
use crate::work::Executor;
use articula_build::{PosedVertices, ReferenceClip, greatest_vertex_error};
use articula_core::source::RawClip;

/// Bytes of clips that are kept between measurements; more are posed each time.
const MAX_BYTES: usize = 512 << 20;

/// The clips of a source, and its mesh as it is stored.
pub(super) struct References<'a> {
    pub(super) source: &'a Source,
    wanted: PosedVertices<'a>,
    stored: PosedVertices<'a>,
    /// Error of the stored mesh at rest in metres.
    rest: f32,
    /// Clips that are kept.
    clips: Vec<Option<ReferenceClip<'a>>>,
    /// The greatest error of the stored mesh in the clips that were asked for, in metres.
    in_clips: f32,
    seed: u64,
}

impl<'a> References<'a> {
    /// Poses the clips with these indices.
    pub(super) fn new(
        source: &'a Source,
        stored: &'a Source,
        clips: &[usize],
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Self> {
        let (wanted, stored) = (source.posed()?, stored.posed()?);
        let at_rest = (&mut wanted.clone(), &mut stored.clone());
        let rest = greatest_vertex_error((at_rest.0, None), (at_rest.1, None), options.seed);
        let (mut bytes, all) = (0, &source.character.clips);
        let clips = clips.iter().map(|c| {
            bytes += ReferenceClip::bytes(&wanted, &stored, &all[*c]);
            (*c, bytes <= MAX_BYTES)
        });
        let made = work.map("measuring the error", clips.collect(), |(c, is_kept)| {
            let reference = ReferenceClip::new(&wanted, &stored, &all[c], options.seed);
            Ok((c, reference.rounding(), is_kept.then_some(reference)))
        })?;
        let mut in_clips = 0.0f32;
        let mut clips = vec![None; all.len()];
        for (c, rounding, kept) in made {
            in_clips = in_clips.max(rounding);
            clips[c] = kept;
        }
        Ok(Self {
            source,
            wanted,
            stored,
            rest,
            clips,
            in_clips,
            seed: options.seed,
        })
    }

    /// The greatest error of the stored mesh, at rest and in the clips that were asked for as they are, in metres.
    pub(super) fn greatest(&self) -> f32 {
        self.rest.max(self.in_clips)
    }

    /// Measures versions of a clip, which is posed anew if it was not kept.
    pub(super) fn measured<T>(
        &self,
        index: usize,
        measure: impl FnOnce(&ReferenceClip<'a>) -> T,
    ) -> T {
        match &self.clips[index] {
            Some(kept) => measure(kept),
            None => measure(&ReferenceClip::new(
                &self.wanted,
                &self.stored,
                self.clip(index),
                self.seed,
            )),
        }
    }

    /// A clip as the source has it.
    pub(super) fn clip(&self, index: usize) -> &'a RawClip {
        &self.source.character.clips[index]
    }

    /// Errors of a written file.
    pub(super) fn errors_of(
        &self,
        shown: &Source,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Errors> {
        let has_all = shown.character.clips.len() == self.clips.len();
        if !has_all || !shown.posed()?.moves_as(&self.stored) {
            return Errors::measured(self.source, shown, options, work);
        }
        let clips: Vec<usize> = (0..self.clips.len()).collect();
        let clips = work.map("measuring the error", clips, |c| {
            let version = &shown.character.clips[c];
            Ok(self.measured(c, |clip| clip.greatest_error(version)))
        })?;
        Ok(Errors {
            rest: self.rest,
            clips,
        })
    }
}
