//! Clips made clean before anything else is done with them.
//!
//! - [`trim`]: a part of a clip, its keys at both cuts exact
//! - [`resample`]: every channel keyed at one rate
//! - [`find`], [`close`]: the part that loops, and its ends made to meet
//! - [`split`]: the way over the ground apart from the rest
//! - [`reduce_keys`]: fewer keys, with a bound in metres of the character
//!
//! All of them take a source clip and give a source clip. What is done is stated in numbers.

mod channel;
mod grid;
pub(crate) mod heading;
mod spline;
mod subject;
#[cfg(test)]
mod test_clips;

mod cycle;
mod key_reduction;
mod rate;
mod root_motion;
mod trim;

pub use cycle::{CloseOptions, ClosedLoop, LoopCycle, MIN_SCORE, close, find};
pub use key_reduction::{ReduceOptions, ReducedClip, reduce_keys};
pub use rate::resample;
pub use root_motion::{RootMotion, RootMotionMode, RootMotionOptions, TrajectoryKey, split};
pub use subject::EditSubject;
pub use trim::trim;
