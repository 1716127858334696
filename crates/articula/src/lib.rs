//! Animates virtual humans and adapts their level of detail to the viewer, the device and the frame
//! budget.
//!
//! A crowd of one character (`cargo run --release -p articula --example crowd -- my.glb [walk.bvh
//! …]`; without a path, the built-in reference human):
//!
//! ```
#![doc = include_str!("../examples/crowd.rs")]
//! ```
//!
//! A single character whose level of articulation follows its distance (`--example hero --
//! my.glb`):
//!
//! ```
#![doc = include_str!("../examples/hero.rs")]
//! ```
//!
//! Entry points:
//!
//! - [`fs::open`], [`open()`], [`CharacterFile`]: reads GLB, glTF, VRM, VRMA, BVH, ASF and AMC,
//!   BVA, X3D, BAP, ABP and MP4 files into one editable [`Character`](core::source::Character), with
//!   the data needed to write them back; [`CharacterFile::add_clips`] adds the motions of other
//!   files
//! - [`Figure`]: rig, mesh and clips in the form that a frame reads
//! - [`playback`]: live playback of one character: layers, levels of articulation, skinning
//! - [`crowd`]: thousands of instances of one character, each at a level of detail chosen by
//!   projected error or by a time budget
//! - [`prepare()`]: computes motion tables and, on request, mesh levels, and stores them in a GLB
//! - [`convert()`]: converts between formats, edits clips, selects levels of articulation
//! - [`face`]: facial animation parameters of MPEG-4 on the face of a character
//! - [`speech`]: faces that speak, from a voice
//! - [`clip_streams`]: motions of bodies and faces as streams that can be cut
//! - [`item`]: a character as a digital item, a folder of streams that can be cut
//! - [`client`]: digital items as they arrive over a network, and the sessions of a server
//! - [`flatten`]: a moving character as animated SVG, 2D player, Lottie or portrait
//! - [`impostor`]: a character as small pictures, for who is far away
//! - [`device`]: how much of a character a device can play, by a benchmark
//! - [`evaluate`]: error and cost of motion level-of-detail methods on a clip
//! - [`inspect`]: contents of a file, and warnings about it; [`rig_joint_map`]: the joint map of a rig
//!   as it was recognised
//!
//! The library does not parse arguments, write to a console, read a clock or start threads, and it
//! touches paths in [`fs`] alone. Long operations take an [`Executor`], which reports progress, can
//! cancel, and hands out [`Job`]s that the caller may run on its own threads.
//!
//! # Features
//!
//! All are on by default. Without any, the library opens glTF and VRM files, edits and converts characters, plays
//! figures, crowds and faces, and links no codec of pictures or streams, no compressor and no rasteriser.
//!
//! - `prepare`: [`prepare()`] and mesh levels as streams; includes `streams`
//! - `flat`: [`flat`], [`flatten`], [`impostor`], and the impostors of a [`crowd`]
//! - `streams`: [`stream`], [`clip_streams`], and formats that hold streams: ABP, AFP, FBA and MP4 files are read and
//!   written, and the motion streams of an asset are read
//! - `speech`: [`speech`]
//! - `item`: [`item`], and [`fs`] opens digital items; includes the three others
//! - `formats`: BVH, ASF, AMC, BVA, X3D, VRML97 and BAP files are opened; `fbx`: FBX files
//!
//! [`inspect`] and [`device`] need `flat` and `streams`. A file whose feature is off is refused with an error that names it.
//!
//! The crates that the library combines are its modules [`core`], [`formats`], [`build`], [`flat`],
//! [`stream`] and [`human`]; their types stand in its signatures, so that a program depends on this
//! crate alone.
//!
//! Units are metres, seconds and radians; angles entered by a user are in degrees, with the suffix
//! `_deg`. +Y is up and a character faces +Z. Level 0 is the finest.

mod camera_path;
#[cfg(feature = "item")]
pub mod client;
#[cfg(feature = "streams")]
pub mod clip_streams;
pub mod convert;
pub mod crowd;
#[cfg(all(feature = "flat", feature = "streams"))]
pub mod device;
mod error;
pub mod evaluate;
pub mod face;
mod facing;
mod figure;
#[cfg(feature = "flat")]
pub mod flatten;
#[cfg(not(target_family = "wasm"))]
pub mod fs;
mod head;
#[cfg(feature = "flat")]
pub mod impostor;
mod in_place;
mod inner_lips;
#[cfg(all(feature = "flat", feature = "streams"))]
pub mod inspect;
#[cfg(feature = "item")]
pub mod item;
mod joint_map;
#[cfg(feature = "prepare")]
mod mesh_level_rows;
mod mesh_levels;
mod motion_tables;
mod old_hashes;
mod open;
#[cfg(feature = "flat")]
pub mod optimize;
#[cfg(feature = "flat")]
mod painted_human;
#[cfg(feature = "prepare")]
mod prepare;
mod prepared;
mod recording;
mod resampling;
#[cfg(feature = "speech")]
pub mod speech;
#[cfg(feature = "flat")]
mod texture_atlas;
mod work;

pub use camera_path::read_camera_path;
pub use convert::{AddClipsOptions, ConvertOptions, Converted, convert};
pub use error::{Error, Result};
pub use facing::facing;
pub use figure::Figure;
pub use joint_map::{RigJointMap, rig_joint_map};
#[cfg(feature = "prepare")]
pub use mesh_level_rows::{MeshLevelBytes, MeshLevelRow};
pub use mesh_levels::MeshLevelOptions;
#[cfg(feature = "prepare")]
pub use mesh_levels::{CodedMeshLevels, KeptFace, MeshLevelStream};
pub use mesh_levels::{
    LevelChoice, MeshView, ShownInView, ShownLevelOptions, ShownLevels, ShownLevelsReport,
    ShownRegion,
};
pub use motion_tables::{MotionTables, StoredTables};
pub use open::{
    CharacterFile, Data, DataFile, DataFormat, Format, GltfSource, OpenOptions, WriteSupport,
    choose, conversions, open, open_data, readable, reference_human, reference_mannequin,
};
#[cfg(feature = "flat")]
pub use painted_human::painted_human;
#[cfg(feature = "prepare")]
pub use prepare::{
    CheckedPart, ClipTables, PartBytes, PartState, PrepareOptions, PreparedAsset, PreparedCheck,
    PreparedMeshLevels, PreparedPart, check_prepared, prepare,
};
pub use recording::Recording;
pub use resampling::{ClipResampling, clip_resampling};
#[cfg(feature = "flat")]
pub use texture_atlas::TextureAtlas;
pub use work::{Executor, Job, JobRunner, Step, StepCallback};

pub use articula_build as build;
pub use articula_core as core;
#[cfg(feature = "flat")]
pub use articula_flat as flat;
pub use articula_formats as formats;
pub use articula_human as human;
#[cfg(feature = "streams")]
pub use articula_stream as stream;

pub use articula_core::joint_state::LoaRange;
pub use articula_core::playback;
pub use articula_core::{
    Camera, GroupedSkin, PosedMesh, SkinnedMesh, Viewport, Wrap, sample, sample_morphs,
};
pub use glam;

/// The example of the readme.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
