//! Any bytes as a face map: a map that is written and read again as it is, or an error.
#![no_main]

use articula_formats::{Limits, face_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = face_map::parse(bytes, &Limits::default()) {
        let written = face_map::write(&map, Vec::new());
        let again = face_map::parse(&written, &Limits::default());
        assert_eq!(again.ok().map(|again| again.controls), Some(map.controls));
    }
});
