//! Data shared by all characters of a crowd: one rig with its clips, levels and their errors.

use super::clip_times::ClipTimes;
use super::events::{ClipEvent, sorted};
use super::frame::CacheUse;
use super::morphs::MorphClips;
use super::options::{CostOf, OptionLists};
use super::parts::CrowdParts;
use super::root_path::RootTrajectory;
use crate::Mismatch;
use crate::attention::Attention;
use crate::batch::BatchEvaluator;
use crate::lod_error::ClipLodErrors;
use crate::pose_cache::PoseCache;

/// Data shared by all characters of a crowd. Read-only; one model may serve many crowds and
/// threads.
#[derive(Debug, Clone)]
pub struct CrowdModel {
    /// With an entry for each clip in each list.
    parts: CrowdParts,
    durations: Vec<f32>,
    /// Errors of all clips in one array, `levels` for each clip.
    lod_errors: Vec<f32>,
    /// Options of the clips without a cache, with one blended on the CPU, and on the GPU; chosen by the cost
    /// of the frame, and by that of the processor.
    options: [[OptionLists; 3]; 2],
}

impl CrowdModel {
    /// Checks that the parts belong together.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the part that does not fit the others, or the event that lies
    /// outside its clip.
    pub fn new(mut parts: CrowdParts) -> Result<Self, Mismatch> {
        let (clips, errors) = (&parts.clips, &parts.errors);
        BatchEvaluator::new(clips, &parts.palette, parts.form, parts.backend)?;
        let count = clips.clips();
        errors
            .check(count, clips.joint_lods().levels())
            .map_err(|e| Mismatch::new(format!("errors.{}", e.at), e.what))?;
        if parts.bounds.clips.len() != count {
            let what = format!("{} entries for {count} clips", parts.bounds.clips.len());
            return Err(Mismatch::new("bounds.clips", what));
        }
        let levels = clips.joint_lods().levels();
        if !parts.triangles.is_empty() && parts.triangles.len() != levels {
            let what = format!("{} entries for {levels} levels", parts.triangles.len());
            return Err(Mismatch::new("triangles", what));
        }
        if count > usize::from(u16::MAX) {
            return Err(Mismatch::new(
                "clips",
                format!("{count} clips, at most 65535"),
            ));
        }
        filled("events", &mut parts.events, count)?;
        filled("paths", &mut parts.paths, count)?;
        filled("attention", &mut parts.attention, count)?;
        let durations: Vec<f32> = (0..count).map(|c| parts.clips.duration_secs(c)).collect();
        for (c, events) in parts.events.iter_mut().enumerate() {
            *events = sorted(events, durations[c])
                .map_err(|e| Mismatch::new(format!("events[{c}]{}", e.at), e.what))?;
        }
        if let Some(cache) = &parts.cache {
            check_cache(&parts, cache)?;
        }
        if let Some(morphs) = parts.morphs.as_ref().filter(|m| m.clips() != count) {
            let what = format!("{} entries for {count} clips", morphs.clips());
            return Err(Mismatch::new("morphs", what));
        }
        if let Some(impostors) = parts.impostors.as_ref().filter(|i| i.clips() != count) {
            let what = format!("{} entries for {count} clips", impostors.clips());
            return Err(Mismatch::new("impostors", what));
        }
        let errors = parts.errors.clips.iter();
        let lod_errors: Vec<f32> = errors.flat_map(ClipLodErrors::judged).collect();
        let uses = [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu];
        Ok(Self {
            options: [CostOf::Frame, CostOf::Processor].map(|cost| {
                uses.map(|cache_use| OptionLists::new(&parts, &lod_errors, cache_use, cost))
            }),
            lod_errors,
            durations,
            parts,
        })
    }

    /// The parts, with an entry for each clip in each list and events in the order of their times.
    #[inline]
    pub fn parts(&self) -> &CrowdParts {
        &self.parts
    }

    /// Number of levels.
    pub(crate) fn levels(&self) -> usize {
        self.parts.clips.joint_lods().levels()
    }

