//! What a server refuses, without harm to others.

use crate::client::{Server, options};
use std::io::Write;
use std::net::TcpStream;

#[test]
fn what_is_not_there_or_not_allowed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("secret.txt"), b"secret").unwrap();
    let mut options = options();
    options.token = Some("open sesame".to_owned());
    options.most_bytes = 1000;
    let server = Server::start(folder.path(), &options);
    let hash = "0".repeat(64);
    for (path, status) in [
        ("/v1/characters/man", 404),
        ("/v1/characters/man/manifest.json", 404),
        ("/v1/characters/man/figure.glb", 404),
        ("/v1/characters/..%2Fsecret.txt", 404),
        ("/v1/characters/%2e%2e/secret.txt", 404),
        ("/v1/o/secret.txt", 404),
        ("/v1/o/..%2F..%2Fsecret.txt", 404),
        (&format!("/v1/o/{hash}"), 404),
        ("/../secret.txt", 404),
        ("/v1/characters?wait=1", 200),
        ("/healthz", 200),
        ("/readyz", 200),
    ] {
        let answer = server.get(path, &[]);
        assert_eq!(answer.status, status, "{path}");
        assert!(
            !answer.body.windows(6).any(|word| word == b"secret"),
            "{path}"
        );
    }
    let put = |path: &str, token: &str, body: &[u8]| {
        let headers = [("Authorization", token)];
        server.request("PUT", path, &headers, body).status
    };
    let (path, token) = ("/v1/characters/man", "Bearer open sesame");
    assert_eq!(put(path, "", b"glTF"), 401);
    assert_eq!(put(path, "Bearer open sesam", b"glTF"), 401);
    assert_eq!(put(path, "Basic open sesame", b"glTF"), 401);
    assert_eq!(put(path, token, b"BM"), 415);
    assert_eq!(put(path, token, &[b'g'; 1001]), 413);
    for name in [".articula", "a%2Fb", "%2e%2e", "a%20b", "%FF"] {
        let status = put(&format!("/v1/characters/{name}"), token, b"glTF");
        assert_eq!(status, 400, "{name}");
    }
    let left = std::fs::read_dir(folder.path()).unwrap();
    let left = left.map(|entry| entry.unwrap().file_name());
    let others: Vec<_> = left.filter(|name| name != ".articula").collect();
    assert_eq!(others, ["secret.txt"]);
    assert_eq!(server.request("DELETE", path, &[], b"").status, 401);
    let headers = [("Authorization", token)];
    assert_eq!(server.request("DELETE", path, &headers, b"").status, 404);
    assert_eq!(server.request("POST", path, &headers, b"").status, 405);
    assert_eq!(server.get("/v1/characters", &[]).body, b"[]");
}

#[test]
fn a_broken_character_fails_and_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &options());
    let put = server.request("PUT", "/v1/characters/broken", &[], b"glTF and no more");
    assert_eq!(put.status, 202);
    // Waits until there is news: that it failed.
    let path = "/v1/characters/broken/manifest.json?wait=60";
    let answer = server.get(path, &[]);
    let why = answer.json()["error"].as_str().unwrap().to_owned();
    assert!(answer.status == 422 && why.contains("broken.glb"), "{why}");
    let state = server.get("/v1/characters/broken", &[]).json();
    assert_eq!(
        (state["state"].as_str(), state["why"].as_str()),
        (Some("failed"), Some(&*why))
    );
    let page = server.get("/", &[]);
    assert!(String::from_utf8(page.body).unwrap().contains("failed: "));
    // Nonsense on one connection does not end others.
    let mut stream = TcpStream::connect(server.at).unwrap();
    stream.write_all(b"\x16\x03\x01 nonsense\r\n\r\n").unwrap();
    assert_eq!(server.get("/healthz", &[]).body, b"ok\n");
}

#[test]
fn requests_beyond_the_limit_are_told_to_come_later() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = options();
    options.most_requests = 0;
    let server = Server::start(folder.path(), &options);
    let answer = server.get("/v1/characters", &[]);
    assert_eq!((answer.status, answer.header("retry-after")), (503, "1"));
    assert_eq!(server.get("/healthz", &[]).status, 200);
    let counted = String::from_utf8(server.get("/metrics", &[]).body).unwrap();
    assert!(counted.contains("articula_overloaded_total 1\n"));
}

#[test]
fn the_routes_are_part_of_other_ones() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::nested(folder.path(), &options());
    assert_eq!(server.get("/avatars/v1/characters", &[]).body, b"[]");
    assert_eq!(server.get("/v1/characters", &[]).status, 404);
}
