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
//! Manifest, ItemCut ─ ItemReceiver::missing ─▶ ItemBytes to fetch ─ ItemReceiver::receive ─▶ ItemReceiver
//! ItemReceiver ─ ItemReceiver::character ─▶ CharacterFile: what has arrived
//! Item, Context ─ TracePlayer::new, TracePlayer::play ─▶ TracePlayback: what a client shows over time
//! ```
//!
//! In the order of the work:
//!
//! - `options`, `package`, `draft`: from a character to an item, in stages
//! - `figure`: the character without geometry, clips and large pictures
//! - `mesh_part`, `motion_part`, `face_part`, `texture_part`, `flat`: its parts, with measured errors
//! - `motion_error`: the error of motions at the skin
//! - `carried`: files that are never cut
//! - `manifest`, `part`, `check`: what an item holds, as JSON
//! - `governed`: which units belong to which layers, and where they lie
//! - `sent`: how files travel; `rounding`: numbers of few digits, for short manifests
//! - `name`, `files`: names of files, and the item itself
//! - `adapt`: from an item to one that a context asks for; `decision_report`: what was decided, as JSON
//! - `documents`: declaration, descriptions, table and stylesheet after MPEG-21
//! - `decoded_mesh`, `shown`, `assemble`: from an item to a character
//! - `wanted`, `pieces`, `stream_receiver`, `receiver`, `renewed`: the same while its bytes arrive, in any order
//! - `delivery`: an item in pieces, and the levels of quality that they make
//! - `trace`: an item played over a recorded bandwidth
//!
//! ```no_run
//! use articula::item::{PackageOptions, PartKind, assemble, package};
//! use articula::{Executor, OpenOptions, fs};
//!
//! # fn main() -> articula::Result<()> {
//! let human = fs::open("human.glb")?;
//! let item = package(human, &PackageOptions::default(), &Executor::default())?;
//! // The coarsest mesh level, all motions, textures at their smallest size.
//! let coarse = item.kept(|part, layer| {
//!     layer == 0 || matches!(part.kind, PartKind::BodyMotion | PartKind::FaceMotion)
//! })?;
//! assert!(coarse.bytes() < item.bytes());
//! let shown = assemble(&coarse, &OpenOptions::default())?;
//! # let _ = shown;
//! # Ok(())
//! # }
//! ```

mod adapt;
mod assemble;
mod carried;
mod check;
mod decision_report;
mod decoded_mesh;
pub(crate) mod delivery;
mod documents;
mod draft;
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
mod pieces;
mod receiver;
mod renewed;
mod rounding;
mod sent;
mod shown;
mod stream_receiver;
mod texture_part;
mod trace;
mod wanted;

pub(crate) use adapt::texture_error_px;
pub use adapt::{
    AdaptOptions, AdaptedItem, ItemCut, ItemDecision, ItemParts, PartLayers, Regions, Transform,
    adapt, adapt_by_description, aqos, decide, decide_by_table,
};
pub use assemble::assemble;
pub use decision_report::{DecisionReport, NextReport, PartReport};
pub use documents::{AQOS, DID, STYLESHEET, declaration, documents, gbsd};
pub use files::{INDEX_EXTENSION, Item, MANIFEST};
pub use manifest::{FigureEntry, FlatEntry, Manifest, WholeFile};
pub use options::{CarriedFile, FaceMotion, PackageOptions};
pub use package::{StageCallback, package, package_in_stages};
pub use part::{ItemLayer, ItemPart, MeshLevelEntry, PartKind, RegionEntry, TextureView};
pub use receiver::{ItemChange, ItemReceiver};
pub use sent::{FileEntry, compressed, decompressed};
pub use trace::{TraceOptions, TracePlayback, TracePlayer, TracePolicy, TraceSample};
pub use wanted::ItemBytes;
