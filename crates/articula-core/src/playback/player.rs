//! The state of one figure, and the stages of its frame.

use super::controller::{ClipFrame, FrameContext, MotionController};
use super::layer::MotionLayer;
use super::model::FigureModel;
use super::report::FrameReport;
use super::state::{FigureState, Refinement};
use super::views::FigureViews;
use crate::Mismatch;
use crate::blend::blend;
use crate::clip::Clip;
use crate::crowd::{CharacterState, ClipEvent, ClipState, RootDelta};
use crate::drift::MAX_VIEWS;
use crate::joint_set::JointSet;
use crate::pose::{LocalPose, ModelPose};
use crate::sample::{frame_position_f32, sample_at, sample_morphs_at};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// Maximum time step in seconds; longer ones count as this.
const MAX_STEP_SECS: f32 = 60.0;

/// An event that a figure passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlayedEvent {
    /// Index of the layer that played the clip; `None` for the base motion.
    pub layer: Option<usize>,
    /// Index of the clip.
    pub clip: usize,
    /// The event.
    pub event: ClipEvent,
    /// Weight of the clip in its cross-fade, 0 to 1.
    pub weight: f32,
}

/// One figure in motion. See the [module](super) for the stages of a frame.
///
/// A player owns its state and shares its model, so sessions of a server and components of an engine
/// can hold it. Only [`FigurePlayer::new`], [`FigurePlayer::add_layer`] and
/// [`FigurePlayer::set_model`] allocate.
#[derive(Debug, Clone)]
pub struct FigurePlayer {
    model: Arc<FigureModel>,
    /// Tolerance factor of each joint, 1 by default: below 1 where errors are noticed more.
    pub attention: Vec<f32>,
    /// Joints that a controller may sample in a frame.
    pub max_joints: usize,
    state: FigureState,
}

impl FigurePlayer {
    /// A figure in its rest pose that plays the first clip, if there is one, in a loop.
    /// `morph_weights` are the weights of morph targets without a track
    /// ([`Mesh::morph_weights`](crate::Mesh::morph_weights)).
    pub fn new(model: impl Into<Arc<FigureModel>>, morph_weights: &[f32]) -> Self {
        let model = model.into();
        Self {
            attention: vec![1.0; model.rig().len()],
            max_joints: usize::MAX,
            state: FigureState::new(&model, morph_weights),
            model,
        }
    }

    /// Goes on with a model of the same rig whose clips were refined, as when more of a stream has
    /// arrived. What is shown moves from the old clips to the new ones within `secs` seconds; with 0
    /// it jumps. Keys and error matrices that a controller reads belong to the clips before, so such a
    /// controller is made anew. Allocates.
    ///
    /// # Errors
    /// A [`Mismatch`] if the model is of another rig, or the number of clips or a duration differs;
    /// the player then goes on unchanged.
    pub fn set_model(
        &mut self,
        model: impl Into<Arc<FigureModel>>,
        secs: f32,
    ) -> Result<(), Mismatch> {
        let model = model.into();
        check_refined(&self.model, &model)?;
        let all = model.rig().all();
        self.sample(&all);
        self.sample_morphs();
        let (before, morphs) = (self.state.wanted.clone(), self.state.morphs.clone());
        self.state.refinement = None;
        self.model = model;
        self.sample(&all);
        self.sample_morphs();
        if secs > 0.0 {
            let now = (&self.state.wanted, &self.state.morphs[..]);
            self.state.refinement = Refinement::new((&before, &morphs), now, secs);
        } else {
            self.state.cut = true;
        }
        Ok(())
    }

    /// The model that is played.
    pub fn model(&self) -> &Arc<FigureModel> {
        &self.model
    }

    /// Plays another motion from now on, without a fade.
    pub fn play(&mut self, state: impl Into<CharacterState>) {
        self.state.base = Some(state.into());
        self.state.cut = true;
    }

