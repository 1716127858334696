//! The joints of a fixed level of articulation: given as an expression or as a saved selection,
//! and written as one.

use crate::files::{self, Files};
use crate::{fault, selection};
use anyhow::Context;
use articula::core::loa::{self, Selection};
use articula::core::{JointSet, Rig, Zone};
use articula::formats::loa_profile::{self, LoaProfile};
use clap::Args;
use std::path::{Path, PathBuf};

/// The joints that may move.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct SelectionArgs {
    /// Joints that may move, such as "loa(Low) + zone(hands)" (with --method loa)
    #[arg(long, value_name = "EXPR")]
    pub(crate) loa: Option<String>,
    /// LoA profile with the joints that may move (JSON), instead of --loa
    #[arg(long, value_name = "F.json", conflicts_with = "loa")]
    loa_profile: Option<PathBuf>,
    /// Also move the ancestors of joints that may move (with --loa or --loa-profile)
    #[arg(long)]
    with_ancestors: bool,
}

impl SelectionArgs {
    /// The file that is read.
    pub(crate) fn input(&self) -> &Option<PathBuf> {
        &self.loa_profile
    }

    /// Whether joints are selected.
    pub(crate) fn is_given(&self) -> bool {
        self.loa.is_some() || self.loa_profile.is_some()
    }

    /// Whether the saved selection bounds what a metric may choose, instead of deciding alone.
    pub(crate) fn is_bound(&self) -> anyhow::Result<bool> {
        let profile = self.loa_profile.as_deref().map(selection::saved);
        Ok(profile.transpose()?.is_some_and(|profile| !profile.manual))
    }

    /// Refuses flags that need a selection; `saved` if it is to be written.
    pub(crate) fn check(&self, saved: bool) -> anyhow::Result<()> {
        let needs = match self.with_ancestors {
            _ if self.is_given() => return Ok(()),
            true => "--with-ancestors",
            false if saved => "--write loa-profile",
            false => return Ok(()),
        };
        let what = format!("{needs} needs --loa EXPR or --loa-profile F.json");
        Err(fault::usage(what))
    }

    /// The selected joints of a rig, with the words of a report for them.
    pub(crate) fn joints(&self, rig: &Rig) -> anyhow::Result<Option<(String, JointSet)>> {
        let (name, set) = match (&self.loa, &self.loa_profile) {
            (Some(text), _) => (text.clone(), joints(text, rig)?),
            (None, Some(path)) => {
                let joints = selection::saved(path)?.selection.joints(rig);
                (
                    files::shown(path),
                    joints.with_context(|| files::shown(path))?,
                )
            }
            (None, None) => return Ok(None),
        };
        Ok(Some(match self.with_ancestors {
            true => (
                format!("{name} with ancestors"),
                loa::with_ancestors(rig, &set),
            ),
            false => (name, set),
        }))
    }

    /// Writes the selected joints; returns the path for the report.
    pub(crate) fn save(
        &self,
        rig: &Rig,
        path: &Path,
        files: &Files,
    ) -> anyhow::Result<Option<String>> {
        let Some((_, set)) = self.joints(rig)? else {
            return Ok(None);
        };
        let profile = LoaProfile {
            manual: true,
            selection: named(rig, &set)?,
        };
        files.write(path, &loa_profile::write(&profile))?;
        Ok(Some(files::shown(path)))
    }
}

/// The joints of an expression; a mistake in it is a usage error.
fn joints(text: &str, rig: &Rig) -> anyhow::Result<JointSet> {
    let joints = selection::expression("--loa", text)?.joints(rig);
    joints
        .map_err(|e| fault::usage(e.to_string()))
        .with_context(|| format!("--loa \"{text}\""))
}

/// A selection that lists joints by name.
fn named(rig: &Rig, set: &JointSet) -> anyhow::Result<Selection> {
    let selection = Selection {
        // No zone selects no joint; without any selector, all joints would be selected.
        zone: Some(Zone::default()),
        plus: set.iter().map(|j| rig.name(j).to_owned()).collect(),
        ..Selection::default()
    };
    match selection.joints(rig) {
        Ok(found) if found == *set => Ok(selection),
        _ => anyhow::bail!(
            "--write loa-profile: joints of this file share a name or have none, so a list of names \
             does not select them; give the joints names of their own"
        ),
    }
}
