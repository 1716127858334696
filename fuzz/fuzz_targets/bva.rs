//! Any bytes as a BVA file: a value or an error, and segments that are read can be joined to a
//! tree.
#![no_main]

use articula_formats::{Limits, ReadOptions, bva, joint_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(read) = bva::read(bytes, &ReadOptions::default(), &Limits::default()) {
        articula_build::joint_names::segments(&read.value.character.skeleton, joint_map::builtin()).and_then(|s| bva::tree(&read.value, &s));
    }
});
