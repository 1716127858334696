//! Routes.
//!
//! Form: `docs/formats/delivery.md`.

use crate::answer::Answer;
use crate::catalogue::Catalogue;
use crate::error::ServeError;
use crate::metrics::Metrics;
use crate::objects::ObjectName;
use crate::origins::shared;
use crate::page::{list, path_of};
use crate::reply::{CHANGING, IMMUTABLE, blocking, fault, is_allowed, later, stored, unknown};
use crate::state::{CharacterState, Progress};
use crate::upload::upload;
use crate::watcher::watched;
use crate::{connections, cut, devices, glb, openapi, session, studio};
use axum::Json;
use axum::body::Body;
use axum::extract::{Path, Query, RawQuery, Request, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, put};
use serde::{Deserialize, Serialize};
use std::future::Future;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

/// Whether a manifest is that of the whole item: `ready` or `packaging`.
const STATE: HeaderName = HeaderName::from_static("articula-state");
/// Longest time that a request waits for news, seconds.
const LONGEST_WAIT_SECS: f64 = 60.0;

/// Answers connections until `stop` ends; those that are open then have the time of
/// [`ServeOptions::drain`](crate::ServeOptions::drain) to end.
///
/// # Errors
/// [`ServeError::Network`] if the listener accepts no connections.
pub async fn serve(
    listener: TcpListener,
    catalogue: Catalogue,
    stop: impl Future<Output = ()> + Send + 'static,
) -> Result<(), ServeError> {
    let routes = router(catalogue.clone());
    connections::answer(listener, routes, &catalogue, stop).await
}

/// Returns the routes of a catalogue.
pub fn router(catalogue: Catalogue) -> axum::Router {
    let places = Arc::new(Semaphore::new(catalogue.options().most_requests));
    let watcher = catalogue.options().watcher.clone();
    let origin = catalogue.options().allow_origin.as_deref();
    let origin = origin.and_then(|origin| HeaderValue::from_str(origin).ok());
    let limited = (catalogue.clone(), places);
    let routes = axum::Router::new()
        .route("/", get(page))
        .route("/v1/characters", get(characters))
        .route(
            "/v1/characters/{name}",
            put(put_character).get(character).delete(remove_character),
        )
        .route("/v1/characters/{name}/manifest.json", get(manifest))
        .route("/v1/characters/{name}/{*file}", get(file))
        .route("/v1/o/{hash}", get(object))
        .merge(session::routes())
        .merge(cut::routes())
        .merge(devices::routes())
        .merge(openapi::routes());
    let routes = routes.merge(studio::routes(catalogue.options().studio.as_deref()));
    routes
        .layer(from_fn_with_state(limited, limit))
        // These answer also when all places are taken.
        .route("/healthz", get(|| async { "ok\n" }))
        .route("/readyz", get(ready))
        .route("/metrics", get(metrics))
        .layer(from_fn_with_state(origin, shared))
        .layer(from_fn_with_state(watcher, watched))
        .with_state(catalogue)
}

/// Counts requests, and refuses those beyond the limit.
async fn limit(
    State((catalogue, places)): State<(Catalogue, Arc<Semaphore>)>,
    request: Request,
    next: Next,
) -> Response {
    let metrics = catalogue.metrics();
    Metrics::add(&metrics.requests, 1);
    let Ok(_place) = places.try_acquire() else {
        Metrics::add(&metrics.overloaded, 1);
        return later("too many requests at once");
    };
    let response = next.run(request).await;
    if response.status().as_u16() >= 400 {
        Metrics::add(&metrics.refused, 1);
    }
    response
}

/// A character as JSON.
#[derive(Debug, Serialize)]
struct CharacterReport {
    name: String,
    #[serde(flatten)]
    progress: Progress,
    /// Where its manifest is, once a stage is made.
    manifest: Option<String>,
    bytes: Option<u64>,
    bytes_sent: Option<u64>,
}

impl CharacterReport {
    fn new(name: String, state: CharacterState) -> Self {
        let served = state.served.as_ref();
        Self {
            manifest: served.map(|_| format!("/v1/characters/{}/manifest.json", path_of(&name))),
            bytes: served.map(|served| served.bytes),
            bytes_sent: served.map(|served| served.sent_bytes),
            progress: state.progress,
            name,
        }
    }
}

async fn page(State(catalogue): State<Catalogue>) -> Response {
    let policy = "default-src 'none'; style-src 'unsafe-inline'";
    let headers = [
        (CONTENT_TYPE, "text/html; charset=utf-8"),
        (CONTENT_SECURITY_POLICY, policy),
    ];
    let has_studio = studio::IS_EMBEDDED || catalogue.options().studio.is_some();
    let sessions = catalogue.sessions().reports();
    let html = list(&catalogue.states(), &sessions, has_studio);
    (headers, html).into_response()
}

async fn characters(State(catalogue): State<Catalogue>) -> Response {
    let states = catalogue.states().into_iter();
    let all: Vec<CharacterReport> = states.map(|(n, s)| CharacterReport::new(n, s)).collect();
    Json(all).into_response()
}

/// A character, or its file by its name with `.glb` behind it.
async fn character(
    State(catalogue): State<Catalogue>,
    Path(name): Path<String>,
    pairs: cut::Pairs,
    RawQuery(raw): RawQuery,
    request: HeaderMap,
) -> Response {
    match catalogue.state(&name) {
        Some(state) => Json(CharacterReport::new(name, state)).into_response(),
        None if name.ends_with(".glb") => {
            glb::answer(&catalogue, &name, pairs, raw, &request).await
        }
        None => unknown("character"),
    }
}

