//! The routes as OpenAPI 3.1, for programs that make clients.

use crate::catalogue::Catalogue;
use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

/// The document; a test compares it with the routes and with `docs/formats/delivery.md`.
const DOCUMENT: &str = include_str!("openapi.json");

pub(crate) fn routes() -> Router<Catalogue> {
    Router::new().route("/openapi.json", get(document))
}

async fn document() -> Response {
    ([(CONTENT_TYPE, "application/json")], DOCUMENT).into_response()
}
