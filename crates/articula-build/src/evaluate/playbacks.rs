//! Playback of each method over one pass of a clip, by the playback that ships.
//!
//! Source: `docs/methods/motion-lod.md` 3 (thesis, Ahn), 4 (ours), 11 (baselines). A method is a
//! controller of a [`FigurePlayer`]; what is measured is what the player shows.

use super::baselines::ahn;
use super::baselines::thesis::radii;
use super::controllers::{ClosedLoop, Held, HeldView, Segments, Skipped};
use super::method::{ClusterKey, Method, Playback, SkinPxVariant};
use super::stage::{ClipEvaluator, MethodRun};
use crate::motion_error::contacts::attention;
use crate::motion_error::hull::nearest_view;
use crate::motion_error::keys::{Segment, central_rotation, linear_keys, pose_segments};
use articula_core::crowd::ClipState;
use articula_core::joint_state::{LoaRange, PassivePolicy, TransitionOptions};
use articula_core::playback::{
    FigureModel, FigurePlayer, FigureViews, FullDetail, LoaController, MotionController,
    StoredKeys, TableController, ThesisController, Threshold,
};
use articula_core::{JointSet, KeyMode, KeyTable, LocalPose, TableHashes};
use glam::Quat;
use std::sync::Arc;

/// Plays a clip with a method at one parameter; returns its statistics and one playback (one for
/// each azimuth if the method depends on the view).
pub fn play(
    stage: &ClipEvaluator<'_>,
    method: &Method,
    parameter: f32,
) -> (MethodRun, Vec<Playback>) {
    let playbacks = playbacks(stage, method, parameter);
    (stage.trial(parameter, &playbacks), playbacks)
}

/// One playback of a method, or one per azimuth where the method depends on the view.
fn playbacks(stage: &ClipEvaluator<'_>, method: &Method, parameter: f32) -> Vec<Playback> {
    let rig = &stage.asset.rig;
    let levers = stage.levers.as_slice();
    let one = |control: &mut dyn MotionController| vec![stage.bounded(control)];
    match method {
        Method::SkinPx(variant @ (SkinPxVariant::View | SkinPxVariant::Hull)) => {
            let hulls = (*variant == SkinPxVariant::Hull).then(|| stage.hulls());
            let held = |direction| {
                // Hulls are projected from a half-sphere of cameras, not from the camera itself.
                let direction = hulls.map_or(direction, |_| nearest_view(direction));
                let view = HeldView {
                    rig,
                    direction,
                    hulls,
                };
                stage.bounded(&mut Held::new(levers, parameter, Some(view)))
            };
            stage.view_directions().map(held).collect()
        }
        Method::SkinPx(SkinPxVariant::Hold) => one(&mut Held::new(levers, parameter, None)),
        Method::SkinPx(SkinPxVariant::KeyPose) => one(&mut stage.segments(|joint, values| {
            pose_segments(values, parameter / levers[joint].rest_metres)
        })),
        Method::SkinPx(SkinPxVariant::ClosedLoop) => {
            let radians = levers.iter().map(|lever| parameter / lever.rest_metres);
            one(&mut ClosedLoop::new(rig, stage.moving, radians.collect()))
        }
        Method::SkinPx(SkinPxVariant::Linear) => {
            let table = linear_table(stage, parameter);
            vec![stage.by_table(table, parameter)]
        }
        Method::SkinPx(SkinPxVariant::Tables) => {
            vec![stage.by_table(stage.key_table().clone(), parameter)]
        }
        Method::Thesis => one(&mut stage.thesis(Threshold::constant(parameter))),
        Method::Ahn => {
            let radii = radii(rig, stage.options.thesis.radius);
            let alpha = stage.options.thesis.alpha;
            let cut = match stage.options.cluster_key {
                ClusterKey::Middle => ahn::clusters,
                ClusterKey::LeastSum => ahn::least_sum_clusters,
            };
            one(&mut stage.segments(|joint, values| {
                cut(values, parameter / (alpha + radii[joint]).max(1e-9))
            }))
        }
        Method::PrincipalComponents => {
            let starts = stage.postures().held(f64::from(parameter));
            one(&mut stage.segments(|_, values| {
                let run = |start: &usize| Segment {
                    start: *start,
                    key: values[*start],
                };
                starts.iter().map(run).collect()
            }))
        }
        Method::SkipHold => one(&mut Skipped::new(stage.every(parameter), None)),
        Method::SkipLerp => {
            let ahead = stage.truth.iter().map(|p| p.rotations.clone()).collect();
            one(&mut Skipped::new(stage.every(parameter), Some(ahead)))
        }
        Method::Loa(levels) => {
            let at = (parameter.max(0.0) as usize).min(levels.len().saturating_sub(1));
            let set = levels.get(at).copied().unwrap_or(rig.all());
            vec![stage.fixed(&set)]
        }
    }
}

/// Keys of each moving joint between which a blend stays within one tolerance.
fn linear_table(stage: &ClipEvaluator<'_>, tolerance: f32) -> KeyTable {
    let all: Vec<u32> = (0..stage.truth.len() as u32).collect();
    let keys = |joint: usize| {
        if !stage.moving.contains(joint) {
            return vec![Vec::new()];
        }
        let radians = tolerance / stage.levers[joint].rest_metres;
        vec![linear_keys(&stage.values(joint), radians, &all)]
    };
    KeyTable {
        hashes: TableHashes::default(),
        rate_hz: stage.clip.rate_hz(),
        frames: stage.truth.len() as u32,
        base_metres: tolerance,
        mode: KeyMode::Linear,
        keys: (0..stage.asset.rig.len()).map(keys).collect(),
    }
}

