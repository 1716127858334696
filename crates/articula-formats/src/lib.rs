//! How a virtual human is written down: from bytes to editable nouns, and back.
//!
//! Every reader takes bytes and limits, and gives a value with warnings or one error that
//! names the place. What lies beside a file (buffers, pictures) is asked of a resolver, so
//! nothing here opens a file.
//!
//! - [`gltf`]: GLB and glTF 2.0, VRM files as such, in and out
//! - [`meshopt`]: the codec of compressed glTF buffer views, decoding only
//! - [`acclaim`]: ASF skeletons and AMC motions, in and out
//! - [`bva`]: Biovision animation, segments without a hierarchy, in
//! - [`bvh`]: Biovision hierarchical motion, in and out
//! - [`mpeg4`]: FAP, BAP, EPF and FDP text
//! - [`x3d`]: H-Anim figures in X3D and VRML97
//! - [`profile`]: joint-name profiles, name to H-Anim joint, level and region
//! - [`loa_profile`]: a saved selection of levels of articulation
//! - [`motion_table`]: motion-error tables as bytes
//! - [`error`], [`limits`]: what can be wrong, and how much is too much

pub mod acclaim;
pub mod bva;
pub mod bvh;
pub mod error;
mod euler;
pub mod gltf;
pub mod limits;
pub mod loa_profile;
pub mod meshopt;
pub mod motion_table;
pub mod mpeg4;
mod notes;
pub mod profile;
mod sampled;
mod units;
mod uri;
mod words;
pub mod x3d;

pub use error::{Guess, Read, ReadError, Warning};
pub use limits::Limits;

/// Fetches what lies beside a file by its relative URI (already percent-decoded).
pub type Resolver<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;