    /// Starts a cross-fade to another clip over `secs` seconds; without a motion it starts at once.
    pub fn fade_to(&mut self, clip_state: ClipState, secs: f32) {
        match &mut self.state.base {
            Some(base) => {
                base.fade_to(clip_state, secs);
                self.state.cut |= !base.is_fading();
            }
            None => self.play(clip_state),
        }
    }

    /// The base motion.
    pub fn state(&self) -> Option<&CharacterState> {
        self.state.base.as_ref()
    }

    /// Adds a layer on top of the others; returns its index. Allocates.
    ///
    /// # Errors
    /// A [`Mismatch`] if the layer belongs to another rig.
    pub fn add_layer(&mut self, layer: MotionLayer) -> Result<usize, Mismatch> {
        let (found, joints) = (layer.joints(), self.model.rig().len());
        if found != joints {
            let what = format!("{found} joints, the rig has {joints}");
            return Err(Mismatch::new("layer", what));
        }
        self.state.layers.push(layer);
        Ok(self.state.layers.len() - 1)
    }

    /// A layer, to change its weight or motion.
    pub fn layer_mut(&mut self, layer: usize) -> Option<&mut MotionLayer> {
        self.state.layers.get_mut(layer)
    }

    /// Keeps a joint and its ancestors at full detail, whatever a controller holds, as for an
    /// attachment; [`FigurePlayer::joint`] gives its place.
    ///
    /// # Panics
    /// If there is no such joint.
    pub fn pin(&mut self, joint: usize) {
        let rig = self.model.rig();
        let chain = std::iter::successors(Some(joint), |j| rig.parent(*j));
        self.state.pinned.extend(chain);
    }

    /// Sets the joints that are kept at full detail, without their ancestors.
    pub fn set_pinned(&mut self, joints: JointSet) {
        self.state.pinned = joints.intersection(&self.model.rig().all());
    }

    /// Advances all clocks by a time step in seconds, from 0 to 60, and reports the events passed;
    /// returns the motion of the whole figure, which goes on at every level of detail.
    pub fn advance(&mut self, dt_secs: f32, tell: &mut dyn FnMut(PlayedEvent)) -> RootDelta {
        let dt_secs = if dt_secs.is_nan() { 0.0 } else { dt_secs };
        let dt_secs = dt_secs.clamp(0.0, MAX_STEP_SECS);
        self.state.dt_secs = dt_secs;
        self.state.now_secs += f64::from(dt_secs);
        self.state.refine(dt_secs);
        let mut way = RootDelta::default();
        if let Some(base) = &mut self.state.base {
            let (step, wrapped) =
                base.advance(&*self.model, dt_secs, &mut |clip, event, weight| {
                    tell(played(None, clip, event, weight));
                });
            way = step;
            self.state.cut |= wrapped;
        }
        for (l, layer) in self.state.layers.iter_mut().enumerate() {
            layer
                .state
                .advance(&*self.model, dt_secs, &mut |clip, event, weight| {
                    tell(played(Some(l), clip, event, weight));
                });
        }
        way
    }

    /// Sets the clock of playback and the time of the base clip, as a caller with a clock of its own
    /// does in place of [`FigurePlayer::advance`]; the motion goes on from the frame before, and
    /// jumps only where the clip starts again. Reports no events and no root motion.
    pub fn advance_to(&mut self, now_secs: f64, clip_secs: f32) {
        self.state.dt_secs = (now_secs - self.state.now_secs) as f32;
        self.state.now_secs = now_secs;
        self.state.refine(self.state.dt_secs);
        if let Some(base) = &mut self.state.base {
            let before = base.from.secs();
            base.from = base.from.at_secs(&*self.model, clip_secs);
            self.state.cut |= base.from.secs() < before;
        }
    }

