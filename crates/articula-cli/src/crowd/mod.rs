//! Playing and measuring a crowd of one character, shared by `crowd` and `demo`.
//!
//! A run has two passes over the same frames. The first is timed and does nothing else; the second
//! measures what the first one showed: true errors, levels, a hash of every palette. The frame
//! itself is computed by the library ([`articula::crowd`]).
//!
//! - [`stage`]: frames on one or several threads, timed
//! - [`timing`]: processor time of threads, and its median and percentiles over frames
//! - [`run`]: both passes
//! - [`faces`]: morph targets that are shown
//! - [`picture`]: a picture of the crowd, coloured by level

pub(crate) mod faces;
pub(crate) mod picture;
pub(crate) mod roles;
pub(crate) mod run;
pub(crate) mod stage;
pub(crate) mod timing;
