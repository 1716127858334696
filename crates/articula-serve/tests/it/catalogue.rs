//! The catalogue of a store: where it lies, who may open it, what is taken over of earlier versions, and that nothing that
//! was done is done again.

use crate::client::{Server, options};
use crate::queries::{counter, ready};
use articula_serve::{Catalogue, Progress, ServeOptions};
use rusqlite::Connection;
use std::path::{Path, PathBuf};

fn case(name: &str) -> PathBuf {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases");
    cases.join(name)
}

fn walker(folder: &Path, name: &str) {
    std::fs::copy(case("base.glb"), folder.join(name)).unwrap();
}

fn opened(folder: &Path) -> Connection {
    Connection::open(folder.join(".articula/catalogue.sqlite3")).unwrap()
}

fn text(db: &Connection, select: &str) -> String {
    db.query_row(select, [], |row| row.get(0)).unwrap()
}

fn refused(folder: &Path, options: &ServeOptions) -> String {
    Catalogue::open(folder, options).unwrap_err().to_string()
}

const WALKER: &str = "SELECT state FROM characters JOIN jobs USING (job) WHERE name = 'walker'";

#[test]
fn other_programs_read_the_jobs_while_they_are_done() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &options());
    let glb = std::fs::read(case("base.glb")).unwrap();
    let path = "/v1/characters/walker";
    assert_eq!(server.request("PUT", path, &[], &glb).status, 202);
    assert_eq!(
        server
            .request("PUT", "/v1/characters/broken", &[], b"glTF")
            .status,
        202
    );
    let manifest = ready(&server, "walker");
    server.get("/v1/characters/broken/manifest.json?wait=60", &[]);
    let db = opened(folder.path());
    assert_eq!(text(&db, WALKER), "ready");
    let why = text(&db, "SELECT why FROM jobs WHERE state = 'failed'");
    assert!(why.contains("broken.glb"), "{why}");
    let bytes: u64 = db
        .query_row(
            "SELECT bytes FROM items JOIN jobs ON item = manifest WHERE state = 'ready'",
            [],
            |row| row.get(0),
        )
        .unwrap();
    assert_eq!(
        bytes,
        manifest.files.values().map(|of| of.bytes).sum::<u64>()
    );
    let counted = String::from_utf8(server.get("/metrics", &[]).body).unwrap();
    for line in [
        "state=\"ready\"} 1\n",
        "state=\"failed\"} 1\n",
        "state=\"waiting\"} 0\n",
    ] {
        assert!(
            counted.contains(&format!("articula_characters{{{line}")),
            "{counted}"
        );
    }
    // Another program that writes for long holds up what changes something, and nothing else.
    let captioned = folder.path().join("captioned.vtt");
    std::fs::write(captioned, "WEBVTT\n").unwrap();
    let put = |name: &str| {
        let path = format!("/v1/characters/{name}");
        server.request("PUT", &path, &[], &glb)
    };
    assert_eq!(put("captioned").status, 202);
    db.execute_batch("BEGIN IMMEDIATE").unwrap();
    assert_eq!(server.get(path, &[]).status, 200);
    assert_eq!(server.get("/v1/devices", &[]).status, 200);
    let late = put("other");
    assert_eq!((late.status, late.header("retry-after")), (503, "1"));
    let other = folder.path().join("other.glb");
    assert!(!other.exists(), "it was not accepted");
    db.execute_batch("ROLLBACK").unwrap();
    assert_eq!(put("other").status, 202);
    // What was being packaged meanwhile is not given up.
    assert_eq!(ready(&server, "captioned").whole.len(), 1);
    ready(&server, "other");
    assert_eq!(counter(&server, "articula_failed_total"), 1);
}

#[test]
fn the_same_bytes_are_packaged_once_by_any_names_and_at_any_start() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["walker.glb", "runner.glb", "third.vrm"] {
        walker(folder.path(), name);
    }
    let server = Server::start(folder.path(), &options());
    let manifests = ["walker", "runner", "third"].map(|name| ready(&server, name));
    assert!(manifests.windows(2).all(|two| two[0] == two[1]));
    assert_eq!(counter(&server, "articula_packaged_total"), 1);
    drop(server);
    // As a server leaves it that is killed: the first step of one job is done.
    opened(folder.path())
        .execute_batch("UPDATE jobs SET state = 'packaging', item = NULL, ended = NULL")
        .unwrap();
    let server = Server::start(folder.path(), &options());
    assert!(ready(&server, "third") == manifests[0]);
    assert_eq!(counter(&server, "articula_packaged_total"), 1);
    let db = opened(folder.path());
    assert_eq!(text(&db, "SELECT attempts || state FROM jobs"), "2ready");
}

