//! The library in web pages, as classes for JavaScript.
//!
//! Two modules are built from this crate by `cargo xtask web`: *play*, with the feature of that name, opens GLB and
//! VRM files and plays figures and crowds; *tools*, with both features, also prepares, converts, flattens and
//! packages characters of all formats, in a worker. The documentation of a class is that of its TypeScript
//! declaration. `docs/web.md` describes both.
//!
//! - `asset::Asset`: an opened character; `geometry::Geometry`: the vertices of a mesh
//! - `figure::Figure`: one character in motion; `crowd::Crowd`: many of one character
//! - `tools::Tools`: what takes long
//! - `error::Fault`: every call that can fail throws an `ArticulaError`
//!
//! What changes in every frame is not copied: methods whose names end in `_at` return byte offsets into the memory
//! of the module. JavaScript makes its views there, so this crate has no unsafe code of its own.

mod asset;
mod crowd;
mod crowd_arrays;
mod crowd_options;
mod error;
mod expressions;
mod figure;
mod geometry;
mod materials;
mod matrix_rows;
mod metric;
mod morphs;
mod opening;
mod picking;
#[cfg(feature = "tools")]
mod tools;
mod view;
