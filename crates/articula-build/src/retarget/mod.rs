//! A motion of one skeleton put onto another.
//!
//! Stands on the PREPARE line: a source clip and two figures give a source clip for the second
//! figure. In the order of the work:
//!
//! - `rest`, `body`, `frames`: what two rest poses say of two bodies, told from joint positions
//! - `chain`, `plan`: which source joint turns which target joint
//! - `motion`, `hinge`, `contacts`, `steps`: the source's poses, how its limbs bend, what it
//!   stands on
//! - `transfer`, `pose`: the target's poses
//! - `limb`, `pin`, `planted`, `twist`: feet and hands that rest, limbs that do not wrap
//! - `tracks`, `quality`, `report`: the keys, how good they are, where they come from
//!
//! Source: M. Gleicher, Retargetting Motion to New Characters, SIGGRAPH 1998, for what must be
//! kept; the method is another: anatomical frames instead of constraints on one skeleton.

mod body;
mod chain;
mod contacts;
mod frames;
mod hinge;
mod limb;
mod motion;
mod pair;
mod pin;
mod plan;
mod planted;
mod pose;
mod quality;
mod report;
mod rest;
mod side;
mod steps;
mod tracks;
mod transfer;
mod twist;

pub use pair::Retargeter;
pub use planted::ContactPinning;
pub use quality::{EndEffectorError, FootSlide, RetargetQuality};
pub use report::{JointReport, RetargetReport, RotationOrigin};

use articula_core::Articulation;
use articula_core::source::{RawClip, Skeleton};

/// A skeleton and what its joints are.
#[derive(Debug, Clone, Copy)]
pub struct RetargetFigure<'a> {
    /// The joints at rest.
    pub skeleton: &'a Skeleton,
    /// Their twins in the standard, one entry for each joint.
    pub articulation: &'a Articulation,
}

/// How a motion is put onto another figure.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RetargetOptions {
    /// Frames per second of the result; `None` takes the rate of the source's keys.
    pub rate_hz: Option<f32>,
    /// What is kept in place while it rests.
    pub pinning: ContactPinning,
    /// Height of the floor in the source's world, metres; `None` finds it.
    pub floor_metres: Option<f32>,
}

/// A motion of the target, and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Retargeted {
    /// Channels for the target's skeleton: linear, at one rate, times from 0 to the end.
    pub clip: RawClip,
    /// Where each joint's motion comes from, and numbers of quality.
    pub report: RetargetReport,
}
