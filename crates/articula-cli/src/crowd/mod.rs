//! A crowd of one character, played and measured: what `crowd` and `demo` have in common.
//!
//! A run has two passes over the same frames. The first is timed and does nothing else; the second
//! looks at what the first has shown: true errors, levels, a hash of every palette. What a frame
//! does is the library's ([`articula::crowd`]).
//!
//! - [`stage`]: frames on one thread or several, and the time that they take
//! - [`timing`]: processor time of threads, and its spread over frames
//! - [`run`]: both passes
//! - [`picture`]: the same to look at, coloured by level

pub(crate) mod picture;
pub(crate) mod run;
pub(crate) mod stage;
pub(crate) mod timing;
