//! Vector graphics, still and moving: what is written, and what reads it back.
//!
//! Source: thesis 4.2, `spec/vector.md` 7 to 11; what the files hold: `docs/formats/svg.md`.
//!
//! - [`keyed_clip`]: shapes with keys, what the key-framed writers take
//! - [`lottie`]: Lottie JSON
//! - [`path`]: the shortest text for outlines, numbers, colours and ids
//! - [`player`]: a clip as a small file with a small player
//! - [`raster`]: still SVG to pixels
//! - [`smil`]: animated SVG from key to key, without script
//! - [`smil_sampler`]: what such a file shows at a moment, as still SVG
//! - [`flipbook`]: animated SVG with a group for each frame
//! - [`moving_picture`]: GIF and animated WebP
//! - [`thesis`]: the files of the thesis, the baseline of all ratios
//! - [`still`]: one frame as SVG

pub mod flipbook;
pub mod keyed_clip;
pub mod lottie;
pub mod moving_picture;
pub mod path;
pub mod player;
pub mod raster;
pub mod smil;
pub mod smil_sampler;
pub mod still;
mod svg_text;
pub mod thesis;

pub use keyed_clip::{KeyedClip, KeyedPaint, KeyedShape, KeyedTrack, LineUnits};
