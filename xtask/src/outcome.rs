//! Outcomes of a step that did not fail.

use anyhow::Result;

/// The outcome of a step that did not fail.
pub(crate) enum Outcome {
    Done,
    /// Not run, with the reason; printed as the line `skipped: …`.
    Skipped(String),
}

/// Skips a step that lacks a tool, or fails if `ARTICULA_REQUIRE_TOOLS` is 1 (as in CI).
pub(crate) fn lacking(what: String) -> Result<Outcome> {
    if std::env::var_os("ARTICULA_REQUIRE_TOOLS").is_some_and(|v| v == "1") {
        anyhow::bail!("ARTICULA_REQUIRE_TOOLS=1, but {what}");
    }
    Ok(Outcome::Skipped(what))
}
