//! `serve` as a process: it says where it listens, keeps what it was given, and ends when it is asked to.

use crate::program::{fault, folder};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A server of a folder, with its address.
fn started(folder: &Path, arguments: &[&str]) -> (Child, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_articula"))
        .args(["--json", "serve"])
        .arg(folder)
        .args(["--addr", "127.0.0.1:0"])
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
    (child, address)
}

fn request(address: &str, head: &str, body: &[u8]) -> String {
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
    let (mut server, address) = started(&within.join(folder), &[]);
    let answer = request(&address, "GET / HTTP/1.1\r\n", b"");
    server.kill().unwrap();
    server.wait().unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

#[test]
fn what_was_taken_is_there_after_a_kill() {
    let folder = folder("serve-kill");
    let (mut server, address) = started(&folder, &["--token", "t"]);
    let put = "PUT /v1/characters/man HTTP/1.1\r\nAuthorization: Bearer t\r\n";
    let answer = request(&address, put, b"glTF, but nothing more");
    assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
    server.kill().unwrap();
    server.wait().unwrap();
    let stored = std::fs::read(folder.join("man.glb")).unwrap();
    assert_eq!(stored, b"glTF, but nothing more");

    let (mut server, address) = started(&folder, &[]);
    let list = request(&address, "GET /v1/characters HTTP/1.1\r\n", b"");
    assert!(list.contains("\"name\":\"man\""), "{list}");
    #[cfg(unix)]
    {
        let asked = Command::new("kill").arg(server.id().to_string()).status();
        assert!(asked.unwrap().success());
        assert!(server.wait().unwrap().success(), "it ends as it should");
    }
    #[cfg(not(unix))]
    server.kill().unwrap();
}

#[test]
fn addresses_that_others_reach_and_missing_folders_are_refused() {
    let folder = folder("serve-refusals");
    let path = folder.to_str().unwrap();
    let why = fault(&folder, 2, &["serve", path, "--addr", "0.0.0.0:0"]);
    assert!(why.contains("--token"), "{why}");
    let why = fault(&folder, 2, &["serve", "nowhere"]);
    assert!(why.contains("nowhere"), "{why}");
    let (mut server, address) = started(&folder, &[]);
    let why = fault(&folder, 1, &["serve", path, "--addr", &address]);
    assert!(why.contains("another port"), "{why}");
    server.kill().unwrap();
    server.wait().unwrap();
}
