//! Any bytes as a joint-name profile and as a saved selection: a value or an error.
#![no_main]

use articula_formats::{Limits, loa_profile, profile};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = profile::parse(bytes, &Limits::default());
    let _ = loa_profile::read(bytes, &Limits::default());
});
