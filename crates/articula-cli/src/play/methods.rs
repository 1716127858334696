//! The flags that choose a method of motion level of detail, and the parameters of the thesis.

use super::selection::SelectionArgs;
use crate::fault;
use articula::build::ChainTolerance;
use articula::build::evaluate::{BoneDirection, ClusterKey, SegmentRadius};
use articula::build::evaluate::{Method, MethodOptions, PathMethod, SkinPxVariant};
use articula::core::joint_state::{Ease, PassivePolicy, TransitionOptions};
use articula::core::playback::{Threshold, ThresholdCurve};
use articula::core::{DriftOptions, JointSet, Rig};
use articula::evaluate::NamedMethod;
use clap::{Args, ValueEnum};

use crate::arguments::{not_negative, number, positive, settings, word};

/// Heading of the thesis' parameters in the help.
const THESIS: &str = "Parameters of the method thesis";

/// A method, or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodName {
    /// Drift of the skin against the shown pose (Articula's method): hold the last key until the drift
    /// exceeds the tolerance
    SkinPx,
    /// As skin-px, with the error as seen by each camera
    SkinPxView,
    /// As skin-px-view, with the distance between outlines of the skin (slow; a reference)
    SkinPxHull,
    /// As skin-px, with one central rotation per run of frames
    SkinPxKeyPose,
    /// As skin-px; children cancel the error of their ancestors
    SkinPxClosedLoop,
    /// As skin-px, with interpolation between keys
    SkinPxLinear,
    /// The key table stored in the file, or the one that `build` would store
    SkinPxTables,
    /// Two-step metric of the thesis
    Thesis,
    /// Clusters of similar postures of each joint (after Ahn), shown by the middle frame of a run
    Ahn,
    /// As ahn, shown by the frame with the least sum of errors to all frames of the run, as in the
    /// thesis
    AhnLeastSum,
    /// Whole postures, held while they are near in the space of their principal components
    Pc,
    /// Every n-th frame, held until the next
    SkipHold,
    /// Every n-th frame, interpolated to the next
    SkipLerp,
    /// Fixed level of articulation
    Loa,
    /// All methods
    All,
}

impl MethodName {
    /// The variant of skin-px; `None` for other methods.
    fn variant(self) -> Option<SkinPxVariant> {
        Some(match self {
            Self::SkinPx => SkinPxVariant::Hold,
            Self::SkinPxView => SkinPxVariant::View,
            Self::SkinPxHull => SkinPxVariant::Hull,
            Self::SkinPxKeyPose => SkinPxVariant::KeyPose,
            Self::SkinPxClosedLoop => SkinPxVariant::ClosedLoop,
            Self::SkinPxLinear => SkinPxVariant::Linear,
            Self::SkinPxTables => SkinPxVariant::Tables,
            _ => return None,
        })
    }
}

/// Pose of joints outside a fixed level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Passive {
    /// First frame of the clip
    Hold,
    /// Rest pose
    Rest,
    /// Rotation with the smallest maximum angle to all frames
    KeyPose,
}

impl Passive {
    fn policy(self) -> PassivePolicy {
        match self {
            Self::Hold => PassivePolicy::HoldLast,
            Self::Rest => PassivePolicy::Rest,
            Self::KeyPose => PassivePolicy::KeyPose,
        }
    }
}

/// Division of a tolerance among the joints of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Chain {
    /// Full tolerance for every joint; errors of a chain may add up
    Whole,
    /// Divided by the square root of the chain's length: sufficient on average
    Root,
    /// Divided by the chain's length: always sufficient
    Split,
}

/// Parses parameters of the thesis' method that are rarely changed.
fn thesis_settings(text: &str) -> Result<MethodOptions, String> {
    const CURVES: &[(&str, ThresholdCurve)] = &[
        ("literal", ThresholdCurve::Literal),
        ("fixed", ThresholdCurve::Fixed),
    ];
    const DIRECTIONS: &[(&str, BoneDirection)] =
        &[("bone", BoneDirection::Bone), ("path", BoneDirection::Path)];
    const RADII: &[(&str, SegmentRadius)] =
        &[("mean", SegmentRadius::Mean), ("sum", SegmentRadius::Sum)];
    const EASES: &[(&str, Ease)] = &[("smooth", Ease::Smoothstep), ("linear", Ease::Linear)];
    settings(text, |to: &mut MethodOptions, key, value| {
        match key {
            "d-min" => to.threshold.d_min_metres = not_negative(value)?,
            "lookup-every" => to.lookup_every = usize::from(every(value)?),
            "curve" => to.threshold.curve = word(value, CURVES)?,
            "direction" => to.thesis.direction = word(value, DIRECTIONS)?,
            "radius" => to.thesis.radius = word(value, RADII)?,
            "transition" => to.transition.ease = word(value, EASES)?,
            _ => {
                return Ok(Some(
                    "d-min, lookup-every, curve, direction, radius, transition",
                ));
            }
        }
        Ok(None)
    })
}

