//! In which order triangles are painted, and which pixels that leaves wrong.
//!
//! Source: `docs/methods/vector.md` 4. Vector players have no depth buffer: what is painted later lies
//! on top. Wherever a triangle that is painted covers a sample that another one owns in the
//! item buffer, it has to come first; where such constraints contradict each other, the order
//! that leaves fewest samples wrong is sought.
//!
//! - `overlap`: who covers whom, sample by sample, summed up
//! - `graph`: a first order, by strongly connected components and least incoming weight
//! - `sift`: moves single triangles to where they leave fewest samples wrong
//! - `epochs`: spans of frames that share one order
//! - `gaps`: hidden triangles that are better not painted
//! - `painting`: the order itself
//! - `painted`: all of this for a clip: what is drawn, in which order, what stays wrong
//! - `layers`: one list with copies that shows every epoch's order
//! - `comparison`: what the ways of ordering show wrong, beside each other
//!
//! Differs: constraints also bind what is painted but hidden (short gaps are drawn), and an
//! order is improved by sifting after the greedy choice.

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
pub(crate) use overlap::{Overlaps, wrong_pixels};
pub(crate) use painted::Painted;
pub use painting::OrderOptions;
pub(crate) use painting::{Epoch, Painting};

#[cfg(test)]
mod tests;
