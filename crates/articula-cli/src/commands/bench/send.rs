//! Puts a report to a server.

use crate::fault::{self, clean};
use anyhow::{Context, bail};
use articula::device::DeviceReport;
use serde::Deserialize;
use std::time::Duration;

/// Longest time of the request.
const TIMEOUT: Duration = Duration::from_secs(30);
/// Most bytes of an answer.
const MOST_BYTES: u64 = 1 << 20;

/// A server that takes reports.
#[derive(Debug)]
pub(super) struct Server(String);

/// What an answer says.
#[derive(Deserialize)]
struct Said {
    error: String,
}

impl Server {
    pub(super) fn new(url: &str) -> anyhow::Result<Self> {
        if !url.starts_with("http://") {
            let what = "expected an address that begins with http://";
            return Err(fault::usage(format!("--send {}: {what}", clean(url))));
        }
        Ok(Self(format!("{}/v1/devices", url.trim_end_matches('/'))))
    }

    /// Sends a report; returns where it went.
    pub(super) fn put(&self, report: &DeviceReport, token: Option<&str>) -> anyhow::Result<String> {
        let config = ureq::Agent::config_builder();
        let config = config
            .timeout_global(Some(TIMEOUT))
            .http_status_as_error(false);
        let agent: ureq::Agent = config.build().into();
        let mut request = agent
            .put(&self.0)
            .header("content-type", "application/json");
        if let Some(token) = token {
            request = request.header("authorization", format!("Bearer {token}"));
        }
        let at = || self.0.clone();
        let json = serde_json::to_vec(report).with_context(at)?;
        let mut response = request.send(&json[..]).with_context(at)?;
        let body = response.body_mut().with_config().limit(MOST_BYTES);
        let body = body.read_to_vec().with_context(at)?;
        match response.status().as_u16() {
            200..=299 => Ok(at()),
            401 => bail!(
                "{}: the server takes results with a token; give --token",
                self.0
            ),
            status => {
                let said: Option<Said> = serde_json::from_slice(&body).ok();
                let said = said.map_or_else(
                    || format!("the server answers {status}"),
                    |said| clean(&said.error),
                );
                bail!("{}: {said}", self.0)
            }
        }
    }
}
