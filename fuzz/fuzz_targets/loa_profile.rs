//! Any bytes as a saved LoA selection: an error or a selection that survives a round trip.
#![no_main]

use articula_formats::{Limits, loa_profile};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits::default();
    if let Ok(profile) = loa_profile::read(bytes, &limits) {
        let again = loa_profile::read(&loa_profile::write(&profile), &limits);
        assert_eq!(again, Ok(profile));
    }
});
