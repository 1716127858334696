//! Tests of the reader of FBX: real files against the values of another reader, each repair by a small file, and
//! hostile files.

mod hostile;
mod legacy;
mod mutated;
mod repairs;
mod shipped;
mod tiny;

use articula_formats::fbx::{self, FbxFile};
use articula_formats::{Limits, Parsed, ReadError, ReadOptions};

/// Reads a file without pictures beside it.
fn read(bytes: &[u8]) -> Result<Parsed<FbxFile>, ReadError> {
    let mut alone = |name: &str| Err(format!("there is no {name}"));
    let (options, limits) = (ReadOptions::default(), Limits::default());
    fbx::read(bytes, "a", &options, &limits, &mut alone)
}
