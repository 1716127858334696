//! Invalid files: one line with the file, the place and the remedy; no panic, no long delay.

use crate::program;
use crate::program::{BVH, fault, folder, human, word};
use std::path::Path;

fn gltf(buffer: &str) -> String {
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"byteLength\":4,\"uri\":\"{buffer}\"}}]}}"
    )
}

fn check(here: &Path, name: &str, bytes: &[u8], words: &[&str]) {
    std::fs::write(here.join(name), bytes).unwrap();
    let line = fault(here, 1, &["inspect", name]);
    for word in words.iter().chain(&[name]) {
        assert!(line.contains(word), "{name}: \"{word}\" is not in: {line}");
    }
}

#[test]
fn what_cannot_be_read_names_file_place_and_mend() {
    let here = folder("hostile");
    let line = fault(&here, 1, &["inspect", "gone.glb"]);
    assert!(
        line.contains("gone.glb") && line.contains("check its name"),
        "{line}"
    );
    std::fs::create_dir_all(here.join("folder.glb")).unwrap();
    assert!(fault(&here, 1, &["inspect", "folder.glb"]).contains("name a file in it"));
    check(&here, "empty.glb", b"", &[]);
    check(&here, "picture.png", b"\x89PNG\r\n", &[".glb", ".bvh"]);
    check(&here, "short.glb", b"glTF\x02\0\0\0", &[]);
    check(&here, "deep.gltf", "[".repeat(100_000).as_bytes(), &[]);
    check(
        &here,
        "object.gltf",
        b"{\"asset\":{\"version\":\"2.0\"}}",
        &["with a character"],
    );
    check(
        &here,
        "nine.bvh",
        BVH.replace("CHANNELS 6 ", "CHANNELS 9 ").as_bytes(),
        &["line"],
    );
    check(
        &here,
        "nan.bvh",
        BVH.replace("OFFSET 0 90 0", "OFFSET 0 NaN 0").as_bytes(),
        &["line"],
    );
}

#[test]
fn only_files_beside_the_input_are_read() {
    let here = folder("beside");
    std::fs::create_dir_all(here.join("in")).unwrap();
    std::fs::write(here.join("secret.bin"), [1, 2, 3, 4]).unwrap();
    std::fs::write(here.join("in/beside.bin"), [1, 2, 3, 4]).unwrap();
    let absolute = here.join("secret.bin");
    let absolute = word(&absolute).replace('\\', "/");
    for (uri, why) in [
        ("../secret.bin", "outside the folder"),
        ("a/../../secret.bin", "outside the folder"),
        ("%2e%2e/secret.bin", "outside the folder"),
        (absolute.as_str(), "absolute"),
        ("http://127.0.0.1/secret.bin", "URL"),
        ("gone.bin", "put it there"),
    ] {
        let name = "in/a.gltf";
        std::fs::write(here.join(name), gltf(uri)).unwrap();
        let line = fault(&here, 1, &["inspect", name]);
        assert!(
            line.contains(why) && line.contains("buffers[0]"),
            "{uri}: {line}"
        );
    }
    std::fs::write(here.join("in/a.gltf"), gltf("beside.bin")).unwrap();
    let line = fault(&here, 1, &["inspect", "in/a.gltf"]);
    assert!(!line.contains("beside.bin"), "the buffer is read: {line}");
}

#[test]
fn a_file_cut_anywhere_is_one_error() {
    let here = folder("cut");
    let whole = std::fs::read(human()).unwrap();
    for share in [0.001, 0.01, 0.1, 0.3, 0.5, 0.9, 0.9999] {
        let end = (whole.len() as f64 * share) as usize;
        check(&here, "cut.glb", &whole[..end], &[]);
    }
}

#[test]
fn names_cannot_steer_the_terminal() {
    let here = folder("steer");
    let bvh = BVH.replace("LeftForeArm", "Left\u{1b}[2JArm");
    std::fs::write(here.join("a.bvh"), bvh).unwrap();
    let ran = program::articula(&here, &["inspect", "a.bvh", "--map"]);
    assert!(!ran.out.contains('\u{1b}') && !ran.err.contains('\u{1b}'));
}

#[test]
fn bad_side_files_are_named_too() {
    let here = folder("side");
    let human = word(human());
    let cases: &[(&str, &str, &[&str])] = &[
        ("{", "p.json", &["lod", human, "--camera-path", "p.json"]),
        ("[]", "p.json", &["lod", human, "--camera-path", "p.json"]),
        (
            "[{\"t\":0}]",
            "p.json",
            &["lod", human, "--camera-path", "p.json"],
        ),
        (
            "{\"rules\":1}",
            "l.json",
            &["convert", human, "o.glb", "--loa-profile", "l.json"],
        ),
        (
            "{\"joints\":{\"plus\":[\"tail\"],\"minus\":[]}}",
            "l.json",
            &["convert", human, "o.glb", "--loa-profile", "l.json"],
        ),
        ("{}", "n.json", &["inspect", human, "--joint-map", "n.json"]),
    ];
    for (text, name, words) in cases {
        std::fs::write(here.join(name), text).unwrap();
        let line = fault(&here, 1, words);
        assert!(line.contains(name), "{text}: {line}");
    }
}
