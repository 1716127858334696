//! Offline preparation of characters: everything slow happens here, once per character.
//!
//! - [`character`]: builds rig, mesh and clips from a source character
//! - [`clip_edit`]: trims, loops and reduces source clips
//! - [`joint_names`]: recognises the joints of a skeleton by their names
//! - [`set_joint_scheme`]: converts a character between the joint schemes of H-Anim and the thesis
//! - [`retarget`]: transfers a motion from one skeleton to another
//! - [`bake`], [`resolve`]: convert expressions to morph weights and joint transforms
//! - [`levers`], [`key_table`], [`pose_keys`]: tables for the error of held
//!   joints, and nested keys
//! - [`merged_levels`]: joint LODs of a crowd: joint order, skins and errors of every level
//! - [`simplify`], [`decimate`], [`cluster`], [`mesh_levels`]: simplify the mesh of an animated
//!   character into levels that are ranges of one object
//! - [`surface_distances`]: measures the distance of a mesh level from the original, at rest and in
//!   motion; [`RegionMix`], [`measure_levels`]: each region of a mesh at a level of its own;
//!   [`measure_mesh`]: the error of a decoded mesh
//! - [`figure_levels`]: pairs levels of joints and mesh that are shown together
//! - [`cached_poses`], [`motion_bounds`], [`occluders`]: data that a crowd reads instead of
//!   computing it
//! - [`greatest_vertex_error`]: how far two characters are apart in motion; [`ReferenceClip`]: how far
//!   versions of one clip; [`greatest_surface_error`]: how far their surfaces; [`watched_poses`],
//!   [`simplify_within`]: fewer triangles within a distance in motion
//! - [`hold_joints_in_clip`]: writes a motion at a level of articulation
//! - [`face`]: facial animation parameters of MPEG-4 to blend shapes and back
//! - [`evaluate`]: plays a clip with a method and measures its gain and its error in pixels
//! - [`Scene`], [`plaza`]: positions and clips of the characters of a crowd, and its camera path
//!
//! ```
//! use articula_build::{ClipOptions, SimplifyOptions, character, simplify};
//! use articula_human::{HumanOptions, human};
//!
//! let source = human(&HumanOptions::mannequin(2_000))?;
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
//! This crate reads no files or clocks, spawns no threads, and is never called from a frame.

pub mod clip_edit;
pub mod evaluate;
pub mod face;
pub mod joint_names;
pub mod retarget;

mod beyond;
mod character;
mod clip;
mod clusters;
mod decimate;
mod expression;
mod figure_levels;
mod influences;
mod joint_lods;
mod joint_scheme;
mod key_times;
mod mesh_levels;
mod moment;
mod motion_bounds;
mod motion_error;
mod occluders;
mod part_mesh;
mod points;
mod pose_cache;
mod poses;
mod reduce;
mod resampling_error;
mod sampling_rate;
mod scene;
mod simplify;
mod simplify_within;
mod skin_patches;
mod source_hash;
mod split_mix;
mod surface_distance;
mod surface_error;
mod vertex_error;
mod watched_poses;

pub use character::{Asset, character, rig_and_mesh, sampled_clip};
pub use clip::{ClipOptions, sampling_rate_hz};
pub use clusters::{ClusterOrder, Clustered, cluster};
pub use decimate::decimate;
pub use expression::{bake, resolve};
pub use figure_levels::{FigureLevels, figure_levels, paired_levels};
pub use joint_lods::{
    FarLevels, JointLodOptions, MergedLevels, far_levels, far_order, joint_lods, level_skins,
    levels_of, lod_errors, mean_pose, merged_levels, named_joint_lods, skin_of,
};
pub use joint_scheme::{
    InsertedJoint, JointEdit, JointScheme, MergedJoint, SchemeChange, set_joint_scheme,
};
pub use mesh_levels::{
    LeftOutLevel, LeftOutReason, MeasurementPoses, MeshLevelOptions, MeshLevels, RegionMix,
    measure_levels, measure_mesh, mesh_level_triangles, mesh_levels,
};
pub use motion_bounds::{motion_bounds, reach_bounds};
pub use motion_error::{
    ChainTolerance, JointLever, contact_table, joint_bounds, key_table, levers, moving_joints,
    pose_keys, table_hashes,
};
pub use occluders::occluders;
pub use points::draw_vertices;
pub use pose_cache::{
    CacheDecision, CacheOptions, CacheReport, CachedPoses, cache_of_keys, cached_poses,
};
pub use poses::{PoseOptions, PoseOrigin, Poses, SkinPose, SkinPoseSource, poses, positions};
pub use reduce::{ClipSize, clip_size, hold_joints_in_clip, whole_clip_size};
pub use resampling_error::{Played, ResamplingError, resampling_error};
pub use sampling_rate::{sampling_bound_metres, source_rate_hz};
pub use scene::{
    ClipPlayback, CrossFade, Cue, IMPORTANCE_RANGE, PLAZA_COUNT, Plaza, Role, Scene,
    SceneCharacter, SceneImportance, SceneView, USUAL_ROLES, Wall, Zone, plaza,
};
pub use simplify::{
    ErrorWeighting, LevelTriangles, Simplified, SimplifyLimit, SimplifyOptions, region_weights,
    simplify, skin_regions, vertex_regions,
};
pub use simplify_within::{SimplifiedWithin, simplify_within};
pub use source_hash::{SourceHash, hash_bytes, rig_hash};
pub use split_mix::SplitMix;
pub use surface_distance::{
    Borders, DistanceOptions, LevelDistances, SkinPoint, attach, compact, surface_distances,
};
pub use surface_error::{ChangedTriangles, greatest_surface_error};
pub use vertex_error::{PosedVertices, ReferenceClip, greatest_vertex_error};
pub use watched_poses::watched_poses;
