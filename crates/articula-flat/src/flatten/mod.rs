//! One call from a planar clip to a file with its size and error; with a byte budget, the best
//! setting that fits.
//!
//! Source: `spec/vector.md` 1, 4 and 9.
//!
//! - [`prepared`]: what is drawn, in which order, and what that leaves wrong, worked out once
//! - [`settings`]: profiles and how near to the truth they come
//! - [`written`]: a file of a profile, and what it shows at any moment
//! - [`live`]: a file that a host drives
//! - [`pages`]: the pages of a flip-book
//! - [`search`]: the best setting of a ladder under a byte budget
//! - [`truth`]: what the character really looks like
//! - [`report`]: sizes, errors, and the entry of what can stand for a character

pub mod live;
pub mod pages;
pub mod prepared;
pub mod report;
pub mod search;
pub mod settings;
pub mod truth;
pub mod written;

pub use live::flatten_live;
pub use prepared::{PrepareOptions, Prepared};
pub use report::{Entry, Errors, Sizes};
pub use search::{Flattened, Trial, flatten};
pub use settings::{Profile, Quality, Settings};
pub use truth::{ImageError, Truth, sampled_frames};
