//! Integration tests of the server: real connections to it on the loopback address.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, looks for the folder of real files, and says what it skips"
)]

mod catalogue;
mod client;
mod connection;
mod devices;
#[path = "../../../articula-cli/tests/it/judges/mod.rs"]
mod judges;
mod openapi;
mod origins;
mod packed;
mod queries;
#[path = "../../../articula-formats/tests/it/real/mod.rs"]
mod real;
mod refusals;
mod removal;
mod sessions;
mod slow;
mod stages;
mod studio;

// The judges of pictures want it here.
use articula::flat::Picture;
