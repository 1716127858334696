//! A crowd of one character, played and measured: what `crowd` and `demo` have in common.
//!
//! A run has two passes over the same frames. The first is timed and does nothing else; the second
//! looks at what the first has shown: true errors, levels, a hash of every palette.
//!
//! - [`cast`]: the character with its levels, ready for a crowd
//! - [`figure`]: coarser meshes that go with coarser joints
//! - [`scene_file`]: who stands where, read from a file or saved to one
//! - [`stage`]: one frame after the other, on one thread or several
//! - [`output`]: the memory that palettes are written to, and reading them again
//! - [`timing`]: processor time of threads, and its spread over frames
//! - [`purse`]: what a frame may cost, learnt from frames before
//! - [`run`]: both passes
//! - [`pixel_error`]: what is shown against what should be, in pixels
//! - [`tiers`]: who is shown at which level, and what a renderer pays for it
//! - [`picture`]: the same to look at, coloured by level

pub(crate) mod cast;
pub(crate) mod figure;
pub(crate) mod output;
pub(crate) mod picture;
pub(crate) mod pixel_error;
pub(crate) mod purse;
pub(crate) mod run;
pub(crate) mod scene_file;
pub(crate) mod stage;
pub(crate) mod tiers;
pub(crate) mod timing;
