//! A clip as the camera sees it: projected triangles with their light, and what is known of
//! them before anything is written.
//!
//! Source: thesis 4.2, `spec/vector.md` 2 to 7.
//!
//! - [`clip`]: the noun, places and light of every vertex in every frame
//! - [`bake`]: skins, projects and lights a character into it
//! - `vertex_colors`: what it gives vertices, so that their blends show the texture
//! - [`stage`]: where a moving subject is, and which of its triangles are ever seen
//! - [`drawn`]: which triangles are seen in which frames
//! - [`mod@reference`]: the supersampled Gouraud picture that every output is measured against
//! - [`order`]: in which order triangles are painted, in epochs, and what stays wrong
//! - [`underlap`]: edges that reach under what is painted later, so that no gap shows
//! - [`shading`]: one gradient for each triangle
//! - [`low_rank`]: a table of numbers as its mean row and a few components
//! - [`mod@split`]: cuts triangles that pass through each other
//! - [`mod@merge`]: regions of triangles of nearly one colour
//! - [`key_frames`]: few keys instead of every frame
//! - [`error`]: what can be wrong with a clip that is to be converted

pub mod bake;
pub mod clip;
pub mod drawn;
pub mod error;
#[cfg(test)]
mod fixture;
pub mod key_frames;
pub mod low_rank;
pub mod merge;
mod moving_gradient;
pub mod order;
pub mod reference;
pub mod shading;
pub mod split;
pub mod stage;
mod tunnel;
pub mod underlap;
mod vertex_colors;

pub use clip::{PlanarClip, PlanarFrame, Surface};
pub use drawn::Drawn;
pub use error::PlanarError;
pub use key_frames::{KeyOptions, KeyStats, keyed, keyed_regions};
pub use merge::Region;
pub use order::{
    Epoch, Layer, OrderOptions, Overlaps, Painted, Painting, WrongPixels, wrong_pixels,
};
pub use shading::{Colors, Shading};
pub use split::{Split, SplitOptions, split};
pub use underlap::{Sealed, UnderlapOptions};
