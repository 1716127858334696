//! Any bytes as the description of a stream: a map that is written again as it was read, a stream of
//! bounded size, a transformation that can be read; or errors.
#![no_main]

use articula_stream::DescriptionLimits;
use articula_stream::description::{
    AdaptMode, GbsdOptions, Holes, Selection, adapt_gbsd, gbsd_to_bin, read_gbsd, write_gbsd,
};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = DescriptionLimits {
        bytes: 1 << 18,
        nodes: 1 << 14,
    };
    let stream = [0x5a; 512];
    if let Ok(made) = gbsd_to_bin(bytes, &stream, Holes::Skip, &limits) {
        assert!(made.len() <= stream.len() + bytes.len());
    }
    let selection = Selection {
        tier: Some(1),
        body_regions: Some(6),
        ..Selection::of_loa(2)
    };
    let literal = adapt_gbsd(bytes, &selection, AdaptMode::AnnexBLiteral, &limits);
    let adapted = adapt_gbsd(bytes, &selection, AdaptMode::Conformant, &limits);
    let wide = DescriptionLimits {
        bytes: 1 << 20,
        ..limits
    };
    for text in [literal, adapted].into_iter().flatten() {
        let _ = gbsd_to_bin(text.as_bytes(), &stream, Holes::Copy, &wide);
    }
    if let Ok(found) = read_gbsd(bytes, &limits) {
        found.unit.check().expect("a sound map");
        if let Ok(text) = write_gbsd(&found.unit, &GbsdOptions::default()) {
            let again = read_gbsd(text.as_bytes(), &DescriptionLimits::default());
            let mut again = again.expect("what was written").unit;
            let mut unit = found.unit;
            sort_fields(&mut again);
            sort_fields(&mut unit);
            assert_eq!(again, unit);
        }
    }
});

/// A description has the fields of a unit in rising order.
fn sort_fields(unit: &mut articula_stream::Unit) {
    unit.fields.sort_by_key(|field| field.bits.start);
    unit.children.iter_mut().for_each(sort_fields);
}
