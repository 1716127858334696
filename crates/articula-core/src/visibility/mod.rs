//! Which bodies are seen, soon may be, and how large they look: the part before any level is chosen.
//!
//! - [`View`]: who looks, how far, and how many pixels a metre spans
//! - [`Bodies`], [`cull`]: who is looked at; one pass over a crowd
//! - [`Occlusion`]: how much of a body others hide, for those who ask no renderer

mod cull;
mod frustum;
mod occlusion;
mod world_bounds;

pub use cull::{
    ApproachSpeed, Bodies, CullResult, MIN_DEPTH_METRES, View, Visibility, cull, secs_until_grown,
};
pub use frustum::Tangents;
pub use occlusion::Occlusion;
pub(crate) use world_bounds::{Places, carry};
