//! Clients that are slow, silent or too many, and a store that fails: no harm to others.

use crate::client::{Server, options};
use articula_serve::{RequestWatcher, ServeOptions};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// A server that loses patience at once.
fn impatient() -> ServeOptions {
    ServeOptions {
        silence: Duration::from_millis(100),
        drain: Duration::from_millis(100),
        ..options()
    }
}

/// Sends bytes and nothing more; returns what comes until the server ends the connection.
fn said(server: &Server, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(server.at).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    stream.write_all(bytes).unwrap();
    let mut answer = Vec::new();
    let ended = stream.read_to_end(&mut answer);
    let is_kept = ended.is_err_and(|e| e.kind() == std::io::ErrorKind::WouldBlock);
    assert!(!is_kept, "the connection is kept");
    String::from_utf8(answer).unwrap()
}

#[test]
fn clients_that_say_nothing_more_are_left() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &impatient());
    assert_eq!(said(&server, b""), "");
    let begun = said(&server, b"GET /healthz HTTP/1.1\r\nHost: a\r\nX-");
    assert!(!begun.contains("ok"), "{begun}");
    // A connection that is kept for more requests.
    let kept = said(&server, b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n");
    assert!(
        kept.starts_with("HTTP/1.1 200") && kept.ends_with("ok\n"),
        "{kept}"
    );
    // A body that stops.
    let put = b"PUT /v1/characters/a HTTP/1.1\r\nHost: a\r\nContent-Length: 900\r\n\r\nglTF";
    assert!(said(&server, put).starts_with("HTTP/1.1 408"));
    assert_eq!(server.get("/v1/characters", &[]).body, b"[]");
}

#[test]
fn who_waits_for_an_answer_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        packaging: 0,
        ..impatient()
    };
    let server = Server::start(folder.path(), &options);
    let put = server.request("PUT", "/v1/characters/a", &[], b"glTF");
    assert_eq!(put.status, 202);
    // Longer than a silent client is kept.
    let waited = server.get("/v1/characters/a/manifest.json?wait=0.4", &[]);
    assert_eq!((waited.status, waited.header("retry-after")), (503, "1"));
}

#[test]
fn a_body_is_refused_by_its_size_whatever_its_head_says() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        most_bytes: 1000,
        ..impatient()
    };
    let server = Server::start(folder.path(), &options);
    let put = |head: &str, body: &[u8]| {
        let head = format!("PUT /v1/characters/a HTTP/1.1\r\nHost: a\r\n{head}\r\n\r\n");
        said(&server, &[head.as_bytes(), body].concat())
    };
    // Told too large, it is not read.
    assert!(put("Content-Length: 1001", b"").starts_with("HTTP/1.1 413"));
    let chunk = [b"1f4\r\n".as_slice(), &[b'g'; 500], b"\r\n"].concat();
    let chunked = "Transfer-Encoding: chunked";
    assert!(put(chunked, &chunk.repeat(3)).starts_with("HTTP/1.1 413"));
    let broken = put(chunked, b"zz\r\nglTF");
    assert!(broken.starts_with("HTTP/1.1 400"), "{broken}");
    let fits = put(chunked, &[&chunk.repeat(2)[..], b"0\r\n\r\n"].concat());
    assert!(fits.starts_with("HTTP/1.1 415"), "{fits}");
    // More than it tells: the rest is another request, and a wrong one.
    let more = put("Content-Length: 4", b"glTFglTF\r\n\r\n");
    assert!(
        more.starts_with("HTTP/1.1 202") && more.contains("HTTP/1.1 400"),
        "{more}"
    );
    assert_eq!(server.get("/healthz", &[]).status, 200);
}

#[test]
fn characters_that_are_put_at_once_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        most_uploads: 0,
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    let put = server.request("PUT", "/v1/characters/a", &[], b"glTF");
    assert_eq!((put.status, put.header("retry-after")), (503, "1"));
}

