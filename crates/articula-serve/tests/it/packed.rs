//! Items that were packaged elsewhere: put as ZIP files, or lying in folders of their own.

use crate::client::{Answer, Server, options};
use crate::queries::{counter, ready};
use articula::item::{MANIFEST, Manifest};
use articula_serve::ServeOptions;
use std::io::{Cursor, Write};
use std::path::Path;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

type Files = Vec<(String, Vec<u8>)>;

/// The files of an item as a server made it, the manifest first.
fn made() -> (Manifest, Files) {
    let folder = tempfile::tempdir().unwrap();
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb");
    std::fs::copy(case, folder.path().join("walker.glb")).unwrap();
    let server = Server::start(folder.path(), &options());
    let manifest = ready(&server, "walker");
    let names = [MANIFEST].into_iter();
    let names = names.chain(manifest.files.keys().map(String::as_str));
    let file = |name: &str| {
        let answer = server.get(&format!("/v1/characters/walker/{name}"), &[]);
        assert_eq!(answer.status, 200, "{name}");
        (name.to_owned(), answer.body)
    };
    let files = names.map(file).collect();
    (manifest, files)
}

fn packed(files: &[(String, Vec<u8>)], folder: &str) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        let options = SimpleFileOptions::default();
        archive
            .start_file(format!("{folder}{name}"), options)
            .unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn put(server: &Server, name: &str, body: &[u8]) -> Answer {
    server.request("PUT", &format!("/v1/characters/{name}"), &[], body)
}

fn status_of(server: &Server, manifest: &Manifest) -> u16 {
    let statuses = manifest.files.values().map(|entry| {
        let answer = server.get(&format!("/v1/o/{}", entry.hash), &[]);
        assert!(answer.status != 200 || answer.body.len() as u64 == entry.bytes);
        answer.status
    });
    statuses.max().unwrap()
}

#[test]
fn an_item_that_is_put_is_served_as_it_is_and_read_once() {
    let (manifest, files) = made();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &options());
    for (name, within) in [("root", ""), ("within", "walker/")] {
        assert_eq!(put(&server, name, &packed(&files, within)).status, 202);
        assert_eq!(ready(&server, name), manifest);
    }
    assert_eq!(status_of(&server, &manifest), 200);
    drop(server);
    let server = Server::start(folder.path(), &options());
    assert_eq!(ready(&server, "within"), manifest);
    assert_eq!(counter(&server, "articula_packaged_total"), 0);
    assert!(folder.path().join("within.zip").is_file());
    // A character file takes its place, and it that of the file.
    assert_eq!(put(&server, "root", b"glTF").status, 202);
    assert!(!folder.path().join("root.zip").exists());
    assert_eq!(put(&server, "root", &packed(&files, "")).status, 202);
    assert!(!folder.path().join("root.glb").exists());
    assert_eq!(ready(&server, "root"), manifest);
}

#[test]
fn an_item_in_a_folder_is_served_as_it_is() {
    let (manifest, files) = made();
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &files {
        let path = folder.path().join("hero").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    // No item.
    std::fs::create_dir(folder.path().join("notes")).unwrap();
    let server = Server::start(folder.path(), &options());
    assert_eq!(ready(&server, "hero"), manifest);
    let list = server.get("/v1/characters", &[]).json();
    assert_eq!(list.as_array().map(Vec::len), Some(1));
    assert_eq!(status_of(&server, &manifest), 200);
    let removed = server.request("DELETE", "/v1/characters/hero", &[], b"");
    assert_eq!(removed.status, 204);
    assert!(!folder.path().join("hero").exists());
}

#[test]
fn archives_that_are_no_items_are_refused_with_the_reason_and_nothing_is_written_beside() {
    let (_, files) = made();
    let above = tempfile::tempdir().unwrap();
    let folder = above.path().join("store");
    std::fs::create_dir(&folder).unwrap();
    // Zeros take a thousandth of their bytes.
    let most_bytes = files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() + (1 << 16);
    let server = Server::start(
        &folder,
        &ServeOptions {
            most_bytes,
            ..options()
        },
    );
    let with = |name: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let mut files = files.clone();
        let found = files.iter_mut().find(|(file, _)| file == name).unwrap();
        change(&mut found.1);
        files
    };
    let renamed = |manifest: &mut Vec<u8>| {
        let text = String::from_utf8(manifest.clone()).unwrap();
        *manifest = text.replace("figure.glb", "../escaped").into_bytes();
    };
    let mut escaped = with(MANIFEST, &renamed);
    escaped.push(("../escaped".to_owned(), files[1].1.clone()));
    let whole = packed(&files, "");
    let refused = [
        (
            "no manifest",
            packed(&files[1..], ""),
            "has no manifest.json",
        ),
        ("too deep", packed(&files, "a/b/"), "has no manifest.json"),
        ("cut", whole[..whole.len() / 2].to_vec(), "ZIP"),
        ("lacking", packed(&files[..2], ""), "not found"),
        (
            "changed",
            packed(&with("figure.glb", &|b| b[20] ^= 1), ""),
            "was changed",
        ),
        // A bomb: as little as a file of zeros takes.
        (
            "bomb",
            packed(&with("figure.glb", &|b| b.resize(20 << 20, 0)), ""),
            "more than",
        ),
        (
            "huge manifest",
            packed(&with(MANIFEST, &|b| b.resize(20 << 20, b' ')), ""),
            "more than",
        ),
        ("above", packed(&escaped, ""), "../escaped"),
        (
            "no json",
            packed(&with(MANIFEST, &|b| b[0] = b'!'), ""),
            "manifest.json",
        ),
    ];
    for (what, body, wanted) in refused {
        assert!(body.len() < most_bytes, "{what}");
        assert_eq!(put(&server, "walker", &body).status, 202, "{what}");
        let path = "/v1/characters/walker/manifest.json?wait=60";
        let mut answer = server.get(path, &[]);
        while answer.status == 503 {
            answer = server.get(path, &[]);
        }
        assert_eq!(answer.status, 422, "{what}");
        let error = answer.json()["error"].as_str().unwrap().to_owned();
        assert!(error.contains(wanted), "{what}: {error}");
    }
    assert_eq!(put(&server, "walker", b"PK\x05\x06").status, 415);
    assert_eq!(put(&server, "walker", &whole).status, 202);
    assert!(!ready(&server, "walker").files.is_empty());
    assert_eq!(std::fs::read_dir(above.path()).unwrap().count(), 1);
}
