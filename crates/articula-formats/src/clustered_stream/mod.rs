//! Mesh levels of a character as one stream that refines: a head, then chunks, level after level.
//!
//! Source: `spec/clustered-mesh.md` 7 (TRANSPORT form); the page is
//! `docs/formats/clustered-stream.md`. A chunk holds what one level adds to one object (a part of a
//! mesh, or a region of it), coded by [`mesh_codec`](crate::mesh_codec); no vertex is ever sent
//! twice. Any prefix of whole levels shows the character.
//!
//! - [`write()`]: levels to bytes, with the map of what is where; also one level alone
//! - [`MeshStream`]: the head, opened
//! - [`Receiver`]: the client's side, which checks, decodes and puts together

mod head;
mod receiver;
mod write;

pub use head::{MeshStream, StreamObject};
pub use receiver::Receiver;
pub use write::{ObjectLevels, Written, write};

/// Hash of a chunk: the first 8 bytes of BLAKE3 over the level, the object's record and the
/// coded bytes. It tells a damaged chunk, or one in the wrong place; it is no signature.
type Hash = [u8; 8];

fn hash(level: usize, record: &[u8], chunk: &[u8]) -> Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(level as u32).to_le_bytes());
    hasher.update(&(record.len() as u32).to_le_bytes());
    hasher.update(record);
    hasher.update(chunk);
    let all = hasher.finalize();
    let mut first = Hash::default();
    first.copy_from_slice(&all.as_bytes()[..8]);
    first
}
