//! The upgrade of a connection to a session.

use super::run::run;
use crate::addresses::AddressPlace;
use crate::catalogue::Catalogue;
use crate::metrics::Metrics;
use crate::origins::may_open_session;
use crate::reply::later;
use crate::sessions::SessionReport;
use articula::client::MOST_MESSAGE_BYTES;
use axum::extract::{State, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Json, Router};
use std::sync::Arc;

/// Bytes that wait for a client at most; who does not take them is sent nothing more.
const MOST_WAITING_BYTES: usize = 4 * MOST_MESSAGE_BYTES;

/// Bytes that are read at once: messages of clients are short.
const READ_BYTES: usize = 4096;

/// The routes of sessions.
pub(crate) fn routes() -> Router<Catalogue> {
    Router::new()
        .route("/v1/session", get(open))
        .route("/v1/sessions", get(sessions))
}

async fn open(
    State(catalogue): State<Catalogue>,
    of_address: Option<Extension<Arc<AddressPlace>>>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !may_open_session(&headers, catalogue.options().allow_origin.as_deref()) {
        let what = "pages of this origin may open no session; see --allow-origin\n";
        return (StatusCode::FORBIDDEN, what).into_response();
    }
    let Some(place) = catalogue.sessions().open() else {
        Metrics::add(&catalogue.metrics().overloaded, 1);
        return later("too many sessions at once");
    };
    Metrics::add(&catalogue.metrics().sessions, 1);
    upgrade
        .max_message_size(MOST_MESSAGE_BYTES)
        .max_frame_size(MOST_MESSAGE_BYTES)
        .read_buffer_size(READ_BYTES)
        .write_buffer_size(0)
        .max_write_buffer_size(MOST_WAITING_BYTES)
        .on_upgrade(async move |socket| {
            run(socket, catalogue, place).await;
            drop(of_address);
        })
}

async fn sessions(State(catalogue): State<Catalogue>) -> Response {
    let all: Vec<SessionReport> = catalogue.sessions().reports();
    Json(all).into_response()
}
