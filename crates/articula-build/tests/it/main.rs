//! Properties of prepared data, on random and hand-made figures.
//!
//! One program: linking one is faster than linking many.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod bounds;
mod clip_edit;
mod clusters;
mod entering_view;
mod evaluate;
mod face_errors;
mod figure_levels;
mod joint_lods;
mod levels_over_time;
mod mesh_levels;
mod motion_bounds;
mod occluders;
mod one_pass;
mod pose_cache;
mod random_figure;
mod reference_human;
mod resampling;
mod retarget;
mod simplify;
#[path = "../../src/surface_distance/slow.rs"]
mod slow;
mod surface_distance;
