//! Any bytes as a BVH file: a value or an error, and whatever is read can be mapped.
#![no_main]

use articula_formats::{Limits, ReadOptions, bvh, joint_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(read) = bvh::read(bytes, &ReadOptions::default(), &Limits::default()) {
        articula_build::joint_names::map(&read.value.character.skeleton, joint_map::builtin(), None);
    }
});
