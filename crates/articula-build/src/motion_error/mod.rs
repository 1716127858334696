//! The first step of every motion error metric: tables computed before a clip plays.
//!
//! - [`levers`]: extent of the skin that each joint moves
//! - [`moving_joints`], [`joint_bounds`]: speed bounds and shares for the drift controller
//! - [`key_table`]: nested keys for increasing tolerances, held, posed or blended, with
//!   [`table_hashes`]
//! - [`pose_keys`]: whole-pose keys between which palettes are blended
//! - [`contact_table`]: intervals in which feet and hands stand still

pub(crate) mod bounds;
pub(crate) mod contacts;
pub(crate) mod hull;
pub(crate) mod joint_lever;
pub(crate) mod keys;
pub(crate) mod levers;
pub(crate) mod pose_keys;
pub(crate) mod runs;
pub(crate) mod tables;

pub use bounds::{ChainTolerance, joint_bounds, moving_joints};
pub use contacts::contact_table;
pub use joint_lever::JointLever;
pub use levers::levers;
pub use pose_keys::pose_keys;
pub use tables::{key_table, table_hashes};
