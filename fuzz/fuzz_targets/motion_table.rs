//! Any bytes as motion tables: an error or a value whose keys are within its frames.
#![no_main]

use articula_formats::{
    Limits, read_compact_clip, read_contact_table, read_error_matrix, read_key_table, read_pose_keys,
    write_compact_clip, write_contact_table, write_error_matrix, write_key_table, write_pose_keys,
};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // A matrix of zeros takes memory without bytes, up to the limit.
    let limits = Limits {
        elements: 1 << 20,
        ..Limits::default()
    };
    if let Ok(table) = read_key_table(bytes, &limits) {
        let again = read_key_table(&write_key_table(&table), &limits);
        assert_eq!(again.as_ref().map(|t| &t.keys), Ok(&table.keys));
    }
    if let Ok(keys) = read_pose_keys(bytes, &limits) {
        let again = read_pose_keys(&write_pose_keys(&keys), &limits);
        assert_eq!(again, Ok(keys));
    }
    if let Ok(table) = read_contact_table(bytes, &limits) {
        assert_eq!(read_contact_table(&write_contact_table(&table), &limits), Ok(table));
    }
    if let Ok((hashes, stream)) = read_compact_clip(bytes, &limits) {
        let again = write_compact_clip(&hashes, stream);
        assert_eq!(read_compact_clip(&again, &limits), Ok((hashes, stream)));
    }
    if let Ok(table) = read_error_matrix(bytes, &limits) {
        assert_eq!(read_error_matrix(&write_error_matrix(&table), &limits), Ok(table));
    }
});
