//! Visibility of bodies: frustum culling, occlusion and size on screen, before any level is chosen.
//!
//! - [`View`]: frustum, pixels per metre, cull margin and occluded fractions of one view
//! - [`Bodies`], [`cull`]: bounds of the bodies, and one pass over them that culls against all
//!   views
//! - [`Occlusion`]: occluded fraction of a body, for callers that query no renderer

mod cull;
mod density;
mod frustum;
mod look;
mod occlusion;
mod view;
mod world_bounds;

pub use cull::{Bodies, CullResult, Visibility, cull};
pub use density::MIN_DEPTH_METRES;
pub use frustum::Tangents;
pub(crate) use look::{Bands, BoxSight, Sight, Spheres, look, look_at_box, look_at_one};
pub use occlusion::{BoxOcclusion, Occlusion};
pub use view::View;
pub(crate) use world_bounds::{carry_four, filled};
