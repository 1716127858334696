//! Which bodies are seen, soon may be, and how large they look: the part before any level is chosen.
//!
//! - [`View`]: who looks, how far, and how many pixels a metre spans
//! - [`Bodies`], [`see`]: who is looked at; one pass over a crowd
//! - [`Occlusion`]: how much of a body others hide, for those who ask no renderer

mod frustum;
mod occlusion;
mod see;
mod world_bounds;

pub use frustum::Tangents;
pub use occlusion::Occlusion;
pub use see::{Bodies, ApproachSpeed, LEAST_DEPTH_METRES, CullResult, View, Visibility, secs_until_grown, see};
pub(crate) use world_bounds::{Places, carry};
