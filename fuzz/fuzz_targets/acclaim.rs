//! Any bytes as a skeleton and, after the first zero byte, a motion: a value or an error, and every
//! value that is read can be mapped and written.
#![no_main]

use articula_formats::acclaim::{self, WriteOptions};
use articula_formats::{Limits, ReadOptions, joint_map};
use libfuzzer_sys::fuzz_target;

/// Maximum duration in seconds: a clip of hours in few bytes only costs time.
const MAX_SECS: f32 = 10.0;

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.splitn(2, |b| *b == 0);
    let asf = parts.next().unwrap_or_default();
    let read = acclaim::read(asf, parts.next(), &ReadOptions::default(), &Limits::default());
    let Ok(read) = read else { return };
    let file = read.value;
    articula_build::joint_names::map(&file.character.skeleton, joint_map::builtin(), None);
    let clip = file.character.clips.first();
    let clip = clip.filter(|c| c.duration_secs < MAX_SECS).map(|_| 0);
    let options = WriteOptions {
        rate_hz: 30.0,
        end_sites: file.end_sites,
    };
    if let Ok(written) = acclaim::write(&file.character, clip, &options) {
        let amc = written.motion.as_deref();
        let _ = acclaim::read(&written.bytes, amc, &ReadOptions::default(), &Limits::default());
    }
});
