//! Any bytes as a joint-name profile: a value or an error.
#![no_main]

use articula_formats::{Limits, profile};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = profile::parse(bytes, &Limits::default());
});
