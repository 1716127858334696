//! What a level of articulation leaves of the stored animation, in numbers.

use articula_build::{MotionSize, motion_size, reduce};
use articula_core::joint_state::PassivePolicy;
use articula_core::source::Clip;
use articula_core::{JointSet, Rig};
use serde::Serialize;
use std::ops::AddAssign;

/// How much animation there is, morph weights left out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Amount {
    /// Joints with a channel of more than one key in any clip.
    pub(crate) joints_animated: usize,
    pub(crate) channels: usize,
    pub(crate) keys: usize,
    /// Times and values of all keys as 32-bit floats.
    pub(crate) animation_bytes: usize,
}

impl AddAssign<MotionSize> for Amount {
    fn add_assign(&mut self, size: MotionSize) {
        self.channels += size.channels;
        self.keys += size.keys;
        self.animation_bytes += size.bytes;
    }
}

/// Clips before and after they were reduced.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Saving {
    pub(crate) clips: Vec<Clip>,
    pub(crate) before: Amount,
    pub(crate) after: Amount,
}

impl Saving {
    /// Holds every joint that is not active. Nodes that are no joints follow the clip.
    pub(crate) fn new(rig: &Rig, clips: &[Clip], active: &JointSet, policy: PassivePolicy) -> Self {
        let plain = rig.all().difference(rig.skin_joints());
        let active = active.union(&plain);
        let (mut before, mut after) = (Amount::default(), Amount::default());
        let reduced = clips.iter().map(|clip| {
            before += motion_size(clip);
            let out = reduce(rig, clip, &active, policy);
            after += motion_size(&out);
            out
        });
        let reduced: Vec<Clip> = reduced.collect();
        before.joints_animated = animated(clips);
        after.joints_animated = animated(&reduced);
        Self {
            clips: reduced,
            before,
            after,
        }
    }

    /// Share of the animation's bytes that is gone, 0 to 1.
    pub(crate) fn share(&self) -> f64 {
        let bytes = |amount: Amount| amount.animation_bytes as f64;
        1.0 - bytes(self.after) / bytes(self.before).max(1.0)
    }
}

fn animated(clips: &[Clip]) -> usize {
    let channels = clips.iter().flat_map(|c| &c.channels);
    let moving = channels.filter(|c| c.property.is_of_joint() && c.times_secs.len() > 1);
    moving.map(|c| c.target).collect::<JointSet>().len()
}

/// Reads `hold`, `rest`, `key-pose` or `blend-to-rest:SECS`.
pub(crate) fn passive(text: &str) -> Result<PassivePolicy, String> {
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

/// The policy as the command line spells it.
pub(crate) fn name(policy: PassivePolicy) -> String {
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
