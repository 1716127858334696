//! How a step ended, if it did not fail.

use anyhow::Result;

/// How a step ended, if it did not fail.
pub(crate) enum Outcome {
    Done,
    /// Not run, and why; printed as the step's one line `skipped: …`.
    Skipped(String),
}

/// Whether a step that lacks a tool must fail (CI) or may be skipped (a person's machine).
pub(crate) fn lacking(what: String) -> Result<Outcome> {
    if std::env::var_os("ARTICULA_REQUIRE_TOOLS").is_some_and(|v| v == "1") {
        anyhow::bail!("ARTICULA_REQUIRE_TOOLS=1, but {what}");
    }
    Ok(Outcome::Skipped(what))
}
