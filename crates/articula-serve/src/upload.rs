//! Bodies that clients send: of bounded size, at a least rate.
#![allow(clippy::disallowed_methods, reason = "a rate needs a clock")]

use crate::options::ServeOptions;
use axum::body::{Body, HttpBody};
use axum::http::StatusCode;
use std::future::poll_fn;
use std::pin::Pin;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};

/// Reads a body. The client has the time of [`ServeOptions::silence`], and for each byte more by
/// [`ServeOptions::least_upload_bps`].
///
/// # Errors
/// What the client is told: 413 for more bytes than allowed, 408 for fewer in the time, 400 for one that breaks
/// off.
pub(crate) async fn upload(
    mut body: Body,
    options: &ServeOptions,
) -> Result<Vec<u8>, (StatusCode, String)> {
    let most = options.most_bytes;
    let too_large = || {
        let what = format!("the body has more than {most} bytes");
        Err((StatusCode::PAYLOAD_TOO_LARGE, what))
    };
    // The length that is told, if it is.
    if body.size_hint().lower() > most as u64 {
        return too_large();
    }
    let start = Instant::now();
    let mut bytes = Vec::new();
    loop {
        let secs = 8.0 * bytes.len() as f64 / options.least_upload_bps.max(1.0);
        let deadline = start + options.silence + Duration::from_secs_f64(secs);
        let frame = poll_fn(|context| Pin::new(&mut body).poll_frame(context));
        let Ok(frame) = timeout_at(deadline, frame).await else {
            let what = "the body comes too slowly";
            return Err((StatusCode::REQUEST_TIMEOUT, what.to_owned()));
        };
        match frame {
            None => return Ok(bytes),
            Some(Err(_)) => {
                let what = "the body breaks off or has a wrong form";
                return Err((StatusCode::BAD_REQUEST, what.to_owned()));
            }
            Some(Ok(frame)) => {
                let Ok(data) = frame.into_data() else {
                    continue;
                };
                if data.len() > most - bytes.len() {
                    return too_large();
                }
                bytes.extend_from_slice(&data);
            }
        }
    }
}
