//! Properties of speech on made sound, and on recordings of people.
//!
//! One program: linking one is faster than linking many.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, reads files of the repository, and prints what it measures"
)]

mod people;
mod recogniser;
mod resampler;
