//! What a virtual human is, and how it moves this frame.
//!
//! The modules stand in the order of the FRAME line: a view asks for detail, a selection
//! says which joints may move, the clip is sampled, the hierarchy turns local transforms into
//! model space, the skin follows.
//!
//! - [`source`]: the editable nouns that readers give and builders take
//! - [`rig`], [`clip`], [`mesh`]: the read-only nouns of the frame
//! - [`articulation`]: H-Anim level and region of every joint
//! - [`hanim_table`]: the joints of the standard humanoid
//! - [`loa`]: joint sets, the selectors, their combination and the expression language
//! - [`view`]: viewport, camera, pixels per metre
//! - [`pose`], [`sample`], [`hierarchy`], [`skin`]: one verb each
//! - [`joint_state`]: active, passive and the transitions between them
//! - [`motion_error`]: errors of held joints, looked up and scaled by the view
//!
//! What is deliberately absent: files, clocks, threads, logging, JSON, and any allocation in a
//! function that runs once a frame (a test counts them).
//!
//! Units are metres, seconds and radians; +Y is up and a character faces +Z.

pub mod articulation;
pub mod clip;
pub mod hanim_table;
pub mod hierarchy;
pub mod loa;
pub mod math;
pub mod mesh;
pub mod pose;
pub mod rig;
pub mod sample;
pub mod skin;
pub mod source;
pub mod view;

mod mismatch;
pub use mismatch::Mismatch;
