//! Any bytes as FAP, BAP, EPF or FDP, selected by the first byte: a value or an error, and values
//! that are read can be sampled and survive a round trip.
#![no_main]

use articula_formats::mpeg4::{bap, epf, fap, fdp};
use articula_formats::{Limits, joint_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else {
        return;
    };
    let limits = Limits::default();
    match first % 4 {
        0 => {
            if let Ok(read) = fap::read(bytes, fap::AbsentPolicy::Hold, &limits) {
                let back = fap::read(&fap::write(&read.value), fap::AbsentPolicy::Zero, &limits);
                assert_eq!(back.unwrap().value.frames, read.value.frames);
            }
        }
        1 => {
            if let Ok(read) = bap::read(bytes, bap::AbsentPolicy::Hold, &limits) {
                let character = bap::character(&read.value);
                let map = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
                let seconds = character.clips.first().map_or(0.0, |c| c.duration_secs);
                if !character.clips.is_empty() && seconds < 5.0 {
                    bap::sample(&character, &map.articulation, 0, 5.0).unwrap();
                }
                let back = bap::read(&bap::write(&read.value), bap::AbsentPolicy::Zero, &limits);
                assert_eq!(back.unwrap().value.frames.len(), read.value.frames.len());
            }
        }
        2 => drop(epf::read(bytes, &limits)),
        _ => drop(fdp::read(bytes, &limits)),
    }
});
