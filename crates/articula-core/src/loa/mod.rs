//! Levels of articulation: which joints are allowed to move.
//!
//! Source: thesis 5.1, `spec/motion-lod.md` part 1. Every selector is a [`JointSet`], so any
//! combination is set arithmetic.

pub mod expression;
mod joint_set;
pub mod selection;

pub use expression::Expression;
pub use joint_set::{JointSet, MAX_JOINTS};
pub use selection::{Rule, Selection};
