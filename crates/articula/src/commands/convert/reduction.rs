//! `convert --loa`: the animation that a level of articulation leaves, and what that saves.

use super::ConvertArgs;
use crate::load::Loaded;
use crate::play::methods::joints;
use crate::play::saved::{self, Amount, Saving};
use crate::prepared::articulation_of;
use crate::{fault, files};
use anyhow::Context;
use articula_core::joint_state::PassivePolicy;
use articula_core::loa::with_ancestors;
use articula_core::{JointSet, Rig};
use articula_formats::{Limits, loa_profile};
use serde::Serialize;

/// What was held, and what that saved.
#[derive(Debug, Serialize)]
pub(super) struct Reduction {
    selection: String,
    passive: String,
    joints: usize,
    joints_active: usize,
    before: Amount,
    after: Amount,
    /// Share of the animation's bytes that is gone, 0 to 1.
    saved: f64,
}

/// Reduces all clips of a character if the command asks for it.
pub(super) fn apply(args: &ConvertArgs, loaded: &mut Loaded) -> anyhow::Result<Option<Reduction>> {
    if args.loa.is_none() && args.loa_profile.is_none() {
        return Ok(None);
    }
    let place = loaded.place();
    if loaded.character.clips.is_empty() {
        anyhow::bail!("{place}: clips: there is none to reduce; leave --loa out");
    }
    let rig = Rig::new(&loaded.character.skeleton, articulation_of(loaded)).context(place)?;
    let (selection, mut active) = selected(args, &rig)?;
    if args.close_up {
        active = with_ancestors(&rig, &active);
    }
    let policy = args.passive.unwrap_or(PassivePolicy::KeyPose);
    let saving = Saving::new(&rig, &loaded.character.clips, &active, policy);
    let reduction = Reduction {
        selection,
        passive: saved::name(policy),
        joints: rig.skin_joints().len(),
        joints_active: active.intersection(rig.skin_joints()).len(),
        before: saving.before,
        after: saving.after,
        saved: saving.share(),
    };
    loaded.character.clips = saving.clips;
    Ok(Some(reduction))
}

fn selected(args: &ConvertArgs, rig: &Rig) -> anyhow::Result<(String, JointSet)> {
    if let Some(text) = &args.loa {
        return Ok((text.clone(), joints(text, rig)?));
    }
    let Some(path) = &args.loa_profile else {
        return Err(fault::usage("--loa EXPR or --loa-profile F.json is needed"));
    };
    let place = files::shown(path);
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    let profile = loa_profile::read(&bytes, &limits).with_context(|| place.clone())?;
    let set = profile
        .selection
        .joints(rig)
        .with_context(|| place.clone())?;
    Ok((place, set))
}

impl Reduction {
    /// The share that is saved, for a table.
    pub(super) fn percent(&self) -> String {
        format!("{:.1}%", 100.0 * self.saved)
    }

    /// The saving for people.
    pub(super) fn text(&self) -> String {
        let line = |what: &str, before: usize, after: usize| {
            format!("  {what:<18} {before:>10} -> {after:>10}\n")
        };
        let (before, after) = (&self.before, &self.after);
        format!(
            "{}: {} of {} joints active, the others: {}; {:.1}% of the animation saved\n{}{}{}{}",
            self.selection,
            self.joints_active,
            self.joints,
            self.passive,
            100.0 * self.saved,
            line(
                "animation bytes",
                before.animation_bytes,
                after.animation_bytes
            ),
            line("channels", before.channels, after.channels),
            line("keys", before.keys, after.keys),
            line(
                "joints animated",
                before.joints_animated,
                after.joints_animated
            ),
        )
    }
}
