//! Pages of other origins read what is served, and no more.

use crate::client::{Server, options};
use articula_serve::ServeOptions;

#[test]
fn pages_of_an_origin_may_read_and_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let page = ("Origin", "https://example.com");
    let closed = Server::start(folder.path(), &options());
    let answer = closed.get("/v1/characters", &[page]);
    assert_eq!(answer.header("access-control-allow-origin"), "");
    let ask = [page, ("Access-Control-Request-Method", "GET")];
    let asked = closed.request("OPTIONS", "/v1/characters", &ask, b"");
    assert_eq!(asked.status, 405);
    drop(closed);

    let options = ServeOptions {
        allow_origin: Some("https://example.com".to_owned()),
        ..options()
    };
    let open = Server::start(folder.path(), &options);
    let answer = open.get("/v1/characters", &[page]);
    assert_eq!(answer.status, 200);
    let allowed = answer.header("access-control-allow-origin");
    assert_eq!(allowed, "https://example.com");
    assert_eq!(answer.header("vary"), "origin");
    let read = answer.header("access-control-expose-headers");
    assert!(read.contains("articula-state"), "{read}");
    // Errors are read too.
    let missing = open.get("/v1/characters/none/manifest.json", &[page]);
    assert_eq!(missing.status, 404);
    assert_eq!(missing.header("access-control-allow-origin"), allowed);

    let asked = open.request("OPTIONS", "/v1/characters/walker", &ask, b"");
    assert_eq!(asked.status, 204);
    assert_eq!(asked.header("access-control-allow-methods"), "GET");
    let sent = asked.header("access-control-allow-headers");
    assert!(sent.contains("if-none-match") && !sent.contains("authorization"));
}

#[test]
fn pages_of_other_origins_open_no_session() {
    let folder = tempfile::tempdir().unwrap();
    let status = |server: &Server, origin: Option<&str>| {
        let upgrade = [
            ("Upgrade", "websocket"),
            ("Sec-WebSocket-Version", "13"),
            ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
        ];
        let origin = origin.map(|origin| ("Origin", origin));
        let headers: Vec<_> = upgrade.into_iter().chain(origin).collect();
        server.upgrade("/v1/session", &headers)
    };
    let closed = Server::start(folder.path(), &options());
    assert_eq!(status(&closed, None), 101);
    // The host that these requests name.
    assert_eq!(status(&closed, Some("http://test")), 101);
    for other in ["https://example.com", "http://test.example.com", "null", ""] {
        assert_eq!(status(&closed, Some(other)), 403, "{other}");
    }
    drop(closed);

    let of_one = ServeOptions {
        allow_origin: Some("https://example.com".to_owned()),
        ..options()
    };
    let open = Server::start(folder.path(), &of_one);
    assert_eq!(status(&open, Some("https://example.com")), 101);
    assert_eq!(status(&open, Some("http://example.com")), 403);
    drop(open);
    let of_all = ServeOptions {
        allow_origin: Some("*".to_owned()),
        ..options()
    };
    let open = Server::start(folder.path(), &of_all);
    assert_eq!(status(&open, Some("http://example.com")), 101);
}