#[test]
fn a_file_that_is_changed_while_no_server_runs_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    walker(folder.path(), "walker.glb");
    let before = ready(&Server::start(folder.path(), &options()), "walker");
    let age = |name: &str, secs: u64| {
        let path = folder.path().join(name);
        let file = std::fs::File::options().write(true).open(path).unwrap();
        let past = std::time::SystemTime::now() - std::time::Duration::from_secs(secs);
        file.set_modified(past).unwrap();
    };
    age("walker.glb", 100);
    drop(Catalogue::open(folder.path(), &options()).unwrap());
    let stamp = "SELECT stamp FROM characters";
    let known = text(&opened(folder.path()), stamp);
    assert!(known.starts_with("walker.glb "), "{known}");
    // Captions beside it, and then another figure with the same time.
    std::fs::write(folder.path().join("walker.vtt"), "WEBVTT\n").unwrap();
    age("walker.vtt", 100);
    let with = ready(&Server::start(folder.path(), &options()), "walker");
    assert!(with != before && with.whole.len() == 1);
    std::fs::remove_file(folder.path().join("walker.vtt")).unwrap();
    std::fs::copy(case("matrix_nodes.glb"), folder.path().join("walker.glb")).unwrap();
    age("walker.glb", 100);
    assert!(ready(&Server::start(folder.path(), &options()), "walker") != before);
}

/// Lays the files that earlier versions wrote of all that is in a catalogue, and removes it.
fn lay_old(folder: &Path) -> usize {
    let made = folder.join(".articula");
    let db = opened(folder);
    let mut laid = 0;
    let mut lay = |place: String, text: String| {
        let path = made.join(place);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
        laid += 1;
    };
    let mut jobs = db
        .prepare("SELECT job, item FROM jobs WHERE item IS NOT NULL")
        .unwrap();
    let mut jobs = jobs.query([]).unwrap();
    while let Some(row) = jobs.next().unwrap() {
        let [job, item] = [0, 1].map(|i| row.get::<_, String>(i).unwrap());
        lay(
            format!("items/{job}.json"),
            serde_json::json!({"manifest": item}).to_string(),
        );
    }
    let mut made_by = db
        .prepare("SELECT variant, object, item, form FROM variants")
        .unwrap();
    let mut made_by = made_by.query([]).unwrap();
    while let Some(row) = made_by.next().unwrap() {
        let [key, object, item, form] = [0, 1, 2, 3].map(|i| row.get::<_, String>(i).unwrap());
        let record = serde_json::json!({"object": object, "item": item, "form": form});
        lay(format!("queries/{key}.json"), record.to_string());
    }
    let reports = "SELECT device, group_concat(report, char(10)) FROM device_runs GROUP BY device";
    let mut devices = db.prepare(reports).unwrap();
    let mut devices = devices.query([]).unwrap();
    while let Some(row) = devices.next().unwrap() {
        let [device, reports] = [0, 1].map(|i| row.get::<_, String>(i).unwrap());
        lay(format!("devices/{device}.jsonl"), format!("{reports}\n"));
    }
    drop(devices);
    for name in ["catalogue.sqlite3", "catalogue.sqlite3.lock"] {
        std::fs::remove_file(made.join(name)).unwrap();
    }
    laid
}

#[test]
fn a_store_of_an_earlier_version_is_taken_over_once_and_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    walker(folder.path(), "walker.glb");
    let server = Server::start(folder.path(), &options());
    let manifest = ready(&server, "walker");
    let queries = ["walker/cut?loa=1", "walker.glb?clip=none"];
    let get = |server: &Server, query: &str| {
        let answer = server.get(&format!("/v1/characters/{query}"), &[]);
        assert_eq!(answer.status, 200, "{query}");
        answer.body
    };
    let bodies = queries.map(|query| get(&server, query));
    let report = r#"{"device": {"cpu": "a", "cores": 2, "os": "linux", "arch": "x86_64", "program": "1",
        "backend": "avx2", "threads": 1},
        "results": [{"application": "body", "grades": [{"grade": 5, "fps": 30.0, "runs": 6}]}]}"#;
    for _ in 0..3 {
        let put = server.request("PUT", "/v1/devices", &[], report.as_bytes());
        assert_eq!(put.status, 201);
    }
    drop(server);
    assert_eq!(lay_old(folder.path()), 4);
    let made = folder.path().join(".articula");
    // What is no record is no reason to stop.
    std::fs::write(made.join("items").join("0".repeat(64) + ".json"), "{").unwrap();
    std::fs::write(made.join("queries/.part"), "half").unwrap();
    let old = ["items", "queries", "devices"].map(|name| made.join(name));

    let check = |options: &ServeOptions| {
        let server = Server::start(folder.path(), options);
        assert!(ready(&server, "walker") == manifest);
        assert!(queries.map(|query| get(&server, query)) == bodies);
        assert_eq!(server.get("/v1/devices?cpu=a", &[]).json()["runs"], 3);
        assert_eq!(counter(&server, "articula_packaged_total"), 0);
        assert_eq!(counter(&server, "articula_made_total"), 0);
    };
    // A server that may not write has it all too, and leaves it.
    let read_only = ServeOptions {
        read_only: true,
        ..options()
    };
    check(&read_only);
    assert!(old.iter().all(|folder| folder.is_dir()));
    assert!(!made.join("catalogue.sqlite3").exists());
    let notes = Catalogue::open(folder.path(), &options())
        .unwrap()
        .notes()
        .to_vec();
    assert!(
        notes.len() == 1 && notes[0].contains("6 records"),
        "{notes:?}"
    );
    assert!(old.iter().all(|folder| !folder.exists()));
    check(&options());
    assert!(
        Catalogue::open(folder.path(), &options())
            .unwrap()
            .notes()
            .is_empty()
    );
    check(&read_only);
}

