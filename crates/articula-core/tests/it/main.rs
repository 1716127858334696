//! Properties of the runtime: the same values by every path, and no allocation in a frame.
//!
//! One test program, because linking one is faster than linking many.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod batch;
mod clustered;
mod crowd;
mod crowd_budget;
mod crowd_impostors;
mod crowd_levels;
mod crowd_morph_levels;
mod crowd_morphs;
mod crowd_sections;
mod crowd_selection;
mod crowd_steps;
mod drift;
mod loa;
mod occlusion;
mod playback;
mod pose_cache;
mod random_rig;
mod skin_groups;
mod visibility;
