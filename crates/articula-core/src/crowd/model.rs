//! What all characters of a crowd share: one rig with its clips, levels and their errors.

use super::events::{ClipEvent, sorted};
use super::root_path::RootPath;
use crate::Mismatch;
use crate::attention::Attention;
use crate::batch::BatchEvaluator;
use crate::clip_set::ClipSet;
use crate::level_error::{ClipErrors, LevelErrors};
use crate::motion_bounds::MotionBounds;
use crate::palette::{PaletteForm, PaletteMap};
use crate::pose_cache::PoseCache;
use crate::simd::Backend;

/// The parts of a [`CrowdModel`], as their builders give them.
#[derive(Debug, Clone)]
pub struct CrowdParts {
    /// All clips in ladder order.
    pub clips: ClipSet,
    /// Which matrices evaluation writes.
    pub palette: PaletteMap,
    /// How they are written.
    pub form: PaletteForm,
    /// The instruction set; [`Backend::best`] unless results of two are to be compared.
    pub backend: Backend,
    /// What each level costs in each clip.
    pub errors: LevelErrors,
    /// Where the skin is in each clip.
    pub bounds: MotionBounds,
}

/// What all characters of a crowd share. Read-only; one may serve many crowds and threads.
#[derive(Debug, Clone)]
pub struct CrowdModel {
    clips: ClipSet,
    palette: PaletteMap,
    form: PaletteForm,
    backend: Backend,
    errors: LevelErrors,
    bounds: MotionBounds,
    cache: Option<PoseCache>,
    durations: Vec<f32>,
    /// Errors of all clips in one array, `levels` for each clip.
    level_errors: Vec<f32>,
    events: Vec<Vec<ClipEvent>>,
    paths: Vec<Option<RootPath>>,
    /// Whether no clip has events or a path.
    plain: bool,
    attention: Vec<Option<Attention>>,
}

impl CrowdModel {
    /// Checks that the parts belong together.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the part that was made for something else.
    pub fn new(parts: CrowdParts) -> Result<Self, Mismatch> {
        let CrowdParts {
            clips,
            palette,
            form,
            backend,
            errors,
            bounds,
        } = parts;
        BatchEvaluator::new(&clips, &palette, form, backend)?;
        let count = clips.clips();
        errors
            .check(count, clips.ladder().levels())
            .map_err(|e| Mismatch::new(format!("errors.{}", e.at), e.what))?;
        if bounds.clips.len() != count {
            let what = format!("{} entries for {count} clips", bounds.clips.len());
            return Err(Mismatch::new("bounds.clips", what));
        }
        if count > usize::from(u16::MAX) {
            return Err(Mismatch::new(
                "clips",
                format!("{count} clips, at most 65535"),
            ));
        }
        Ok(Self {
            level_errors: errors.clips.iter().flat_map(ClipErrors::judged).collect(),
            durations: (0..count).map(|c| clips.duration_secs(c)).collect(),
            events: vec![Vec::new(); count],
            paths: vec![None; count],
            plain: true,
            attention: vec![None; count],
            clips,
            palette,
            form,
            backend,
            errors,
            bounds,
            cache: None,
        })
    }

    /// The same with events on a clip, in any order.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no such clip, or an event lies outside it.
    pub fn with_events(mut self, clip: usize, events: &[ClipEvent]) -> Result<Self, Mismatch> {
        let at = self.clip("events", clip)?;
        self.events[at] = sorted(events, self.durations[at])
            .map_err(|e| Mismatch::new(format!("events[{clip}]{}", e.at), e.what))?;
        self.plain &= self.events[at].is_empty();
        Ok(self)
    }

    /// The same with the way over the ground that a clip carries its character.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no such clip.
    pub fn with_root_path(mut self, clip: usize, path: RootPath) -> Result<Self, Mismatch> {
        let at = self.clip("paths", clip)?;
        self.paths[at] = Some(path);
        self.plain = false;
        Ok(self)
    }

