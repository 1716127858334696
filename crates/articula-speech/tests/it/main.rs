//! Tests of speech on whole recordings.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod recogniser;
mod resampler;
