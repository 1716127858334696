//! What all characters of a crowd share: one rig with its clips, levels and their errors.

use super::events::{ClipEvent, sorted};
use super::root_path::RootTrajectory;
use crate::Mismatch;
use crate::attention::Attention;
use crate::batch::BatchEvaluator;
use crate::clip_set::ClipSet;
use crate::lod_error::{ClipLodErrors, LodErrors};
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
    pub errors: LodErrors,
    /// Where the skin is in each clip.
    pub bounds: MotionBounds,
    /// What is told while a clip plays, a list for each clip, in any order. Empty if there is
    /// nothing to tell; so are the two lists that follow.
    pub events: Vec<Vec<ClipEvent>>,
    /// The way over the ground that each clip carries its character.
    pub paths: Vec<Option<RootTrajectory>>,
    /// Stretches of each clip that a viewer looks at more closely, or less.
    pub attention: Vec<Option<Attention>>,
    /// Cached palettes of these clips, levels and matrices.
    pub cache: Option<PoseCache>,
}

/// What all characters of a crowd share. Read-only; one may serve many crowds and threads.
#[derive(Debug, Clone)]
pub struct CrowdModel {
    /// With an entry for each clip in each list.
    parts: CrowdParts,
    durations: Vec<f32>,
    /// Errors of all clips in one array, `levels` for each clip.
    lod_errors: Vec<f32>,
    /// Whether no clip has events or a path.
    plain: bool,
}

impl CrowdModel {
    /// Checks that the parts belong together.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the part that was made for something else, or the event that lies
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
        let errors = parts.errors.clips.iter();
        let no_event = parts.events.iter().all(Vec::is_empty);
        Ok(Self {
            lod_errors: errors.flat_map(ClipLodErrors::judged).collect(),
            plain: no_event && parts.paths.iter().all(Option::is_none),
            durations,
            parts,
        })
    }

    /// What it was made of: an entry for each clip in each list, events in the order of their times.
    #[inline]
    pub fn parts(&self) -> &CrowdParts {
        &self.parts
    }

    /// Number of levels.
    pub(crate) fn levels(&self) -> usize {
        self.parts.clips.joint_lods().levels()
    }

    /// The evaluator of its batches.
    pub fn evaluator(&self) -> BatchEvaluator<'_> {
        let parts = &self.parts;
        BatchEvaluator::checked(&parts.clips, &parts.palette, parts.form, parts.backend)
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
        &self.lod_errors[clip * levels..][..levels]
    }

    /// Whether nothing of a clip but its pose is to be told.
    #[inline]
    pub(crate) fn is_plain(&self) -> bool {
        self.plain
    }

    pub(crate) fn durations(&self) -> &[f32] {
        &self.durations
    }

    pub(crate) fn events(&self, clip: usize) -> &[ClipEvent] {
        &self.parts.events[clip]
    }

    pub(crate) fn path(&self, clip: usize) -> Option<&RootTrajectory> {
        self.parts.paths[clip].as_ref()
    }

    /// Whether any clip carries its character.
    pub(crate) fn has_paths(&self) -> bool {
        self.parts.paths.iter().any(Option::is_some)
    }

    /// Whether any clip has stretches that are looked at more closely, or less.
    pub(crate) fn has_attention(&self) -> bool {
        self.parts.attention.iter().any(Option::is_some)
    }

    pub(crate) fn attention(&self, clip: usize) -> Option<&Attention> {
        self.parts.attention[clip].as_ref()
    }
}

/// Gives each clip an entry, nothing where there is none at all.
fn filled<T: Clone + Default>(
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

/// Whether cached palettes are of these clips, levels and matrices.
fn check_cache(parts: &CrowdParts, cache: &PoseCache) -> Result<(), Mismatch> {
    let levels = parts.clips.joint_lods().levels();
    let of = |count, cached, what: &str| {
        (count != cached).then(|| format!("{cached} {what}, the model has {count}"))
    };
    let wrong = of(parts.clips.clips(), cache.clips(), "clips")
        .or_else(|| of(levels, cache.levels(), "levels"))
        .or_else(|| {
            (0..levels).find_map(|l| of(parts.palette.len(l), cache.matrices(l), "matrices"))
        })
        .or_else(|| (cache.form() != parts.form).then(|| "another form".to_owned()));
    match wrong {
        Some(what) => Err(Mismatch::new("cache", what)),
        None => Ok(()),
    }
}
