//! The methods and what they are told.
//!
//! Source: `docs/methods/motion-lod.md` 3 (thesis, Ahn), 4 (ours), 11 (baselines).

use super::baselines::thesis::ThesisMetricOptions;
use super::baselines::thesis_metric::Threshold;
use crate::motion_error::bounds::ChainTolerance;
use articula_core::JointSet;
use articula_core::joint_state::{PassivePolicy, TransitionOptions};
use glam::Quat;

/// Form of our metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SkinPxVariant {
    /// Holds the last key until the drift exceeds the tolerance (4.2).
    #[default]
    Hold,
    /// As `Hold`, with the error as each camera sees it (4.1); one playback for each azimuth.
    View,
    /// Shows one central rotation for each run of frames.
    KeyPose,
    /// Holds, and lets children cancel their ancestors' error (4.4).
    ClosedLoop,
    /// Blends between keys; every frame still blends, keys alone are counted.
    Linear,
}

/// A way to save joint updates. Its one parameter is given when it is played.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Ours; the parameter is the tolerance in metres of skin.
    SkinPx(SkinPxVariant),
    /// The thesis' two-step metric; the parameter is the threshold on the normalised error.
    Thesis,
    /// Posture clusters of each joint; the parameter is the threshold in metres.
    Ahn,
    /// Updates all joints every n-th frame and holds; the parameter is n.
    SkipHold,
    /// Updates all joints every n-th frame and blends ideally; the parameter is n.
    SkipLerp,
    /// A fixed level of articulation; the parameter is the index of the level.
    Loa(Vec<JointSet>),
}

impl Method {
    /// Name as the command line spells it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::SkinPx(_) => "skin-px",
            Self::Thesis => "thesis",
            Self::Ahn => "ahn",
            Self::SkipHold => "skip-hold",
            Self::SkipLerp => "skip-lerp",
            Self::Loa(_) => "loa",
        }
    }
}

/// What methods need besides their parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodOptions {
    /// The formula of the thesis' first step.
    pub thesis: ThesisMetricOptions,
    /// The threshold of its second step, used where no parameter is given.
    pub threshold: Threshold,
    /// Transitions of the thesis' joints, and what passive joints of a fixed level show.
    pub transition: TransitionOptions,
    /// How the drift controller shares its tolerance along a chain of joints (4.4).
    pub chain: ChainTolerance,
    /// Whether joints on the way to a standing foot get a quarter of the tolerance (4.6).
    pub protect_contacts: bool,
}

impl Default for MethodOptions {
    fn default() -> Self {
        Self {
            thesis: ThesisMetricOptions::default(),
            threshold: Threshold::default(),
            transition: TransitionOptions {
                secs: 0.0,
                policy: PassivePolicy::KeyPose,
                ..TransitionOptions::default()
            },
            chain: ChainTolerance::Root,
            protect_contacts: false,
        }
    }
}

/// One pass of a clip as a method shows it.
#[derive(Debug, Clone, Default)]
pub struct Playback {
    /// `shown[frame][joint]`: local rotations.
    pub shown: Vec<Vec<Quat>>,
    /// Joints updated at each frame.
    pub updated: Vec<JointSet>,
    /// Joints in transition at each frame.
    pub in_transition: Vec<JointSet>,
}
