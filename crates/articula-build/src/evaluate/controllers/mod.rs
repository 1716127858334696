//! Controllers of the evaluated methods that are not in the core: they run in the same playback as
//! those that ship, and are measured in the same way.

mod closed_loop;
mod held;
mod segments;
mod skipped;

pub(super) use closed_loop::ClosedLoop;
pub(super) use held::{Held, HeldView};
pub(super) use segments::Segments;
pub(super) use skipped::Skipped;
