//! The extension `ARTICULA_clustered_mesh`: levels of meshes as ranges of stored triangles.
//!
//! Vertices of a primitive are in the order in which successive levels add them, and its own index
//! list is the finest level, so any viewer shows that. The primitive's extension names a longer
//! index list that begins with the primitive's own, and states which levels show which of its
//! triangles. The document's extension has a row for each level. The page is
//! `docs/formats/ARTICULA_clustered_mesh.md`; the schema is next to it.
//!
//! - `write`, `level_table`: write levels into a document
//! - `read`: reads levels from a document
//! - `version`: order of levels in older documents
//! - `level_nodes`: the same levels as nodes of `MSFT_lod`

mod level_nodes;
mod level_table;
mod read;
mod version;
mod write;

pub use write::{MeshParts, PartLevels};

pub(super) use level_table::read_levels;
pub(super) use read::read_parts;
