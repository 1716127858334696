//! Any bytes as a face stream: a clip with fields in their ranges, or an error. What can be mapped can
//! be cut, and is then mapped alike.
#![no_main]

use articula_stream::abp2::motion_map;
use articula_stream::afp2::{Afp2Options, read, write};
use articula_stream::{CutRule, FaceReadOptions, StreamLimits, cut};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = StreamLimits {
        bytes: 1 << 16,
        elements: 1 << 18,
    };
    if let Ok(map) = motion_map(bytes, &limits) {
        map.check_values(bytes).unwrap();
        let rule = CutRule::default()
            .at_most("face_loa", 2)
            .in_mask("face_region", 0b1010_1010)
            .at_least("tier", 1);
        let shorter = cut(bytes, &map, |unit| rule.keeps(unit)).unwrap();
        assert_eq!(motion_map(&shorter.bytes, &limits).unwrap(), shorter.unit);
    }
    if let Ok(decoded) = read(bytes, &FaceReadOptions::default(), &limits) {
        decoded.clip.check().unwrap();
        // A clip that was decoded is written again, unless it is too long to wait for.
        if decoded.clip.frames.len() <= 8 {
            let _ = write(&decoded.clip, &Afp2Options::default());
        }
    }
});
