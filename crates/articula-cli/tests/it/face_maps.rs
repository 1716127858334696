//! Names of morph targets: what `inspect` says, and `--face-map`.

use crate::program::{edited, fault, folder, json};
use crate::real;

#[test]
fn a_face_of_unknown_names_is_driven_by_a_map() {
    let Some(head) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let here = folder("face-maps");
    // The 17 shapes of the head under names that tell nothing.
    edited(&head, &here.join("keys.glb"), |document| {
        for mesh in document["meshes"].as_array_mut().unwrap() {
            let names = mesh["extras"]["targetNames"].as_array_mut().unwrap();
            for (index, name) in names.iter_mut().enumerate() {
                *name = format!("Key {index}").into();
            }
        }
    });
    let found = json(&here, &["inspect", "keys.glb"]);
    assert_eq!(found["face"]["morphs"], 17);
    assert!(found["face"]["driven_by"].is_null());

    let map = |controls: &str| format!("{{\"name\": \"x\", \"controls\": {{{controls}}}}}");
    std::fs::write(here.join("map.json"), map("\"Key 6\": \"jawOpen\"")).unwrap();
    let told = ["inspect", "keys.glb", "--face-map", "map.json"];
    let found = json(&here, &told);
    let by = &found["face"]["driven_by"];
    assert_eq!(
        (&by["arkit_shapes"], &by["visemes"]),
        (&1.into(), &0.into())
    );
    let written = [&told[..], &["--write", "face-map=again.json"]].concat();
    json(&here, &written);
    let again = std::fs::read(here.join("again.json")).unwrap();
    let again: serde_json::Value = serde_json::from_slice(&again).unwrap();
    assert_eq!(again["controls"]["Key 6"], "jawOpen");
    assert_eq!(again["unmapped"].as_array().unwrap().len(), 16);

    std::fs::write(here.join("wrong.json"), map("\"Key 6\": \"jaw\"")).unwrap();
    let said = fault(
        &here,
        1,
        &["inspect", "keys.glb", "--face-map", "wrong.json"],
    );
    assert!(
        said.contains("wrong.json") && said.contains("\"jaw\" is neither"),
        "{said}"
    );
}

#[test]
fn shapes_are_made_beside_morph_targets_of_identities() {
    let Some(head) = real::file("face/ict_identity10.glb") else {
        return;
    };
    let here = folder("face-identities");
    let head = head.to_string_lossy().into_owned();
    json(&here, &["convert", &head, "shaped.glb", "--face-shapes"]);
    let found = json(&here, &["inspect", "shaped.glb"]);
    // The head has a tongue, so all are made.
    assert_eq!(found["face"]["morphs"], 10 + 52);
    assert_eq!(found["face"]["driven_by"]["arkit_shapes"], 52);
}
