//! Descriptions without any codec.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, hands files over, and says what it skips"
)]

mod adapt;
mod annex_b;
mod documents;
mod gbsd;
mod hostile;
mod random;
mod tools;