    /// Lets a controller decide what is sampled and shown: samples the joints that it asks for and
    /// the morph weights, and keeps what it writes until the next frame.
    ///
    /// Depths are those of the pose of the frame before, moved as the root moves now.
    ///
    /// # Panics
    /// If the controller belongs to another rig.
    pub fn control(
        &mut self,
        controller: &mut dyn MotionController,
        views: FigureViews<'_>,
    ) -> &FrameReport {
        let fading = self.state.base.is_some_and(|base| base.is_fading());
        let mixed = (fading, self.layered());
        self.state.cut |= mixed != self.state.mixed;
        self.state.mixed = mixed;
        let carriers = *self.model.carriers();
        let mut sampled = self.sample(&carriers);
        let (distance_metres, count) = self.look(views);
        let asked = controller.due(&self.context(distance_metres, count));
        let due = asked
            .intersection(&self.model.rig().all())
            .union(&self.state.pinned);
        sampled += self.sample(&due.difference(&carriers));
        // Taken out while the context borrows the player.
        let mut shown = std::mem::take(&mut self.state.pose);
        shown.copy_from(&self.state.controlled);
        let frame = self.context(distance_metres, count);
        let result = controller.control(&frame, &due, &self.state.wanted, &mut shown);
        for joint in self.state.pinned.iter() {
            shown.set(joint, self.state.wanted.get(joint));
        }
        self.state.controlled.copy_from(&shown);
        self.state.pose = shown;
        self.state.cut = false;
        self.sample_morphs();
        let updated = result.updated.union(&self.state.pinned);
        self.state.report = FrameReport {
            sampled: due.union(&carriers).intersection(&self.animated()),
            updated,
            in_transition: result.in_transition,
            held: self.model.rig().all().difference(&updated),
            bound_px: result.bound_px,
            transforms_sampled: sampled + result.keys_read,
            matrices: 0,
        };
        &self.state.report
    }

    /// Calls a hook that may change the pose before the hierarchy, as inverse kinematics and
    /// ragdolls do. Controllers do not see its changes.
    pub fn edit(&mut self, hook: &mut dyn FnMut(&mut LocalPose)) {
        hook(&mut self.state.pose);
    }

    /// Computes the model matrices of the joints that changed since the last call, and of those
    /// below them; returns their number.
    ///
    /// # Panics
    /// If a hook has changed the number of joints.
    pub fn hierarchy(&mut self) -> usize {
        let rig = self.model.rig();
        let mut changed = JointSet::EMPTY;
        for joint in 0..rig.len() {
            let parent = rig.parent(joint);
            let local = self.state.pose.get(joint);
            if local == self.state.posed.get(joint) && !parent.is_some_and(|p| changed.contains(p))
            {
                continue;
            }
            changed.insert(joint);
            let above = parent.map_or(Affine3A::IDENTITY, |p| self.state.joints.matrices[p]);
            self.state.joints.matrices[joint] = above * local.to_affine();
        }
        self.state.posed.copy_from(&self.state.pose);
        self.state.report.matrices = changed.len();
        changed.len()
    }

    /// The pose shown.
    pub fn pose(&self) -> &LocalPose {
        &self.state.pose
    }

    /// The model matrices of the last [`FigurePlayer::hierarchy`].
    pub fn model_pose(&self) -> &ModelPose {
        &self.state.joints
    }

    /// Model-from-joint matrix of a joint, exact if it is [pinned](FigurePlayer::pin).
    ///
    /// # Panics
    /// If there is no such joint.
    pub fn joint(&self, joint: usize) -> Affine3A {
        self.state.joints.matrices[joint]
    }

    /// Morph weights of the last [`FigurePlayer::control`].
    pub fn morph_weights(&self) -> &[f32] {
        &self.state.morphs
    }

    /// Counts of the last frame.
    pub fn report(&self) -> &FrameReport {
        &self.state.report
    }

    /// Joints that the base motion or a layer moves.
    fn animated(&self) -> JointSet {
        let states = self
            .state
            .base
            .iter()
            .map(|base| (base, self.model.rig().all()));
        let layers = self.state.layers.iter().map(|l| (&l.state, l.moved()));
        let moved = states.chain(layers).map(|(state, masked)| {
            let (from, to) = state.clips();
            let both = self.model.animated(from).union(self.model.animated(to));
            both.intersection(&masked)
        });
        moved.fold(JointSet::EMPTY, |all, some| all.union(&some))
    }

