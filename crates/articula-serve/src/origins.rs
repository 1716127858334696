//! Pages of other origins: browsers let them read answers only with the server's leave (CORS), and open sessions
//! without it, so that the server refuses those itself (RFC 6455, 10.2).

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::header::{
    ACCESS_CONTROL_ALLOW_HEADERS, ACCESS_CONTROL_ALLOW_METHODS, ACCESS_CONTROL_ALLOW_ORIGIN,
    ACCESS_CONTROL_EXPOSE_HEADERS, ACCESS_CONTROL_MAX_AGE, ACCESS_CONTROL_REQUEST_METHOD, HOST,
    ORIGIN, VARY,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::Response;

/// What a page may send: conditions and ranges. It may read, and change nothing.
const SENT: HeaderValue = HeaderValue::from_static("if-none-match, if-range, range");
/// What a page may read beside the body.
const READ: HeaderValue =
    HeaderValue::from_static("articula-state, content-encoding, content-range, etag, retry-after");
/// Seconds for which a browser may keep the leave.
const KEPT_SECS: HeaderValue = HeaderValue::from_static("86400");

/// Lets pages of an origin, or of all, read what is answered; without one this does nothing.
pub(crate) async fn shared(
    State(origin): State<Option<HeaderValue>>,
    request: Request,
    next: Next,
) -> Response {
    let Some(origin) = origin else {
        return next.run(request).await;
    };
    let is_asked = request.method() == Method::OPTIONS
        && request
            .headers()
            .contains_key(ACCESS_CONTROL_REQUEST_METHOD);
    let mut response = match is_asked {
        true => leave(),
        false => next.run(request).await,
    };
    grant(response.headers_mut(), origin);
    response
}

/// Whether who asks may open a session: a program, which names no origin, a page of this server, and pages of the origin
/// that may read, or of all.
pub(crate) fn may_open_session(headers: &HeaderMap, allowed: Option<&str>) -> bool {
    let Some(origin) = headers.get(ORIGIN) else {
        return true;
    };
    let Ok(origin) = origin.to_str() else {
        return false;
    };
    let host = headers.get(HOST).and_then(|host| host.to_str().ok());
    let of_page = origin.split_once("://").map(|(_, authority)| authority);
    let is_own = of_page.is_some() && of_page == host;
    is_own || allowed.is_some_and(|allowed| allowed == "*" || allowed == origin)
}

/// The answer to a browser that asks what a page may do.
fn leave() -> Response {
    let mut response = Response::new(Body::empty());
    *response.status_mut() = StatusCode::NO_CONTENT;
    let headers = response.headers_mut();
    headers.insert(
        ACCESS_CONTROL_ALLOW_METHODS,
        HeaderValue::from_static("GET"),
    );
    headers.insert(ACCESS_CONTROL_ALLOW_HEADERS, SENT);
    headers.insert(ACCESS_CONTROL_MAX_AGE, KEPT_SECS);
    response
}

fn grant(headers: &mut HeaderMap, origin: HeaderValue) {
    if origin != "*" {
        headers.append(VARY, HeaderValue::from_static("origin"));
    }
    headers.insert(ACCESS_CONTROL_ALLOW_ORIGIN, origin);
    headers.insert(ACCESS_CONTROL_EXPOSE_HEADERS, READ);
}
