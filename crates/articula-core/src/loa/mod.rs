//! Levels of articulation: the joints that are allowed to move.
//!
//! Source: thesis 5.1, `docs/methods/motion-lod.md` part 1. Every selector returns a
//! [`JointSet`](crate::JointSet), so that any combination is set arithmetic. Levels of articulation
//! are numbered as in H-Anim, from 0, the root alone, and are always called `loa`; levels of detail
//! are numbered in the opposite direction, from 0, the finest.

mod expression;
mod selection;

pub use crate::articulation::MAX_LEVEL;
pub use expression::{LoaExpression, LoaExpressionError};
pub use selection::{
    MAX_HANIM_LEVEL, Rule, Selection, UnknownJoint, complexity, depth, hanim, joint,
    with_ancestors, zone,
};
