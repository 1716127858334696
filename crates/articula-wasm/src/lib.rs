//! The library in web pages, as classes for JavaScript.
//!
//! Modules are built from this crate by `cargo xtask web`, each with the feature of its name: *play* opens GLB and VRM
//! files and plays figures and crowds, *stream* shows a character of a server while it arrives; *tools* prepares,
//! converts and describes characters of all formats in a worker, *publish* makes 2D pictures, items and lighter
//! files of them, moves their faces, evaluates level of detail and benchmarks the device. The documentation of a class is that of its TypeScript declaration. `docs/web.md` describes all.
//!
//! - `asset::Asset`: an opened character; `geometry::Geometry`: the vertices of a mesh
//! - `figure::Figure`: one character in motion; `crowd::Crowd`: many of one character
//! - `levels`, `steering`: which joints move, what decides it, and what that shows
//! - `stream::Client`: characters of a server, and its `Arrival`, what is shown of one
//! - `tools::Tools`, `publish::Publisher`: what takes long
//! - `error::Fault`: every call that can fail throws an `ArticulaError`
//!
//! What changes in every frame is not copied: methods whose names end in `_at` return byte offsets into the memory
//! of the module. JavaScript makes its views there, so this crate has no unsafe code of its own.

#[cfg(any(feature = "play", feature = "stream"))]
mod asset;
#[cfg(feature = "play")]
mod clip_events;
#[cfg(feature = "play")]
mod crowd;
#[cfg(feature = "play")]
mod crowd_arrays;
#[cfg(feature = "play")]
mod crowd_options;
mod error;
#[cfg(any(feature = "play", feature = "stream"))]
mod expression_names;
#[cfg(feature = "play")]
mod expressions;
#[cfg(feature = "play")]
mod figure;
#[cfg(any(feature = "play", feature = "stream"))]
mod geometry;
#[cfg(feature = "play")]
mod levels;
#[cfg(any(feature = "tools", feature = "publish"))]
mod long_options;
#[cfg(any(feature = "play", feature = "stream"))]
mod materials;
#[cfg(any(feature = "play", feature = "stream"))]
mod matrix_rows;
#[cfg(feature = "play")]
mod metric;
#[cfg(any(feature = "play", feature = "stream"))]
mod morphs;
mod opening;
#[cfg(feature = "play")]
mod picking;
#[cfg(any(feature = "tools", feature = "publish"))]
mod progress;
#[cfg(feature = "publish")]
mod publish;
#[cfg(feature = "play")]
mod steering;
#[cfg(feature = "stream")]
mod stream;
#[cfg(any(feature = "play", feature = "stream"))]
mod texture_coordinates;
#[cfg(feature = "tools")]
mod tools;
#[cfg(any(feature = "play", feature = "stream"))]
mod variants;
#[cfg(feature = "play")]
mod view;
