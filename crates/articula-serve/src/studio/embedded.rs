//! Pages inside of the program, compressed by gzip as they are sent.

use crate::answer::takes;
use crate::objects::unzipped;
use crate::reply::{CHANGING, IMMUTABLE, unknown};
use axum::http::HeaderMap;
use axum::http::header::{CACHE_CONTROL, CONTENT_ENCODING, CONTENT_TYPE, VARY};
use axum::response::{IntoResponse, Response};

/// Paths of files and their bytes, compressed.
type Pages = &'static [(&'static str, &'static [u8])];

/// What the build script found, and its routes.
#[cfg(feature = "studio")]
mod built {
    use super::{Pages, answer};
    use axum::Router;
    use axum::extract::Path;
    use axum::http::HeaderMap;
    use axum::routing::get;

    include!(concat!(env!("OUT_DIR"), "/studio_pages.rs"));

    pub(in crate::studio) fn routes<S: Clone + Send + Sync + 'static>() -> Router<S> {
        let first = |headers: HeaderMap| async move { answer(PAGES, "index.html", &headers) };
        let named = |Path(path): Path<String>, headers: HeaderMap| async move {
            answer(PAGES, &path, &headers)
        };
        Router::new()
            .route("/studio/", get(first))
            .route("/studio/{*path}", get(named))
    }
}

#[cfg(feature = "studio")]
pub(super) use built::routes;

fn answer(pages: Pages, path: &str, request: &HeaderMap) -> Response {
    let Some((_, zipped)) = pages.iter().find(|(known, _)| *known == path) else {
        return unknown("page");
    };
    // The names of these files have the hash of their contents.
    let kept = match path.starts_with("assets/") {
        true => IMMUTABLE,
        false => CHANGING,
    };
    let headers = [
        (CONTENT_TYPE, media_type(path)),
        (CACHE_CONTROL, kept),
        (VARY, "accept-encoding"),
    ];
    match takes(request, "gzip") {
        true => (headers, [(CONTENT_ENCODING, "gzip")], *zipped).into_response(),
        false => (headers, unzipped(zipped).unwrap_or_default()).into_response(),
    }
}

fn media_type(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript",
        Some("css") => "text/css",
        Some("json") => "application/json",
        Some("wasm") => "application/wasm",
        Some("svg") => "image/svg+xml",
        Some("glb") => "model/gltf-binary",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::to_bytes;
    use axum::http::HeaderValue;
    use axum::http::header::ACCEPT_ENCODING;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn zipped(text: &str) -> &'static [u8] {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(text.as_bytes()).unwrap();
        encoder.finish().unwrap().leak()
    }

    fn body(response: Response) -> Vec<u8> {
        let runtime = tokio::runtime::Builder::new_current_thread();
        let runtime = { runtime }.build().unwrap();
        let read = runtime.block_on(to_bytes(response.into_body(), 1 << 20));
        read.unwrap().to_vec()
    }

    #[test]
    fn pages_are_sent_as_they_are_or_as_they_were() {
        let module = zipped("module");
        let pages: Pages = vec![("index.html", zipped("<p>")), ("assets/play.wasm", module)].leak();
        let plain = answer(pages, "assets/play.wasm", &HeaderMap::new());
        assert_eq!(plain.headers()[CONTENT_TYPE], "application/wasm");
        assert_eq!(plain.headers()[CACHE_CONTROL], IMMUTABLE);
        assert!(!plain.headers().contains_key(CONTENT_ENCODING));
        assert_eq!(body(plain), b"module");
        let takes_gzip = (ACCEPT_ENCODING, HeaderValue::from_static("br, gzip"));
        let takes_gzip = HeaderMap::from_iter([takes_gzip]);
        let sent = answer(pages, "assets/play.wasm", &takes_gzip);
        assert_eq!(sent.headers()[CONTENT_ENCODING], "gzip");
        assert_eq!(body(sent), module);
        let first = answer(pages, "index.html", &takes_gzip);
        assert_eq!(first.headers()[CONTENT_TYPE], "text/html; charset=utf-8");
        assert_eq!(first.headers()[CACHE_CONTROL], CHANGING);
        assert_eq!(answer(pages, "../index.html", &takes_gzip).status(), 404);
    }
}
