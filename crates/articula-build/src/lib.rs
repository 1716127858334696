//! What is prepared before the frame: everything slow happens here, once per character.
//!
//! - [`character`]: the recipe, from a source character to rig, mesh and clips
//! - [`clip`]: keyed channels to a uniform rate
//! - [`clip_edit`]: source clips trimmed, looped, thinned out before anything else
//! - [`clusters`]: the levels of a mesh put together as ranges of one object
//! - [`decimate`]: one coarser list of triangles, for one clip and what is seen of it
//! - [`expression`]: expressions written out as morph weights and joint transforms
//! - [`figure_levels`]: levels of joints and mesh that are shown together
//! - [`influences`]: fewer joints for each vertex
//! - [`joint_names`]: what the joints of a skeleton are, told by their names
//! - [`ladder`]: merged levels of a crowd: joint order, skins and errors of every level
//! - [`motion_bounds`]: what holds a character in each second of each clip
//! - [`motion_error`]: levers, error matrices, key tables for every metric
//! - [`occluders`]: what of a body hides others through a clip
//! - [`pose_cache`]: pose keys of all clips and levels, baked into one cache
//! - [`poses`]: poses to simplify a mesh by, and others to measure it on
//! - [`reduce`]: a motion saved at a level of articulation
//! - [`retarget`]: a motion of one skeleton put onto another
//! - [`evaluate`]: a clip played under a method, its gain and its error in pixels
//! - [`simplify`]: fewer triangles for a character that moves, in chained levels
//! - [`scene`]: who stands where in a crowd, and where its camera goes
//! - [`surface_distance`]: how far a mesh level lies from the original surface, at rest and in motion
//!
//! What is deliberately absent: files, clocks, and any call from a frame.

pub mod character;
pub mod clip;
pub mod clip_edit;
pub mod clusters;
pub mod decimate;
pub mod evaluate;
pub mod expression;
pub mod figure_levels;
pub mod influences;
pub mod joint_names;
pub mod ladder;
pub mod mesh_levels;
pub mod motion_bounds;
pub mod motion_error;
pub mod occluders;
pub mod pose_cache;
pub mod poses;
pub mod reduce;
pub mod retarget;
pub mod scene;
pub mod simplify;
pub mod surface_distance;

mod split_mix;
