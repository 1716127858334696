//! Published per-joint metrics, used as baselines.

pub(crate) mod ahn;
pub(crate) mod thesis;
