//! Promises of the X3D reader and writer: every feature by a small file, every real file, what
//! is written read again, hostile and mutated files.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "tests fail by panicking, read files and say what they skip"
)]

mod compare;
mod features;
mod hostile;
mod mutated;
#[path = "../real/mod.rs"]
mod real;
mod written;
