//! Promises of the glTF reader and writer: every feature by a tiny file made in code, every
//! real file, hostile and mutated ones.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "tests fail by panicking, read files and say what they skip"
)]

mod clustered;
mod compressed;
mod features;
mod files;
mod hostile;
mod khr_character;
mod levels;
mod mutated;
mod quantized;
#[path = "../real/mod.rs"]
mod real;
#[path = "../thinned/mod.rs"]
mod thinned;
mod tiny;
mod vertex_classes;
mod vrm;
mod written;
