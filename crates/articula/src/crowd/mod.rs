//! Crowds of one character: prepared once, played every frame.
//!
//! - [`CrowdAsset`]: the character with its joint and mesh LODs and what each costs the viewer
//! - [`CrowdPlayer`]: a crowd of it, with all the memory that a frame needs
//! - [`ScenePlayer`]: the same as a scene says: places, cameras, cross-fades; [`read_scene`]
//! - [`put_in_place`]: clips that carry their character away, on the spot
//! - [`BudgetController`]: what a frame may spend, learnt from what frames took
//! - [`ErrorMeter`], [`LevelTally`]: what is shown against what should be, and who is shown how
//!
//! An example is on the [first page](crate).
//!
//! Nothing here has a clock, a thread or a policy of its own: time steps, the nanoseconds that
//! frames took and the threads that evaluate [`parts`](CrowdPlayer::parts) are the caller's.

mod asset;
mod budget;
mod in_place;
mod level_use;
mod lod_error;
mod mesh_lods;
mod options;
mod palette_hash;
mod palettes;
mod player;
mod scene_file;
mod scene_player;

pub use asset::{CrowdAsset, CrowdLevel};
pub use budget::{BudgetController, FrameBudget};
pub use in_place::put_in_place;
pub use level_use::{DrawCost, LevelTally, LevelUse, MeasuredError};
pub use lod_error::{CharacterError, ErrorMeter, ErrorSample, ErrorSummary, NEAR_METRES};
pub use mesh_lods::MAX_MESH_LEVELS;
pub use options::{CrowdOptions, JointLodMethod, PaletteMatrices, RootMotion};
pub use palette_hash::PaletteHash;
pub use palettes::PaletteSlice;
pub use player::{CrowdGroup, CrowdPlayer, FramePart, PoseSource};
pub use scene_file::{MAX_MEMBERS, read_scene, write_scene};
pub use scene_player::{DetailGoal, SceneOptions, ScenePlayer};

pub use articula_core::crowd::{CacheUse, Crowd, CrowdEvent, CrowdReport, Culling, Detail, Draw};
pub use articula_core::visibility::View;
pub use articula_core::{Backend, Camera, ClipStorage, PaletteForm, Viewport};
