//! Any bytes as an X3D or VRML97 file: a value or an error, and whatever is read can be written.
#![no_main]

use articula_formats::x3d;
use articula_formats::{Limits, joint_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits {
        bytes: 1 << 20,
        elements: 1 << 18,
        nodes: 1 << 12,
        ..Limits::default()
    };
    let mut picture = |_: &str| Ok(vec![0x89, b'P', b'N', b'G']);
    let Ok(file) = x3d::read(bytes, &limits, &mut picture) else {
        return;
    };
    let character = &file.value.character;
    let mapping = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
    let written =
        x3d::write(character, &mapping.articulation, &file.value.sites).expect("it has joints");
    if let Err(error) = x3d::read(&written.bytes, &Limits::default(), &mut picture) {
        // Summing joint offsets near the largest allowed number may exceed the limits.
        let why = error.to_string();
        let huge = why.contains("up to 1e9") || why.contains("too large");
        assert!(huge, "{why}");
    }
});
