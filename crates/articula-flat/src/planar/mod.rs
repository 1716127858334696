//! A clip as the camera sees it: projected triangles with their light, and what is known of
//! them before anything is written.
//!
//! Source: thesis 4.2, `spec/vector.md` 2 to 7.
//!
//! - [`clip`]: the noun, places and light of every vertex in every frame
//! - [`bake`]: skins, projects and lights a character into it
//! - [`drawn`]: which triangles are seen in which frames
//! - [`reference`]: the supersampled Gouraud picture that every output is measured against
//! - [`error`]: what can be wrong with a clip that is to be converted

pub mod bake;
pub mod clip;
pub mod drawn;
pub mod error;
pub mod reference;

pub use clip::{PlanarClip, PlanarFrame, Surface};
pub use drawn::Drawn;
pub use error::PlanarError;
