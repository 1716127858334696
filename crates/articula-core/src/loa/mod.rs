//! Levels of articulation: which joints are allowed to move.
//!
//! Source: thesis 5.1, `docs/methods/motion-lod.md` part 1. Every selector gives a
//! [`JointSet`](crate::JointSet), so any combination is set arithmetic. Numbers of levels are those
//! of H-Anim, 0 the root alone, and are always called `loa`; levels of detail count the other way,
//! from 0, the finest.

mod expression;
mod selection;

pub use crate::articulation::MAX_LEVEL;
pub use expression::{LoaExpression, LoaExpressionError};
pub use selection::{
    Rule, Selection, UnknownJoint, complexity, depth, joint, with_ancestors, zone,
};
