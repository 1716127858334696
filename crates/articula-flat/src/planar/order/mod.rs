//! Painting order of triangles, and the pixels that it leaves wrong.
//!
//! Source: `docs/methods/vector.md` 4. Vector players have no depth buffer: what is painted later
//! covers what was painted before. Wherever a drawn triangle covers a sample that another one owns
//! in the item buffer, it has to be painted first; where such constraints contradict each other,
//! the order with the fewest wrong samples is searched. Triangles that are drawn while hidden
//! (short gaps) are constrained too.
//!
//! - `overlap`: sets of triangles that cover each other at a sample, summed up
//! - `graph`: a first order, by strongly connected components and least incoming weight
//! - `sift`: moves single triangles to where they leave the fewest wrong samples
//! - `epochs`: spans of frames that share one order
//! - `gaps`: short gaps in which hidden triangles are not drawn
//! - `painting`: the order itself
//! - `painted`: visibility, order and overlaps of a clip
//! - `layers`: one list with copies that contains every epoch's order
//! - `comparison`: wrong pixels of each ordering method

mod comparison;
mod epochs;
mod gaps;
mod graph;
mod layers;
mod overlap;
mod painted;
mod painting;
mod sift;

pub use comparison::OrderComparison;
pub(crate) use layers::Layer;
pub(crate) use overlap::Overlaps;
#[cfg(test)]
pub(crate) use overlap::wrong_pixels;
pub(crate) use painted::Painted;
pub use painting::OrderOptions;
pub(crate) use painting::{Epoch, Painting};

#[cfg(test)]
mod tests;
