//! Opening of files that are whole in memory.

use articula::formats::Limits;
use articula::{CharacterFile, OpenOptions, Result, open};

/// What a file may ask for: decoded arrays of half a gigabyte, since addresses have 32 bits, and a failed allocation
/// ends the module.
const LIMITS: Limits = Limits {
    bytes: 1 << 29,
    elements: 1 << 25,
    nodes: 1 << 16,
    depth: 128,
    frames: 1 << 20,
};

/// How files are opened.
pub(crate) fn open_options() -> OpenOptions {
    OpenOptions {
        limits: LIMITS,
        ..OpenOptions::default()
    }
}

/// Opens a file with no others beside it.
pub(crate) fn open_alone(bytes: &[u8], name: &str) -> Result<CharacterFile> {
    let mut alone =
        |_: &str| Err("only what is in the file can be read; give a .glb file".to_owned());
    open(bytes, name, &open_options(), &mut alone)
}
