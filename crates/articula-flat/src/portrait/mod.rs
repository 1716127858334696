//! A talking face in 2D that can turn its head: warped view pictures of a 3D figure.
//!
//! Source: `docs/methods/vector.md` part 10; thesis 4.1 (a 2D mesh over a portrait, driven by face
//! parameters) and annex C (which of them it supports). What differs: the head turns, what is
//! behind (teeth, tongue, eyes under lids) is found rather than drawn by hand, and every shape
//! of the face moves in all views.
//!
//! - [`PortraitSource`]: figure, head, expressions; [`PortraitClip`]: motions to carry along
//! - [`build()`]: makes a [`Portrait`] of it
//! - [`page()`]: one HTML page with its player; [`Portrait::to_files`]: JSON and pictures
//!
//! Inside: `flat_mesh`, the 2D mesh; `visibility`, its layers in each view; `views`, the view
//! pictures; `view_weights`, how much each counts for a triangle; `pose_grid`, where vertices
//! are for any turn, nod and expression; `paint_order`, back to front for a range of turns;
//! `sealing`, no gap between neighbours; `raster`, the picture of a pose, without a browser;
//! `evaluate`, how far it is from a render of the 3D figure.

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
pub use model::{Portrait, PortraitCounts};
pub use page::{EmbeddedFile, PageOptions, page};
pub use source::{PortraitOptions, PortraitSource};
