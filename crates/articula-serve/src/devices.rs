//! Routes of the reference server for benchmarks of devices: those who ran one put its result, others
//! look up that of the nearest device.
//!
//! Source: thesis 3.2.2, figure 3.13. Form: `docs/formats/delivery.md`.

use crate::catalogue::Catalogue;
use crate::database::Database;
use crate::device_store::{KnownDevice, MOST_DEVICES, all, get as known, put};
use crate::error::ServeError;
use crate::objects::ObjectName;
use crate::reply::{blocking, fault, is_allowed, unknown};
use articula::device::{DeviceDescription, DeviceReport};
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};

/// Most bytes of a result.
const MOST_BYTES: usize = 64 << 10;

/// The routes.
pub(crate) fn routes() -> Router<Catalogue> {
    Router::new()
        .route("/v1/devices", get(nearest).put(put_result))
        .route("/v1/devices/{hash}", get(device))
        .layer(DefaultBodyLimit::max(MOST_BYTES))
}

/// A device as JSON.
#[derive(Debug, Serialize)]
struct DeviceAnswer {
    hash: String,
    /// How unlike the device that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    distance: Option<f64>,
    /// Number of results that it stands for.
    runs: usize,
    #[serde(flatten)]
    report: DeviceReport,
}

impl DeviceAnswer {
    fn new(known: KnownDevice, distance: Option<f64>) -> Self {
        Self {
            hash: known.name.as_str().to_owned(),
            distance,
            runs: known.runs,
            report: known.report,
        }
    }
}

/// What is told of a device that is looked for; what is not told may be anything.
#[derive(Debug, Deserialize)]
struct Asked {
    cpu: Option<String>,
    cores: Option<usize>,
    os: Option<String>,
    arch: Option<String>,
    program: Option<String>,
    backend: Option<String>,
    threads: Option<usize>,
}

impl Asked {
    fn is_anything(&self) -> bool {
        let texts = [
            &self.cpu,
            &self.os,
            &self.arch,
            &self.program,
            &self.backend,
        ];
        let numbers = [self.cores, self.threads];
        texts.iter().all(|t| t.is_none()) && numbers.iter().all(Option::is_none)
    }

    fn distance(&self, known: &DeviceDescription) -> f64 {
        let or = |told: &Option<String>, known: &String| told.as_ref().unwrap_or(known).clone();
        let asked = DeviceDescription {
            cpu: or(&self.cpu, &known.cpu),
            cores: self.cores.unwrap_or(known.cores),
            os: or(&self.os, &known.os),
            arch: or(&self.arch, &known.arch),
            program: or(&self.program, &known.program),
            backend: or(&self.backend, &known.backend),
            threads: self.threads.unwrap_or(known.threads),
        };
        asked.distance(known)
    }
}

async fn put_result(
    State(catalogue): State<Catalogue>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    if catalogue.options().read_only {
        return fault(StatusCode::FORBIDDEN, "this server takes no results");
    }
    if !is_allowed(&catalogue, &headers) {
        let what = "Authorization: Bearer TOKEN is missing or wrong";
        return fault(StatusCode::UNAUTHORIZED, what);
    }
    let report = match DeviceReport::read(&body) {
        Ok(report) => report,
        Err(error) => return fault(StatusCode::BAD_REQUEST, error.to_string()),
    };
    let stored = with_database(catalogue, move |database| put(database, &report));
    match stored.await {
        Ok(Some(known)) => {
            let answer = Json(DeviceAnswer::new(known, None));
            (StatusCode::CREATED, answer).into_response()
        }
        Ok(None) => {
            let what = format!("the server knows {MOST_DEVICES} devices, which is all it takes");
            fault(StatusCode::INSUFFICIENT_STORAGE, what)
        }
        Err(error) => error.into_response(),
    }
}

/// The nearest device to what is told of one; all devices if nothing is told.
async fn nearest(State(catalogue): State<Catalogue>, Query(asked): Query<Asked>) -> Response {
    let all = match with_database(catalogue, all).await {
        Ok(all) => all,
        Err(error) => return error.into_response(),
    };
    if asked.is_anything() {
        let all = all.into_iter().map(|known| DeviceAnswer::new(known, None));
        return Json(all.collect::<Vec<_>>()).into_response();
    }
    let distance = |known: &KnownDevice| asked.distance(&known.report.device);
    let found = all.into_iter().map(|known| (distance(&known), known));
    match found.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((distance, known)) => Json(DeviceAnswer::new(known, Some(distance))).into_response(),
        None => fault(StatusCode::NOT_FOUND, "no device is known yet"),
    }
}

async fn device(State(catalogue): State<Catalogue>, Path(hash): Path<String>) -> Response {
    let Some(name) = ObjectName::parse(&hash) else {
        return unknown("device");
    };
    match with_database(catalogue, move |database| known(database, &name)).await {
        Ok(Some(known)) => Json(DeviceAnswer::new(known, None)).into_response(),
        Ok(None) => unknown("device"),
        Err(error) => error.into_response(),
    }
}

/// Runs what waits for files on a thread for that.
async fn with_database<T: Send + 'static>(
    catalogue: Catalogue,
    work: impl FnOnce(&Database) -> Result<T, ServeError> + Send + 'static,
) -> Result<T, ServeError> {
    blocking(move || work(catalogue.database())).await
}
