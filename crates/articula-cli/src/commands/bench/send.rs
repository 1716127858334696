//! Puts a report to a server.

use crate::commands::server::Server;
use anyhow::{Context, bail};
use articula::device::DeviceReport;

/// Where results go.
const PATH: &str = "/v1/devices";

/// Sends a report; returns where it went.
pub(super) fn put(
    server: &Server,
    report: &DeviceReport,
    token: Option<&str>,
) -> anyhow::Result<String> {
    let token = token.map(|token| format!("Bearer {token}"));
    let token = token.as_deref().map(|token| ("authorization", token));
    let kind = ("content-type", "application/json");
    let headers: Vec<(&str, &str)> = [kind].into_iter().chain(token).collect();
    let json = serde_json::to_vec(report).context("the report")?;
    let (at, answer) = server.put(PATH, &json, &headers)?;
    match answer.status {
        200..=299 => Ok(at),
        401 => bail!("{at}: the server takes results with a token; give --token"),
        _ => bail!("{at}: {}", answer.fault()),
    }
}
