//! Mesh levels of a character as one progressive stream: a head, then chunks, level by level.
//!
//! Source: `docs/methods/clustered-mesh.md` parts 7 (TRANSPORT form) and 8.1; the formats are
//! described in `docs/formats/clustered-stream.md` and `docs/formats/mesh-stream.md`. A chunk holds
//! the data that one level adds to one object (a part of a mesh, or a region of it); no vertex is
//! sent twice. Any prefix of whole levels is a complete character.
//!
//! - [`quantise`], [`restore`]: conversion from floating point to whole numbers and back
//! - [`encode_level`], [`decode_level`]: one level, alone or as a refinement of a coarser one
//! - [`write()`]: encodes all levels of all objects, with a map of the stream
//! - [`MeshStream`]: the parsed head
//! - [`Receiver`]: client side, which checks and decodes chunks and assembles meshes
//!
//! ```
//! use articula_core::{LevelRow, LevelTable, SurfaceError};
//! use articula_core::source::Primitive;
//! use articula_stream::StreamLimits;
//! use articula_stream::mesh::{
//!     Grid, ObjectLevels, Precision, Receiver, StreamObject, quantise, write,
//! };
//! use glam::Vec3;
//!
//! // A square of four triangles around its centre; level 1 shows two without it.
//! let part = Primitive {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::splat(0.5)],
//!     influences: 1,
//!     joints: vec![0; 5],
//!     weights: vec![1.0; 5],
//!     ..Primitive::default()
//! };
//! let triangles = [
//!     vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
//!     vec![[0, 1, 2], [0, 2, 3]],
//! ];
//! let precision = Precision::default();
//! let grid = Grid::new(std::slice::from_ref(&part), precision.position_bits)?;
//! let coded = quantise(&part, &triangles, &grid, &precision)?;
//! let row = |triangles, vertices, max_metres| LevelRow {
//!     triangles,
//!     vertices,
//!     rest: SurfaceError { max_metres, ..SurfaceError::default() },
//!     motion: SurfaceError { max_metres, ..SurfaceError::default() },
//! };
//! let table = LevelTable {
//!     levels: vec![row(4, 5, 0.0), row(2, 4, 0.5)],
//!     ..LevelTable::default()
//! };
//! let object = ObjectLevels {
//!     object: StreamObject {
//!         mesh: 0,
//!         primitive: 0,
//!         region: 0,
//!         layout: coded.layout,
//!         scale: coded.scale,
//!     },
//!     levels: coded.levels,
//! };
//! let written = write(&table, &[object], 0..2)?;
//!
//! // Cut off after the coarser level, it is a whole, coarser square.
//! let coarse = written.unit.children[1].bits.end as usize / 8;
//! let mut client = Receiver::read(&written.bytes[..coarse], &StreamLimits::default())?;
//! assert_eq!((client.finest_level(0), client.next_level(0)), (Some(1), Some(0)));
//! assert_eq!(client.mesh(0).map(|m| m.faces.len()), Some(2));
//! client.refine(0, &written.bytes[coarse..])?;
//! assert_eq!(client.mesh(0).map(|m| m.faces.len()), Some(4));
//! # Ok::<(), articula_stream::StreamError>(())
//! ```

mod codec;
mod hash;
mod head;
mod receiver;
mod write;

pub use codec::{
    Grid, Layout, MorphLayout, Precision, Quantised, QuantisedMesh, Scale, decode_level,
    encode_level, quantise, restore,
};
pub use head::{MeshStream, StreamObject};
pub use receiver::Receiver;
pub use write::{EncodedMeshStream, ObjectLevels, write};