#[test]
fn the_catalogue_may_lie_elsewhere_than_the_characters() {
    let (folder, disk) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    walker(folder.path(), "walker.glb");
    let elsewhere = ServeOptions {
        catalogue: Some(disk.path().join("deep/er/articula.db")),
        ..options()
    };
    let manifest = ready(&Server::start(folder.path(), &elsewhere), "walker");
    assert!(disk.path().join("deep/er/articula.db").is_file());
    assert!(!folder.path().join(".articula/catalogue.sqlite3").exists());
    let server = Server::start(folder.path(), &elsewhere);
    assert!(ready(&server, "walker") == manifest);
    assert_eq!(counter(&server, "articula_packaged_total"), 0);
    // One server writes to it, others read.
    let second = refused(folder.path(), &elsewhere);
    assert!(second.contains("articula.db: another server"), "{second}");
    let reader = ServeOptions {
        read_only: true,
        ..elsewhere
    };
    let reader = Server::start(folder.path(), &reader);
    assert!(ready(&reader, "walker") == manifest);
}

#[test]
fn a_damaged_catalogue_is_made_anew_and_one_of_a_later_version_is_left() {
    let folder = tempfile::tempdir().unwrap();
    walker(folder.path(), "walker.glb");
    let manifest = ready(&Server::start(folder.path(), &options()), "walker");
    let place = folder.path().join(".articula/catalogue.sqlite3");
    std::fs::write(
        &place,
        b"nothing that SQLite knows, of some length".repeat(50),
    )
    .unwrap();
    let read_only = ServeOptions {
        read_only: true,
        ..options()
    };
    let error = refused(folder.path(), &read_only);
    assert!(
        error.contains("catalogue.sqlite3: ") && error.contains("without --read-only"),
        "{error}"
    );
    let catalogue = Catalogue::open(folder.path(), &options()).unwrap();
    assert!(
        catalogue.notes()[0].contains("damaged-1"),
        "{:?}",
        catalogue.notes()
    );
    assert_eq!(
        catalogue.state("walker").unwrap().progress,
        Progress::Waiting
    );
    drop(catalogue);
    assert!(ready(&Server::start(folder.path(), &options()), "walker") == manifest);
    opened(folder.path())
        .pragma_update(None, "user_version", 7)
        .unwrap();
    let error = refused(folder.path(), &options());
    assert!(
        error.contains("version 7") && !error.contains('\n'),
        "{error}"
    );
}

#[test]
fn a_store_that_is_removed_in_mid_run_takes_characters_again() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    std::fs::create_dir(&store).unwrap();
    walker(&store, "walker.glb");
    let server = Server::start(&store, &options());
    let manifest = ready(&server, "walker");
    std::fs::remove_dir_all(&store).unwrap();
    let answer = server.get("/readyz", &[]);
    assert_eq!(answer.status, 503);
    assert!(answer.json()["error"].as_str().unwrap().contains("store"));
    assert_eq!(server.get("/healthz", &[]).status, 200);
    let glb = std::fs::read(case("base.glb")).unwrap();
    assert_eq!(
        server
            .request("PUT", "/v1/characters/walker", &[], &glb)
            .status,
        202
    );
    assert!(ready(&server, "walker") == manifest);
    assert_eq!(server.get("/readyz", &[]).status, 200);
    assert_eq!(
        text(&opened(&store), "SELECT name FROM characters"),
        "walker"
    );
}
