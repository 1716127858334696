//! Published metrics, used as baselines.

pub(crate) mod ahn;
pub(crate) mod postures;
pub(crate) mod thesis;
