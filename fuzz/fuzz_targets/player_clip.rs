//! Any bytes as the body of a player's container, both as they are and compressed: an error or a
//! clip that can be sampled at any time and survives a round trip.
#![no_main]

use articula_flat::vector::player::{decode, encode};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use libfuzzer_sys::fuzz_target;
use std::io::Write;

/// Magic number and version of the container.
const HEAD: &[u8] = b"ARTV\x01";

fuzz_target!(|bytes: &[u8]| {
    let _ = decode(bytes);
    let mut encoder = ZlibEncoder::new(HEAD.to_vec(), Compression::fast());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    let Ok(clip) = decode(&packed.unwrap_or_default()) else {
        return;
    };
    let moment = clip.moment(0.5);
    assert_eq!(moment.xy.len(), clip.wedge_points.len());
    assert_eq!(decode(&encode(&clip)), Ok(clip));
});
