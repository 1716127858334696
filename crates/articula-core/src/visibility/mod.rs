//! Which bodies are seen, soon may be, and how large they look: the part before any level is chosen.
//!
//! - [`View`], [`Frustum`]: who looks, and how far
//! - [`Bodies`], [`see`]: who is looked at; one pass over a crowd
//! - [`Places`], [`carry`]: bounds in model space, carried into the world
//! - [`Occlusion`]: how much of a body others hide, for those who ask no renderer

mod frustum;
mod occlusion;
mod see;
mod world_bounds;

pub use frustum::{Frustum, Tangents};
pub use occlusion::Occlusion;
pub use see::{
    Bodies, Closing, LEAST_DEPTH_METRES, PixelDensity, Seen, View, Visibility, secs_until_grown,
    see, wake_metres,
};
pub use world_bounds::{Places, carry};
