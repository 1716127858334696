//! The pages of the studio, below `/studio/`: those of a folder, or those inside of the program (feature `studio`).
//! They are no part of the interface that the document tells.

#[cfg(any(test, feature = "studio"))]
mod embedded;

use axum::http::header::{CONTENT_SECURITY_POLICY, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderName, HeaderValue};
use axum::middleware::map_response;
use axum::response::{Redirect, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde_json::json;
use std::path::Path;
use tower_http::services::ServeDir;

/// What a page cannot say of itself; the rest of its policy stands in it.
const GUARDS: [(HeaderName, &str); 2] = [
    (CONTENT_SECURITY_POLICY, "frame-ancestors 'none'"),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
];

/// Whether the program has the pages inside.
pub(crate) const IS_EMBEDDED: bool = cfg!(feature = "studio");

/// Routes of the pages of a folder, else of those inside of the program; none without.
pub(crate) fn routes<S: Clone + Send + Sync + 'static>(folder: Option<&Path>) -> Router<S> {
    let pages = match folder {
        Some(folder) => Router::new().nest_service("/studio/", ServeDir::new(folder)),
        #[cfg(feature = "studio")]
        None => embedded::routes(),
        #[cfg(not(feature = "studio"))]
        None => return Router::new(),
    };
    pages
        // Relative addresses of the pages lie below.
        .route_service("/studio", get(|| async { Redirect::permanent("studio/") }))
        // Beside the pages on any other server lies a file that says no.
        .route_service(
            "/studio/server.json",
            get(|| async { Json(json!({"characters": true})) }),
        )
        .layer(map_response(guarded))
}

async fn guarded(mut response: Response) -> Response {
    for (name, value) in GUARDS {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}
