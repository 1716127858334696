//! Conversion of a planar clip to a file, with its size and error; under a byte budget, at the best
//! quality that fits.
//!
//! Source: `docs/methods/vector.md` 1, 4 and 9.
//!
//! - [`PreparedClip`]: visibility, painting order and its wrong pixels, computed once for all
//!   settings
//! - [`Settings`]: a [`Profile`] and its tolerances ([`Quality`])
//! - [`ReferenceFrames`]: reference pictures of the simplified character; [`SourceFrames`]:
//!   pictures of the character itself, from which the largest local difference is measured
//! - [`flatten()`]: writes a file, under a byte budget at the best of the quality steps;
//!   [`flatten_unmeasured`]: writes a file without measuring pictures of it;
//!   [`flatten_live`]: writes a file that a host drives
//! - [`Flattened`]: bytes, [`FileSize`], [`FileErrors`], and the [`Representation`] that a decision
//!   compares
//!
//! Long work reports its progress and can be cancelled ([`articula_core::Progress`]).

mod live;
mod pages;
mod prepared;
mod reference_frames;
mod report;
mod search;
mod settings;
mod source_frames;
mod strays;
mod written;

pub use crate::local_difference::{JudgedRegion, LocalDifferences, WorstDifference};
pub use crate::vector::player::ShownTexture;
pub use live::flatten_live;
pub use prepared::{PrepareClipOptions, PreparedClip};
pub use reference_frames::{ImageError, ReferenceFrames, sampled_frames};
pub use report::{FileErrors, FileSize, Representation};
pub use search::{Flattened, TriedQuality, Unmeasured, flatten, flatten_unmeasured};
pub use settings::{Profile, Quality, Settings};
pub use source_frames::{DroppedDetail, SourceFrames, SourceTime, dropped_detail};
