//! What of a retargeted motion a viewer would notice, and why.

use super::plan::{Drive, Plan};
use super::report::{RestPose, RetargetReport};
use super::side::Side;

/// Joints that a motion of a whole body drives; the first vertebra stands for the spine. Without
/// wrists: hands that stay in line with their forearms are hardly seen.
const MAIN: [&str; 13] = [
    "humanoid_root",
    "vl5",
    "skullbase",
    "l_shoulder",
    "l_elbow",
    "r_shoulder",
    "r_elbow",
    "l_hip",
    "l_knee",
    "l_ankle",
    "r_hip",
    "r_knee",
    "r_ankle",
];

/// Share of frames in which a knee or elbow bends the wrong way, from which it is seen.
const HINGE_SHARE: f32 = 0.01;
/// Greatest usual angular speed of a joint: a factor of the source's and an addition, radians per
/// second.
const SPEED: (f32, f32) = (1.3, 5.0);
/// Usual error of hands, feet and head, in lengths of the limb: proportions of game characters
/// explain 0.22.
const END_ERROR: f32 = 0.3;
/// Foot slide that is seen, and depth below the floor, in leg lengths: 20 and 5 mm of an adult.
const SLIDE: f32 = 0.025;
const BELOW_FLOOR: f32 = 0.006;

/// An end of the body whose position is compared with the source's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyEnd {
    /// The wrists, relative to the shoulders.
    Hands,
    /// The ankles, relative to the hips.
    Feet,
    /// The head, relative to the hips.
    Head,
}

/// Something in a retargeted motion that a viewer would notice, or that its quality depends on.
#[derive(Debug, Clone, PartialEq)]
pub enum RetargetFinding {
    /// Main joints of the target that have no counterpart in the source and keep their rest pose:
    /// H-Anim names.
    NotDriven(Vec<&'static str>),
    /// The rest pose of the source is no standing figure; another one was found from its motions.
    SourceRestFound,
    /// The rest pose of the target is no standing figure; another one was found from its motions.
    TargetRestFound,
    /// From its first to its second frame the source turns a joint as it does nowhere else: index
    /// in the source skeleton, radians.
    FirstFrameJumps(usize, f32),
    /// Knees or elbows bend the wrong way, in this share of the frames.
    HingesWrong(f32),
    /// A joint turns much faster than any of the source: index in the target skeleton, radians per
    /// second.
    TurnsFast(usize, f32),
    /// Ends of the body are far from where the source has them: mean error in lengths of the limb.
    EndsOff(BodyEnd, f32),
    /// Feet slide during their contacts: mean, metres.
    FeetSlide(f32),
    /// Soles are below the floor: maximum depth, metres.
    BelowFloor(f32),
    /// Contacts that could not be kept and were left as they were: their number.
    ContactsLeft(usize),
}

/// Main joints of a target that nothing drives.
#[derive(Debug, Clone, PartialEq)]
pub struct NotDriven {
    /// Their H-Anim names.
    pub joints: Vec<&'static str>,
    /// Their share of the main joints that the target has, 0 to 1.
    pub share: f32,
}

/// Main joints of the target that no source joint drives.
pub(super) fn not_driven(target: &Side, plan: &Plan) -> NotDriven {
    let found = MAIN
        .iter()
        .filter_map(|name| Some((*name, target.rest.find(name)?)));
    let found: Vec<(&str, usize)> = found.collect();
    let is_held = |(_, joint): &&(&'static str, usize)| plan.drives[*joint] == Drive::Held;
    let held = found.iter().filter(is_held).map(|(name, _)| *name);
    let joints: Vec<&str> = held.collect();
    NotDriven {
        share: joints.len() as f32 / found.len().max(1) as f32,
        joints,
    }
}

/// The findings of a report that has its numbers; `leg_metres` is the length of the target's legs.
pub(super) fn findings(report: &RetargetReport, leg_metres: f32) -> Vec<RetargetFinding> {
    use RetargetFinding as Finding;
    let quality = &report.quality;
    let mut found = Vec::new();
    if !report.not_driven.is_empty() {
        found.push(Finding::NotDriven(report.not_driven.clone()));
    }
    if report.source_rest != RestPose::OfFile {
        found.push(Finding::SourceRestFound);
    }
    if report.target_rest != RestPose::OfFile {
        found.push(Finding::TargetRestFound);
    }
    if let Some((joint, radians)) = report.first_frame_jump {
        found.push(Finding::FirstFrameJumps(joint, radians));
    }
    if quality.hinge_wrong_share > HINGE_SHARE {
        found.push(Finding::HingesWrong(quality.hinge_wrong_share));
    }
    let (factor, more) = SPEED;
    let source = report.fastest_source.map_or(0.0, |(_, speed)| speed);
    if let Some((joint, speed)) = report.fastest
        && speed > factor * source + more
    {
        found.push(Finding::TurnsFast(joint, speed));
    }
    let ends = [
        (BodyEnd::Hands, quality.hands),
        (BodyEnd::Feet, quality.feet),
        (BodyEnd::Head, quality.head),
    ];
    for (end, error) in ends {
        if error.mean > END_ERROR {
            found.push(Finding::EndsOff(end, error.mean));
        }
    }
    if quality.slide.mean_metres > SLIDE * leg_metres {
        found.push(Finding::FeetSlide(quality.slide.mean_metres));
    }
    if quality.below_floor_metres > BELOW_FLOOR * leg_metres {
        found.push(Finding::BelowFloor(quality.below_floor_metres));
    }
    if report.contacts_left > 0 {
        found.push(Finding::ContactsLeft(report.contacts_left));
    }
    found
}
