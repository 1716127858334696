//! What several routes share: errors as JSON, objects of the store, and who may write.

use crate::answer::Answer;
use crate::catalogue::Catalogue;
use crate::error::ServeError;
use crate::metrics::Metrics;
use axum::Json;
use axum::http::header::{AUTHORIZATION, RETRY_AFTER};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

/// What changes is asked for again, by its tag.
pub(crate) const CHANGING: &str = "no-cache";

/// What never changes may be kept for a year.
pub(crate) const IMMUTABLE: &str = "public, max-age=31536000, immutable";

/// An error as JSON.
#[derive(Debug, Serialize)]
struct Fault {
    error: String,
}

pub(crate) fn fault(status: StatusCode, what: impl Into<String>) -> Response {
    let error = what.into();
    (status, Json(Fault { error })).into_response()
}

pub(crate) fn later(what: &str) -> Response {
    let mut response = fault(StatusCode::SERVICE_UNAVAILABLE, what);
    response.headers_mut().insert(RETRY_AFTER, 1.into());
    response
}

pub(crate) fn unknown(what: &str) -> Response {
    fault(StatusCode::NOT_FOUND, format!("there is no such {what}"))
}

impl IntoResponse for ServeError {
    fn into_response(self) -> Response {
        let status = match &self {
            Self::Name(_) | Self::Character(_) => StatusCode::BAD_REQUEST,
            Self::Form => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Full { .. } => StatusCode::INSUFFICIENT_STORAGE,
            Self::Locked { .. } => return later(&self.to_string()),
            Self::Store { .. } | Self::Network(_) => StatusCode::INTERNAL_SERVER_ERROR,
        };
        fault(status, self.to_string())
    }
}

/// An object that is not in memory.
struct Elsewhere;

/// Answers with an object of the store.
pub(crate) async fn stored(
    catalogue: &Catalogue,
    answer: &Answer<'_>,
    request: &HeaderMap,
) -> Response {
    let metrics = catalogue.metrics();
    let objects = catalogue.objects();
    let recent = |coding| objects.recent(answer.name, coding).ok_or(Elsewhere);
    if let Ok(Some(response)) = answer.of(request, metrics, recent) {
        Metrics::add(&metrics.recent, 1);
        return response;
    }
    let (catalogue, request) = (catalogue.clone(), request.clone());
    let (name, media_type, cache_control) =
        (answer.name.clone(), answer.media_type, answer.cache_control);
    let read = blocking(move || {
        let answer = Answer {
            name: &name,
            media_type,
            cache_control,
        };
        let load = |coding| catalogue.objects().get(&name, coding);
        answer.of(&request, catalogue.metrics(), load)
    });
    match read.await {
        Ok(Some(response)) => response,
        Ok(None) => unknown("object"),
        Err(error) => error.into_response(),
    }
}

/// Runs what waits for files on a thread for that.
pub(crate) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, ServeError> + Send + 'static,
) -> Result<T, ServeError> {
    let done = tokio::task::spawn_blocking(work).await;
    done.unwrap_or_else(|error| Err(ServeError::Network(std::io::Error::other(error))))
}

/// Whether a request has the token; hashes are compared, which takes the same time for any.
pub(crate) fn is_allowed(catalogue: &Catalogue, headers: &HeaderMap) -> bool {
    let Some(token) = &catalogue.options().token else {
        return true;
    };
    let given = headers
        .get(AUTHORIZATION)
        .and_then(|value| value.to_str().ok());
    let given = given
        .and_then(|value| value.strip_prefix("Bearer "))
        .unwrap_or_default();
    blake3::hash(given.as_bytes()) == blake3::hash(token.as_bytes())
}
