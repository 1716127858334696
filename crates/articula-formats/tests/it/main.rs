//! Tests of readers and writers: each feature by a small file, real files, and hostile ones.
//!
//! One program: linking one is faster than linking many.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, reads files, and says what it skips"
)]

mod acclaim;
mod bva_files;
mod bvh_files;
mod captures;
mod cases;
#[cfg(feature = "fbx")]
mod fbx;
mod gltf;
mod joint_map_characters;
mod meshopt;
mod mpeg4;
mod mutated_text;
mod prepared;
mod real;
mod simplified_characters;
mod thinned;
mod world;
mod x3d;
mod zero_pose;
