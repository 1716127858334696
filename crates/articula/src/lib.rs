//! The library.

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
    Data, DataFormat, Format, GltfSource, OpenOptions, Opened, OpenedData, Writes, choose,
    conversions, open, open_data, readable,
};
pub use prepare::{PrepareOptions, Prepared, prepare};
pub use work::{Job, OnStep, RunJobs, Step, Work};

pub use articula_core::{Camera, PosedMesh, SkinnedMesh, Viewport, Wrap, sample, sample_morphs};
pub use glam;
