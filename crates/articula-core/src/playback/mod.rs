//! Playback of one figure, live: clips with cross-fades, layers, levels of detail for each joint,
//! forward kinematics and skinning.
//!
//! Source: thesis 5.1, 5.2 and 7.2.3; `docs/methods/motion-lod.md` parts 2 to 4. A frame consists of
//! these calls, each of which may be timed and left out apart:
//!
//! 1. [`FigurePlayer::advance`]: clocks, cross-fades, events and root motion
//! 2. [`FigurePlayer::control`]: a [`MotionController`] names the joints whose transform it needs,
//!    these are sampled from clips and layers, and the controller writes what is shown
//! 3. [`FigurePlayer::edit`]: a hook that overrides the pose, for inverse kinematics or ragdolls
//! 4. [`FigurePlayer::hierarchy`]: forward kinematics of the subtrees that changed
//! 5. [`FigureSkin::skin`]: skinning of the vertices whose joints changed
//!
//! A controller is the only place where a level of detail is decided:
//!
//! - [`FullDetail`]: every joint in every frame, or as many as a budget allows, in turn
//! - [`LoaController`]: levels of articulation with transitions, around any other controller
//! - [`DriftController`](crate::DriftController): joints are held while the error that they show is
//!   within the tolerance
//! - [`TableController`]: stored key frames, at the tolerance of each joint
//! - [`ThesisController`]: error matrix and distance threshold of the thesis
//!
//! While a clip arrives as a stream, [`FigurePlayer::set_model`] goes on with what has arrived; what
//! is shown moves there within a given time.
//!
//! Players, skins and controllers share what they read, a rig, clips, a mesh or tables, by
//! [`Arc`](std::sync::Arc), and none borrows: they can be held from frame to frame by any owner and
//! moved to other threads.
//!
//! No call but constructors, `add_layer` and `set_model` allocates, none reads a clock, and the same
//! calls give the same pose. The controllers in this crate are deterministic; a controller of a
//! caller runs in the same playback and is measured in the same way.

mod controller;
mod drift;
mod figure_skin;
mod full_detail;
mod layer;
mod loa;
mod model;
mod player;
mod report;
mod state;
mod tables;
mod thesis;
mod views;

pub use controller::{ClipFrame, ControlResult, FrameContext, MotionController};
pub use figure_skin::FigureSkin;
pub use full_detail::FullDetail;
pub use layer::{LayerMode, MotionLayer};
pub use loa::LoaController;
pub use model::FigureModel;
pub use player::{FigurePlayer, PlayedEvent};
pub use report::FrameReport;
pub use tables::{StoredKeys, TableController};
pub use thesis::{ErrorMatrix, ErrorMatrixTable, ThesisController, Threshold, ThresholdCurve};
pub use views::FigureViews;
