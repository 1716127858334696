//! A clip projected to the screen: triangles with light, visibility and painting order, before
//! anything is written.
//!
//! Source: thesis 4.2, `docs/methods/vector.md` 2 to 7.
//!
//! - [`PlanarSubject`]: the character that is shown; [`bake()`] skins, projects and lights it into
//!   a [`PlanarClip`]: position and light of every vertex in every frame
//! - [`PlanarTexture`]: a picture that triangles of a clip show
//! - [`PlanarSubject::bounds`], [`PlanarSubject::camera`], [`PlanarSubject::seen`]: bounds, camera
//!   placement and visible triangles of a moving subject
//! - [`OrderOptions`]: painting order in epochs; [`OrderComparison`]: wrong pixels of each ordering
//!   method
//! - [`Shading`]: one gradient per triangle, or one colour
//! - [`SplitOptions`]: how intersecting triangles are cut
//! - [`reference()`]: the supersampled Gouraud picture that every output is measured against
//! - [`PlanarError`]: errors of the conversion
//!
//! Private modules: `drawn` finds the visible triangles of each frame; `underlap` moves edges under
//! neighbours that are painted later, so that no gap shows; `keyed_clip` stores a few keys instead
//! of every frame.

mod atlas;
mod bake;
mod changing_color;
pub(crate) mod clip;
mod contrast;
pub(crate) mod drawn;
mod error;
mod fan;
mod few_colors;
#[cfg(test)]
pub(crate) mod fixture;
pub(crate) mod key_frames;
pub(crate) mod keyed_clip;
pub(crate) mod keyed_motion;
mod keyed_track;
mod merge;
mod moving_gradient;
mod neighbours;
pub(crate) mod order;
mod pull;
pub(crate) mod reference;
pub(crate) mod shading;
pub(crate) mod shared_motion;
mod small_shapes;
pub(crate) mod source_picture;
pub(crate) mod split;
mod stage;
mod subject;
mod texture;
mod tunnel;
pub(crate) mod underlap;
mod vertex_colors;

pub use atlas::textured;
pub use bake::{BakeOptions, Lighting, Turntable, bake, bake_shapes};
pub use clip::{MAX_FRAMES, MAX_TRIANGLES, PlanarClip, PlanarFrame, PlanarMaterial};
pub use contrast::color_contrast;
pub(crate) use drawn::Drawn;
pub use error::PlanarError;
pub(crate) use order::{Epoch, Painting};
pub use order::{OrderComparison, OrderOptions};
pub use reference::reference;
pub use shading::Shading;
pub use split::SplitOptions;
pub use subject::PlanarSubject;
pub use texture::PlanarTexture;
