//! Animates virtual humans and adapts them, while they move, to whatever must show them.
//!
//! A crowd of your own character (`cargo run --release -p articula --example crowd -- my.glb
//! [walk.bvh …]`; without a path it is the reference human):
//!
//! ```
#![doc = include_str!("../examples/crowd.rs")]
//! ```
//!
//! One figure (`--example hero -- my.glb`):
//!
//! ```
#![doc = include_str!("../examples/hero.rs")]
//! ```
//!
//! What there is:
//!
//! - [`fs::open`], [`open()`], [`CharacterFile`]: GLB, glTF, VRM, VRMA, BVH, ASF and AMC, BVA, X3D and BAP files as
//!   one editable [`Character`](articula_core::source::Character), with what is needed to write
//!   them back; [`CharacterFile::add_clips`] puts the motions of other files onto it
//! - [`Figure`]: rig, mesh and clips, as a frame needs them
//! - [`crowd`]: thousands of one character, each at the level of detail that its viewer can see
//! - [`prepare()`]: what is made once of a character goes into its GLB: mesh levels, motion tables
//! - [`convert()`]: between formats, clips edited, levels of articulation saved
//! - [`flatten`]: a character in motion as animated SVG, player, Lottie or portrait
//! - [`evaluate`]: a clip played under methods of motion level of detail, what they save and cost
//! - [`inspect`]: what is in a file, and what is odd about it
//!
//! What is deliberately absent: arguments, consoles, clocks, threads, and paths outside of [`fs`].
//! Long work takes a [`Executor`], which reports steps, may end it, and hands out [`Job`]s that the
//! caller runs on threads of its own. Units are metres, seconds and radians, but angles that a
//! person names are degrees and say so (`_deg`); +Y is up and a character faces +Z. Level 0 is the
//! finest.

mod camera_path;
pub mod convert;
pub mod crowd;
mod error;
pub mod evaluate;
mod facing;
mod figure;
pub mod flatten;
#[cfg(not(target_family = "wasm"))]
pub mod fs;
pub mod inspect;
mod mesh_levels;
mod motion_tables;
mod open;
mod prepare;
mod work;

pub use camera_path::read_camera_path;
pub use convert::{AddClipsOptions, ConvertOptions, Converted, convert};
pub use error::{Error, Result};
pub use facing::facing;
pub use figure::Figure;
pub use mesh_levels::{CodedMeshLevels, MeshLevelOptions, MeshLevelStream};
pub use motion_tables::{ClipTables, StoredTables, stored_tables};
pub use open::{
    CharacterFile, Data, DataFile, DataFormat, Format, GltfSource, OpenOptions, WriteSupport,
    choose, conversions, open, open_data, readable, reference_human,
};
pub use prepare::{PrepareOptions, PreparedAsset, prepare};
pub use work::{Executor, Job, JobRunner, Step, StepCallback};

pub use articula_core::{Camera, PosedMesh, SkinnedMesh, Viewport, Wrap, sample, sample_morphs};
pub use glam;
