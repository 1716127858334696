//! What a figure player remembers between frames, apart from its model, and how it moves on to
//! clips that have changed.

use super::layer::MotionLayer;
use super::model::FigureModel;
use super::report::FrameReport;
use crate::crowd::{CharacterState, ClipState};
use crate::drift::MAX_VIEWS;
use crate::hierarchy::local_to_model;
use crate::joint_set::JointSet;
use crate::math::nlerp;
use crate::pose::{LocalPose, ModelPose};
use glam::{Quat, Vec3};

/// Change of a value below which it counts as none.
const STILL: f32 = 1e-7;

/// State and buffers of a player.
#[derive(Debug, Clone)]
pub(super) struct FigureState {
    pub(super) base: Option<CharacterState>,
    pub(super) layers: Vec<MotionLayer>,
    /// Joints that are always sampled and shown as wanted.
    pub(super) pinned: JointSet,
    pub(super) now_secs: f64,
    pub(super) dt_secs: f32,
    pub(super) cut: bool,
    /// Whether two clips were blended in the last frame, and the joints that layers moved: bounds
    /// on the motion of a clip do not hold where these change.
    pub(super) mixed: (bool, JointSet),
    pub(super) wanted: LocalPose,
    pub(super) layer_pose: LocalPose,
    pub(super) fade_pose: LocalPose,
    pub(super) controlled: LocalPose,
    pub(super) pose: LocalPose,
    /// The pose of which `joints` are the model matrices.
    pub(super) posed: LocalPose,
    pub(super) joints: ModelPose,
    pub(super) rest_morphs: Vec<f32>,
    pub(super) morphs: Vec<f32>,
    pub(super) layer_morphs: Vec<f32>,
    pub(super) fade_morphs: Vec<f32>,
    pub(super) pixels_per_metre: Vec<f32>,
    pub(super) directions: [Vec3; MAX_VIEWS],
    pub(super) report: FrameReport,
    /// What is left of the difference to clips that were replaced.
    pub(super) refinement: Option<Refinement>,
}

impl FigureState {
    pub(super) fn new(model: &FigureModel, morph_weights: &[f32]) -> Self {
        let rig = model.rig();
        let rest = rig.rest_pose();
        let mut joints = ModelPose::new(rig.len());
        local_to_model(rig, rest, &mut joints);
        let first = !model.clips().is_empty();
        Self {
            base: first.then(|| ClipState::new(model, 0).into()),
            layers: Vec::new(),
            pinned: JointSet::EMPTY,
            now_secs: 0.0,
            dt_secs: 0.0,
            cut: true,
            mixed: (false, JointSet::EMPTY),
            wanted: rest.clone(),
            layer_pose: rest.clone(),
            fade_pose: rest.clone(),
            controlled: rest.clone(),
            pose: rest.clone(),
            posed: rest.clone(),
            joints,
            rest_morphs: morph_weights.to_vec(),
            morphs: morph_weights.to_vec(),
            layer_morphs: morph_weights.to_vec(),
            fade_morphs: morph_weights.to_vec(),
            pixels_per_metre: vec![0.0; rig.len()],
            directions: [Vec3::ZERO; MAX_VIEWS],
            report: FrameReport::default(),
            refinement: None,
        }
    }

    /// Lets time pass for the refinement.
    pub(super) fn refine(&mut self, dt_secs: f32) {
        if let Some(refinement) = &mut self.refinement {
            refinement.left_secs -= dt_secs;
            if refinement.left_secs <= 0.0 {
                self.refinement = None;
            }
        }
    }
}

/// Differences of two versions of a motion at a time, which fade out.
#[derive(Debug, Clone)]
pub(super) struct Refinement {
    /// Joints that differ.
    joints: JointSet,
    /// Rotation in front of the new one, and summands of translation and scale.
    offsets: LocalPose,
    morphs: Vec<f32>,
    left_secs: f32,
    whole_secs: f32,
}

impl Refinement {
    /// The differences of poses and morph weights; `None` if there are none.
    pub(super) fn new(
        (before, morphs_before): (&LocalPose, &[f32]),
        (now, morphs_now): (&LocalPose, &[f32]),
        secs: f32,
    ) -> Option<Self> {
        let mut offsets = now.clone();
        let mut joints = JointSet::EMPTY;
        for j in 0..now.rotations.len() {
            let turn = before.rotations[j] * now.rotations[j].conjugate();
            offsets.rotations[j] = turn;
            offsets.translations[j] = before.translations[j] - now.translations[j];
            offsets.scales[j] = before.scales[j] - now.scales[j];
            let moved = offsets.translations[j].length() + offsets.scales[j].length();
            if turn.xyz().length() + moved > STILL {
                joints.insert(j);
            }
        }
        let pairs = morphs_before.iter().zip(morphs_now);
        let morphs: Vec<f32> = pairs.map(|(before, now)| before - now).collect();
        if joints.is_empty() && morphs.iter().all(|offset| offset.abs() <= STILL) {
            return None;
        }
        Some(Self {
            joints,
            offsets,
            morphs,
            left_secs: secs,
            whole_secs: secs,
        })
    }

    fn weight(&self) -> f32 {
        (self.left_secs / self.whole_secs).clamp(0.0, 1.0)
    }

    /// Adds what is left of the differences to some joints of the new motion.
    pub(super) fn apply(&self, joints: &JointSet, pose: &mut LocalPose) {
        let weight = self.weight();
        for j in self.joints.intersection(joints).iter() {
            let turn = nlerp(Quat::IDENTITY, self.offsets.rotations[j], weight);
            pose.rotations[j] = turn * pose.rotations[j];
            pose.translations[j] += weight * self.offsets.translations[j];
            pose.scales[j] += weight * self.offsets.scales[j];
        }
    }

    /// The same of morph weights.
    pub(super) fn apply_morphs(&self, morphs: &mut [f32]) {
        let weight = self.weight();
        for (morph, offset) in morphs.iter_mut().zip(&self.morphs) {
            *morph += weight * offset;
        }
    }
}
