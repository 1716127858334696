//! Which method plays, and the parameters of the thesis: from words of the command line.

use crate::fault;
use anyhow::Context;
use articula::evaluate::NamedMethod;
use articula_build::ChainTolerance;
use articula_build::evaluate::ThresholdCurve;
use articula_build::evaluate::{BoneDirection, SegmentRadius};
use articula_build::evaluate::{Method, MethodOptions, SkinPxVariant};
use articula_core::joint_state::PassivePolicy;
use articula_core::loa::{self, LoaExpression};
use articula_core::{DriftOptions, JointSet, Rig};
use clap::{Args, ValueEnum};

use crate::arguments::{not_negative, positive};

/// Heading of the thesis' own parameters in the help.
const THESIS: &str = "Parameters of the method thesis";

/// A method, or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// Ours: drift of the skin against what is shown
    SkinPx,
    /// The two-step metric of the thesis
    Thesis,
    /// Posture clusters of each joint
    Ahn,
    /// Every n-th frame, held
    SkipHold,
    /// Every n-th frame, blended ideally
    SkipLerp,
    /// A fixed level of articulation
    Loa,
    /// Every one of them
    All,
}

/// Form of our metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Variant {
    /// Hold the last key until the drift exceeds the tolerance
    Hold,
    /// The same, with the error as each camera sees it
    View,
    /// One central rotation for each run of frames
    KeyPose,
    /// Hold, children cancel their ancestors' error
    ClosedLoop,
    /// Blend between keys
    Linear,
}

impl Variant {
    fn of_metric(self) -> SkinPxVariant {
        match self {
            Self::Hold => SkinPxVariant::Hold,
            Self::View => SkinPxVariant::View,
            Self::KeyPose => SkinPxVariant::KeyPose,
            Self::ClosedLoop => SkinPxVariant::ClosedLoop,
            Self::Linear => SkinPxVariant::Linear,
        }
    }
}

/// What joints outside a fixed level show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Passive {
    /// The clip's first frame
    Hold,
    /// The rest pose
    Rest,
    /// The rotation nearest to all frames
    KeyPose,
}

/// The curve of the thesis' threshold over distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Curve {
    /// As printed; dips near the viewer
    Literal,
    /// Rising, as the text describes
    Fixed,
}

/// Which direction the thesis' position term turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Turning {
    /// From the joint to the mean of its children
    Bone,
    /// Along the path of the joint
    Path,
}

/// How a tolerance is shared along a chain of joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Chain {
    /// Every joint has all of it; errors of a chain may add up
    Whole,
    /// Divided by the square root of the chain's length: right on average
    Root,
    /// Divided by the chain's length: right always
    Split,
}

/// The lever arm of the thesis' position term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Lever {
    /// Length-weighted mean
    Mean,
    /// Plain sum
    Sum,
}

/// Choice of the method and its parameters.
#[derive(Debug, Clone, Args)]
pub(crate) struct MethodArgs {
    /// How detail is reduced
    /// [default: skin-px, or loa where --loa is given]
    #[arg(long, value_enum, value_name = "M")]
    method: Option<MethodName>,
    /// Form of skin-px
    /// [default: hold]
    #[arg(long, value_enum, value_name = "V")]
    variant: Option<Variant>,
    /// Joints that may move, such as "loa(Low) + zone(hands)" (with --method loa)
    #[arg(long, value_name = "EXPR")]
    pub(crate) loa: Option<String>,
    /// Let every joint above one that may move, move too (with --loa)
    #[arg(long, requires = "loa")]
    with_ancestors: bool,
    /// What joints outside the level show (with --method loa)
    /// [default: key-pose]
    #[arg(long, value_enum, value_name = "POLICY")]
    passive: Option<Passive>,
    /// How joints of a chain share the tolerance (with --camera-path)
    #[arg(long, value_enum, default_value = "root", requires = "camera_path")]
    chain: Chain,
    /// Give the joints on the way to a standing foot a quarter of the tolerance (skin-px)
    #[arg(long)]
    protect_contacts: bool,
    /// Weight of the angle terms against the position term, metres a radian
    #[arg(long, help_heading = THESIS, default_value_t = 1.0, value_parser = not_negative, value_name = "A")]
    alpha: f32,
    /// 1 judges orientation only, 0 angular velocity only
    #[arg(long, help_heading = THESIS, default_value_t = 0.5, value_parser = share, value_name = "B")]
    beta: f32,
    /// Threshold at the closest view
    #[arg(long, help_heading = THESIS, default_value_t = 1e-4, value_parser = not_negative, value_name = "E")]
    thr_init: f32,
    /// Threshold at the farthest view [default: 10 times --thr-init]
    #[arg(long, help_heading = THESIS, value_parser = not_negative, value_name = "E")]
    thr_max: Option<f32>,
    /// Closest view, metres
    #[arg(long, help_heading = THESIS, default_value_t = 3.5, value_parser = not_negative, value_name = "M")]
    d_min: f32,
    /// Farthest view, metres
    #[arg(long, help_heading = THESIS, default_value_t = 16.0, value_parser = positive, value_name = "M")]
    d_max: f32,
    /// How long a joint takes between active and passive, milliseconds [default: thesis 0,
    /// along a camera path 200]
    #[arg(long, value_parser = not_negative, value_name = "MS")]
    transition_ms: Option<f32>,
    /// Threshold over distance
    #[arg(long, help_heading = THESIS, value_enum, default_value = "literal")]
    curve: Curve,
    /// Which direction turns
    #[arg(long, help_heading = THESIS, value_enum, default_value = "bone")]
    direction: Turning,
    /// Lever arm of the position term
    #[arg(long, help_heading = THESIS, value_enum, default_value = "mean")]
    radius: Lever,
}

