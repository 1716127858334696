//! No file is lost: inputs are never written to, other files only with `--force`, and an error
//! changes nothing.

use crate::program::{BVH, articula, fault, folder, small, word};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Every file and link below a folder with its content or target.
fn snapshot(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_symlink() {
            let target = std::fs::read_link(&path).unwrap();
            all.insert(path, target.as_os_str().as_encoded_bytes().to_vec());
        } else if path.is_dir() {
            all.extend(snapshot(&path));
            all.insert(path, Vec::new());
        } else if path.is_file() {
            let bytes = std::fs::read(&path).unwrap_or_default();
            all.insert(path, bytes);
        }
    }
    all
}

/// A folder with an input of every kind.
fn inputs(name: &str) -> PathBuf {
    let here = folder(name);
    std::fs::copy(small(), here.join("a.glb")).unwrap();
    std::fs::write(here.join("m.bvh"), BVH).unwrap();
    // A file whose buffer has the name of a possible output.
    let gltf = std::fs::read(small()).unwrap();
    let json_bytes = u32::from_le_bytes(gltf[12..16].try_into().unwrap()) as usize;
    let text = std::str::from_utf8(&gltf[20..20 + json_bytes]).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(text).unwrap();
    document["buffers"][0]["uri"] = "buffer.glb".into();
    std::fs::write(here.join("g.gltf"), document.to_string()).unwrap();
    std::fs::write(here.join("buffer.glb"), &gltf[28 + json_bytes..]).unwrap();
    std::fs::write(here.join("path.json"), CAMERA).unwrap();
    std::fs::write(here.join("schedule.json"), "[{\"t\": 0.5, \"level\": 4}]").unwrap();
    std::fs::write(here.join("profile.json"), "{\"zones\": [\"torso\"]}").unwrap();
    std::fs::write(here.join("lock.json"), "[[0, [1, 2]]]").unwrap();
    let names = "{\"name\": \"own\", \"joints\": {\"x\": \"vl5\"}}";
    std::fs::write(here.join("names.json"), names).unwrap();
    let made: &[&[&str]] = &[
        &["convert", "a.glb", "w.bvh", "--clip", "walk"],
        &["build", "a.glb", "l.glb", "--levels", "2"],
        &[
            "crowd",
            "a.glb",
            "--count",
            "2",
            "--seconds",
            "0.1",
            "--save-scene",
            "scene.json",
        ],
        &[
            "flatten",
            "a.glb",
            "drawn.svg",
            "--triangles",
            "100",
            "--clip",
            "wave",
            "--size",
            "100",
        ],
    ];
    for words in made {
        let ran = articula(&here, words);
        assert_eq!(ran.status, 0, "{words:?}: {}", ran.err);
    }
    here
}

const CAMERA: &str = "[{\"t\":0,\"eye\":[0,1.5,5],\"target\":[0,1,0]},\
                       {\"t\":1,\"eye\":[0,1.5,4],\"target\":[0,1,0]}]";

/// Words with the name of a file in place of another.
fn filled(words: &[&str], from: &str, to: &str) -> Vec<String> {
    words.iter().map(|word| word.replace(from, to)).collect()
}

