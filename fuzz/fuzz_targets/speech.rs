//! Any bytes as a recording and as the times of phones: an error, or sound that is heard, and phones in order
//! that make weights.
#![no_main]

use articula::speech::{Sound, VisemeTrack, read_phone_times};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let (kind, bytes) = bytes.split_at(bytes.len().min(1));
    let sound = if kind == [0] {
        Sound::from_wav(bytes).unwrap_or_default()
    } else {
        Sound::default()
    };
    let phones = read_phone_times(bytes).unwrap_or_default();
    assert!(phones.windows(2).all(|w| w[0].end_secs <= w[1].start_secs + 2e-3));
    if sound.duration_secs() < 10.0 {
        let track = VisemeTrack::of_phones(&phones, &sound);
        for frame in &track.smoothed().eased().frames {
            let sum: f32 = frame.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-3);
        }
    }
});
