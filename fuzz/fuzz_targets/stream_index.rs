//! Any bytes as the index of a stream: a map that is written again as it was read, or an error.
#![no_main]

use articula_stream::{StreamLimits, read_index, write_index};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = StreamLimits {
        bytes: 1 << 16,
        elements: 1 << 18,
    };
    if let Ok(map) = read_index(bytes, &limits) {
        let again = read_index(&write_index(&map), &limits);
        assert_eq!(again, Ok(map));
    }
});
