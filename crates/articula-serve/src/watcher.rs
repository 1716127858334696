//! Telling what each request was and how it was answered.
#![allow(clippy::disallowed_methods, reason = "a request takes time")]

use axum::body::HttpBody;
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;
use serde::Serialize;
use std::fmt;
use std::sync::Arc;
use std::time::Instant;

/// A request that was answered.
#[derive(Debug, Clone, Serialize)]
pub struct AnsweredRequest {
    /// Method.
    pub method: String,
    /// Path and query, as they came.
    pub path: String,
    /// Status.
    pub status: u16,
    /// Bytes of the body, if they are known before it is sent.
    pub bytes: Option<u64>,
    /// Time until the answer began, milliseconds.
    pub ms: f64,
}

/// Is told of every request.
#[derive(Clone)]
pub struct RequestWatcher(Arc<dyn Fn(&AnsweredRequest) + Send + Sync>);

impl RequestWatcher {
    /// `watch` is called by the threads that answer, so it should not take long.
    pub fn new(watch: impl Fn(&AnsweredRequest) + Send + Sync + 'static) -> Self {
        Self(Arc::new(watch))
    }
}

impl fmt::Debug for RequestWatcher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RequestWatcher")
    }
}

/// Answers a request and tells of it.
pub(crate) async fn watched(
    State(watcher): State<Option<RequestWatcher>>,
    request: Request,
    next: Next,
) -> Response {
    let Some(RequestWatcher(watch)) = watcher else {
        return next.run(request).await;
    };
    let start = Instant::now();
    let (method, path) = (request.method().to_string(), request.uri().to_string());
    let response = next.run(request).await;
    watch(&AnsweredRequest {
        method,
        path,
        status: response.status().as_u16(),
        bytes: response.body().size_hint().exact(),
        ms: start.elapsed().as_micros() as f64 / 1e3,
    });
    response
}
