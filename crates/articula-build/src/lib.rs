//! What is prepared before the frame: everything slow happens here, once per character.
//!
//! - [`character`]: the recipe, from a source character to rig, mesh and clips
//! - [`clip_edit`]: source clips trimmed, looped, thinned out before anything else
//! - [`joint_names`]: what the joints of a skeleton are, told by their names
//! - [`retarget`]: a motion of one skeleton put onto another
//! - [`bake`], [`resolve`]: expressions written out as morph weights and joint transforms
//! - [`levers`], [`contact_intervals`], [`key_table`], [`pose_keys`]: what the error of a motion
//!   and nested keys are told by
//! - [`merged_levels`]: merged levels of a crowd: joint order, skins and errors of every level
//! - [`simplify`], [`decimate`], [`cluster`], [`mesh_levels`]: fewer triangles for a character that
//!   moves, in levels that are ranges of one object
//! - [`surface_distances`]: how far a mesh level lies from the original, at rest and in motion
//! - [`figure_levels`]: levels of joints and mesh that are shown together
//! - [`cached_poses`], [`motion_bounds`], [`occluders`]: what a crowd reads instead of working it out
//! - [`reduce`]: a motion saved at a level of articulation
//! - [`evaluate`]: a clip played under a method, its gain and its error in pixels
//! - [`Scene`], [`plaza`]: who stands where in a crowd, and where its camera goes
//!
//! ```
//! use articula_build::{ClipOptions, SimplifyOptions, character, simplify};
//! use articula_human::{HumanOptions, human};
//!
//! let source = human(&HumanOptions { triangles: 2_000 })?;
//! let asset = character(&source, None, &ClipOptions::default())?;
//! let options = SimplifyOptions {
//!     targets: vec![1.0, 0.5],
//!     ..SimplifyOptions::default()
//! };
//! let rest = [asset.mesh.positions.clone()];
//! let levels = simplify(&asset.mesh, &rest, &options)?.levels;
//! assert_eq!(levels[1].triangles.len(), asset.mesh.triangles.len() / 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What is deliberately absent: files, clocks, threads, and any call from a frame.

pub mod clip_edit;
pub mod evaluate;
pub mod joint_names;
pub mod retarget;

mod character;
mod clip;
mod clusters;
mod decimate;
mod expression;
mod figure_levels;
mod influences;
mod joint_lods;
mod mesh_levels;
mod motion_bounds;
mod motion_error;
mod occluders;
mod points;
mod pose_cache;
mod poses;
mod reduce;
mod rotation_vector;
mod scene;
mod simplify;
mod split_mix;
mod surface_distance;

pub use character::{Asset, character};
pub use clip::{ClipOptions, source_rate_hz};
pub use clusters::{ClusterOrder, Clustered, cluster};
pub use decimate::decimate;
pub use expression::{bake, resolve};
pub use figure_levels::{FigureLevel, FigureLevels, figure_levels};
pub use joint_lods::{
    FarLevels, LevelOptions, LevelSkin, LevelSkins, MergedLevels, far_levels, far_order,
    joint_lods, level_skins, levels_of, lod_errors, mean_pose, merged_levels, named_joint_lods,
    skin_of,
};
pub use mesh_levels::{MeasurementPoses, MeshLevelOptions, MeshLevels, mesh_levels};
pub use motion_bounds::motion_bounds;
pub use motion_error::{
    ChainTolerance, JointLever, contact_intervals, joint_bounds, key_table, levers, moving_joints,
    pose_keys, table_hashes,
};
pub use occluders::occluders;
pub use points::draw_vertices;
pub use pose_cache::{CacheDecision, CacheOptions, CacheReport, CachedPoses, cached_poses};
pub use poses::{PoseOptions, PoseOrigin, Poses, SkinPose, SkinPoseSource, poses, positions};
pub use reduce::{MotionSize, motion_size, reduce};
pub use scene::{ClipPlayback, CrossFade, PLAZA_COUNT, Plaza, Scene, SceneCharacter, plaza};
pub use simplify::{
    ErrorWeighting, LevelTriangles, Simplified, SimplifyOptions, region_weights, simplify,
};
pub use surface_distance::{
    DistanceOptions, LevelDistances, SkinPoint, attach, compact, surface_distances,
};