/// The method and its parameters.
#[derive(Debug, Clone, Args)]
pub(crate) struct MethodArgs {
    /// Method that reduces the detail
    /// [default: skin-px, or loa if --loa or --loa-profile is given]
    #[arg(long, value_enum, value_name = "M")]
    method: Option<MethodName>,
    #[command(flatten)]
    pub(crate) selection: SelectionArgs,
    /// Pose of joints outside the level (with --method loa or a profile that bounds the method)
    /// [default: key-pose, with --schedule hold]
    #[arg(long, value_enum, value_name = "POLICY")]
    passive: Option<Passive>,
    /// Division of the tolerance among the joints of a chain (with --camera-path)
    #[arg(long, value_enum, default_value = "root", requires = "camera_path")]
    chain: Chain,
    /// Reduce the tolerance of joints between the root and a planted foot to a quarter (skin-px)
    #[arg(long)]
    protect_contacts: bool,
    /// Weight of the angle terms against the position term in metres per radian
    #[arg(long, help_heading = THESIS, default_value_t = 1.0, value_parser = not_negative, value_name = "A")]
    alpha: f32,
    /// Weight of orientation against angular velocity: 1 orientation only, 0 velocity only
    #[arg(long, help_heading = THESIS, default_value_t = 0.5, value_parser = share, value_name = "B")]
    beta: f32,
    /// Threshold at the closest distance
    #[arg(long, help_heading = THESIS, default_value_t = 1e-4, value_parser = not_negative, value_name = "E")]
    thr_init: f32,
    /// Threshold at the farthest distance [default: 10 times --thr-init]
    #[arg(long, help_heading = THESIS, value_parser = not_negative, value_name = "E")]
    thr_max: Option<f32>,
    /// Farthest viewing distance in metres
    #[arg(long, help_heading = THESIS, default_value_t = 16.0, value_parser = positive, value_name = "M")]
    d_max: f32,
    /// Duration of the transition between active and passive in milliseconds [default: 0; 200 with
    /// --schedule, and for skin-px with --camera-path]
    #[arg(long, value_parser = not_negative, value_name = "MS")]
    transition_ms: Option<f32>,
    /// Rarely changed: d-min=M, the closest viewing distance [default: 3.5]; lookup-every=N, frames
    /// between look-ups of the error matrix [default: 1]; curve of the threshold over distance, literal
    /// as printed (it dips near the viewer) or fixed (rising, as the text describes); direction whose
    /// rotation the position term measures, bone (to the mean of the children) or path (of the joint);
    /// radius, its lever arm, mean (weighted by length) or sum; transition=smooth or linear, the course
    /// of transitions of every method [default: the first of each]
    #[arg(long, help_heading = THESIS, value_name = "KEY=VALUE,…", value_parser = thesis_settings)]
    thesis: Option<MethodOptions>,
}

fn share(text: &str) -> Result<f32, String> {
    number(text, |n| (0.0..=1.0).contains(&n), "a number from 0 to 1")
}

fn every(text: &str) -> Result<u16, String> {
    let number = text.parse::<u16>().ok().filter(|n| *n > 0);
    number.ok_or_else(|| "expected a whole number of frames from 1 to 65535".into())
}

impl MethodArgs {
    /// The method to play; selected joints imply the method `loa`, unless they only bound a metric.
    pub(crate) fn method(&self) -> MethodName {
        let decides = self.selection.is_given() && !self.is_bound();
        let usual = match decides {
            true => MethodName::Loa,
            false => MethodName::SkinPx,
        };
        self.method.unwrap_or(usual)
    }

    /// Whether the selected joints bound what a metric may choose. A profile that cannot be read
    /// is refused by [`MethodArgs::check`].
    fn is_bound(&self) -> bool {
        self.selection.is_bound().unwrap_or(false)
    }

    fn rare(&self) -> MethodOptions {
        self.thesis.unwrap_or_default()
    }

    /// Refuses flags that the method would ignore; `scheduled` says that levels change over time.
    pub(crate) fn check(&self, scheduled: bool) -> anyhow::Result<()> {
        self.selection.is_bound()?;
        let (near, far) = (self.rare().threshold.d_min_metres, self.d_max);
        if near >= far {
            return Err(fault::usage(format!(
                "--thesis d-min={near} --d-max {far}: the closest view must be nearer than the farthest"
            )));
        }
        let method = self.method();
        let what = match method.variant() {
            Some(_) if self.passive.is_some() && !scheduled && !self.is_bound() => {
                "--passive sets the pose of joints outside a fixed level; add --loa EXPR or --method loa"
            }
            None if self.protect_contacts && method != MethodName::All => {
                "--protect-contacts applies to skin-px; leave it out, or play --method skin-px"
            }
            _ => return Ok(()),
        };
        Err(fault::usage(what))
    }

