//! Any bytes as a stream of facial animation parameters: a clip with fields in their ranges, or an
//! error. What can be mapped can be cut, and is then mapped alike.
#![no_main]

use articula_stream::afp1::{Afp1Options, read, unit, write};
use articula_stream::{CutRule, FaceReadOptions, StreamLimits, cut};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = StreamLimits {
        elements: 1 << 18,
        ..StreamLimits::default()
    };
    if let Ok(map) = unit(bytes, &limits) {
        map.check_values(bytes).unwrap();
        let rule = CutRule::default().at_most("loa", 2).in_mask("region", 0b1010_1010);
        let shorter = cut(bytes, &map, |unit| rule.keeps(unit)).unwrap();
        assert_eq!(unit(&shorter.bytes, &limits).unwrap(), shorter.unit);
    }
    if let Ok(decoded) = read(bytes, &FaceReadOptions::default(), &limits) {
        decoded.clip.check().unwrap();
        // Values may be too great for the steps of the writer.
        let _ = write(&decoded.clip, &Afp1Options::default());
    }
});
