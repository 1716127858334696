//! Any bytes as a binary stream of face animation: a clip that can be written, or an error.
#![no_main]

use articula_stream::StreamLimits;
use articula_stream::fba::read;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = StreamLimits {
        bytes: 1 << 16,
        elements: 1 << 16,
    };
    if let Ok(found) = read(bytes, &limits) {
        assert!(found.intra_frames <= found.clip.frames.len());
    }
});