/// Each way to write a file: the words, where OUT stands for the output, and the inputs that OUT
/// must not be.
const WAYS: &[(&[&str], &[&str])] = &[
    (&["convert", "a.glb", "OUT"], &["a.glb"]),
    (&["convert", "g.gltf", "OUT"], &["buffer.glb"]),
    (&["convert", "m.bvh", "OUT"], &["m.bvh"]),
    (&["convert", "w.bvh", "OUT", "--onto", "a.glb"], &["a.glb"]),
    (
        &[
            "convert",
            "l.glb",
            "fresh.glb",
            "--mesh-level",
            "0",
            "--mesh-picture",
            "OUT",
        ],
        &["levels.png"],
    ),
    (&["build", "a.glb", "OUT"], &["a.glb"]),
    (
        &["build", "a.glb", "g.gltf", "OUT"],
        &["a.glb", "buffer.glb"],
    ),
    (
        &[
            "build",
            "a.glb",
            "fresh.glb",
            "--levels",
            "2",
            "--mesh-stream",
            "OUT",
        ],
        &["a.glb"],
    ),
    (&["lod", "a.glb", "--plot", "OUT"], &["link.svg"]),
    (&["lod", "a.glb", "--contact-sheet", "OUT"], &["link.png"]),
    (
        &[
            "lod",
            "a.glb",
            "--camera-path",
            "path.json",
            "--loa",
            "loa(Low)",
            "--method",
            "loa",
            "--write",
            "loa-profile=OUT",
        ],
        &["path.json"],
    ),
    (
        &[
            "lod",
            "a.glb",
            "--method",
            "loa",
            "--loa-profile",
            "profile.json",
            "--write",
            "loa-profile=OUT",
        ],
        &["profile.json"],
    ),
    (
        &[
            "crowd",
            "a.glb",
            "--scene",
            "scene.json",
            "--save-scene",
            "OUT",
        ],
        &["scene.json"],
    ),
    (
        &[
            "crowd",
            "a.glb",
            "--count",
            "2",
            "--camera-path",
            "path.json",
            "--save-scene",
            "OUT",
        ],
        &["path.json"],
    ),
    (
        &["crowd", "a.glb", "--count", "2", "--plot", "OUT"],
        &["link.svg"],
    ),
    (
        &["crowd", "a.glb", "--count", "2", "--picture", "OUT"],
        &["link.png"],
    ),
    (&["flatten", "a.glb", "OUT"], &["link.svg"]),
    (&["flatten", "frame", "drawn.svg", "OUT"], &["drawn.svg"]),
    (&["flatten", "movie", "drawn.svg", "OUT"], &["link.gif"]),
    (&["human", "OUT"], &[]),
    (
        &[
            "inspect",
            "a.glb",
            "--joint-map",
            "names.json",
            "--write",
            "joint-map=OUT",
        ],
        &["names.json"],
    ),
];

#[cfg(unix)]
#[test]
fn no_command_writes_to_an_input_under_any_name() {
    let here = inputs("own-inputs");
    std::os::unix::fs::symlink("l.glb", here.join("levels.png")).unwrap();
    // Links to the character with the endings of other outputs.
    for ending in ["png", "svg", "gif"] {
        let link = here.join(format!("link.{ending}"));
        let target = if ending == "gif" {
            "drawn.svg"
        } else {
            "a.glb"
        };
        std::os::unix::fs::symlink(target, link).unwrap();
    }
    std::fs::create_dir(here.join("sub")).unwrap();
    let before = snapshot(&here);
    for (words, own) in WAYS {
        for input in *own {
            let ending = Path::new(input).extension().unwrap().to_str().unwrap();
            let linked = format!("to-input.{ending}");
            let hard = format!("hard.{ending}");
            std::os::unix::fs::symlink(input, here.join(&linked)).unwrap();
            std::fs::hard_link(here.join(input), here.join(&hard)).unwrap();
            let spelled = [(*input).to_owned(), format!("sub/../{input}"), linked, hard];
            for out in &spelled {
                let words = filled(words, "OUT", out);
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                let line = fault(&here, 2, &[&words[..], &["--force"]].concat());
                assert!(line.contains("never replaced"), "{words:?}: {line}");
            }
            for link in &spelled[2..] {
                std::fs::remove_file(here.join(link)).unwrap();
            }
        }
    }
    // A folder whose files would be those that were read.
    for words in [
        &["convert", "a.glb", "./"][..],
        &["convert", "a.glb", "m.bvh", ".", "--to", "glb"],
    ] {
        let line = fault(&here, 2, &[words, &["--force"]].concat());
        assert!(line.contains("never replaced"), "{words:?}: {line}");
    }
    assert_eq!(snapshot(&here), before);
}

