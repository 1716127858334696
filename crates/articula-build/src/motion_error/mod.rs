//! The first step of every motion error metric: what is worked out before a clip plays.
//!
//! - [`levers`]: how the skin hangs on each joint
//! - [`moving_joints`], [`joint_bounds`]: speed bounds and shares for the drift controller
//! - [`key_table`]: nested keys for a ladder of tolerances, held, posed or blended, with [`table_hashes`]
//! - [`pose_keys`]: whole-pose keys between which palettes blend
//! - [`contact_intervals`]: when feet and hands stand still

pub(crate) mod bounds;
pub(crate) mod closed_loop;
pub(crate) mod contacts;
pub(crate) mod joint_lever;
pub(crate) mod keys;
pub(crate) mod levers;
pub(crate) mod pose_keys;
pub(crate) mod runs;
pub(crate) mod tables;

pub use bounds::{ChainTolerance, joint_bounds, moving_joints};
pub use contacts::contact_intervals;
pub use joint_lever::JointLever;
pub use levers::levers;
pub use pose_keys::pose_keys;
pub use tables::{key_table, table_hashes};
