//! Characters that are removed, what is left of them, and bodies in the coding that browsers take.

use crate::client::{Server, options};
use crate::queries::{counter, ready};
use articula::item::Manifest;
use std::io::Read as _;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Makes all files of a folder two hours old; returns their number.
fn age(folder: &Path) -> u64 {
    let mut aged = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            aged += age(&path);
            continue;
        }
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        let past = SystemTime::now() - Duration::from_secs(7200);
        file.set_modified(past).unwrap();
        aged += 1;
    }
    aged
}

/// Makes all rows of a catalogue two hours old.
fn age_rows(catalogue: &Path) {
    let db = rusqlite::Connection::open(catalogue).unwrap();
    let aged = "UPDATE jobs SET queued = queued - 7200, ended = ended - 7200;
        UPDATE variants SET made = made - 7200;";
    db.execute_batch(aged).unwrap();
}

#[test]
fn what_is_left_of_a_character_that_was_removed_goes_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases");
    for (name, case) in [("walker", "base.glb"), ("other", "matrix_nodes.glb")] {
        let to = folder.path().join(format!("{name}.glb"));
        std::fs::copy(cases.join(case), to).unwrap();
    }
    let server = Server::start(folder.path(), &options());
    let (kept, gone) = (ready(&server, "walker"), ready(&server, "other"));
    let cut = "/v1/characters/walker/cut?loa=1";
    let cut_before = server.get(cut, &[]);
    for path in [
        "/v1/characters/walker.glb?clip=none",
        "/v1/characters/other/cut?loa=1",
    ] {
        let answer = server.get(path, &[]);
        assert_eq!(answer.status, 200, "{path}");
    }
    assert_eq!(cut_before.status, 200);
    let removed = server.request("DELETE", "/v1/characters/other", &[], b"");
    assert_eq!((removed.status, removed.body.len()), (204, 0));
    assert_eq!(server.get("/v1/characters/other", &[]).status, 404);
    let list = server.get("/v1/characters", &[]).json();
    assert_eq!(list.as_array().map(Vec::len), Some(1));
    assert!(!folder.path().join("other.glb").exists());
    drop(server);

    // What is young stays: it may be that of a server that begins to package.
    let server = Server::start(folder.path(), &options());
    assert_eq!(counter(&server, "articula_swept_total"), 0);
    drop(server);

    let objects = folder.path().join(".articula");
    // As a server leaves it that is killed while it writes.
    let part = objects.join("objects/00/00.1-1.part");
    std::fs::create_dir_all(part.parent().unwrap()).unwrap();
    std::fs::write(&part, b"half").unwrap();
    age_rows(&objects.join("catalogue.sqlite3"));
    let before = age(&objects);
    let server = Server::start(folder.path(), &options());
    let swept = counter(&server, "articula_swept_total");
    assert!(swept > 5 && swept < before, "{swept} of {before}");
    assert!(!part.exists());
    let status = |of: &Manifest, file: &str| {
        let path = format!("/v1/o/{}", of.files[file].hash);
        server.get(&path, &[]).status
    };
    let only_gone = |file: &&String| {
        let hash = &gone.files[*file].hash;
        kept.files.values().all(|entry| entry.hash != *hash)
    };
    assert!(kept.files.keys().all(|file| status(&kept, file) == 200));
    assert!(gone.files.keys().any(|file| only_gone(&file)));
    let mut of_gone = gone.files.keys().filter(only_gone);
    assert!(of_gone.all(|file| status(&gone, file) == 404));
    // Nothing is made again, and the cut has all of its objects.
    let cut_after = server.get(cut, &[]);
    assert!(cut_after.body == cut_before.body);
    let of_cut: Manifest = serde_json::from_slice(&cut_after.body).unwrap();
    assert!(of_cut.files.keys().all(|file| status(&of_cut, file) == 200));
    assert_eq!(counter(&server, "articula_packaged_total"), 0);
    assert_eq!(counter(&server, "articula_made_total"), 0);
}

#[test]
fn a_client_that_takes_gzip_alone_gets_it_and_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb");
    std::fs::copy(case, folder.path().join("walker.glb")).unwrap();
    let server = Server::start(folder.path(), &options());
    ready(&server, "walker");
    let path = "/v1/characters/walker/manifest.json";
    let plain = server.get(path, &[]);
    for _ in 0..2 {
        let short = server.get(path, &[("Accept-Encoding", "gzip, deflate")]);
        assert_eq!(short.header("content-encoding"), "gzip");
        assert!(short.header("etag").ends_with("-gzip\""));
        assert!(2 * short.body.len() < plain.body.len());
        let mut whole = Vec::new();
        let mut decoder = flate2::read::GzDecoder::new(&short.body[..]);
        decoder.read_to_end(&mut whole).unwrap();
        assert!(whole == plain.body);
    }
    let both = server.get(path, &[("Accept-Encoding", "gzip, deflate, br")]);
    assert_eq!(both.header("content-encoding"), "br");
}
