//! Any bytes as an FBX file: a value or an error, and whatever is read is sound.
#![no_main]

use articula_formats::{Limits, ReadOptions, fbx, joint_map};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits {
        bytes: 1 << 20,
        elements: 1 << 20,
        nodes: 1 << 12,
        frames: 1 << 12,
        ..Limits::default()
    };
    let mut picture = |_: &str| Ok(vec![0x89, b'P', b'N', b'G']);
    let options = ReadOptions::default();
    let Ok(file) = fbx::read(bytes, "a", &options, &limits, &mut picture) else {
        return;
    };
    let character = &file.value.character;
    let joints = &character.skeleton.joints;
    assert!(joints.iter().all(|j| j.rest.is_finite()));
    articula_core::Mesh::new(&character.meshes, joints.len()).expect("the meshes fit together");
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        assert!(channel.times_secs.windows(2).all(|t| t[0] < t[1]));
        assert!(channel.values.iter().all(|v| v.is_finite()));
    }
    articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
});
