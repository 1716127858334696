//! Any bytes as the index of a stream: a map that is written again as it was read, or an error.
#![no_main]

use articula_stream::{read_index, write_index};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = read_index(bytes) {
        assert_eq!(read_index(&write_index(&map)), Ok(map));
    }
});
