//! Digital items: a character as a folder of streams that can be cut, with a manifest of bytes and
//! errors.
//!
//! Form: `docs/formats/item.md`. Source: ISO/IEC 21000-2 and 21000-7 (digital items and their
//! adaptation), thesis 3.1 and 6.1.
//!
//! ```text
//! CharacterFile ─ package ─▶ Item: files by name, Manifest
//! Item ─ Item::kept ─▶ Item: fewer layers, cut by unit tree alone
//! Item, Context ─ decide ─▶ ItemDecision ─ adapt ─▶ AdaptedItem: what is sent in a context
//! Item ─ assemble ─▶ CharacterFile: what the item holds, whole or cut
//! ```
//!
//! In the order of the work:
//!
//! - `options`, `package`: from a character to an item
//! - `figure`: the character without geometry, clips and large pictures
//! - `mesh_part`, `motion_part`, `face_part`, `texture_part`, `flat`: its parts, with measured errors
//! - `motion_error`: the error of motions at the skin
//! - `manifest`, `part`, `check`: what an item holds, as JSON
//! - `governed`: which units belong to which layers
//! - `name`, `files`: names of files, and the item itself
//! - `adapt`: from an item to one that a context asks for
//! - `decoded_mesh`, `assemble`: from an item to a character
//!
//! ```
//! use articula::item::{PackageOptions, assemble, package};
//! use articula::{Executor, reference_human};
//!
//! # fn main() -> articula::Result<()> {
//! let options = PackageOptions { mesh_levels: 2, flat: false, ..PackageOptions::default() };
//! let human = reference_human(600, &Default::default())?;
//! # let human = { let mut human = human; human.character.clips.truncate(1); human };
//! let item = package(human, &options, &Executor::default())?;
//! let mesh = &item.manifest.parts[0];
//! // The coarsest level alone is a usable character.
//! let coarse = item.kept(|part, layer| part.kind != mesh.kind || layer == 0)?;
//! assert!(coarse.bytes() < item.bytes());
//! assert!(assemble(&coarse, &Default::default())?.character.meshes.len() > 0);
//! # Ok(())
//! # }
//! ```

mod adapt;
mod assemble;
mod check;
mod decoded_mesh;
mod face_part;
mod figure;
mod files;
mod flat;
mod governed;
mod manifest;
mod mesh_part;
mod motion_error;
mod motion_part;
mod name;
mod options;
mod package;
mod part;
mod texture_part;

pub use adapt::{AdaptOptions, AdaptedItem, ItemDecision, ItemParts, PartLayers, adapt, decide};
pub use assemble::assemble;
pub use files::{INDEX_EXTENSION, Item, MANIFEST};
pub use manifest::{FigureEntry, FlatEntry, Manifest, WholeFile};
pub use options::{CarriedFile, FaceMotion, PackageOptions};
pub use package::package;
pub use part::{ItemLayer, ItemPart, MeshLevelEntry, PartKind, RegionEntry, TextureView};