fn share(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    let number = number.filter(|n| (0.0..=1.0).contains(n));
    number.ok_or_else(|| "expected a number from 0 to 1".into())
}

impl MethodArgs {
    /// The method asked for: a level of articulation asks for itself.
    pub(crate) fn method(&self) -> MethodName {
        let usual = match self.loa {
            Some(_) => MethodName::Loa,
            None => MethodName::SkinPx,
        };
        self.method.unwrap_or(usual)
    }

    fn variant(&self) -> Variant {
        self.variant.unwrap_or(Variant::Hold)
    }

    /// Flags that the method would not heed are wrong usage.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        if self.d_min >= self.d_max {
            let (near, far) = (self.d_min, self.d_max);
            return Err(fault::usage(format!(
                "--d-min {near} --d-max {far}: the closest view must be nearer than the farthest"
            )));
        }
        let method = self.method();
        let what = match method {
            MethodName::SkinPx if self.passive.is_some() => {
                "--passive says what a fixed level shows; add --loa EXPR or --method loa"
            }
            MethodName::SkinPx => return Ok(()),
            MethodName::All if self.variant.is_some() => {
                "--method all plays the forms of skin-px anyway; leave --variant out"
            }
            _ if self.variant.is_some() => {
                "--variant is a form of skin-px; leave it out, or play --method skin-px"
            }
            _ if self.protect_contacts && method != MethodName::All => {
                "--protect-contacts belongs to skin-px; leave it out, or play --method skin-px"
            }
            _ => return Ok(()),
        };
        Err(fault::usage(what))
    }

    /// The methods to play.
    pub(crate) fn chosen(&self, rig: &Rig) -> anyhow::Result<Vec<NamedMethod>> {
        if self.loa.is_some() && !matches!(self.method(), MethodName::Loa | MethodName::All) {
            return Err(fault::usage(
                "--loa chooses fixed joints; add --method loa (or --method all)",
            ));
        }
        Ok(vec![match self.method() {
            MethodName::SkinPx => Method::SkinPx(self.variant().of_metric()).into(),
            MethodName::Thesis => Method::Thesis.into(),
            MethodName::Ahn => Method::Ahn.into(),
            MethodName::SkipHold => Method::SkipHold.into(),
            MethodName::SkipLerp => Method::SkipLerp.into(),
            MethodName::Loa => self.level(rig)?,
            MethodName::All => {
                let mut all = NamedMethod::all(rig);
                all.pop();
                all.push(self.level(rig)?);
                return Ok(all);
            }
        }])
    }

    fn level(&self, rig: &Rig) -> anyhow::Result<NamedMethod> {
        match &self.loa {
            Some(text) if self.with_ancestors => {
                let set = loa::with_ancestors(rig, &joints(text, rig)?);
                Ok(NamedMethod::fixed(&format!("{text}, close up"), set))
            }
            Some(text) => Ok(NamedMethod::fixed(text, joints(text, rig)?)),
            None => Ok(NamedMethod::complexity_levels(rig)),
        }
    }

    /// The parameters that are not the method's own one.
    pub(crate) fn options(&self) -> MethodOptions {
        let mut options = MethodOptions::default();
        options.thesis.alpha = self.alpha;
        options.thesis.beta = self.beta;
        options.thesis.direction = match self.direction {
            Turning::Bone => BoneDirection::Bone,
            Turning::Path => BoneDirection::Path,
        };
        options.thesis.radius = match self.radius {
            Lever::Mean => SegmentRadius::Mean,
            Lever::Sum => SegmentRadius::Sum,
        };
        options.threshold.thr_init = self.thr_init;
        options.threshold.thr_max = self.thr_max.unwrap_or(10.0 * self.thr_init);
        options.threshold.d_min_metres = self.d_min;
        options.threshold.d_max_metres = self.d_max;
        options.threshold.curve = match self.curve {
            Curve::Literal => ThresholdCurve::Literal,
            Curve::Fixed => ThresholdCurve::Fixed,
        };
        options.transition.secs = self.transition_ms.unwrap_or(0.0) / 1000.0;
        options.transition.policy = match self.passive.unwrap_or(Passive::KeyPose) {
            Passive::Hold => PassivePolicy::HoldLast,
            Passive::Rest => PassivePolicy::Rest,
            Passive::KeyPose => PassivePolicy::KeyPose,
        };
        options.protect_contacts = self.protect_contacts;
        options.chain = match self.chain {
            Chain::Whole => ChainTolerance::Whole,
            Chain::Root => ChainTolerance::Root,
            Chain::Split => ChainTolerance::Split,
        };
        options
    }
}

impl MethodArgs {
    /// The controller that holds joints while a camera moves, at a tolerance in pixels.
    pub(crate) fn drift(&self, epsilon_px: f32) -> anyhow::Result<DriftOptions> {
        let ours = self.method() == MethodName::SkinPx && self.variant() == Variant::Hold;
        if !ours {
            let what = "--camera-path plays the controller of skin-px; leave --method, --variant and --loa out";
            return Err(fault::usage(what));
        }
        let mut options = DriftOptions {
            epsilon_px,
            ..DriftOptions::default()
        };
        if let Some(ms) = self.transition_ms {
            options.transition.secs = ms / 1000.0;
        }
        Ok(options)
    }
}

/// The joints of an expression; a mistake in it is wrong usage.
pub(crate) fn joints(text: &str, rig: &Rig) -> anyhow::Result<JointSet> {
    let expression = text
        .parse::<LoaExpression>()
        .map_err(|e| fault::usage(e.to_string()))
        .with_context(|| format!("--loa \"{text}\""))?;
    expression
        .joints(rig)
        .map_err(|e| fault::usage(e.to_string()))
        .with_context(|| format!("--loa \"{text}\""))
}