    /// The same with stretches of a clip that a viewer looks at more closely, or less.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no such clip.
    pub fn with_attention(mut self, clip: usize, attention: Attention) -> Result<Self, Mismatch> {
        let at = self.clip("attention", clip)?;
        self.attention[at] = Some(attention);
        Ok(self)
    }

    /// The same with cached palettes of this model.
    ///
    /// # Errors
    /// A [`Mismatch`] if the cache is of other clips, levels, palettes or of another form.
    pub fn with_cache(mut self, cache: PoseCache) -> Result<Self, Mismatch> {
        let levels = self.levels();
        let of = |count, cached, what: &str| {
            (count != cached).then(|| format!("{cached} {what}, the model has {count}"))
        };
        let wrong = of(self.clips.clips(), cache.clips(), "clips")
            .or_else(|| of(levels, cache.levels(), "levels"))
            .or_else(|| {
                (0..levels).find_map(|l| of(self.palette.len(l), cache.matrices(l), "matrices"))
            })
            .or_else(|| (cache.form() != self.form).then(|| "another form".to_owned()));
        if let Some(what) = wrong {
            return Err(Mismatch::new("cache", what));
        }
        self.cache = Some(cache);
        Ok(self)
    }

    fn clip(&self, which: &str, clip: usize) -> Result<usize, Mismatch> {
        if clip < self.clips.clips() {
            return Ok(clip);
        }
        let what = format!("there are {} clips", self.clips.clips());
        Err(Mismatch::new(format!("{which}[{clip}]"), what))
    }

    /// All clips in ladder order.
    pub fn clips(&self) -> &ClipSet {
        &self.clips
    }

    /// Which matrices evaluation writes.
    pub fn palette(&self) -> &PaletteMap {
        &self.palette
    }

    /// How they are written.
    pub fn form(&self) -> PaletteForm {
        self.form
    }

    /// What each level costs in each clip.
    pub fn errors(&self) -> &LevelErrors {
        &self.errors
    }

    /// Where the skin is in each clip.
    pub fn bounds(&self) -> &MotionBounds {
        &self.bounds
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.clips.ladder().levels()
    }

    /// The evaluator of its batches.
    pub fn evaluator(&self) -> BatchEvaluator<'_> {
        BatchEvaluator::checked(&self.clips, &self.palette, self.form, self.backend)
    }

    /// Error of a level in metres, as levels are chosen by it, while one clip plays, or while two
    /// are blended: the greater. Of a clip it is the greater of the 95th percentile over vertices
    /// and half of the worst vertex (`docs/metrics.md`).
    ///
    /// # Panics
    /// If there is no such clip or level.
    #[inline]
    pub fn error_metres(&self, from: usize, to: usize, level: usize) -> f32 {
        self.errors_of(from)[level].max(self.errors_of(to)[level])
    }

    /// Errors of the levels of a clip.
    #[inline]
    pub(crate) fn errors_of(&self, clip: usize) -> &[f32] {
        let levels = self.levels();
        &self.level_errors[clip * levels..][..levels]
    }

    /// Whether nothing of a clip but its pose is to be told.
    #[inline]
    pub(crate) fn is_plain(&self) -> bool {
        self.plain
    }

    /// Cached palettes, if there are any.
    pub fn cache(&self) -> Option<&PoseCache> {
        self.cache.as_ref()
    }

    /// The instruction set.
    pub fn backend(&self) -> Backend {
        self.backend
    }

    pub(crate) fn durations(&self) -> &[f32] {
        &self.durations
    }

    pub(crate) fn events(&self, clip: usize) -> &[ClipEvent] {
        &self.events[clip]
    }

    pub(crate) fn path(&self, clip: usize) -> Option<&RootPath> {
        self.paths[clip].as_ref()
    }

    /// Whether any clip carries its character.
    pub(crate) fn has_paths(&self) -> bool {
        self.paths.iter().any(Option::is_some)
    }

    /// Whether any clip has stretches that are looked at more closely, or less.
    pub(crate) fn has_attention(&self) -> bool {
        self.attention.iter().any(Option::is_some)
    }

    pub(crate) fn attention(&self, clip: usize) -> Option<&Attention> {
        self.attention[clip].as_ref()
    }
}
