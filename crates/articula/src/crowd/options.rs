//! Options of crowd preparation.

use super::baked_impostors::BakedImpostors;
use articula_build::CacheOptions;
use articula_core::crowd::ClipEvent;
use articula_core::loa::LoaExpression;
use articula_core::{Backend, ClipStorage, PaletteForm};

/// Method by which joint LODs are made.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum JointLodMethod {
    /// Full detail only.
    Whole,
    /// Joints are merged in the order that minimises skin error in the character's own clips; up to
    /// eight levels, the coarsest with eight joints.
    #[default]
    Merged,
    /// Full detail, and one level with the joints selected by an expression such as `loa(Low) +
    /// zone(hands)`.
    Named(LoaExpression),
}

/// Kind of matrices in a palette: model-space joint matrices or skinning matrices.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PaletteMatrices {
    /// One per joint of the level, in model space, without the inverse bind matrix.
    Joints,
    /// One per binding of the level's mesh, inverse bind matrix included: the matrices of a vertex
    /// shader.
    #[default]
    Skin,
}

/// Treatment of clips with root motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RootMotionPolicy {
    /// The character travels, and jumps back when the clip repeats.
    AsAuthored,
    /// Root motion is removed.
    #[default]
    OnTheSpot,
    /// Root motion is removed from the clip and reported per character and frame
    /// ([`Crowd::root_delta`](articula_core::crowd::Crowd::root_delta)).
    Extracted,
}

/// Options of [`CrowdAsset::new`](super::CrowdAsset::new).
///
/// ```
/// use articula::crowd::{CrowdOptions, JointLodMethod, PaletteMatrices};
///
/// let options = CrowdOptions { mesh_levels: Some(1), ..CrowdOptions::default() };
/// assert_eq!(options.joints, JointLodMethod::Merged);
/// assert_eq!(options.matrices, PaletteMatrices::Skin);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdOptions {
    /// Names of the clips to be played, in the order of the file; empty for all. Levels that a file stores serve each
    /// choice of its clips, in place ([`RootMotionPolicy`]); else they are made for those chosen.
    pub clips: Vec<String>,
    /// Events of clips, each with the name of its clip, which is one of those played.
    pub events: Vec<(String, ClipEvent)>,
    /// Treatment of clips with root motion.
    pub root_motion: RootMotionPolicy,
    /// Method by which joint LODs are made.
    pub joints: JointLodMethod,
    /// Maximum number of mesh levels, the original included, at most
    /// [`MAX_MESH_LEVELS`](super::MAX_MESH_LEVELS); they are chosen together with the joint LODs.
    /// They are those of the file unless it has none or more, else those of
    /// [`MeshLevelOptions::levels`](crate::MeshLevelOptions::levels). With 1 all levels use the original
    /// mesh. `None`: with merged joints those of the file, or, of a file that is not prepared,
    /// [`MeshLevelOptions::for_crowds`](crate::MeshLevelOptions::for_crowds); else the original mesh.
    /// Without the feature `prepare`, files that store no levels show the original mesh.
    pub mesh_levels: Option<usize>,
    /// Kind of matrices in a palette.
    pub matrices: PaletteMatrices,
    /// Data layout of a palette.
    pub form: PaletteForm,
    /// Memory layout of clips.
    pub storage: ClipStorage,
    /// Whether poses are cached, if the palettes are [`PaletteMatrices::Skin`] in a form of matrices.
    pub pose_cache: bool,
    /// Maximum size of the cached palettes in bytes.
    pub cache_bytes: usize,
    /// Impostors for who is far away, if the character has a mesh; they are shown where their error is
    /// within the tolerance and cached poses may be ([`CacheUse`](super::CacheUse)). With pitches that
    /// leave some out, the errors hold only for eyes within them, which a frame does not check.
    #[cfg(feature = "flat")]
    pub impostors: Option<articula_flat::impostor::ImpostorOptions>,
    /// Impostors of this character that were baked before, in place of choosing them. Their errors are those
    /// of their table: errors at points that they show are not measured.
    pub baked_impostors: Option<BakedImpostors>,
    /// Instruction set; all produce the same bits.
    pub backend: Backend,
    /// Seed of the vertices and frames on which errors are measured.
    pub seed: u64,
}

impl Default for CrowdOptions {
    /// All clips in place, merged joints with mesh levels, skinning matrices of three rows of 32-bit floats,
    /// and cached poses of at most 32 MB.
    fn default() -> Self {
        Self {
            clips: Vec::new(),
            events: Vec::new(),
            root_motion: RootMotionPolicy::default(),
            joints: JointLodMethod::default(),
            mesh_levels: None,
            matrices: PaletteMatrices::default(),
            form: PaletteForm::Matrix,
            storage: ClipStorage::Float,
            pose_cache: true,
            cache_bytes: CacheOptions::default().palette_bytes,
            #[cfg(feature = "flat")]
            impostors: None,
            baked_impostors: None,
            backend: Backend::best(),
            seed: 1,
        }
    }
}
