//! Promises of the meshopt decoder: the vectors of its makers, and whatever the bytes.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, with the vector at hand"
)]

mod mutated;
mod vectors;
