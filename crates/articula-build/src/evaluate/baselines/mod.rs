//! The metrics of the literature, for each joint alone: what ours is measured against.

pub(crate) mod ahn;
pub(crate) mod thesis;
pub(crate) mod thesis_metric;
