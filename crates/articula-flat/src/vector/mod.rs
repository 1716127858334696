//! Still and animated vector graphics: writers, and readers of what they wrote.
//!
//! Source: thesis 4.2, `docs/methods/vector.md` 7 to 11; file contents: `docs/formats/svg.md`.
//! [`crate::flatten`] chooses among the writers and measures the files.
//!
//! - [`player`]: a clip as a small file with a small player
//! - [`AnimatedSvg`], [`raster()`]: samples an animated SVG of this crate at a time, and rasterises
//!   it
//! - [`gif()`], [`webp()`]: pictures as a movie
//! - [`thesis()`]: the files of the thesis, the baseline of all ratios
//!
//! Private modules: `smil` and `lottie` (a clip of keyed shapes as animated SVG without script, as
//! Lottie), the flipbook, stills, and the shortest text for outlines, numbers and colours.

pub(crate) mod flipbook;
mod lottie;
mod moving_picture;
mod path;
pub mod player;
mod raster;
mod smil;
mod smil_motion;
mod smil_sampler;
pub(crate) mod still;
mod svg_text;
pub(crate) mod thesis;

pub(crate) use lottie::lottie;
pub use moving_picture::{gif, webp};
pub use raster::raster;
pub(crate) use raster::raster_scaled;
pub(crate) use smil::smil;
pub use smil_sampler::AnimatedSvg;
pub use thesis::{ThesisFile, ThesisForm, ThesisSvgOptions, thesis};