#[test]
fn every_command_keeps_other_files_unless_forced() {
    let here = inputs("other-files");
    let endings = |words: &[&str]| match words {
        ["convert", .., "--mesh-picture", _] => "png",
        ["convert" | "build", .., "--mesh-stream", _] => "ams",
        ["convert" | "build" | "human", ..] => "glb",
        [.., "--plot", _] | ["flatten", "a.glb", _] => "svg",
        [.., "--contact-sheet" | "--picture", _] => "png",
        ["flatten", "frame", ..] => "png",
        ["flatten", "movie", ..] => "gif",
        _ => "json",
    };
    for (words, _) in WAYS {
        let out = format!("out.{}", endings(words));
        let shown = filled(words, "OUT", &out);
        let words: Vec<&str> = shown.iter().map(String::as_str).collect();
        let words = [&words[..], &["--quiet"]].concat();
        std::fs::write(here.join(&out), b"somebody's work").unwrap();
        let before = snapshot(&here);
        let line = fault(&here, 1, &words);
        assert!(
            line.contains(&out) && line.contains("--force"),
            "{words:?}: {line}"
        );
        assert_eq!(snapshot(&here), before, "{words:?}");
        let missing = format!("no/such/{out}");
        let elsewhere = filled(&words, &out, &missing);
        let elsewhere: Vec<&str> = elsewhere.iter().map(String::as_str).collect();
        let line = fault(&here, 1, &elsewhere);
        assert!(
            line.contains("no/such does not exist"),
            "{elsewhere:?}: {line}"
        );
        assert_eq!(snapshot(&here), before, "{words:?}");
        let ran = articula(&here, &[&words[..], &["--force"]].concat());
        assert_eq!(ran.status, 0, "{words:?}: {}", ran.err);
        let new = std::fs::read(here.join(&out)).unwrap();
        assert_ne!(new, b"somebody's work", "{words:?}");
        for made in [&out, "fresh.glb"] {
            let _ = std::fs::remove_file(here.join(made));
        }
    }
}

#[test]
fn folders_that_a_command_owns_are_made_and_their_files_kept() {
    let here = inputs("owned-folders");
    let ways: &[(&[&str], &str)] = &[
        (
            &["convert", "a.glb", "m.bvh", "deep/out/", "--to", "glb"],
            "deep/out/a.glb",
        ),
        (
            &["flatten", "movie", "drawn.svg", "frames/of/drawn"],
            "frames/of/drawn/0000.png",
        ),
        (
            &["lod", "a.glb", "--distances", "5", "--plot", "plots/all"],
            "plots/all/gain.svg",
        ),
    ];
    for (words, first) in ways {
        let ran = articula(&here, words);
        assert_eq!(ran.status, 0, "{words:?}: {}", ran.err);
        assert!(here.join(first).is_file(), "{first}");
        let before = snapshot(&here);
        assert!(fault(&here, 1, words).contains("--force"));
        assert_eq!(snapshot(&here), before);
        let ran = articula(&here, &[words, &["--force"][..]].concat());
        assert_eq!(ran.status, 0, "{words:?}: {}", ran.err);
    }
}

