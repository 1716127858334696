//! The library.

mod camera_path;
pub mod convert;
pub mod crowd;
mod error;
mod figure;
#[cfg(not(target_family = "wasm"))]
pub mod fs;
mod mesh_levels;
mod motion_tables;
mod open;
mod prepare;
mod work;

pub use camera_path::read_camera_path;
pub use convert::{AddClipsOptions, ConvertOptions, Converted, convert};
pub use error::{Error, Result};
pub use figure::Figure;
pub use mesh_levels::{CodedMeshLevels, MeshLevelOptions, MeshLevelStream};
pub use motion_tables::{ClipTables, StoredTables, stored_tables};
pub use open::{
    Data, DataFormat, Format, GltfSource, OpenOptions, Opened, OpenedData, Writes, choose,
    conversions, open, open_data, readable,
};
pub use prepare::{PrepareOptions, Prepared, prepare};
pub use work::{Job, OnStep, RunJobs, Step, Work};

pub use glam;
