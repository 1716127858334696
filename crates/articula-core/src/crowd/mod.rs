//! One frame of a crowd: clocks, culling, levels of detail, batches and palettes.
//!
//! Source: `docs/methods/motion-lod.md` parts 5 to 8, `docs/methods/runtime.md` parts 3 and 4.
//! [`Crowd::tick`] advances all clocks, reports events, culls, chooses a level for each character and
//! sorts the characters into batches; [`Crowd::tick_on`] does so on the caller's threads.
//! [`Crowd::evaluate`] writes the palettes of any range of batches and changes no state, so the
//! caller may distribute ranges over threads too. Results do not depend on the number of threads.
//!
//! - [`CrowdModel`]: the data that all characters share, made once
//! - [`CharacterState`], [`ClipState`]: the playback state of one character
//! - [`MorphClips`]: morph target weights of the clips, which [`Crowd::evaluate_morphs`] writes for
//!   characters near enough to show them; [`MorphLods`]: how many targets of a face are shown
//! - [`ClipEvent`], [`RootTrajectory`], [`attachment`]: events, root motion and attachments, which
//!   are never skipped, whatever the level and visibility of a character
//!
//! There is no hidden policy: [`Detail`] sets the tolerance of each frame, a [`Budget`] derives it
//! from measured times, and every change of level is an event ([`CrowdEvent::Level`]).
//!
//! # For an engine
//!
//! *Input*: positions, rotations, views, importance and time ([`Frame`]). *Output*: draws grouped
//! by level ([`Crowd::draw_list`]), palettes, events and root motion ([`Crowd::root_delta`]). What of
//! it a GPU reads is defined byte by byte in `docs/formats/crowd-buffers.md`.
//!
//! - **A plain renderer on wgpu** keeps one vertex buffer for each level's mesh and one storage
//!   buffer for all palettes. Each group is one instanced draw: the instance data is its world
//!   transform and [`Draw::first_matrix`], the vertex shader reads
//!   `palettes[first_matrix + joint]`. `evaluate` may write straight into a mapped buffer: it
//!   writes every byte once and in order. Weights of morph targets are a second storage buffer,
//!   and the index of a character's set in it is that of its draw ([`DrawList::with_morphs`]).
//!   Steps ([`DrawKind::Step`]) are drawn alike, with the cached palettes bound instead.
//! - **Bevy**: a system in `PostUpdate` fills [`Frame`] from `GlobalTransform` and the cameras'
//!   `Frustum`, ticks, spreads `evaluate` over the task pool, and hands the palettes to the render
//!   world as one buffer; no entity per joint is needed. Attachments write the `Transform` of
//!   attached entities.
//! - **three.js**: through WebAssembly; the palette of a character is what `Skeleton.boneMatrices`
//!   holds, transposed to columns, or the whole array is one `DataTexture` for an
//!   `InstancedMesh` whose shader reads `first_matrix` from an instanced attribute.

mod attachment;
mod budget;
mod character_state;
mod choosing;
mod clip_times;
mod clocks;
mod demand;
mod draws;
mod evaluate;
mod events;
mod frame;
mod keys;
mod learned_cost;
mod mode;
mod model;
mod morph_levels;
mod morph_lods;
mod morphs;
mod options;
mod parts;
mod places;
mod plan;
mod root_path;
mod section;
mod sources;
mod tick;
mod weights;
mod workload;

pub use crate::allowance::Allowance;
pub use attachment::attachment;
pub use budget::{Budget, BudgetReport, Sacrifice};
pub use character_state::{CharacterState, ClipState};
pub use clip_times::ClipTimes;
pub use draws::{CachedDraw, Draw, ImpostorDraw};
pub use events::ClipEvent;

pub(crate) use events::sorted as sorted_events;
pub use frame::{CacheUse, CrowdEvent, CrowdReport, Culling, Detail, Frame, Moved};
pub use model::CrowdModel;
pub(crate) use model::filled;
pub use morph_lods::MorphLods;
pub use morphs::MorphClips;
pub use parts::CrowdParts;
pub use plan::{DrawGroup, DrawList};
pub use root_path::{RootDelta, RootTrajectory};
pub use section::CrowdSection;
pub use sources::DrawKind;
pub use tick::Crowd;
pub use workload::Workload;