async fn put_character(
    State(catalogue): State<Catalogue>,
    Path(name): Path<String>,
    headers: HeaderMap,
    body: Body,
) -> Response {
    if let Some(refused) = refused(&catalogue, &headers) {
        return refused;
    }
    let places = catalogue.clone();
    let Ok(_place) = places.uploads().try_acquire() else {
        return later("too many characters are put at once");
    };
    let body = match upload(body, catalogue.options()).await {
        Ok(body) => body,
        Err((status, what)) => return fault(status, what),
    };
    let stored = blocking(move || {
        let state = catalogue.put(&name, &body)?;
        Ok(CharacterReport::new(name, state))
    });
    match stored.await {
        Ok(report) => (StatusCode::ACCEPTED, Json(report)).into_response(),
        Err(error) => error.into_response(),
    }
}

async fn remove_character(
    State(catalogue): State<Catalogue>,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Response {
    if let Some(refused) = refused(&catalogue, &headers) {
        return refused;
    }
    match blocking(move || catalogue.remove(&name)).await {
        Ok(true) => StatusCode::NO_CONTENT.into_response(),
        Ok(false) => unknown("character"),
        Err(error) => error.into_response(),
    }
}

/// The answer to who may not change the characters.
fn refused(catalogue: &Catalogue, headers: &HeaderMap) -> Option<Response> {
    if catalogue.options().read_only {
        let what = "the characters of this server do not change";
        return Some(fault(StatusCode::FORBIDDEN, what));
    }
    let what = "Authorization: Bearer TOKEN is missing or wrong";
    (!is_allowed(catalogue, headers)).then(|| fault(StatusCode::UNAUTHORIZED, what))
}

/// How a request for a manifest waits.
#[derive(Debug, Deserialize)]
struct Waiting {
    /// Seconds to wait for one that the client does not have.
    #[serde(default)]
    wait: f64,
}

/// The manifest of a character as far as it is made. With `wait`, a client that names the one that it
/// has by `If-None-Match` gets the next one as soon as there is one.
async fn manifest(
    State(catalogue): State<Catalogue>,
    Path(name): Path<String>,
    Query(waiting): Query<Waiting>,
    request: HeaderMap,
) -> Response {
    let Some(mut states) = catalogue.characters().watch(&name) else {
        return unknown("character");
    };
    let secs = waiting.wait.clamp(0.0, LONGEST_WAIT_SECS);
    let known = request.get(axum::http::header::IF_NONE_MATCH).cloned();
    let is_news = |state: &CharacterState| {
        let known = known
            .as_ref()
            .and_then(|tags| tags.to_str().ok())
            .unwrap_or_default();
        let has = |served: &crate::served::Served| known.contains(served.name.as_str());
        let is_busy = matches!(state.progress, Progress::Waiting | Progress::Packaging);
        !is_busy || state.served.as_ref().is_some_and(|served| !has(served))
    };
    if secs > 0.0 {
        let news = states.wait_for(is_news);
        // What is there in the end is answered, news or not.
        let _ = tokio::time::timeout(Duration::from_secs_f64(secs), news).await;
    }
    let state = states.borrow().clone();
    let Some(served) = state.served else {
        return match state.progress {
            Progress::Failed(why) => fault(StatusCode::UNPROCESSABLE_ENTITY, why),
            _ => later("the character is being packaged"),
        };
    };
    let answer = Answer {
        name: &served.name,
        media_type: "application/json",
        cache_control: CHANGING,
    };
    let mut response = stored(&catalogue, &answer, &request).await;
    let state = match state.progress {
        Progress::Ready => "ready",
        _ => "packaging",
    };
    let state = HeaderValue::from_static(state);
    response.headers_mut().insert(STATE, state);
    response
}

/// A file of a character as far as it is made, by its name in the item.
async fn file(
    State(catalogue): State<Catalogue>,
    Path((name, file)): Path<(String, String)>,
    request: HeaderMap,
) -> Response {
    let state = catalogue.state(&name);
    let served = state.and_then(|state| state.served);
    let Some(object) = served.and_then(|served| served.files.get(&file).cloned()) else {
        return unknown("file");
    };
    let answer = Answer {
        name: &object,
        media_type: media_type(&file),
        cache_control: CHANGING,
    };
    stored(&catalogue, &answer, &request).await
}

/// An object by its hash.
async fn object(
    State(catalogue): State<Catalogue>,
    Path(hash): Path<String>,
    request: HeaderMap,
) -> Response {
    let Some(name) = ObjectName::parse(&hash) else {
        return unknown("object");
    };
    let answer = Answer {
        name: &name,
        media_type: "application/octet-stream",
        cache_control: IMMUTABLE,
    };
    stored(&catalogue, &answer, &request).await
}

async fn ready(State(catalogue): State<Catalogue>) -> Response {
    match blocking(move || catalogue.check()).await {
        Ok(()) => "ok\n".into_response(),
        Err(error) => fault(StatusCode::SERVICE_UNAVAILABLE, error.to_string()),
    }
}

async fn metrics(State(catalogue): State<Catalogue>) -> Response {
    let form = [(CONTENT_TYPE, "text/plain; version=0.0.4")];
    let counts = catalogue.characters().counts();
    let counts = counts.map(|(state, count)| (state.word(), count));
    (form, catalogue.metrics().text(&counts)).into_response()
}

/// Media type of a file of an item.
fn media_type(file: &str) -> &'static str {
    match file.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "glb" => "model/gltf-binary",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "svg" => "image/svg+xml",
        "mp3" => "audio/mpeg",
        "json" => "application/json",
        _ => "application/octet-stream",
    }
}
