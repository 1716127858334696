//! What became of each joint, and how good a retargeted motion is.

use super::plan::{Drive, Plan};
use super::quality::RetargetQuality;
use super::side::Side;
use super::twist::Twists;

/// Where a target joint's rotation comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum RotationOrigin {
    /// One source joint that stands for the same joint.
    Mapped {
        /// Index in the source skeleton.
        source: usize,
    },
    /// Source joints of the same chain, each with its share. The shares sum to 1, except of a
    /// twist joint: its one share is of the turn about the limb.
    Shared {
        /// Index in the source skeleton, and share.
        sources: Vec<(usize, f32)>,
    },
    /// It stays as at rest, relative to its parent.
    Held,
}

/// What became of one target joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointReport {
    /// Index in the target skeleton.
    pub joint: usize,
    /// Where its rotation comes from.
    pub origin: RotationOrigin,
    /// Whether it is moved as well as turned.
    pub moved: bool,
}

/// How a motion was put onto another figure.
#[derive(Debug, Clone, PartialEq)]
pub struct RetargetReport {
    /// One for each target joint, in its order.
    pub joints: Vec<JointReport>,
    /// Mapped source joints that nothing of the target follows.
    pub dropped: Vec<usize>,
    /// Size of the target over that of the source, measured by the legs.
    pub scale: f32,
    /// Fastest turn of a joint relative to its parent: joint of the target, radians a second.
    pub fastest: Option<(usize, f32)>,
    /// The same of the source's mapped joints: joint of the source, radians a second.
    pub fastest_source: Option<(usize, f32)>,
    /// How good it is.
    pub quality: RetargetQuality,
}

/// The report without what the frames tell.
pub(super) fn report(source: &Side, target: &Side, plan: &Plan, twists: &Twists) -> RetargetReport {
    let mut used = vec![false; source.rest.len()];
    let joints = plan
        .drives
        .iter()
        .enumerate()
        .map(|(joint, drive)| {
            let origin = match drive {
                Drive::Held => held_or_twisted(plan, twists, joint),
                Drive::Twin(s) => RotationOrigin::Mapped { source: s.joint },
                Drive::Between(a, b, share) => RotationOrigin::Shared {
                    sources: vec![(a.joint, 1.0 - share), (b.joint, *share)],
                },
            };
            match drive {
                Drive::Held => {}
                Drive::Twin(s) => used[s.joint] = true,
                Drive::Between(a, b, _) => {
                    used[a.joint] = true;
                    used[b.joint] = true;
                }
            }
            let moved = plan.floats[joint].is_some() || joint == target.body.root;
            JointReport {
                joint,
                origin,
                moved,
            }
        })
        .collect();
    let dropped = (0..source.rest.len())
        .filter(|s| source.rest.hanim[*s].is_some() && !used[*s])
        .collect();
    RetargetReport {
        joints,
        dropped,
        scale: plan.scale,
        fastest: None,
        fastest_source: None,
        quality: RetargetQuality::default(),
    }
}

/// What a joint is that the plan holds: twist may be spread to it.
fn held_or_twisted(plan: &Plan, twists: &Twists, joint: usize) -> RotationOrigin {
    let share = twists.shares().find(|s| s.0 == joint);
    match share.map(|(_, turns, share)| (&plan.drives[turns], share)) {
        Some((Drive::Twin(s), share)) => RotationOrigin::Shared {
            sources: vec![(s.joint, share)],
        },
        _ => RotationOrigin::Held,
    }
}
