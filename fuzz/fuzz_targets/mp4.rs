//! Any bytes as an MP4 file: tracks within the file, or an error. A stream that comes out of a file, and
//! can be mapped, goes into one again and comes back unchanged.
#![no_main]

use articula_stream::{StreamKind, StreamLimits, mp4};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = StreamLimits {
        bytes: 1 << 18,
        elements: 1 << 18,
    };
    let Ok(tracks) = mp4::read(bytes, &limits) else {
        return;
    };
    let of_all: usize = tracks.iter().map(mp4::Mp4Track::bytes).sum();
    assert!(of_all <= 2 * bytes.len());
    for track in tracks {
        let Ok(stream) = track.stream(bytes) else {
            continue;
        };
        assert_eq!(StreamKind::of(&stream), track.kind);
        if let Ok(file) = mp4::write(&[&stream], &limits) {
            let again = mp4::read(&file, &StreamLimits::default()).unwrap();
            assert_eq!(again[0].stream(&file).unwrap(), stream);
        }
    }
});
