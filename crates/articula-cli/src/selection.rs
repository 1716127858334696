//! Levels of articulation as a user gives them: an expression, or the file of a saved selection.

use crate::{fault, files};
use anyhow::Context;
use articula::core::loa::LoaExpression;
use articula::formats::Limits;
use articula::formats::loa_profile::{self, LoaProfile};
use std::path::Path;

/// Parses the value of a flag; a mistake in it is a usage error.
pub(crate) fn expression(flag: &str, text: &str) -> anyhow::Result<LoaExpression> {
    let parsed = text.parse::<LoaExpression>();
    let parsed = parsed.map_err(|e| fault::usage(e.to_string()));
    parsed.with_context(|| format!("{flag} \"{text}\""))
}

/// Reads the file of `--loa-profile`.
pub(crate) fn saved(path: &Path) -> anyhow::Result<LoaProfile> {
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    let profile = loa_profile::read(&bytes, &limits);
    profile.with_context(|| files::shown(path))
}
