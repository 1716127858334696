//! A talking 2D face that turns its head: a 2D mesh that warps pictures of a 3D figure.
//!
//! Source: `docs/methods/vector.md` part 10; thesis 4.1 (a 2D mesh over a portrait, driven by face
//! parameters) and annex C (the supported parameters). Differs from the thesis: the head turns,
//! what lies behind (teeth, tongue, eyes under lids) is found and not drawn by hand, and every
//! expression works in all views.
//!
//! - [`PortraitSource`]: figure, head, expressions; [`PortraitClip`]: motions stored in the
//!   portrait
//! - [`build()`]: makes a [`Portrait`] from a source
//! - [`page()`]: one HTML page with its player; [`Portrait::to_files`]: JSON and pictures
//!
//! Private modules: `flat_mesh`, the 2D mesh; `visibility`, its layers in each view; `views`, the
//! view pictures; `view_weights`, the weight of each view for a triangle; `pose_grid`, positions of
//! the vertices for any head angle and expression; `paint_order`, painting orders for ranges of
//! yaw; `roll`, turns in the plane of the picture; `sealing`, underlap of edges; `raster`, rendering without a browser; `evaluate`, the error
//! against a render of the 3D figure.

mod build;
mod clip;
mod document;
mod error;
mod evaluate;
mod flat_mesh;
mod head;
mod model;
mod page;
mod paint_order;
mod pose_grid;
mod posing;
mod raster;
mod roll;
mod sealing;
mod source;
mod view_weights;
mod views;
mod visibility;

#[cfg(test)]
mod tests;

pub use build::build;
pub use clip::PortraitClip;
pub use document::PictureFormat;
pub use error::PortraitError;
pub use head::{Head, HeadPose, JointTurn, PortraitExpression};
pub use model::{Portrait, PortraitCounts, PortraitInput, PortraitLevel};
pub use page::{EmbeddedFile, PageOptions, Slide, page};
pub use source::{PortraitOptions, PortraitSource};
