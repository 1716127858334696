//! `serve` as a process: it says where it listens, keeps what it was given, and ends when it is asked to.

use crate::program::{fault, folder, json};
use articula::flat::Picture;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A server, which ends with the test.
pub(crate) struct Server(Child);

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Server {
    /// Number of the process.
    pub(crate) fn id(&self) -> u32 {
        self.0.id()
    }
}

/// A server of a folder, with its address.
pub(crate) fn started(folder: &Path, arguments: &[&str]) -> (Server, String) {
    // Another build of it, such as the released one.
    let program = std::env::var_os("ARTICULA_PROGRAM");
    let program = program.unwrap_or_else(|| env!("CARGO_BIN_EXE_articula").into());
    started_by(Command::new(program), folder, arguments)
}

fn started_by(mut program: Command, folder: &Path, arguments: &[&str]) -> (Server, String) {
    let local = !arguments.contains(&"--addr");
    let mut child = program
        .args(["--json", "serve"])
        .arg(folder)
        .args(
            local
                .then_some(["--addr", "127.0.0.1:0"])
                .into_iter()
                .flatten(),
        )
        .args(arguments)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let url = lines
        .map(Result::unwrap)
        .find(|line| line.contains("\"url\""))
        .unwrap();
    let address = url.split("http://").nth(1).unwrap();
    let address = address.split('/').next().unwrap().to_owned();
    (Server(child), address)
}