#[test]
fn connections_beyond_the_limit_are_told_to_come_later() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        most_connections: 2,
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    let mut held = [(); 2].map(|()| TcpStream::connect(server.at).unwrap());
    for stream in &mut held {
        // It is held once it is answered.
        stream
            .write_all(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n")
            .unwrap();
        let mut first = [0; 12];
        stream.read_exact(&mut first).unwrap();
        assert_eq!(&first, b"HTTP/1.1 200");
    }
    let refused = said(&server, b"");
    assert!(refused.starts_with("HTTP/1.1 503") && refused.contains("Retry-After"));
    drop(held);
    // A server that is stopped does not wait for those that are kept.
    let kept = loop {
        let mut stream = TcpStream::connect(server.at).unwrap();
        let _ = stream.write_all(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n");
        let mut first = [0; 12];
        if stream.read_exact(&mut first).is_ok() && &first == b"HTTP/1.1 200" {
            break stream;
        }
    };
    let start = Instant::now();
    drop(server);
    assert!(start.elapsed() < Duration::from_secs(5));
    drop(kept);
}

#[test]
fn a_store_that_fails_is_told_and_used_again_when_it_is_mended() {
    let here = tempfile::tempdir().unwrap();
    let folder = here.path().join("characters");
    std::fs::create_dir(&folder).unwrap();
    let options = ServeOptions {
        packaging: 0,
        ..options()
    };
    let server = Server::start(&folder, &options);
    let put = || server.request("PUT", "/v1/characters/man", &[], b"glTF and no more");
    // A file cannot take the place of a folder.
    std::fs::create_dir(folder.join("man.glb")).unwrap();
    let refused = put();
    let why = refused.json()["error"].as_str().unwrap().to_owned();
    assert!(refused.status == 500 && why.contains("man.glb"), "{why}");
    std::fs::remove_dir(folder.join("man.glb")).unwrap();
    assert_eq!(put().status, 202);
    // The folder goes and comes back while it is served.
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(server.get("/readyz", &[]).status, 503);
    let object = format!("/v1/o/{}", "0".repeat(64));
    assert_eq!(server.get(&object, &[]).status, 404);
    assert_eq!(server.get("/healthz", &[]).status, 200);
    assert_eq!(put().status, 202);
    assert_eq!(server.get("/readyz", &[]).status, 200);
}

#[test]
fn a_client_that_takes_nothing_of_an_answer_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        patience: Duration::from_millis(100),
        most_connections: 1,
        packaging: 0,
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    // More than the buffers of a connection hold, as one answer after the other.
    let mut deaf = TcpStream::connect(server.at).unwrap();
    deaf.set_write_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    let asked = b"GET /openapi.json HTTP/1.1\r\nHost: a\r\n\r\n".repeat(100);
    while deaf.write_all(&asked).is_ok() {}
    // Its place is free again.
    let other = b"GET /healthz HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";
    while !said(&server, other).starts_with("HTTP/1.1 200") {}
}

#[test]
fn each_request_is_told_with_its_answer() {
    let folder = tempfile::tempdir().unwrap();
    let (tell, told) = std::sync::mpsc::channel();
    let options = ServeOptions {
        watcher: Some(RequestWatcher::new(move |of| {
            tell.send(of.clone()).unwrap()
        })),
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    server.get("/v1/characters?a=b", &[]);
    server.request("PUT", "/v1/characters/a", &[], b"BM");
    let [list, put] = [(); 2].map(|()| told.recv().unwrap());
    assert_eq!((&*list.method, &*list.path), ("GET", "/v1/characters?a=b"));
    assert_eq!((list.status, list.bytes), (200, Some(2)));
    assert_eq!((&*put.method, put.status), ("PUT", 415));
    assert!(put.ms >= 0.0);
}

#[test]
fn a_connection_is_written_to_at_its_rate() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        throttle_bps: Some(80e3),
        packaging: 0,
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    for number in 0..30 {
        let path = format!("/v1/characters/{number:0100}");
        assert_eq!(server.request("PUT", &path, &[], b"glTF").status, 202);
    }
    let start = Instant::now();
    let list = server.get("/v1/characters", &[]).body.len() as f64;
    let secs = start.elapsed().as_secs_f64();
    // 10 kB a second, of which the first 1.5 kB come at once.
    assert!(
        list > 4000.0 && secs > (list - 1500.0) / 10e3 - 0.1,
        "{list} in {secs} s"
    );
}

#[test]
fn an_address_that_holds_its_share_is_told_to_wait() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        most_of_address: Some(2),
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    let mut held = Vec::new();
    for _ in 0..2 {
        let mut stream = TcpStream::connect(server.at).unwrap();
        let request = b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n";
        stream.write_all(request).unwrap();
        let mut head = [0; 12];
        stream.read_exact(&mut head).unwrap();
        assert_eq!(&head, b"HTTP/1.1 200");
        held.push(stream);
    }
    let third = said(&server, b"");
    assert!(third.starts_with("HTTP/1.1 429"), "{third}");
    assert!(third.contains("Retry-After: 1"), "{third}");
    drop(held.pop());
    // Until the server has seen that it is gone.
    while said(
        &server,
        b"GET /healthz HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n",
    )
    .starts_with("HTTP/1.1 429")
    {}
}
