//! Integration tests of the library: playback and conversion of every kind of file.
//!
//! One program: linking one is faster than linking many.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, looks for the folder of real files, and says what it skips"
)]

mod adapted_items;
mod bare;
mod case_files;
mod convert;
mod crowd;
mod crowd_buffers;
mod crowd_casts;
mod crowd_draws;
mod crowd_faces;
mod crowd_impostors;
mod crowd_measured;
mod crowd_roles;
mod crowd_vertices;
mod delivered_items;
mod devices;
mod face_errors;
mod face_joints;
mod faces;
mod fbx;
mod flat_features;
mod items;
mod joint_schemes;
mod kept_faces;
mod keys;
mod made_faces;
mod merged_joints;
mod mesh_levels;
mod mp4;
mod optimized;
mod optimized_textures;
mod painted_human;
mod played_traces;
mod portrait_mouths;
mod prepared;
mod promised_errors;
#[path = "../../../articula-formats/tests/it/real/mod.rs"]
mod real;
mod received_items;
mod round_trips;
mod shaders;
mod short;
mod simplified;
mod speech;
mod staged_items;
mod streams;
mod texture_atlas;
mod travelling_items;
mod zero_poses;
