//! The FRAME line of a crowd: clocks, views, levels, batches, palettes.
//!
//! Source: `docs/methods/motion-lod.md` parts 5 to 8, `docs/methods/runtime.md` parts 3 and 4. [`Crowd::tick`]
//! does what is cheap and serial: it runs every clock on, tells the events, looks who is seen,
//! chooses a level for each and sorts them into batches. [`Crowd::evaluate`] writes palettes for
//! any range of batches and changes nothing, so the caller may give ranges to its threads.
//!
//! - [`CrowdModel`]: what all share, made once
//! - [`CharacterState`], [`ClipState`]: what one character plays
//! - [`ClipEvent`], [`RootTrajectory`], [`attachment`]: what is never skipped, whatever is shown
//!
//! No hidden policy: what a level may cost is in [`Detail`], and every change of level is told.
//!
//! # For an engine
//!
//! *In* go places, views, importance and time ([`Frame`]); *out* come draws grouped by level
//! ([`Crowd::drawn`]), palettes, events and root steps.
//!
//! - **A plain renderer on wgpu** keeps one vertex buffer for each level's mesh and one storage
//!   buffer for all palettes. Each group is one instanced draw: the instance's data is its place
//!   and [`Draw::first_matrix`], the vertex shader reads `palettes[first_matrix + joint]`.
//!   `evaluate` may write straight into a mapped buffer: it writes every byte once, in order.
//! - **Bevy**: a system in `PostUpdate` fills [`Frame`] from `GlobalTransform` and the cameras'
//!   `Frustum`, ticks, spreads `evaluate` over the task pool, and hands the palettes to the
//!   render world as one buffer; no entity for each joint is needed. Sockets write the
//!   `Transform` of attached entities.
//! - **three.js**: through WebAssembly; the palette of a character is what `Skeleton.boneMatrices`
//!   holds, transposed to columns, or the whole array is one `DataTexture` for an
//!   `InstancedMesh` whose shader reads `first_matrix` from an instanced attribute.

mod attachment;
mod character_state;
mod crowd_budget;
mod events;
mod frame;
mod level;
mod model;
mod plan;
mod root_path;
mod share;
mod tick;

pub use attachment::attachment;
pub use character_state::{CharacterState, ClipState};
pub use events::ClipEvent;
pub use frame::{CacheUse, CrowdEvent, CrowdReport, Culling, Detail, Frame};
pub use model::{CrowdModel, CrowdParts};
pub use plan::{Draw, DrawGroup, DrawList, RecordGroup};
pub use root_path::{RootDelta, RootTrajectory};
pub use tick::Crowd;
