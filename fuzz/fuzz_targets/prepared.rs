//! Any bytes as parts of a prepared asset: an error, or a value that is written and read again.
#![no_main]

use articula_formats::Limits;
use articula_formats::prepared::{
    CACHE_KEYS_VERSION, read_cache_keys, read_clips, read_motion_bounds, read_paired_levels, read_source_orders,
    write_cache_keys, write_clips, write_motion_bounds, write_paired_levels, write_source_orders,
};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits {
        elements: 1 << 20,
        ..Limits::default()
    };
    if let Ok(clips) = read_clips(bytes, &[], &limits) {
        assert_eq!(read_clips(&write_clips(&clips, &[]), &[], &limits), Ok(clips));
    }
    for version in [1, CACHE_KEYS_VERSION] {
        if let Ok(keys) = read_cache_keys(bytes, version, &limits) {
            let written = write_cache_keys(&keys.keys, &keys.steps);
            assert_eq!(read_cache_keys(&written, CACHE_KEYS_VERSION, &limits), Ok(keys));
        }
    }
    if let Ok(bounds) = read_motion_bounds(bytes, &limits) {
        assert_eq!(read_motion_bounds(&write_motion_bounds(&bounds), &limits), Ok(bounds));
    }
    if let Ok(levels) = read_paired_levels(bytes, &limits) {
        assert_eq!(read_paired_levels(&write_paired_levels(&levels), &limits), Ok(levels));
    }
    if let Ok(orders) = read_source_orders(bytes, &limits) {
        assert_eq!(read_source_orders(&write_source_orders(&orders), &limits), Ok(orders));
    }
});
