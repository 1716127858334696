//! Levels of articulation as a user gives them: an expression, or the file of a saved selection.

use crate::{fault, files};
use anyhow::Context;
use articula::convert::MovingJoints;
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

/// Joints that may move, as a user chose them.
#[derive(Debug)]
pub(crate) struct Chosen {
    /// As written on the command line.
    pub(crate) named: String,
    /// Prefix of errors about it.
    place: String,
    pub(crate) moving: MovingJoints,
}

impl Chosen {
    /// Reads `--loa`, or the file of `--loa-profile`.
    pub(crate) fn of(loa: Option<&str>, profile: Option<&Path>) -> anyhow::Result<Option<Self>> {
        let (named, place, moving) = match (loa, profile) {
            (Some(text), _) => {
                let place = format!("--loa \"{text}\"");
                let expression = expression("--loa", text)?;
                (
                    text.to_owned(),
                    place,
                    MovingJoints::LoaExpression(expression),
                )
            }
            (None, Some(path)) => {
                let place = files::shown(path);
                let selection = saved(path)?.selection;
                (place.clone(), place, MovingJoints::Selection(selection))
            }
            (None, None) => return Ok(None),
        };
        Ok(Some(Self {
            named,
            place,
            moving,
        }))
    }

    /// An error of the library with the selection as the user wrote it.
    pub(crate) fn placed(&self, mut fault: articula::Error) -> articula::Error {
        if let articula::Error::At { place, .. } = &mut fault
            && place == "selection"
        {
            place.clone_from(&self.place);
        }
        fault
    }
}
