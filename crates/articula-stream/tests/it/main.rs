//! Integration tests of streams: round trips, whole and cut.
//!
//! One program: linking one is faster than linking many.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, reads files, and says what it skips"
)]

mod abp1;
mod afp1;
mod afp2;
mod clustered_stream;
mod cut_streams;
#[path = "../../../articula-stream-alone/tests/descriptions_alone/tools.rs"]
mod description_tools;
mod descriptions;
mod fba;
mod fba_judged;
mod flipped_bits;
mod increments;
mod mesh_increments;
mod mesh_levels;
mod motion_stream;
mod mp4;
#[path = "../../../articula-formats/tests/it/real/mod.rs"]
mod real;
mod small_human;
mod stored_levels;