    fn layered(&self) -> JointSet {
        let moved = self.state.layers.iter().map(MotionLayer::moved);
        moved.fold(JointSet::EMPTY, |all, some| all.union(&some))
    }

    fn context(&self, distance_metres: f32, views: usize) -> FrameContext<'_> {
        let alone = self.state.base.filter(|base| !base.is_fading());
        FrameContext {
            now_secs: self.state.now_secs,
            dt_secs: self.state.dt_secs,
            pixels_per_metre: &self.state.pixels_per_metre,
            attention: &self.attention,
            view_directions: &self.state.directions[..views],
            distance_metres,
            allowed: self.model.rig().all(),
            max_joints: self.max_joints,
            clip: alone.map(|base| {
                let state = base.clip_state();
                let clip = &self.model.clips()[state.clip()];
                ClipFrame {
                    index: state.clip(),
                    at: frame_position_f32(clip, state.secs(), state.wrap()),
                    clip,
                }
            }),
            layered: self.layered(),
            cut: self.state.cut,
            shown: &self.state.controlled,
            model: &self.state.joints,
        }
    }

    /// Computes pixels per metre and view directions; returns the distance of the nearest view and
    /// the number of directions.
    fn look(&mut self, views: FigureViews<'_>) -> (f32, usize) {
        let root = self.wanted_root();
        let moved = root - self.state.joints.position(self.model.rig().root());
        match views {
            FigureViews::Parallel {
                pixels_per_metre,
                distance_metres,
                directions,
            } => {
                self.state.pixels_per_metre.fill(pixels_per_metre);
                let told = directions.iter().take(MAX_VIEWS);
                for (place, direction) in self.state.directions.iter_mut().zip(told) {
                    *place = *direction;
                }
                (distance_metres, some_views(directions.len()))
            }
            FigureViews::Cameras(cameras) => {
                for (joint, scale) in self.state.pixels_per_metre.iter_mut().enumerate() {
                    let at = self.state.joints.position(joint) + moved;
                    let seen = cameras.iter().map(|camera| {
                        let depth = camera.view(at).z.abs();
                        camera.viewport.pixels_per_metre(depth)
                    });
                    *scale = seen.fold(0.0, f32::max);
                }
                for (place, camera) in self.state.directions.iter_mut().zip(cameras) {
                    *place = (camera.eye - root).try_normalize().unwrap_or(Vec3::Z);
                }
                let distances = cameras.iter().map(|camera| camera.eye.distance(root));
                (
                    distances.fold(f32::INFINITY, f32::min),
                    some_views(cameras.len()),
                )
            }
        }
    }

    /// Model-space position of the root by the transforms wanted now.
    fn wanted_root(&self) -> Vec3 {
        let rig = self.model.rig();
        let chain = std::iter::successors(Some(rig.root()), |j| rig.parent(*j));
        let model = chain.fold(Affine3A::IDENTITY, |below, j| {
            self.state.wanted.get(j).to_affine() * below
        });
        model.translation.into()
    }

    /// Samples some joints from the base motion and the layers; returns the number of transforms.
    fn sample(&mut self, joints: &JointSet) -> usize {
        let mut count = match &self.state.base {
            Some(base) => {
                let (out, fade) = (&mut self.state.wanted, &mut self.state.fade_pose);
                sample_state(&self.model, base, joints, out, fade)
            }
            None => {
                reset(&self.model, joints, &mut self.state.wanted);
                0
            }
        };
        for layer in &self.state.layers {
            let moved = layer.moved().intersection(joints);
            if moved.is_empty() {
                continue;
            }
            let (out, fade) = (&mut self.state.layer_pose, &mut self.state.fade_pose);
            count += sample_state(&self.model, &layer.state, &moved, out, fade);
            layer.apply(&moved, &self.state.layer_pose, &mut self.state.wanted);
        }
        if let Some(refinement) = &self.state.refinement {
            refinement.apply(joints, &mut self.state.wanted);
        }
        count
    }

    fn sample_morphs(&mut self) {
        if self.state.rest_morphs.is_empty() {
            return;
        }
        let (rest, fade) = (&self.state.rest_morphs, &mut self.state.fade_morphs);
        self.state.morphs.copy_from_slice(rest);
        if let Some(base) = &self.state.base {
            morphs_of(&self.model, base, rest, &mut self.state.morphs, fade);
        }
        for layer in &self.state.layers {
            let over = &mut self.state.layer_morphs;
            over.copy_from_slice(rest);
            morphs_of(&self.model, &layer.state, rest, over, fade);
            let (from, to) = layer.state.clips();
            for clip in [from, to].into_iter().take(if from == to { 1 } else { 2 }) {
                for track in &self.model.clips()[clip].tracks().morphs {
                    let slot = usize::from(track.target);
                    let told_before = clip != from
                        && self.model.clips()[from]
                            .tracks()
                            .morphs
                            .iter()
                            .any(|t| t.target == track.target);
                    if let (Some(weight), false) = (self.state.morphs.get_mut(slot), told_before) {
                        *weight = layer.morph(*weight, over[slot]);
                    }
                }
            }
        }
        if let Some(refinement) = &self.state.refinement {
            refinement.apply_morphs(&mut self.state.morphs);
        }
    }
}

