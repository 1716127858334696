//! A clip as the camera sees it: projected triangles with their light, and what is known of
//! them before anything is written.
//!
//! Source: thesis 4.2, `docs/methods/vector.md` 2 to 7.
//!
//! - [`PlanarSubject`]: who is shown; [`bake()`] skins, projects and lights it into a [`PlanarClip`]:
//!   places and light of every vertex in every frame
//! - [`PlanarSubject::bounds`], [`PlanarSubject::camera`], [`PlanarSubject::seen`]: where a moving subject is, and
//!   which of its triangles are ever seen
//! - [`OrderOptions`]: in which order triangles are painted, in epochs; [`OrderComparison`]: what
//!   stays wrong
//! - [`Shading`]: one gradient for each triangle, or one colour
//! - [`SplitOptions`]: how triangles that pass through each other are cut
//! - [`reference()`]: the supersampled Gouraud picture that every output is measured against
//! - [`PlanarError`]: what can be wrong with a clip that is to be converted
//!
//! Inside stand `drawn`, which triangles are seen in which frames; `underlap`, how edges reach
//! under what is painted later, so that no gap shows; and `keyed_clip`, few keys instead of every
//! frame.

mod bake;
pub(crate) mod clip;
pub(crate) mod drawn;
mod error;
#[cfg(test)]
mod fixture;
pub(crate) mod key_frames;
pub(crate) mod keyed_clip;
mod merge;
mod moving_gradient;
pub(crate) mod order;
pub(crate) mod reference;
pub(crate) mod shading;
pub(crate) mod split;
mod stage;
mod subject;
mod tunnel;
pub(crate) mod underlap;
mod vertex_colors;

pub use bake::{BakeOptions, Lighting, Turntable, bake, bake_shapes};
pub use clip::{MAX_FRAMES, MAX_TRIANGLES, PlanarClip, PlanarFrame, PlanarMaterial};
pub(crate) use drawn::Drawn;
pub use error::PlanarError;
pub(crate) use order::{Epoch, Painting};
pub use order::{OrderComparison, OrderOptions};
pub use reference::{object_mask, reference};
pub use shading::Shading;
pub use split::SplitOptions;
pub use subject::PlanarSubject;
