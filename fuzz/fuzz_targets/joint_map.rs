//! Any bytes as a joint map: a value or an error.
#![no_main]

use articula_formats::{Limits, joint_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = joint_map::parse(bytes, &Limits::default());
});
