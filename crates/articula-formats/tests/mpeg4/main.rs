//! Promise: the MPEG-4 text forms are read and written, and BAP drives the standard humanoid.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a test reads files, stops at the first surprise, and says what it skips"
)]

mod bap_text;
mod fap_text;
mod fdp_files;
mod mutated;
#[path = "../real/mod.rs"]
mod real;
mod real_files;
mod texts;
