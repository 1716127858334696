//! Any bytes as a capture of Live Link Face: an error, or finite frames with ascending times that can be
//! written.
#![no_main]

use articula_formats::{Limits, live_link};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(read) = live_link::read(bytes, &Limits::default()) {
        let frames = &read.value.frames;
        assert!(frames.windows(2).all(|w| w[0].secs < w[1].secs));
        let values = frames.iter().flat_map(|f| f.shapes.iter().chain(&f.angles));
        assert!(values.into_iter().all(|v| v.is_finite()));
        live_link::write(&read.value);
    }
});
