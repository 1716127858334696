//! `convert --loa`: the joints that may move, and the report of the saving.

use super::ConvertArgs;
use crate::selection::Chosen;
use articula::convert::{JointReduction, JointsReduced};
use articula::core::joint_state::PassivePolicy;
use serde::Serialize;

/// The selection of joints.
#[derive(Debug)]
pub(super) struct Selected {
    chosen: Chosen,
    pub(super) reduction: JointReduction,
}

impl Selected {
    /// Reads the flags, and the file that they name.
    pub(super) fn of(args: &ConvertArgs) -> anyhow::Result<Option<Self>> {
        let chosen = Chosen::of(args.loa.as_deref(), args.loa_profile.as_deref())?;
        Ok(chosen.map(|chosen| Self {
            reduction: JointReduction {
                moving: chosen.moving.clone(),
                with_ancestors: args.with_ancestors,
                passive: args.passive.unwrap_or(PassivePolicy::KeyPose),
            },
            chosen,
        }))
    }

    /// An error of the library with the selection as the user wrote it.
    pub(super) fn placed(&self, fault: articula::Error) -> articula::Error {
        self.chosen.placed(fault)
    }
}

/// What was held and how much it saved.
#[derive(Debug, Serialize)]
pub(super) struct Reduction {
    selection: String,
    passive: String,
    #[serde(flatten)]
    reduced: JointsReduced,
}

impl Reduction {
    /// Makes the report of a selection.
    pub(super) fn new(selected: &Selected, reduced: JointsReduced) -> Self {
        Self {
            selection: selected.chosen.named.clone(),
            passive: name(selected.reduction.passive),
            reduced,
        }
    }

    /// The saved fraction as a percentage.
    pub(super) fn percent(&self) -> String {
        format!("{:.1}%", 100.0 * self.reduced.saved)
    }

    /// Formats the saving for people.
    pub(super) fn text(&self) -> String {
        let line = |what: &str, before: usize, after: usize| {
            format!("  {what:<18} {before:>10} -> {after:>10}\n")
        };
        let (before, after) = (&self.reduced.before, &self.reduced.after);
        format!(
            "{}: {} of {} joints active, others: {}; {:.1}% of the animation saved\n{}{}{}{}",
            self.selection,
            self.reduced.joints_active,
            self.reduced.joints,
            self.passive,
            100.0 * self.reduced.saved,
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

/// Parses `hold`, `rest`, `key-pose` or `blend-to-rest:SECS`.
pub(super) fn passive(text: &str) -> Result<PassivePolicy, String> {
    let wrong = || "expected hold, rest, key-pose or blend-to-rest:SECS".to_owned();
    match text.split_once(':') {
        None => match text {
            "hold" => Ok(PassivePolicy::HoldLast),
            "rest" => Ok(PassivePolicy::Rest),
            "key-pose" => Ok(PassivePolicy::KeyPose),
            _ => Err(wrong()),
        },
        Some(("blend-to-rest", secs)) => {
            let secs = secs.parse::<f32>().ok();
            let secs = secs.filter(|s| s.is_finite() && *s > 0.0);
            secs.map(|secs| PassivePolicy::BlendToRest { secs })
                .ok_or_else(wrong)
        }
        Some(_) => Err(wrong()),
    }
}

/// The policy in the spelling of the command line.
fn name(policy: PassivePolicy) -> String {
    match policy {
        PassivePolicy::HoldLast => "hold".into(),
        PassivePolicy::Rest => "rest".into(),
        PassivePolicy::KeyPose => "key-pose".into(),
        PassivePolicy::BlendToRest { secs } => format!("blend-to-rest:{secs}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn policies_are_spelled_in_one_way() {
        for text in ["hold", "rest", "key-pose", "blend-to-rest:0.5"] {
            assert_eq!(name(passive(text).unwrap()), text);
        }
        for bad in [
            "",
            "blend-to-rest",
            "blend-to-rest:-1",
            "blend-to-rest:NaN",
            "hold:1",
        ] {
            assert!(passive(bad).is_err(), "{bad}");
        }
    }
}
