//! How the character of a crowd is prepared.

use articula_core::loa::LoaExpression;
use articula_core::{Backend, ClipStorage, PaletteForm};

/// Which joint LODs a crowd has.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum JointLodMethod {
    /// Every joint, and nothing else.
    Whole,
    /// Joints are merged in the order that costs the skin least in the character's own clips; at
    /// most eight levels, the coarsest of eight joints.
    #[default]
    Merged,
    /// Every joint, and the joints that an expression names, such as `loa(Low) + zone(hands)`.
    Named(LoaExpression),
}

/// Which matrices are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PaletteMatrices {
    /// Of each joint that a level keeps, in model space, without the inverse bind matrix.
    Joints,
    /// Of each binding of the level's mesh, with the inverse bind matrix: what a vertex shader
    /// multiplies vertices with.
    #[default]
    Skin,
}

/// What becomes of clips that carry their character over the ground.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RootMotion {
    /// They travel, and jump back when they begin again.
    AsAuthored,
    /// They are played on the spot.
    #[default]
    OnTheSpot,
    /// They are played on the spot, and every frame tells the way of each character
    /// ([`Crowd::root_delta`](articula_core::crowd::Crowd::root_step)).
    Extracted,
}

/// How a character is prepared for crowds.
///
/// ```
/// use articula::crowd::{CrowdOptions, JointLodMethod, PaletteMatrices};
///
/// let options = CrowdOptions { mesh_levels: 4, ..CrowdOptions::default() };
/// assert_eq!(options.joints, JointLodMethod::Merged);
/// assert_eq!(options.matrices, PaletteMatrices::Skin);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdOptions {
    /// Names of the clips that are played, in the order of the file; empty: all.
    pub clips: Vec<String>,
    /// What becomes of clips that travel.
    pub root_motion: RootMotion,
    /// Joint LODs.
    pub joints: JointLodMethod,
    /// LODs of the mesh, chosen together with those of the joints, the original counted, at most
    /// [`MAX_MESH_LEVELS`](super::MAX_MESH_LEVELS); with 1 everyone has the original.
    pub mesh_levels: usize,
    /// Which matrices a palette holds.
    pub matrices: PaletteMatrices,
    /// How they are written.
    pub form: PaletteForm,
    /// How clips are held in memory.
    pub storage: ClipStorage,
    /// Whether poses are cached; needs [`PaletteMatrices::Skin`] and a form of matrices.
    pub pose_cache: bool,
    /// Instruction set; all give the same bits.
    pub backend: Backend,
    /// Seed of the choice of vertices and frames that errors are measured on.
    pub seed: u64,
}

impl Default for CrowdOptions {
    /// All clips on the spot, merged joints, the original mesh; skinning matrices of three rows
    /// of 32-bit floats, no cache.
    fn default() -> Self {
        Self {
            clips: Vec::new(),
            root_motion: RootMotion::default(),
            joints: JointLodMethod::default(),
            mesh_levels: 1,
            matrices: PaletteMatrices::default(),
            form: PaletteForm::Matrix,
            storage: ClipStorage::Float,
            pose_cache: false,
            backend: Backend::best(),
            seed: 1,
        }
    }
}