impl ClipEvaluator<'_> {
    /// True rotations of a joint at all frames.
    pub(super) fn values(&self, joint: usize) -> Vec<Quat> {
        self.truth.iter().map(|p| p.rotations[joint]).collect()
    }

    /// Every how many frames a skipping method updates.
    fn every(&self, parameter: f32) -> usize {
        (parameter.max(1.0) as usize).min(self.truth.len())
    }

    fn segments(&self, mut cut: impl FnMut(usize, &[Quat]) -> Vec<Segment>) -> Segments {
        let runs = |joint: usize| match self.moving.contains(joint) {
            true => cut(joint, &self.values(joint)),
            false => Vec::new(),
        };
        Segments::new((0..self.asset.rig.len()).map(runs).collect())
    }

    fn by_table(&self, table: impl Into<Arc<KeyTable>>, tolerance_metres: f32) -> Playback {
        let keys = StoredKeys::new(&self.clip, table).ok();
        let shares = vec![1.0; self.asset.rig.len()];
        self.bounded(&mut TableController::new(
            vec![keys],
            shares,
            tolerance_metres,
        ))
    }

    /// The controller of the thesis; passive joints hold their last transform.
    pub(super) fn thesis(&self, threshold: Threshold) -> ThesisController {
        let hold_last = TransitionOptions {
            policy: PassivePolicy::HoldLast,
            ..self.options.transition
        };
        let matrices = vec![Some(self.thesis_matrix().clone())];
        let every = self.options.lookup_every;
        ThesisController::new(&self.asset.rig, matrices, threshold, every, hold_last)
    }

    /// Plays a controller within the articulation of the options, if there is one.
    fn bounded(&self, control: &mut dyn MotionController) -> Playback {
        match &self.options.articulation {
            Some(set) => {
                let mut bounded = self.articulated(set, control);
                self.played(&mut bounded, &self.loose(set))
            }
            None => self.played(control, &self.moving),
        }
    }

    /// Plays a fixed level: joints outside of it hold what the policy of the options says.
    fn fixed(&self, level: &JointSet) -> Playback {
        let mut full = FullDetail::default();
        let mut loa = self.articulated(level, &mut full);
        self.played(&mut loa, &self.loose(level))
    }

    /// The joints that an articulation holds or lets go: those that move, and the root and what is
    /// above it where it is not selected.
    pub(super) fn loose(&self, level: &JointSet) -> JointSet {
        let rig = &self.asset.rig;
        let chain = std::iter::successors(Some(rig.root()), |j| rig.parent(*j));
        let carriers: JointSet = chain.collect();
        self.moving.union(&carriers.difference(level))
    }

    /// A level of articulation around a controller, by the policy of the options.
    pub(super) fn articulated<'c>(
        &self,
        level: &JointSet,
        inner: &'c mut dyn MotionController,
    ) -> LoaController<&'c mut dyn MotionController> {
        let rig = &self.asset.rig;
        let transition = TransitionOptions {
            // A fade to rest would count as an error of the level only until it is over.
            policy: match self.options.transition.policy {
                PassivePolicy::BlendToRest { .. } => PassivePolicy::Rest,
                policy => policy,
            },
            ..self.options.transition
        };
        let range = LoaRange::one(*level);
        let mut loa = LoaController::new(rig, range, transition, inner);
        if transition.policy == PassivePolicy::KeyPose {
            loa.set_key_pose(&self.key_pose());
        }
        loa
    }

    /// The rotation of each joint with the smallest largest angle to all frames.
    pub(super) fn key_pose(&self) -> LocalPose {
        let mut pose = self.truth[0].clone();
        for joint in 0..self.asset.rig.len() {
            if let Some(key) = central_rotation(&self.values(joint)) {
                pose.rotations[joint] = key;
            }
        }
        pose
    }

    /// Plays one pass of the clip at its own frames. `controlled` are the joints that the
    /// controller holds or renews; all others follow the clip.
    fn played(&self, control: &mut dyn MotionController, controlled: &JointSet) -> Playback {
        let rig = &self.asset.rig;
        let model = FigureModel::new(rig.clone(), [self.clip.clone()])
            .expect("the clip must belong to the rig");
        let start = ClipState::new(&model, 0).once();
        let mut player = FigurePlayer::new(model, &[]);
        player.play(start);
        player.set_pinned(rig.all().difference(controlled));
        let mut out = Playback::default();
        for frame in 0..self.truth.len() {
            let secs = frame as f64 / f64::from(self.clip.rate_hz());
            player.advance_to(secs, frame as f32 / self.clip.rate_hz());
            if self.options.protect_contacts {
                attention(self.asset, &self.contacts, frame, &mut player.attention);
            }
            let views = FigureViews::Parallel {
                pixels_per_metre: 1.0,
                distance_metres: 0.0,
                directions: &[],
            };
            let report = *player.control(control, views);
            out.shown.push(player.pose().rotations.clone());
            // The first frame is the start, not an update.
            let counted = if frame > 0 {
                self.moving
            } else {
                JointSet::EMPTY
            };
            out.updated.push(report.updated.intersection(&counted));
            out.in_transition
                .push(report.in_transition.intersection(&counted));
        }
        out
    }
}
