//! Vector graphics, still and moving: what is written, and what reads it back.
//!
//! Source: thesis 4.2, `docs/methods/vector.md` 7 to 11; what the files hold: `docs/formats/svg.md`.
//! [`crate::flatten`] chooses among the writers and measures what they give.
//!
//! - [`player`]: a clip as a small file with a small player
//! - [`AnimatedSvg`], [`raster()`]: what animated SVG of ours shows at a moment, and its pixels
//! - [`gif()`], [`webp()`]: pictures as a movie
//! - [`thesis()`]: the files of the thesis, the baseline of all ratios
//!
//! Inside stand `smil` and `lottie` (a clip of keyed shapes as animated SVG without script, as
//! Lottie), the flip-book, stills, and the shortest text for outlines, numbers and colours.

pub(crate) mod flipbook;
mod lottie;
mod moving_picture;
mod path;
pub mod player;
mod raster;
mod smil;
mod smil_sampler;
pub(crate) mod still;
mod svg_text;
pub(crate) mod thesis;

pub(crate) use lottie::lottie;
pub use moving_picture::{gif, webp};
pub use raster::raster;
pub(crate) use smil::smil;
pub use smil_sampler::AnimatedSvg;
pub use thesis::{ThesisFile, ThesisForm, ThesisSvgOptions, thesis};