/// Checks that a model can take the place of another while its clips play.
fn check_refined(model: &FigureModel, refined: &FigureModel) -> Result<(), Mismatch> {
    if !Arc::ptr_eq(refined.rig(), model.rig()) && refined.rig() != model.rig() {
        let what = "another rig than that of the model before";
        return Err(Mismatch::new("model.rig", what));
    }
    let durations = |model: &FigureModel| -> Vec<f32> {
        model.clips().iter().map(Clip::duration_secs).collect()
    };
    if durations(refined) != durations(model) {
        let what = "clips of other durations than those of the model before";
        return Err(Mismatch::new("model.clips", what));
    }
    Ok(())
}

fn played(layer: Option<usize>, clip: usize, event: &ClipEvent, weight: f32) -> PlayedEvent {
    PlayedEvent {
        layer,
        clip,
        event: *event,
        weight,
    }
}

/// Number of view directions that are told apart: none where there are too many.
fn some_views(views: usize) -> usize {
    if views > MAX_VIEWS { 0 } else { views }
}

fn reset(model: &FigureModel, joints: &JointSet, out: &mut LocalPose) {
    for joint in joints.iter() {
        out.set(joint, model.rig().rest_pose().get(joint));
    }
}

/// Samples some joints of one state, cross-fade included; returns the number of transforms.
fn sample_state(
    model: &FigureModel,
    state: &CharacterState,
    joints: &JointSet,
    out: &mut LocalPose,
    fade: &mut LocalPose,
) -> usize {
    let one = |clip_state: &ClipState, out: &mut LocalPose| {
        reset(model, joints, out);
        let clip = &model.clips()[clip_state.clip()];
        let at = frame_position_f32(clip, clip_state.secs(), clip_state.wrap());
        sample_at(clip, at, joints, out);
        model.animated(clip_state.clip()).intersection(joints).len()
    };
    let mut count = one(state.clip_state(), out);
    if let Some(next) = state.next().filter(|_| state.fade() > 0.0) {
        count += one(next, fade);
        blend(out, fade, state.fade(), joints);
    }
    count
}

/// Morph weights of one state, cross-fade included.
fn morphs_of(
    model: &FigureModel,
    state: &CharacterState,
    rest: &[f32],
    out: &mut [f32],
    fade: &mut [f32],
) {
    let one = |clip_state: &ClipState, out: &mut [f32]| {
        let clip = &model.clips()[clip_state.clip()];
        let at = frame_position_f32(clip, clip_state.secs(), clip_state.wrap());
        sample_morphs_at(clip, at, out);
    };
    one(state.clip_state(), out);
    if let Some(next) = state.next().filter(|_| state.fade() > 0.0) {
        fade.copy_from_slice(rest);
        one(next, fade);
        for (weight, to) in out.iter_mut().zip(fade.iter()) {
            *weight += (to - *weight) * state.fade();
        }
    }
}
