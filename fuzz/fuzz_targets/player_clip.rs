//! Any bytes as the body of a player's container, uncompressed and packed as they should be: a clip
//! that can be drawn at any moment and comes back from what it is written as, or an error.
#![no_main]

use articula_flat::vector::player::{decode, encode};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use libfuzzer_sys::fuzz_target;
use std::io::Write;

/// The container's mark and version.
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