    /// The methods to play.
    pub(crate) fn chosen(&self, rig: &Rig) -> anyhow::Result<Vec<NamedMethod>> {
        let is_fixed = matches!(self.method(), MethodName::Loa | MethodName::All);
        if self.selection.is_given() && !is_fixed && !self.is_bound() {
            return Err(fault::usage(
                "--loa and --loa-profile choose a fixed set of joints; add --method loa (or --method all), \
                 or write \"manual\": false into the profile, so that it bounds the method",
            ));
        }
        let method = self.method();
        if let Some(variant) = method.variant() {
            return Ok(vec![Method::SkinPx(variant).into()]);
        }
        Ok(vec![match method {
            MethodName::Thesis => Method::Thesis.into(),
            MethodName::Ahn | MethodName::AhnLeastSum => Method::Ahn.into(),
            MethodName::Pc => Method::PrincipalComponents.into(),
            MethodName::SkipHold => Method::SkipHold.into(),
            MethodName::SkipLerp => Method::SkipLerp.into(),
            MethodName::All => {
                let mut all = NamedMethod::all(rig);
                all.pop();
                all.push(self.level(rig)?);
                return Ok(all);
            }
            _ => self.level(rig)?,
        }])
    }

    fn level(&self, rig: &Rig) -> anyhow::Result<NamedMethod> {
        Ok(match self.selection.joints(rig)? {
            Some((name, set)) => NamedMethod::fixed(&name, set),
            None => NamedMethod::complexity_levels(rig),
        })
    }

    /// The joints that a metric may choose from, if the selection only bounds it.
    fn articulation(&self, rig: &Rig) -> anyhow::Result<Option<JointSet>> {
        if !self.is_bound() {
            return Ok(None);
        }
        Ok(self.selection.joints(rig)?.map(|(_, set)| set))
    }

    /// The parameters besides the calibrated one.
    pub(crate) fn options(&self, rig: &Rig) -> anyhow::Result<MethodOptions> {
        let mut options = MethodOptions {
            articulation: self.articulation(rig)?,
            ..self.rare()
        };
        options.thesis.alpha = self.alpha;
        options.thesis.beta = self.beta;
        options.threshold.thr_init = self.thr_init;
        options.threshold.thr_max = self.thr_max.unwrap_or(10.0 * self.thr_init);
        options.threshold.d_max_metres = self.d_max;
        if self.method() == MethodName::AhnLeastSum {
            options.cluster_key = ClusterKey::LeastSum;
        }
        options.transition.secs = self.transition_ms.unwrap_or(0.0) / 1000.0;
        options.transition.policy = self.passive.unwrap_or(Passive::KeyPose).policy();
        options.protect_contacts = self.protect_contacts;
        options.chain = match self.chain {
            Chain::Whole => ChainTolerance::Whole,
            Chain::Root => ChainTolerance::Root,
            Chain::Split => ChainTolerance::Split,
        };
        Ok(options)
    }
}

impl MethodArgs {
    /// Transitions of a live playback: 200 ms, and held joints show their last pose, unless given.
    pub(crate) fn live_transition(&self) -> TransitionOptions {
        let usual = TransitionOptions::default();
        TransitionOptions {
            secs: self.transition_ms.map_or(usual.secs, |ms| ms / 1000.0),
            ease: self.rare().transition.ease,
            policy: self.passive.map_or(usual.policy, Passive::policy),
        }
    }

    /// The controller before a moving camera, with its parameter: a tolerance in pixels, a threshold
    /// that does not depend on the distance, or the index of a level. The level's name comes with
    /// it.
    pub(crate) fn before_a_camera(
        &self,
        rig: &Rig,
        parameter: Option<f32>,
    ) -> anyhow::Result<(PathMethod, Option<String>)> {
        let mut drift = DriftOptions {
            epsilon_px: parameter.unwrap_or(1.0),
            ..DriftOptions::default()
        };
        if let Some(ms) = self.transition_ms {
            drift.transition.secs = ms / 1000.0;
        }
        drift.transition.ease = self.rare().transition.ease;
        let method = match self.method() {
            MethodName::SkinPx => PathMethod::Drift(drift),
            MethodName::SkinPxView => PathMethod::DriftInView(drift),
            MethodName::SkinPxTables => PathMethod::Tables(drift.epsilon_px),
            MethodName::Thesis => {
                let by_distance = self.options(rig)?.threshold;
                PathMethod::Thesis(parameter.map_or(by_distance, Threshold::constant))
            }
            MethodName::Loa => {
                let level = self.level(rig)?;
                let Method::Loa(sets) = &level.method else {
                    anyhow::bail!("the level has no joints");
                };
                let at = parameter.unwrap_or(0.0) as usize;
                let Some(set) = sets.get(at) else {
                    let last = sets.len() - 1;
                    return Err(fault::usage(format!(
                        "--parameter {at}: loa takes the index of a level, from 0 (the most joints) to {last}"
                    )));
                };
                return Ok((PathMethod::Loa(*set), level.levels.get(at).cloned()));
            }
            _ => {
                let what = "--camera-path plays skin-px, skin-px-view, skin-px-tables, thesis and loa; \
                            leave other methods out";
                return Err(fault::usage(what));
            }
        };
        Ok((method, None))
    }
}
