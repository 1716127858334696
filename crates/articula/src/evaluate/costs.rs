//! Cost of zones, depths and levels of complexity: counts, and time by the caller's clock.
//!
//! Source: thesis figures 6.14 and 6.15. Counts are exact: joints sampled per frame, and joints
//! whose model matrix changes. Time is that of sampling the set and computing all model matrices on
//! this machine with the plain code; it is not a benchmark.

use articula_build::evaluate::{ClipEvaluator, Method, play};
use articula_core::loa;
use articula_core::{Complexity, JointSet, ModelPose, Region, Wrap, Zone, local_to_model, sample};
use serde::Serialize;

/// Number of passes over the clip, of which the fastest counts, and maximum frames per pass.
const PASSES: usize = 7;
const MAX_FRAMES: usize = 300;

/// Evaluation cost of a clip for one joint set: joint counts and time per frame.
#[derive(Debug, Clone, Serialize)]
pub struct Cost {
    /// Name of the set.
    pub name: String,
    /// Number of joints in the set.
    pub joints: usize,
    /// Number of its joints that the clip animates, sampled in each frame.
    pub joints_sampled: f32,
    /// Number of joints whose model matrix changes per frame.
    pub fk_joints: f32,
    /// Measured time of sampling and all model matrices, in nanoseconds per frame.
    pub measured_ns_per_frame: f64,
}

/// Evaluation costs of a clip by zone, depth of the hierarchy and level of articulation.
#[derive(Debug, Clone, Serialize)]
pub struct Costs {
    /// Cost of each body region, and of composite zones.
    pub zones: Vec<Cost>,
    /// Cost of the joints above each depth of the hierarchy.
    pub depths: Vec<Cost>,
    /// Cost of each level of articulation.
    pub complexities: Vec<Cost>,
}

/// Runs the given function once and returns the time that it took, in nanoseconds.
type Nanoseconds<'a> = &'a dyn Fn(&mut dyn FnMut()) -> f64;

impl Costs {
    /// Computes all costs of a clip; `nanoseconds` runs the given function once and returns the
    /// time that it took, in nanoseconds.
    pub fn new(stage: &ClipEvaluator<'_>, nanoseconds: Nanoseconds<'_>) -> Self {
        let rig = &stage.asset.rig;
        let cost = |name: String, set: JointSet| cost(stage, name, &set, nanoseconds);
        let deepest = rig.skin_joints().iter().map(|j| rig.depth(j)).max();
        let zone = |(name, zone): (String, Zone)| cost(name, loa::zone(rig, zone));
        let regions = Region::ALL.map(|r| (r.to_string(), Zone::from(r)));
        let composites = [
            ("upper", Zone::UPPER),
            ("lower", Zone::LOWER),
            ("all", Zone::ALL),
        ]
        .map(|(name, zone)| (name.to_owned(), zone));
        Self {
            zones: regions.into_iter().chain(composites).map(zone).collect(),
            depths: (0..=deepest.unwrap_or(0) as u32 + 1)
                .map(|k| cost(k.to_string(), loa::depth(rig, k)))
                .collect(),
            complexities: Complexity::ALL
                .map(|c| cost(c.to_string(), loa::complexity(rig, c)))
                .into(),
        }
    }
}

fn cost(
    stage: &ClipEvaluator<'_>,
    name: String,
    set: &JointSet,
    nanoseconds: Nanoseconds<'_>,
) -> Cost {
    let trial = play(stage, &Method::Loa(vec![*set]), 0.0).0;
    Cost {
        name,
        joints: set.intersection(stage.asset.rig.skin_joints()).len(),
        joints_sampled: trial.joints_sampled,
        fk_joints: trial.fk_joints,
        measured_ns_per_frame: measured(stage, set, nanoseconds),
    }
}

fn measured(stage: &ClipEvaluator<'_>, set: &JointSet, nanoseconds: Nanoseconds<'_>) -> f64 {
    let (rig, clip) = (&stage.asset.rig, &stage.clip);
    let mut local = rig.rest_pose().clone();
    let mut model = ModelPose::new(rig.len());
    let frames = clip.frames().min(MAX_FRAMES);
    let mut pass = || {
        for frame in 0..frames {
            let secs = frame as f64 / f64::from(clip.rate_hz());
            sample(clip, secs, Wrap::Clamp, set, &mut local);
            local_to_model(rig, std::hint::black_box(&local), &mut model);
            std::hint::black_box(&model);
        }
    };
    let passes = (0..PASSES).map(|_| nanoseconds(&mut pass) / frames as f64);
    passes.fold(f64::INFINITY, f64::min)
}
