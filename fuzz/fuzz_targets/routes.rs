//! Any bytes as a request: a line with method and path, lines with heads, and a body. All are answered, those that nobody
//! may make by an error, and nothing is written.
#![no_main]

use articula_serve::{Catalogue, ServeOptions, router};
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderName, HeaderValue, Method, Request, StatusCode, Uri};
use libfuzzer_sys::fuzz_target;
use std::path::Path;
use std::sync::LazyLock;
use tokio::runtime::Runtime;
use tower::ServiceExt;

/// A server of one character that waits to be packaged, with a token that no input knows.
static SERVER: LazyLock<(Runtime, Router)> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join("articula-fuzz-routes");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("walker.glb"), b"glTF").unwrap();
    let options = ServeOptions {
        token: Some("0f4d1b6a9c".repeat(4)),
        most_bytes: 1 << 12,
        ..ServeOptions::default()
    };
    let catalogue = Catalogue::open(Path::new(&folder), &options).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    (runtime.unwrap(), router(catalogue))
});

/// The request, if it is one that a connection would pass on.
fn request(bytes: &[u8]) -> Option<Request<Body>> {
    let end = bytes.windows(2).position(|two| two == b"\n\n").unwrap_or(bytes.len());
    let (head, body) = bytes.split_at(end);
    let mut lines = head.split(|byte| *byte == b'\n');
    let mut first = lines.next()?.splitn(2, |byte| *byte == b' ');
    let method = Method::from_bytes(first.next()?).ok()?;
    let uri: Uri = std::str::from_utf8(first.next()?).ok()?.parse().ok()?;
    // As after a request line: a path, and no host.
    if !uri.path().starts_with('/') || uri.query().is_some_and(|query| query.contains("wait")) {
        return None;
    }
    let mut made = Request::builder().method(method).uri(uri);
    for line in lines {
        let mut parts = line.splitn(2, |byte| *byte == b':');
        let name = HeaderName::from_bytes(parts.next()?).ok()?;
        made = made.header(name, HeaderValue::from_bytes(parts.next()?).ok()?);
    }
    made.body(Body::from(body.to_vec())).ok()
}

fuzz_target!(|bytes: &[u8]| {
    let Some(request) = request(bytes) else { return };
    let (runtime, router) = &*SERVER;
    let is_change = !matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    runtime.block_on(async {
        let answer = router.clone().oneshot(request).await.unwrap();
        assert!(!is_change || !answer.status().is_success());
        assert_ne!(answer.status(), StatusCode::INTERNAL_SERVER_ERROR);
        to_bytes(answer.into_body(), 1 << 24).await.unwrap();
    });
});
