//! Editing of source clips: trimming, resampling, loops, root motion and key reduction.
//!
//! - [`trim`]: cuts a part out of a clip, with exact keys at both cuts
//! - [`resample_keys`]: keys every channel at one rate
//! - [`find_loop`], [`close_loop`]: find the part that loops and make its ends meet
//! - [`split_root_motion`]: separates the travel over the ground from the rest
//! - [`reduce_keys`]: removes keys, with a bound in metres of the character
//!
//! All of them take a source clip and return a source clip, with measurements of the change.

pub(crate) mod channel;
pub(crate) mod grid;
pub(crate) mod heading;
pub(crate) mod pieces;
pub(crate) mod similarity;
mod spline;
mod subject;
#[cfg(test)]
mod test_clips;

mod cycle;
mod key_reduction;
mod rate;
mod root_motion;
mod trim;

pub use cycle::{CloseOptions, ClosedLoop, LoopCycle, MIN_SCORE, close_loop, find_loop};
pub use key_reduction::{
    KeyReduction, ReduceOptions, ReducedClip, Timelines, reduce_keys, value_tolerances,
};
pub use rate::resample_keys;
pub use root_motion::{
    RootMotion, RootMotionMode, RootMotionOptions, TrajectoryKey, split_root_motion,
};
pub use subject::EditSubject;
pub use trim::{skip_first_frame, trim};
