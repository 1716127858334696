//! Bytes of files that are not made, from some of their clips.

use super::OptimizeOptions;
use super::rounds::{Clips, with_rounded_mesh};
use super::source::{Shares, Source};
use crate::error::{Error, Result};
use crate::work::Executor;
use articula_core::source::RawClip;
use articula_formats::gltf::{BytesByKind, compressed_clip_bytes};

/// Bytes of a vertex that positions with a step twice as long save, and that weights of 8 bits save; the share of a file
/// above which they are tried.
const COARSER: f64 = 0.375;
const OF_WEIGHTS: f64 = 1.0;
const WORTH: f64 = 0.015;
/// Most clips that are made to choose by; a file with no more is made each way.
const MOST: usize = 12;

/// Whether a larger share of the error for the mesh may save what is worth a try, of a file of some bytes.
pub(super) fn may_save(source: &Source, is_finer: bool, bytes: f64) -> bool {
    let each = COARSER + if is_finer { OF_WEIGHTS } else { 0.0 };
    each * source.vertices() as f64 >= WORTH * bytes
}

/// Some clips of a file, evenly spread.
pub(super) struct Sample {
    clips: Vec<usize>,
    /// Numbers in the keys of all clips over those of the sample.
    scale: f64,
}

impl Sample {
    /// A sample of the clips of a file that has many, with many keys.
    pub(super) fn of(source: &Source) -> Option<Self> {
        let all = &source.character.clips;
        if all.len() <= MOST || Shares::of(&source.character) != Shares::OF_MOTION {
            return None;
        }
        let clips: Vec<usize> = (0..MOST).map(|i| i * all.len() / MOST).collect();
        let numbers = |clip: &RawClip| -> usize {
            clip.channels
                .iter()
                .map(|channel| channel.values.len())
                .sum()
        };
        let sampled: usize = clips.iter().map(|c| numbers(&all[*c])).sum();
        let whole: usize = all.iter().map(numbers).sum();
        (sampled > 0).then(|| Self {
            clips,
            scale: whole as f64 / sampled as f64,
        })
    }

    /// About the fewest bytes that meshes and keys need within a bound in metres, and the shares with which they do.
    pub(super) fn least(
        &self,
        source: &Source,
        bound: f32,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<(f64, Shares)> {
        let least = |shares| -> Result<(f64, Shares)> {
            Ok((self.bytes(source, (bound, shares), options, work)?, shares))
        };
        let motion = least(Shares::OF_MOTION)?;
        if !may_save(source, true, motion.0) {
            return Ok(motion);
        }
        let few = least(Shares::OF_FEW_KEYS)?;
        Ok(if few.0 < motion.0 { few } else { motion })
    }

    fn bytes(
        &self,
        source: &Source,
        bound: (f32, Shares),
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<f64> {
        let mut clips = Clips::new(source, bound.0, self.clips.clone());
        let bytes = with_rounded_mesh(
            source,
            &self.clips,
            bound,
            options,
            work,
            |references, precision| {
                clips.make(references, options, work)?;
                let glb = source.with_meshes(precision, options.compression)?;
                let keys = clips.made.iter().flatten();
                let keys = keys
                    .map(|of| compressed_clip_bytes(&of.clip, &of.steps, options.compression))
                    .sum::<usize>();
                let geometry = BytesByKind::of_glb(&glb).geometry as f64;
                Ok(Some(geometry + self.scale * keys as f64))
            },
        )?;
        bytes.ok_or_else(|| Error::unsuited("nothing was written"))
    }
}
