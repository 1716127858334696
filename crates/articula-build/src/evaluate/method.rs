//! The evaluated methods and their options.
//!
//! Source: `docs/methods/motion-lod.md` 3 (thesis, Ahn), 4 (ours), 11 (baselines).

use super::baselines::thesis::ThesisMetricOptions;
use crate::motion_error::bounds::ChainTolerance;
use articula_core::JointSet;
use articula_core::joint_state::{PassivePolicy, TransitionOptions};
use articula_core::playback::Threshold;
use glam::Quat;

/// Variant of the `skin-px` method, such as holding keys or interpolating between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SkinPxVariant {
    /// Holds the last key until its error exceeds the tolerance (4.2).
    #[default]
    Hold,
    /// Like `Hold`, with the error projected to each camera (4.1); one playback per azimuth.
    View,
    /// Like `View`, with the distance between outlines of the skin in place of the lever (4.1): a
    /// slow reference.
    Hull,
    /// Shows one central rotation for each run of frames.
    KeyPose,
    /// Holds keys and lets children cancel the error of their ancestors (4.4).
    ClosedLoop,
    /// Interpolates between keys; each frame still blends, only keys are counted as updates.
    Linear,
    /// Plays the stored key table of the clip at the nearest stored tolerance (4.5, 9).
    Tables,
}

/// A motion LOD method, which saves joint updates. Its only parameter is given when it is played.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Error metric `skin-px` on each joint; the parameter is the tolerance in metres of skin.
    SkinPx(SkinPxVariant),
    /// The thesis' two-step metric; the parameter is the threshold on the normalised error.
    Thesis,
    /// Posture clusters of each joint, after Ahn and Wohn; the parameter is the threshold in
    /// metres.
    Ahn,
    /// Holds the whole posture until its distance in the space of principal components exceeds the
    /// parameter, in radians.
    PrincipalComponents,
    /// Updates all joints every n-th frame and holds; the parameter is n.
    SkipHold,
    /// Updates all joints every n-th frame and interpolates ideally; the parameter is n.
    SkipLerp,
    /// A fixed level of articulation; the parameter is the index of the level.
    Loa(Vec<JointSet>),
}

impl Method {
    /// Returns the name of the method on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::SkinPx(_) => "skin-px",
            Self::Thesis => "thesis",
            Self::Ahn => "ahn",
            Self::PrincipalComponents => "pc",
            Self::SkipHold => "skip-hold",
            Self::SkipLerp => "skip-lerp",
            Self::Loa(_) => "loa",
        }
    }
}

/// The frame of a run whose rotation Ahn's method shows for the whole run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClusterKey {
    /// The middle frame.
    #[default]
    Middle,
    /// The frame with the least sum of errors to all frames of the run, as the thesis defines it.
    LeastSum,
}

/// Options of the methods besides their parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodOptions {
    /// Parameters of the first step of the thesis' metric.
    pub thesis: ThesisMetricOptions,
    /// Threshold of the second step of the thesis' metric, used where no parameter is given.
    pub threshold: Threshold,
    /// Transitions of joints under the thesis' metric, and the passive policy of a fixed level.
    pub transition: TransitionOptions,
    /// Key of a run in Ahn's method.
    pub cluster_key: ClusterKey,
    /// Distribution of the drift controller's tolerance along a chain of joints (4.4).
    pub chain: ChainTolerance,
    /// Every how many frames the thesis' matrix is consulted, at least 1.
    pub lookup_every: usize,
    /// The joints that the other methods may choose from; all if `None`.
    pub articulation: Option<JointSet>,
    /// Whether joints from the root to a foot in contact get a quarter of the tolerance (4.6).
    pub protect_contacts: bool,
}

impl Method {
    /// Whether the parameter is a real number, as opposed to a count of frames or a level.
    pub(super) fn has_real_parameter(&self) -> bool {
        !matches!(self, Self::SkipHold | Self::SkipLerp | Self::Loa(_))
    }
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
            cluster_key: ClusterKey::Middle,
            chain: ChainTolerance::Root,
            lookup_every: 1,
            articulation: None,
            protect_contacts: false,
        }
    }
}

/// The rotations that a method shows in one pass of a clip, and the joints that it updates.
#[derive(Debug, Clone, Default)]
pub struct Playback {
    /// `shown[frame][joint]`: local rotations.
    pub shown: Vec<Vec<Quat>>,
    /// Joints updated at each frame.
    pub updated: Vec<JointSet>,
    /// Joints in transition at each frame.
    pub in_transition: Vec<JointSet>,
}
