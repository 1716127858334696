//! The extension `ARTICULA_clustered_mesh`: levels of meshes as ranges of stored triangles.
//!
//! Vertices of a primitive stand in the order in which level after level adds them, and its own
//! index list is the finest level, so that any viewer shows that. The extension of the primitive
//! names a longer index list, of which the primitive's own is the first part, and says which
//! levels show which triangles of it. The extension of the document has a row for each level.
//! The page is `docs/formats/ARTICULA_clustered_mesh.md`, the schema stands beside it.
//!
//! - `write`, `level_table`: levels into a document
//! - `read`: levels out of a document
//! - `version`: from which end older documents count levels
//! - `level_nodes`: the same levels as nodes of `MSFT_lod`

mod level_nodes;
mod level_table;
mod read;
mod version;
mod write;

pub use write::{MeshParts, PartLevels};

pub(super) use level_table::read_levels;
pub(super) use read::read_parts;
