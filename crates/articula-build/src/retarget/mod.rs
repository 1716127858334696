//! Retargeting: transfers a motion from one skeleton to another.
//!
//! A step of the PREPARE line: a source clip and two figures give a source clip for the second
//! figure. In the order of processing:
//!
//! - `rest`, `body`, `frames`: body measurements from joint positions at rest
//! - `standing`, `standing_pose`: the standing pose of a figure whose rest pose is none
//! - `chain`, `plan`: which source joint drives which target joint
//! - `motion`, `hinge`, `contacts`, `steps`: the source's poses, the bends of its limbs, its
//!   contacts with the floor
//! - `transfer`, `pose`: the target's poses
//! - `limb`, `pin`, `planted`, `touch`, `twist`, `pass`: pinning of feet and hands, hands on the own
//!   body, distribution of twist
//! - `hands`: hands alone, onto a whole figure
//! - `tracks`, `quality`, `report`, `driven`: the keys, their quality, their origin, and what has none
//! - `finding`, `findings`: what of it a viewer would notice
//!
//! Source: M. Gleicher, Retargetting Motion to New Characters, SIGGRAPH 1998, for the properties to
//! preserve; the method differs: anatomical frames instead of constraints on one skeleton.

mod body;
mod chain;
mod contacts;
mod driven;
mod finding;
mod findings;
mod frames;
mod hands;
mod hinge;
mod limb;
mod motion;
mod oddities;
mod pair;
mod pass;
mod pin;
mod plan;
mod planted;
mod pose;
mod quality;
mod report;
mod rest;
mod side;
mod standing;
mod standing_pose;
mod steps;
mod touch;
mod tracks;
mod transfer;
mod twist;

pub use driven::NotDriven;
pub use finding::{BodyEnd, RetargetFinding};
pub use hands::{is_hands_alone, retarget_hands};
pub use oddities::ClipOddities;
pub use pair::Retargeter;
pub use planted::ContactPinning;
pub use quality::{EndEffectorError, FootSlide, RetargetQuality};
pub use report::{JointReport, RestPose, RetargetReport, RotationOrigin};
pub use standing_pose::Assumed;

use articula_core::Articulation;
use articula_core::source::{RawClip, Skeleton};

/// A skeleton with the mapping of its joints to H-Anim.
#[derive(Debug, Clone, Copy)]
pub struct RetargetFigure<'a> {
    /// Joints in the rest pose.
    pub skeleton: &'a Skeleton,
    /// Mapping to H-Anim, one entry per joint.
    pub articulation: &'a Articulation,
    /// Motions of the figure, from which its standing pose is found if the rest pose is none. May
    /// be empty.
    pub clips: &'a [RawClip],
}

/// Options of retargeting a clip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RetargetOptions {
    /// Frames per second of the result; `None` chooses the rate that
    /// [follows the source's keys](crate::sampling_rate_hz).
    pub rate_hz: Option<f32>,
    /// Ends of limbs that are pinned during their contacts.
    pub pinning: ContactPinning,
    /// Height of the floor in the source's world, metres; `None` detects it.
    pub floor_metres: Option<f32>,
    /// Whether hands that rest on the own body (hips, thighs, trunk, head) or meet each other do so
    /// on a body of other proportions too.
    pub self_contact: bool,
}

/// A motion of the target, with a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Retargeted {
    /// Channels for the target's skeleton: linear, at one rate, times from 0 to the end.
    pub clip: RawClip,
    /// Origin of each joint's motion, and quality measures.
    pub report: RetargetReport,
}