pub(crate) fn request(address: &str, head: &str, body: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let length = body.len();
    let head = format!("{head}Connection: close\r\nContent-Length: {length}\r\nHost: a\r\n\r\n");
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(body).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// Checks that a server of a folder within another one answers.
pub(crate) fn answers(within: &Path, folder: &str) {
    let (server, address) = started(&within.join(folder), &[]);
    let answer = request(&address, "GET / HTTP/1.1\r\n", b"");
    drop(server);
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

#[test]
fn what_was_taken_is_there_after_a_kill() {
    let folder = folder("serve-kill");
    let (server, address) = started(&folder, &["--token", "t"]);
    let put = "PUT /v1/characters/man HTTP/1.1\r\nAuthorization: Bearer t\r\n";
    let answer = request(&address, put, b"glTF, but nothing more");
    assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
    drop(server);
    let stored = std::fs::read(folder.join("man.glb")).unwrap();
    assert_eq!(stored, b"glTF, but nothing more");

    let (mut server, address) = started(&folder, &[]);
    let list = request(&address, "GET /v1/characters HTTP/1.1\r\n", b"");
    assert!(list.contains("\"name\":\"man\""), "{list}");
    #[cfg(unix)]
    {
        let asked = Command::new("kill").arg(server.0.id().to_string()).status();
        assert!(asked.unwrap().success());
        assert!(server.0.wait().unwrap().success(), "it ends as it should");
    }
    drop(server);
}

#[test]
fn addresses_that_others_reach_and_missing_folders_are_refused() {
    let folder = folder("serve-refusals");
    let path = folder.to_str().unwrap();
    let why = fault(&folder, 2, &["serve", path, "--addr", "0.0.0.0:0"]);
    assert!(why.contains("--token"), "{why}");
    let why = fault(&folder, 2, &["serve", "nowhere"]);
    assert!(why.contains("nowhere"), "{why}");
    let (server, address) = started(&folder, &[]);
    let same = fault(&folder, 2, &["serve", "--store", "nowhere"]);
    assert_eq!(same, why);
    let why = fault(&folder, 1, &["serve", "--store", path, "--addr", &address]);
    assert!(why.contains("another server"), "{why}");
    let other = self::folder("serve-refusals-other");
    let why = fault(&other, 1, &["serve", "--store", ".", "--addr", &address]);
    assert!(why.contains("another port"), "{why}");
    drop(server);
}

#[cfg(unix)]
#[test]
fn a_catalogue_that_finds_no_space_says_so_and_is_there_with_space() {
    let here = folder("serve-full-catalogue");
    let store = here.join("store");
    std::fs::create_dir(&store).unwrap();
    // Less than the tables take: 16 blocks of 512 or 1024 bytes.
    let limited = r#"trap "" XFSZ; ulimit -f 16; exec "$0" serve store --addr 127.0.0.1:0"#;
    let mut program = Command::new("sh");
    program.args(["-c", limited, env!("CARGO_BIN_EXE_articula")]);
    let ended = program.current_dir(&here).output().unwrap();
    assert_eq!(ended.status.code(), Some(1));
    let line = String::from_utf8(ended.stderr).unwrap();
    assert!(
        line.contains("catalogue.sqlite3: ") && line.contains("full"),
        "{line}"
    );
    assert_eq!(line.trim_end().lines().count(), 1, "{line}");
    let elsewhere = here.join("elsewhere.db");
    let more = ["--catalogue", elsewhere.to_str().unwrap()];
    for more in [&more[..], &[]] {
        let (server, address) = started(&store, more);
        let list = request(&address, "GET /v1/characters HTTP/1.1\r\n", b"");
        assert!(list.ends_with("[]"), "{list}");
        drop(server);
    }
    assert!(elsewhere.is_file() && store.join(".articula/catalogue.sqlite3").is_file());
    // A file that somebody wants to keep is no catalogue.
    std::fs::write(&elsewhere, b"notes ".repeat(500)).unwrap();
    for companion in ["-wal", "-shm"] {
        let _ = std::fs::remove_file(here.join(format!("elsewhere.db{companion}")));
    }
    let why = fault(&here, 1, &["serve", "store", "--catalogue", "elsewhere.db"]);
    assert!(why.contains("elsewhere.db: this is no catalogue"), "{why}");
    assert_eq!(std::fs::read(&elsewhere).unwrap(), b"notes ".repeat(500));
}

#[cfg(unix)]
#[test]
fn a_store_that_takes_no_more_says_so_and_serves_on() {
    let folder = folder("serve-full");
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb");
    let mut glb = std::fs::read(case).unwrap();
    // A disk without space for a file of this size, but for the catalogue: 512 blocks of 512 or 1024 bytes. Bytes behind
    // those that the head of a GLB tells of are ignored.
    glb.resize(600 * 1024, 0);
    let limited = r#"trap "" XFSZ; ulimit -f 512; exec "$0" "$@""#;
    let mut program = Command::new("sh");
    program.args(["-c", limited, env!("CARGO_BIN_EXE_articula")]);
    let (server, address) = started_by(program, &folder, &[]);
    let put = |name: &str, body: &[u8]| {
        let head = format!("PUT /v1/characters/{name} HTTP/1.1\r\n");
        request(&address, &head, body)
    };
    let refused = put("walker", &glb);
    assert!(refused.starts_with("HTTP/1.1 507"), "{refused}");
    assert!(refused.contains("full"), "{refused}");
    let left = std::fs::read_dir(&folder).unwrap();
    let left: Vec<_> = left.map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, [".articula"]);
    // It takes what is small.
    let taken = put("small", b"glTF, but nothing more");
    assert!(taken.starts_with("HTTP/1.1 202"), "{taken}");
    let list = request(&address, "GET /v1/characters HTTP/1.1\r\n", b"");
    assert!(list.contains("small") && !list.contains("walker"), "{list}");
    drop(server);
    // With space again all is well.
    let (server, address) = started(&folder, &[]);
    let head = "PUT /v1/characters/walker HTTP/1.1\r\n";
    assert!(request(&address, head, &glb).starts_with("HTTP/1.1 202"));
    assert_eq!(std::fs::read(folder.join("walker.glb")).unwrap(), glb);
    drop(server);
}

#[test]
fn a_served_character_is_shown_from_its_base_on() {
    let here = folder("serve-play");
    let characters = here.join("characters");
    std::fs::create_dir(&characters).unwrap();
    let case =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb");
    std::fs::copy(case, characters.join("walker.glb")).unwrap();
    // Captions beside it, which the item carries.
    let captions = "WEBVTT\n\nwalk\n00:00.000 --> 01:00.000\nFollow me.\n\nrun\n00:00.000 --> 01:00.000\nNo.\n";
    std::fs::write(characters.join("walker.vtt"), captions).unwrap();
    let (server, address) = started(&characters, &[]);
    let url = format!("http://{address}");
    let play = |more: &[&str]| json(&here, &[&["play", &url, "--seconds"], more].concat());
    let played = play(&["1.1", "--frames", "frames"]);
    assert_eq!(
        (&played["name"], &played["by"]),
        (&"walker".into(), &"http".into())
    );
    let samples = played["samples"].as_array().unwrap();
    let said = samples
        .iter()
        .filter_map(|sample| sample["caption"].as_str());
    assert!(said.clone().count() > 0 && said.clone().all(|said| said == "Follow me."));
    assert!(
        samples[0]["triangles"].as_u64() > Some(4) && samples[0]["bytes"].as_u64() > Some(1000)
    );
    let pictures = played["pictures"].as_u64().unwrap();
    let first = std::fs::read(here.join("frames/00000.png")).unwrap();
    let picture = Picture::decode(&first).unwrap();
    let last = here.join(format!("frames/{:05}.png", pictures - 1));
    assert!(pictures >= 2 && last.exists());
    assert_ne!(std::fs::read(last).unwrap(), first, "it moves");
    let colors: BTreeSet<[u8; 4]> = picture.pixels().iter().copied().collect();
    assert!(colors.len() > 50, "a lit figure");
    // In a session with little bandwidth it begins with less, and more comes when the slider is moved.
    let slow = play(&["1.2", "--session", "--slider", "0:16,0.4:full"]);
    assert_eq!(slow["by"], "session");
    let samples = slow["samples"].as_array().unwrap();
    let (first, last) = (&samples[0], samples.last().unwrap());
    assert!(last["level"].as_u64() >= first["level"].as_u64());
    assert!(last["bytes"].as_u64() > first["bytes"].as_u64(), "{last}");
    assert!(first["slider_bps"] == 16e3 && last["slider_bps"].is_null());
    let phases = slow["phases"].as_array().unwrap();
    assert_eq!(phases.len(), 2, "{phases:?}");
    assert!(phases[0]["slider_bps"] == 16e3 && phases[1]["slider_bps"].is_null());
    assert!(phases[0]["decided_secs"].is_null(), "nothing before it");
    assert!(phases[1]["secs"].as_f64() >= Some(0.4));

    // Of the levels of quality a slow device plays the first ones alone.
    let [weak, strong] = ["10", "1000"].map(|score| {
        let played = play(&["0.1", "--device-score", score]);
        played["samples"][0]["levels"].as_u64().unwrap()
    });
    assert!(weak < strong, "{weak} {strong}");

    // Another device goes on where a session is.
    let mut other = Command::new(env!("CARGO_BIN_EXE_articula"));
    let other = other.args(["--json", "play", &url, "--session", "--clip", "walk"]);
    let other = other
        .args(["--seconds", "60"])
        .stdout(Stdio::null())
        .spawn();
    let _other = Server(other.unwrap());
    let number = loop {
        let answer = request(&address, "GET /v1/sessions HTTP/1.1\r\n", b"");
        let listed: serde_json::Value =
            serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap()).unwrap();
        let is_walking = listed[0]["characters"][0]["clip"] == "walk";
        if let Some(number) = listed[0]["number"].as_u64().filter(|_| is_walking) {
            break number.to_string();
        }
    };
    let goes_on = play(&["0.1", "--continue", &number]);
    assert_eq!(goes_on["name"], "walker");
    let why = fault(&here, 1, &["--json", "play", &url, "--continue", "999"]);
    assert!(why.contains(&format!("these are: {number}")), "{why}");
    drop(server);
}

#[test]
fn what_cannot_be_played_is_told() {
    let here = folder("serve-unplayable");
    let characters = here.join("characters");
    std::fs::create_dir(&characters).unwrap();
    let (server, address) = started(&characters, &[]);
    let url = format!("http://{address}");
    let play = |status, more: &[&str]| fault(&here, status, &[&["--json", "play"], more].concat());
    assert!(play(1, &[&url]).contains("no character"));
    assert!(play(1, &[&url, "nobody"]).contains("no such character"));
    assert!(play(2, &["https://example.org"]).contains("http://"));
    std::fs::write(characters.join("broken.glb"), b"glTF").unwrap();
    drop(server);
    assert!(play(1, &[&url]).contains(&address));
    let (server, address) = started(&characters, &[]);
    let why = play(1, &[&format!("http://{address}/")]);
    assert!(why.contains("broken.glb"), "{why}");
    let terminal = fault(&here, 2, &["play", &format!("http://{address}")]);
    assert!(terminal.contains("--frames"), "{terminal}");
    drop(server);
}
