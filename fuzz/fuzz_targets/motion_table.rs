//! Any bytes as motion tables: an error or a value whose keys lie within its frames.
#![no_main]

use articula_formats::{Limits, motion_table};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits::default();
    if let Ok(table) = motion_table::read_segs(bytes, &limits) {
        let again = motion_table::read_segs(&motion_table::write_segs(&table), &limits);
        assert_eq!(again.as_ref().map(|t| &t.keys), Ok(&table.keys));
    }
    if let Ok(keys) = motion_table::read_pose_keys(bytes, &limits) {
        let again = motion_table::read_pose_keys(&motion_table::write_pose_keys(&keys), &limits);
        assert_eq!(again, Ok(keys));
    }
});
