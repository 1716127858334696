//! Report of a retargeted motion: the origin of each joint's rotation, and quality measures.

use super::driven::not_driven;
use super::finding::RetargetFinding;
use super::plan::{Drive, Plan};
use super::quality::RetargetQuality;
use super::side::Side;
use super::standing_pose::Assumed;
use super::twist::Twists;

/// Origin of a target joint's rotation.
#[derive(Debug, Clone, PartialEq)]
pub enum RotationOrigin {
    /// One source joint with the same mapping.
    Mapped {
        /// Index in the source skeleton.
        source: usize,
    },
    /// Source joints of the same chain, each with its share. The shares sum to 1, except for a
    /// twist joint: its only share is that of the twist of the limb.
    Shared {
        /// Index in the source skeleton, and share.
        sources: Vec<(usize, f32)>,
    },
    /// The rest rotation, relative to the parent.
    Held,
}

/// The pose of a figure from which rotations are counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum RestPose {
    /// The rest pose of the figure's file.
    #[default]
    OfFile,
    /// A standing pose that was found from the figure's motions, because the rest pose is none.
    Found {
        /// Joints whose orientation in that pose is assumed in part: index in the skeleton, and
        /// what is assumed.
        assumed: Vec<(usize, Assumed)>,
    },
}

/// Treatment of one target joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointReport {
    /// Index in the target skeleton.
    pub joint: usize,
    /// Origin of its rotation.
    pub origin: RotationOrigin,
    /// Whether it is translated as well as rotated.
    pub moved: bool,
}

/// Report of a retargeted clip.
#[derive(Debug, Clone, PartialEq)]
pub struct RetargetReport {
    /// One entry per target joint, in the order of the target.
    pub joints: Vec<JointReport>,
    /// Mapped source joints that no target joint follows.
    pub dropped: Vec<usize>,
    /// The pose of the source from which its rotations are counted.
    pub source_rest: RestPose,
    /// The pose of the target that stands like that of the source.
    pub target_rest: RestPose,
    /// Leg length of the target over that of the source.
    pub scale: f32,
    /// Maximum rotation speed of a target joint relative to its parent: joint, radians per second.
    pub fastest: Option<(usize, f32)>,
    /// Maximum rotation speed of a mapped source joint relative to its parent: joint, radians per
    /// second.
    pub fastest_source: Option<(usize, f32)>,
    /// Quality measures of the clip.
    pub quality: RetargetQuality,
    /// H-Anim names of the main joints of the target that no source joint drives.
    pub not_driven: Vec<&'static str>,
    /// The joint that the source turns between its first two frames as it does nowhere else: index
    /// in the source skeleton, radians.
    pub first_frame_jump: Option<(usize, f32)>,
    /// Number of contacts of feet that are not pinned, since pinned they would slide more.
    pub contacts_left: usize,
    /// What a viewer would notice; empty if the motion is as good as others.
    pub findings: Vec<RetargetFinding>,
}

/// The report without what is measured frame by frame.
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
        source_rest: rest_pose(source),
        target_rest: rest_pose(target),
        scale: plan.scale,
        fastest: None,
        fastest_source: None,
        quality: RetargetQuality::default(),
        not_driven: not_driven(target, plan).joints,
        first_frame_jump: None,
        contacts_left: 0,
        findings: Vec::new(),
    }
}

fn rest_pose(side: &Side) -> RestPose {
    side.found
        .as_ref()
        .map_or(RestPose::OfFile, |found| RestPose::Found {
            assumed: found.assumed.clone(),
        })
}

/// Origin of a joint that the plan holds, to which twist may be distributed.
fn held_or_twisted(plan: &Plan, twists: &Twists, joint: usize) -> RotationOrigin {
    let share = twists.shares().find(|s| s.0 == joint);
    match share.map(|(_, turns, share)| (&plan.drives[turns], share)) {
        Some((Drive::Twin(s), share)) => RotationOrigin::Shared {
            sources: vec![(s.joint, share)],
        },
        _ => RotationOrigin::Held,
    }
}
