//! Readers and writers of character files: from bytes to an editable character, and back.
//!
//! Every reader takes bytes and [`Limits`] and returns a value with warnings for what it repaired,
//! or one error that names the position of the fault. External files (buffers, pictures) are
//! requested from a [`Resolver`], so nothing here opens a file.
//!
//! - [`gltf`]: GLB and glTF 2.0, including VRM; read and write
//! - [`meshopt`]: the codec of compressed glTF buffer views; decode only
//! - [`acclaim`]: ASF skeletons and AMC motions; read and write
//! - [`bva`]: Biovision animation, segments without a hierarchy; read
//! - [`bvh`]: Biovision hierarchical motion; read and write
//! - [`mpeg4`]: FAP, BAP, EPF and FDP text
//! - [`x3d`]: H-Anim figures in X3D and VRML97; read both, write X3D
//! - `fbx`, with the feature of that name: FBX characters and motions; read
//! - [`joint_map`]: joint maps, from joint name to H-Anim joint, level and region
//! - [`face_map`]: face maps, from name to what a morph target or an expression shows
//! - [`face_points`]: feature points of a face
//! - [`live_link`]: face captures of Live Link Face as CSV; read and write
//! - [`loa_profile`]: a saved selection of levels of articulation
//! - [`write_key_table`], [`write_pose_keys`]: motion-error tables as bytes
//! - [`Limits`], [`ReadError`], [`Warning`]: bounds on input, errors, repairs
//! - [`ReadOptions`], [`MotionFile`]: facts that motion files omit, and their content
//! - [`WrittenFile`], [`WriteError`]: results of writers
//!
//! ```
//! use articula_formats::gltf::{self, Document};
//! use articula_formats::{Limits, ReadOptions, bvh};
//!
//! let text = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 90 0\n CHANNELS 3 Zrotation Xrotation Yrotation\n \
//!     JOINT Head\n {\n  OFFSET 0 60 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  End Site\n  \
//!     {\n   OFFSET 0 20 0\n  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: 0.5\n0 0 0 0 0 0\n0 0 9 0 0 0\n";
//! let limits = Limits::default();
//! let motion = bvh::read(text.as_bytes(), &ReadOptions::default(), &limits)?;
//! assert_eq!(motion.value.character.skeleton.joints[0].name, "Hips");
//!
//! // The same character as a GLB, and back.
//! let glb = Document::from_character(&motion.value.character)?.write_glb()?;
//! let mut beside = |uri: &str| Err(format!("there is no {uri}"));
//! let back = gltf::read(&glb, &limits, &mut beside)?;
//! assert_eq!(back.value.character.clips[0].duration_secs, 0.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate uses no paths, files or threads and makes no decision about a character. No input
//! makes it panic, hang or use unbounded memory.

pub mod acclaim;
pub mod bva;
pub mod bvh;
mod capture_text;
mod damage;
mod error;
mod euler;
pub mod face_map;
pub mod face_points;
#[cfg(feature = "fbx")]
pub mod fbx;
pub mod gltf;
pub mod joint_map;
mod limits;
pub mod live_link;
pub mod loa_profile;
pub mod meshopt;
mod motion_file;
mod motion_table;
pub mod mpeg4;
mod notes;
pub mod prepared;
mod sampled;
mod stature;
mod units;
mod uri;
mod words;
mod written;
pub mod x3d;

pub use error::{Assumption, Parsed, ReadError, Warning};
pub use limits::Limits;
pub use motion_file::{MotionFile, ReadOptions};
pub use motion_table::{
    read_compact_clip, read_contact_table, read_error_matrix, read_key_table, read_pose_keys,
    write_compact_clip, write_contact_table, write_error_matrix, write_key_table, write_pose_keys,
};
pub use units::UpAxis;
pub use written::{WriteError, WrittenFile};

/// Fetches an external file by its relative URI (already percent-decoded).
pub type Resolver<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;
