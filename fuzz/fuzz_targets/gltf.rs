//! Any bytes as a glTF file: a value or an error, and whatever is read can be written.
#![no_main]

use articula_formats::Limits;
use articula_formats::gltf::{self, Document};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits {
        bytes: 1 << 20,
        elements: 1 << 18,
        nodes: 1 << 12,
        ..Limits::default()
    };
    let mut alone = |_: &str| Err("nothing".to_owned());
    let Ok(file) = gltf::read(bytes, &limits, &mut alone) else {
        return;
    };
    let anew = Document::from_character(&file.value.character).expect("what is read fits");
    let written = anew.write_glb().expect("it is small");
    gltf::read(&written, &Limits::default(), &mut alone).expect("what is written can be read");
    let nodes = &file.value.node_of_joint;
    let bones = file.value.humanoid.iter().flatten();
    let bones: Vec<_> = bones.map(|(j, bone)| (nodes[*j], bone.clone())).collect();
    let mut character = file.value.document;
    if character.set_khr_character(&bones, "TPose", None).is_ok() {
        let written = character.write_glb().expect("it is small");
        gltf::read(&written, &Limits::default(), &mut alone).expect("what is written can be read");
    }
});
