//! The first step of every motion error metric: what is worked out before a clip plays.
//!
//! - [`levers`]: how the skin hangs on each joint
//! - [`bounds`]: speed bounds and shares for the drift controller
//! - [`keys`]: keys of one joint at one tolerance, held, posed or blended
//! - [`closed_loop`]: held keys in which children cancel their ancestors' error
//! - [`tables`]: nested keys for a ladder of tolerances, and fingerprints
//! - [`pose_keys`]: whole-pose keys between which palettes blend
//! - [`contacts`]: when feet and hands stand still
//! - [`thesis`], [`ahn`]: the two metrics of the literature, as baselines
//! - [`thesis_metric`]: the second step of the thesis' metric: threshold and switching

pub mod ahn;
pub mod bounds;
pub mod closed_loop;
pub mod contacts;
pub mod keys;
pub mod levers;
pub mod pose_keys;
pub(crate) mod runs;
pub mod tables;
pub mod thesis;
pub mod thesis_metric;
