//! Any bytes as the manifest of an item that is received: what it says of its files is asked for and
//! arrives, as pieces of the same bytes, and all ends in values or errors.
#![no_main]

use articula::OpenOptions;
use articula::item::{ItemCut, ItemReceiver, Regions};
use libfuzzer_sys::fuzz_target;

/// Most bytes that arrive in a range.
const MOST: u64 = 1 << 12;

fuzz_target!(|bytes: &[u8]| {
    let mut options = OpenOptions::default();
    options.limits.bytes = 1 << 20;
    let Ok(mut client) = ItemReceiver::new(bytes, &options) else {
        return;
    };
    let parts = client.manifest().parts.iter();
    let all = ItemCut::Layers {
        kept: parts.map(|part| vec![true; part.layers.len()]).collect(),
        regions: Regions::default(),
    };
    let missing = client.missing(&all).unwrap();
    for (name, ranges) in missing.files() {
        for range in ranges.ranges() {
            let count = (range.end - range.start).min(MOST) as usize;
            let given: Vec<u8> = bytes.iter().copied().cycle().take(count).collect();
            let _ = client.receive(name, range.start, &given);
        }
    }
    let held = client.held();
    assert!(missing.without(&held).bytes() <= missing.bytes());
    let _ = client.character();
});