    /// Returns the evaluator of batches of this model.
    pub fn evaluator(&self) -> BatchEvaluator<'_> {
        let parts = &self.parts;
        BatchEvaluator::checked(&parts.clips, &parts.palette, parts.form, parts.backend)
    }

    /// LOD error of a level in metres; while two clips are blended, the larger of the two. For one
    /// clip it is the larger of the 95th percentile over vertices and half of the maximum
    /// (`docs/metrics.md`).
    ///
    /// # Panics
    /// If there is no such clip or level.
    #[inline]
    pub fn error_metres(&self, from: usize, to: usize, level: usize) -> f32 {
        self.errors_of(from)[level].max(self.errors_of(to)[level])
    }

    /// Error of a morph level in metres, as [`error_metres`](Self::error_metres) is that of a level; 0 if
    /// no clip moves morph targets.
    ///
    /// # Panics
    /// If there is no such clip or morph level.
    #[inline]
    pub fn morph_error_metres(&self, from: usize, to: usize, morph_level: usize) -> f32 {
        let lods = self.parts.morphs.as_ref().map(MorphClips::lods);
        lods.map_or(0.0, |lods| {
            lods.errors_metres(from)[morph_level].max(lods.errors_metres(to)[morph_level])
        })
    }

    /// Whether the faces of a level rest at a morph level although the level shows morph targets.
    #[inline]
    pub(crate) fn is_at_rest(&self, level: usize, morph_level: usize) -> bool {
        let morphs = self.parts.morphs.as_ref();
        morphs.is_some_and(|m| level < m.levels() && m.lods().count(morph_level) == 0)
    }

    /// LOD errors of all levels in a clip.
    #[inline]
    pub(crate) fn errors_of(&self, clip: usize) -> &[f32] {
        let levels = self.levels();
        &self.lod_errors[clip * levels..][..levels]
    }

    /// Options of all clips for a use of the cache.
    #[inline]
    pub(crate) fn options(&self, cache_use: CacheUse, by_processor: bool) -> &OptionLists {
        &self.options[usize::from(by_processor)][cache_use as usize]
    }

    pub(crate) fn durations(&self) -> &[f32] {
        &self.durations
    }

    /// Whether any clip has root motion.
    pub(crate) fn has_paths(&self) -> bool {
        self.parts.paths.iter().any(Option::is_some)
    }

    /// Number of levels that show morph targets, from the finest on, and of targets.
    pub(crate) fn morphs(&self) -> (usize, usize) {
        let morphs = self.parts.morphs.as_ref();
        morphs.map_or((0, 0), |m| (m.levels(), m.targets()))
    }

    /// Whether any clip has attention intervals.
    pub(crate) fn has_attention(&self) -> bool {
        self.parts.attention.iter().any(Option::is_some)
    }

    pub(crate) fn attention(&self, clip: usize) -> Option<&Attention> {
        self.parts.attention[clip].as_ref()
    }
}

impl ClipTimes for CrowdModel {
    fn clip_count(&self) -> usize {
        self.durations.len()
    }

    fn clip_secs(&self, clip: usize) -> f32 {
        self.durations[clip]
    }

    fn clip_events(&self, clip: usize) -> &[ClipEvent] {
        &self.parts.events[clip]
    }

    fn clip_path(&self, clip: usize) -> Option<&RootTrajectory> {
        self.parts.paths[clip].as_ref()
    }
}

/// Fills an empty list with a default entry for each clip, and checks the length of others.
pub(crate) fn filled<T: Clone + Default>(
    at: &str,
    entries: &mut Vec<T>,
    clips: usize,
) -> Result<(), Mismatch> {
    if entries.is_empty() {
        entries.resize(clips, T::default());
    }
    if entries.len() != clips {
        let what = format!("{} entries for {clips} clips", entries.len());
        return Err(Mismatch::new(at, what));
    }
    Ok(())
}

/// Checks that cached palettes were made for these clips, levels and matrices.
fn check_cache(parts: &CrowdParts, cache: &PoseCache) -> Result<(), Mismatch> {
    let levels = parts.clips.joint_lods().levels();
    let of = |count, cached, what: &str| {
        (count != cached).then(|| format!("the cache has {cached} {what}, the model has {count}"))
    };
    let wrong = of(parts.clips.clips(), cache.clips(), "clips")
        .or_else(|| of(levels, cache.levels(), "levels"))
        .or_else(|| {
            (0..levels).find_map(|l| of(parts.palette.len(l), cache.matrices(l), "matrices"))
        })
        .or_else(|| {
            (cache.form() != parts.form)
                .then(|| "the cache stores another palette form than the model".to_owned())
        });
    match wrong {
        Some(what) => Err(Mismatch::new("cache", what)),
        None => Ok(()),
    }
}
