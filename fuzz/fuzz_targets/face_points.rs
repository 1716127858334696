//! Any bytes as feature points of a face: an error, or points that survive a round trip.
#![no_main]

use articula_formats::{Limits, face_points};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits::default();
    if let Ok(points) = face_points::read(bytes, &limits) {
        let again = face_points::read(&face_points::write(&points), &limits);
        assert_eq!(again.map(|a| a.len()), Ok(points.len()));
    }
});
