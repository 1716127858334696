//! Crowds of one character: prepared once, updated and posed every frame.
//!
//! - [`CrowdAsset`]: a character with its joint and mesh LODs and their errors
//! - [`CrowdPlayer`]: a crowd of it, with all memory that a frame needs
//! - [`ScenePlayer`]: a crowd driven by a scene with positions, cameras, cross-fades, roles and walls;
//!   [`ParsedScene`]
//! - [`put_in_place`]: removes root motion from clips that travel
//! - [`CrowdBuffers`]: what a GPU reads in a frame, as bytes (`docs/formats/crowd-buffers.md`); [`wgsl`]:
//!   shaders that read them
//! - [`Budget`]: derives the tolerance of the next frame from measured times, for all crowds
//! - [`measure_scene`]: cost and error of a scene, by the clocks of the caller
//! - [`ErrorMeter`], [`LevelTally`]: measured screen errors and statistics of the levels in use
//!
//! The [crate page](crate) has an example.
//!
//! Characters near enough to show their faces get the weights of their morph targets
//! ([`CrowdPlayer::morph_weights`]), of as many targets as their tolerance needs; the errors of coarser
//! levels include that their faces rest.
//!
//! There is no clock and no thread here: the caller provides time steps, frame times in nanoseconds
//! and the threads that evaluate [`parts`](CrowdPlayer::parts).

mod asset;
mod baked_impostors;
mod budget_use;
mod buffer_manifest;
mod buffer_vertices;
mod buffers;
mod cache_places;
mod cached_draws;
mod draws;
mod face_levels;
mod figure_model;
mod frame_parts;
mod hidden;
#[cfg(feature = "flat")]
mod impostor_atlas;
#[cfg(feature = "flat")]
pub(crate) mod impostors;
mod in_place;
mod level_use;
mod lod_error;
mod material_ranges;
mod measure_options;
mod measured_scene;
mod mesh_choice;
pub(crate) mod mesh_lods;
mod morph_order;
mod morph_use;
mod named_events;
#[cfg(not(feature = "flat"))]
mod no_impostors;
mod options;
mod palette_hash;
mod palettes;
mod player;
pub(crate) mod preparation;
mod role_errors;
mod scene_cast;
mod scene_file;
mod scene_measurement;
mod scene_player;
mod scene_roles;
mod share;
mod shared_model;
mod spread;
mod timed_scene;
pub mod wgsl;

#[cfg(not(feature = "flat"))]
use no_impostors as impostors;

pub use asset::{CrowdAsset, CrowdLevel};
pub use baked_impostors::BakedImpostors;
pub use budget_use::{BudgetUse, Sacrificed};
pub use buffer_manifest::{
    BufferManifest, BufferSizes, DrawnManifest, EntryManifest, GroupManifest, LevelManifest,
    PartManifest,
};
pub use buffers::CrowdBuffers;
pub use cached_draws::PoseSource;
pub use draws::{InstancedDraw, Instances};
pub use figure_model::figure_model;
pub use frame_parts::FramePart;
pub use hidden::Hiders;
pub use in_place::put_in_place;
pub use level_use::{DrawCost, LevelStatistics, LevelTally, MeasuredError};
pub use lod_error::{
    CharacterError, ErrorMeter, ErrorSample, ErrorSummary, ErrorView, NEAR_METRES, PartsError,
};
pub use material_ranges::MaterialRange;
pub use measure_options::{FrameClocks, MeasureOptions};
pub use measured_scene::measure_scene;
pub use morph_use::{MorphLevelUse, MorphUse};
pub use named_events::events_by_clip;
pub use options::{CrowdOptions, JointLodMethod, PaletteMatrices, RootMotionPolicy};
pub use palette_hash::PaletteHash;
pub use palettes::PaletteSlice;
pub use player::CrowdPlayer;
pub use role_errors::RoleError;
pub use scene_cast::{CharacterEntry, MAX_CHARACTERS, MAX_VIEWS};
pub use scene_file::{MAX_MEMBERS, ParsedScene, write_scene};
pub use scene_measurement::{CrowdMemory, DISPLAY_HZ, FrameSummary, PoseUse, SceneMeasurement};
pub use scene_player::{DetailGoal, SceneOptions, ScenePlayer};
pub use spread::Spread;

pub use crate::mesh_levels::MAX_MESH_LEVELS;
pub use articula_core::crowd::{
    Allowance, Budget, BudgetReport, CacheUse, ClipEvent, Crowd, CrowdEvent, CrowdReport,
    CrowdSection, Culling, Detail, Draw, DrawKind, ImpostorDraw, Sacrifice,
};
pub use articula_core::visibility::View;
pub use articula_core::{Backend, Camera, ClipStorage, PaletteForm, Viewport};