/// Files that cannot be read as a character.
fn wrong_files(glb: &[u8]) -> Vec<(&'static str, Vec<u8>)> {
    let cut = |at: usize| glb[..at].to_vec();
    let changed = |from: &str, to: &str| BVH.replacen(from, to, 1).into_bytes();
    vec![
        ("empty.glb", Vec::new()),
        ("empty.bvh", Vec::new()),
        ("header.glb", cut(12)),
        ("half.glb", cut(glb.len() / 2)),
        ("short.glb", cut(21)),
        ("noise.glb", (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()),
        ("text.glb", b"not a model".to_vec()),
        ("picture.glb", b"\x89PNG\r\n\x1a\n".to_vec()),
        ("words.txt", b"words".to_vec()),
        ("open.gltf", b"{".to_vec()),
        ("array.gltf", b"[]".to_vec()),
        ("old.gltf", b"{\"asset\":{\"version\":\"1.0\"},\"nodes\":[{}]}".to_vec()),
        ("away.gltf", b"{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"gone.bin\"}]}".to_vec()),
        ("cut.bvh", BVH.as_bytes()[..200].to_vec()),
        ("nan.bvh", changed("OFFSET 0 90 0", "OFFSET 0 NaN 0")),
        ("inf.bvh", changed("OFFSET 0 90 0", "OFFSET 0 inf 0")),
        ("rate.bvh", changed("0.0333333", "0")),
        ("none.bvh", b"HIERARCHY\n".to_vec()),
        ("bad.asf", b":version 1.10\n:bonedata\n  begin\n    id x\n".to_vec()),
        ("bad.x3d", b"<X3D><Scene><Shape></Scene></X3D>".to_vec()),
        ("dtd.x3d", b"<!DOCTYPE a [<!ENTITY b \"c\">]><X3D>&b;</X3D>".to_vec()),
        ("bad.bap", b"4.0 nothing".to_vec()),
        ("bad.fap", b"2.1 nothing".to_vec()),
        ("bad.ams", b"nothing at all".to_vec()),
        ("bad.vrm", b"glTF\x02\0\0\0\xff\xff\xff\xff".to_vec()),
    ]
}

#[test]
fn forty_wrong_inputs_end_in_one_line_and_change_no_file() {
    let here = inputs("forty");
    let files = wrong_files(&std::fs::read(here.join("a.glb")).unwrap());
    for (name, bytes) in &files {
        std::fs::write(here.join(name), bytes).unwrap();
    }
    std::fs::create_dir(here.join("folder.glb")).unwrap();
    let before = snapshot(&here);
    let mut tried = 0;
    let mut check = |words: &[&str], named: &str| {
        let ran = articula(&here, words);
        assert!(
            ran.status == 1 || ran.status == 2,
            "{words:?}: {} {}",
            ran.status,
            ran.err
        );
        let said = ran.err.lines().next().unwrap_or_default();
        assert!(
            ran.err.lines().count() == 1 && said.starts_with("error: "),
            "{words:?}: {}",
            ran.err
        );
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(ran.out, "", "{words:?}");
        tried += 1;
    };
    for (name, _) in &files {
        check(&["inspect", name], name);
        check(&["convert", name, "new.glb"], name);
        check(&["build", name, "new.glb"], name);
    }
    for name in ["folder.glb", "gone.glb", "a.glb/x.glb", "/dev/null"] {
        check(&["inspect", name], name);
        check(&["build", name, "new.glb"], name);
    }
    check(&["convert", "gone.glb", "new.glb"], "gone.glb");
    check(&["convert", "a.glb", "new.dae"], "new.dae");
    check(&["convert", "a.glb", "m.bvh/"], "m.bvh");
    check(
        &["convert", "m.bvh", "new.glb", "--onto", "gone.glb"],
        "gone.glb",
    );
    check(
        &["convert", "m.bvh", "new.glb", "--joint-map", "text.glb"],
        "text.glb",
    );
    check(&["build", "a.glb", "new.bvh"], "new.bvh");
    check(&["build", "a.glb", "./a.glb"], "a.glb");
    check(
        &[
            "build", "a.glb", "new.glb", "--levels", "2", "--lock", "text.glb",
        ],
        "text.glb",
    );
    check(&["lod", "a.glb", "--camera-path", "text.glb"], "text.glb");
    check(&["lod", "a.glb", "--schedule", "gone.json"], "gone.json");
    check(&["crowd", "a.glb", "--scene", "text.glb"], "text.glb");
    check(&["flatten", "frame", "a.glb", "new.png"], "a.glb");
    assert!(tried >= 40);
    assert_eq!(snapshot(&here), before);
}

#[cfg(unix)]
#[test]
fn names_that_are_not_text_and_files_that_cannot_be_read_are_told() {
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::PermissionsExt;
    let here = folder("odd-names");
    let odd = std::ffi::OsStr::from_bytes(b"w\xffalk.bvh");
    if std::fs::write(here.join(odd), BVH).is_ok() {
        // It is an ordinary file with a name that cannot be shown as it is.
        let ran = Command::new(env!("CARGO_BIN_EXE_articula"))
            .args(["inspect".as_ref(), odd])
            .current_dir(&here)
            .output()
            .unwrap();
        assert!(ran.status.success());
    }
    let gone = std::ffi::OsStr::from_bytes(b"g\xffone.bvh");
    let ran = Command::new(env!("CARGO_BIN_EXE_articula"))
        .args(["inspect".as_ref(), gone])
        .current_dir(&here)
        .output()
        .unwrap();
    let said = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(
        (ran.status.code(), said.lines().count()),
        (Some(1), 1),
        "{said}"
    );
    std::fs::write(here.join("closed.bvh"), BVH).unwrap();
    let closed = std::fs::Permissions::from_mode(0o000);
    std::fs::set_permissions(here.join("closed.bvh"), closed).unwrap();
    // An administrator may read everything.
    if std::fs::read(here.join("closed.bvh")).is_err() {
        let line = fault(&here, 1, &["inspect", "closed.bvh"]);
        assert!(
            line.contains("closed.bvh") && line.contains("permission"),
            "{line}"
        );
    }
}

#[cfg(unix)]
#[test]
fn devices_are_written_to_directly() {
    let here = folder("devices");
    let link = here.join("null.glb");
    std::os::unix::fs::symlink("/dev/null", &link).unwrap();
    for _ in 0..2 {
        let ran = articula(&here, &["convert", word(small()), "null.glb"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
    }
    assert!(link.is_symlink() && std::fs::read(link).unwrap().is_empty());
}
