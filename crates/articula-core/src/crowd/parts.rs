//! The parts that a crowd's model is made of.

use super::events::ClipEvent;
use super::morphs::MorphClips;
use super::root_path::RootTrajectory;
use crate::attention::Attention;
use crate::clip_set::ClipSet;
use crate::impostors::Impostors;
use crate::lod_error::LodErrors;
use crate::motion_bounds::MotionBounds;
use crate::palette::{PaletteForm, PaletteMap};
use crate::pose_cache::PoseCache;
use crate::simd::Backend;

/// The parts of a [`CrowdModel`](super::CrowdModel), each from its own builder.
#[derive(Debug, Clone)]
pub struct CrowdParts {
    /// All clips of the rig, laid out in LOD order.
    pub clips: ClipSet,
    /// Matrices that evaluation writes.
    pub palette: PaletteMap,
    /// Format of these matrices.
    pub form: PaletteForm,
    /// Instruction set of the kernels; [`Backend::best`] unless backends are compared.
    pub backend: Backend,
    /// LOD errors of each level in each clip.
    pub errors: LodErrors,
    /// Triangles that each level draws; empty where all draw the same.
    pub triangles: Vec<u32>,
    /// Bounds of the skin in each clip.
    pub bounds: MotionBounds,
    /// Events of each clip, in any order. Empty if no clip has events; the two lists below may be
    /// empty likewise.
    pub events: Vec<Vec<ClipEvent>>,
    /// Root motion of each clip.
    pub paths: Vec<Option<RootTrajectory>>,
    /// Intervals of each clip that tolerate less error than usual, or more.
    pub attention: Vec<Option<Attention>>,
    /// Cached palettes of these clips, levels and matrices.
    pub cache: Option<PoseCache>,
    /// Impostors of these clips, which the renderer draws; `None` without.
    pub impostors: Option<Impostors>,
    /// Morph target weights of these clips; `None` if the faces of all levels rest.
    pub morphs: Option<MorphClips>,
}

impl CrowdParts {
    /// Parts without events, root motion, attention intervals, cache, impostors and morph targets, with
    /// palettes of whole matrices and the kernels of the best [`Backend`].
    pub fn new(
        clips: ClipSet,
        palette: PaletteMap,
        errors: LodErrors,
        bounds: MotionBounds,
    ) -> Self {
        Self {
            clips,
            palette,
            form: PaletteForm::Matrix,
            backend: Backend::best(),
            errors,
            triangles: Vec::new(),
            bounds,
            events: Vec::new(),
            paths: Vec::new(),
            attention: Vec::new(),
            cache: None,
            impostors: None,
            morphs: None,
        }
    }
}
