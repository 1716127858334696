//! Clips made clean before anything else is done with them.
//!
//! - [`trim`]: a part of a clip, its keys at both cuts exact
//! - [`rate`]: every channel keyed at one rate
//! - [`cycle`]: the part that loops, and its ends made to meet
//! - [`root_motion`]: the way over the ground apart from the rest
//! - [`key_reduction`]: fewer keys, with a bound in metres of the character
//!
//! All of them take a source clip and give a source clip. What is done is stated in numbers.

mod channel;
mod grid;
pub(crate) mod heading;
mod spline;
mod subject;
#[cfg(test)]
mod test_clips;

pub mod cycle;
pub mod key_reduction;
pub mod rate;
pub mod root_motion;
pub mod trim;

pub use grid::VERIFIED_HZ;
pub use subject::Subject;
