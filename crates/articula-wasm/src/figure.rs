//! One character in motion.

use crate::asset::Asset;
use crate::clip_events::ClipEvents;
use crate::crowd_options::root_motion;
use crate::error::{Fault, Result, index};
use crate::expressions::Expressions;
use crate::matrix_rows::{IDENTITY, Rows, offset, rows};
use crate::metric::{Metric, StoredErrors};
use crate::view::cameras;
use articula::Camera;
use articula::LoaRange;
use articula::core::crowd::{ClipState, RootDelta};
use articula::core::joint_state::TransitionOptions;
use articula::core::playback::{
    FigureModel, FigurePlayer, FigureViews, LayerMode, LoaController, MotionLayer,
};
use articula::core::{LocalPose, Wrap, normalised, palette, sample};
use articula::crowd::{events_by_clip, figure_model};
use articula::evaluate::ShownErrorMeter;
use articula::glam::{Affine3A, Quat};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// One character, played: clips with cross-fades, layers, a face, and as many joints as are seen.
///
/// After `frame`, the methods that end in `At` are byte offsets into the memory of the module. Make views anew after
/// every call into the module, since its memory may have grown.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Figure {
    pub(crate) figure: Arc<articula::Figure>,
    pub(crate) player: FigurePlayer,
    pub(crate) controller: LoaController<Metric>,
    pub(crate) transition: TransitionOptions,
    /// Made when the first error is asked for.
    pub(crate) meter: Option<ShownErrorMeter>,
    /// Read when a threshold is first set.
    pub(crate) errors: Option<StoredErrors>,
    expressions: Expressions,
    pub(crate) cameras: Vec<Camera>,
    /// Rotations after sampling, by joint.
    posed: Vec<(usize, Quat)>,
    /// Weights that replace those of the clips.
    own_morphs: Vec<Option<f32>>,
    pub(crate) root: RootDelta,
    events: Vec<f64>,
    matrices: Vec<Affine3A>,
    palette: Vec<Rows>,
    joints: Vec<Rows>,
    morphs: Vec<f32>,
}

#[wasm_bindgen]
impl Figure {
    /// A figure that plays the first clip. `rootMotion`: "as-authored" (as without it), "in-place", or "extracted",
    /// where `rootDelta` has what was taken out of the clips. `clipEvents` is JSON: `{[clip: string]: {secs: number, id:
    /// number}[]}`, what `events` tells of.
    ///
    /// Throws if the word is another, the clips do not fit the skeleton, or an event is of no clip or outside of it.
    #[wasm_bindgen(constructor)]
    pub fn new(
        asset: &Asset,
        #[wasm_bindgen(js_name = rootMotion)] policy: Option<String>,
        #[wasm_bindgen(js_name = clipEvents)] clip_events: Option<String>,
    ) -> Result<Figure> {
        let figure = asset.figure().clone();
        let policy = root_motion(policy.as_deref().unwrap_or("as-authored"))?;
        let thrown = |error| Fault::of_file(&error, figure.opened.name());
        let model = figure_model(&figure, policy).map_err(thrown)?;
        let events = ClipEvents::read(clip_events.as_deref())?.named();
        let events = events_by_clip(&events, model.clips()).map_err(thrown)?;
        let with_events = model.with_events(events);
        let model = with_events.map_err(|error| thrown(error.into()))?;
        let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
        let range = LoaRange::named(rig, 0);
        Ok(Self {
            player: FigurePlayer::new(model, &mesh.morph_weights),
            controller: LoaController::new(rig, range, Default::default(), Metric::full()),
            transition: TransitionOptions::default(),
            meter: None,
            errors: None,
            expressions: Expressions::new(&figure),
            cameras: Vec::new(),
            posed: Vec::new(),
            own_morphs: vec![None; mesh.morph_weights.len()],
            root: RootDelta::default(),
            events: Vec::new(),
            matrices: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            palette: vec![IDENTITY; mesh.bindings.len()],
            joints: vec![IDENTITY; rig.len()],
            morphs: mesh.morph_weights.clone(),
            figure,
        })
    }

    /// Plays a clip in a loop from a time in seconds.
    ///
    /// Throws if there is no such clip.
    pub fn play(&mut self, clip: usize, secs: f32) -> Result<()> {
        let state = self.clip(clip)?;
        let state = state.at_secs(&**self.player.model(), secs);
        self.player.play(state);
        Ok(())
    }

    /// Cross-fades to the start of a clip within `fadeSecs` seconds.
    ///
    /// Throws if there is no such clip.
    #[wasm_bindgen(js_name = fadeTo)]
    pub fn fade_to(
        &mut self,
        clip: usize,
        #[wasm_bindgen(js_name = fadeSecs)] fade_secs: f32,
    ) -> Result<()> {
        let state = self.clip(clip)?;
        self.player.fade_to(state, fade_secs);
        Ok(())
    }

    /// Plays a further clip on some joints, on all if none is given, and returns the index of the layer. It replaces
    /// what is below it by its weight, 0 to 1; an additive one adds its difference from its own first frame.
    ///
    /// Throws if there is no such clip or joint.
    #[wasm_bindgen(js_name = addLayer)]
    pub fn add_layer(
        &mut self,
        clip: usize,
        weight: f32,
        joints: &[u32],
        additive: bool,
    ) -> Result<usize> {
        let state = self.clip(clip)?;
        let rig = &self.figure.asset.rig;
        let mut mask = vec![if joints.is_empty() { 1.0 } else { 0.0 }; rig.len()];
        for joint in joints {
            mask[index("joint", *joint as usize, rig.len())?] = 1.0;
        }
        let mode = match additive {
            true => LayerMode::Additive(self.first_pose(clip)),
            false => LayerMode::Override,
        };
        let layer = MotionLayer::new(state.into(), mask, mode);
        let mut layer = layer.map_err(|error| self.thrown(error))?;
        layer.weight = weight;
        let added = self.player.add_layer(layer);
        added.map_err(|error| self.thrown(error))
    }

    /// Sets the weight of a layer, 0 to 1.
    ///
    /// Throws if there is no such layer.
    #[wasm_bindgen(js_name = setLayerWeight)]
    pub fn set_layer_weight(&mut self, layer: usize, weight: f32) -> Result<()> {
        let found = self.player.layer_mut(layer);
        let found = found.ok_or_else(|| Fault::argument(format!("there is no layer {layer}")))?;
        found.weight = weight;
        Ok(())
    }

    /// Moves all joints in every frame, as at first.
    #[wasm_bindgen(js_name = setFullDetail)]
    pub fn set_full_detail(&mut self) {
        self.controller.inner = Metric::full();
        self.controller.request(0);
    }

    /// Shows each joint by its stored keys, the coarsest that move the skin by at most so many pixels. A file that is
    /// not prepared has no keys, and all joints move.
    #[wasm_bindgen(js_name = setTolerance)]
    pub fn set_tolerance(&mut self, px: f32) {
        match &mut self.controller.inner {
            Metric::Keys(keys) => keys.epsilon_px = px,
            full => *full = Metric::keys(&self.figure, px),
        }
    }

    /// Changes to a level of articulation in a transition: 0 moves all joints, 6 none; greater ones count as 6.
    #[wasm_bindgen(js_name = setLoa)]
    pub fn set_loa(&mut self, level: usize) {
        self.controller.request(level);
    }

    /// Turns a joint further after its motion is sampled, in its own space, in all frames until it is cleared; a
    /// unit quaternion.
    ///
    /// Throws if there is no such joint.
    #[wasm_bindgen(js_name = poseJoint)]
    pub fn pose_joint(&mut self, joint: usize, x: f32, y: f32, z: f32, w: f32) -> Result<()> {
        let joint = index("joint", joint, self.joints.len())?;
        let turn = Quat::from_xyzw(x, y, z, w);
        match self.posed.iter_mut().find(|posed| posed.0 == joint) {
            Some(posed) => posed.1 = turn,
            None => self.posed.push((joint, turn)),
        }
        Ok(())
    }

    /// Ends what `poseJoint` began, for all joints.
    #[wasm_bindgen(js_name = clearPosed)]
    pub fn clear_posed(&mut self) {
        self.posed.clear();
    }

    /// Sets the weight of a morph target, in place of what clips give it.
    ///
    /// Throws if there is no such target.
    #[wasm_bindgen(js_name = setMorph)]
    pub fn set_morph(&mut self, target: usize, weight: f32) -> Result<()> {
        let target = index("morph target", target, self.own_morphs.len())?;
        self.own_morphs[target] = Some(weight);
        Ok(())
    }

    /// Gives all morph targets back to the clips, and sets all expressions to 0.
    #[wasm_bindgen(js_name = clearMorphs)]
    pub fn clear_morphs(&mut self) {
        self.own_morphs.fill(None);
        self.expressions.clear();
    }

    /// Sets the weight of an expression, 0 to 1, which is added to what clips do; false if the file has none of this
    /// name.
    #[wasm_bindgen(js_name = setExpression)]
    pub fn set_expression(&mut self, name: &str, weight: f32) -> bool {
        self.expressions.set(name, weight)
    }

    /// Advances by seconds and evaluates, for views in the figure's own space: ten numbers each, position x y z,
    /// rotation x y z w of a camera that looks along its -Z, width and height in pixels, vertical field of view in
    /// radians. Without a view no error is seen. Returns the number of joints whose transforms were renewed.
    ///
    /// Throws if the numbers are not whole views.
    pub fn frame(
        &mut self,
        #[wasm_bindgen(js_name = dtSecs)] dt_secs: f32,
        views: &[f32],
    ) -> Result<usize> {
        self.cameras.clear();
        self.cameras.extend(cameras(views)?);
        let events = &mut self.events;
        events.clear();
        self.root = self.player.advance(dt_secs, &mut |event| {
            let (clip, id, weight) = (event.clip, event.event.id, event.weight);
            events.extend([clip as f64, f64::from(id), f64::from(weight)]);
        });
        Ok(self.evaluate())
    }

    /// Events of clips that the last frame passed, also those of layers, three numbers each: clip, identifier, weight of
    /// the clip.
    #[wasm_bindgen(getter)]
    pub fn events(&self) -> Vec<f64> {
        self.events.clone()
    }

    /// Byte offset of its palette: `Geometry.bindings` matrices of twelve floats, each three rows of four, that take
    /// rest positions to model space.
    #[wasm_bindgen(js_name = paletteAt)]
    pub fn palette_at(&self) -> usize {
        offset(&self.palette)
    }

    /// Byte offset of a matrix of twelve floats for each joint: from its own space to model space.
    #[wasm_bindgen(js_name = jointsAt)]
    pub fn joints_at(&self) -> usize {
        offset(&self.joints)
    }

    /// Byte offset of the weight of each morph target, one float each.
    #[wasm_bindgen(js_name = morphsAt)]
    pub fn morphs_at(&self) -> usize {
        offset(&self.morphs)
    }

    /// Motion of the whole figure in the last frame, where it is extracted: x, y, z in the space before, metres, and
    /// the turn about +Y, radians.
    #[wasm_bindgen(getter, js_name = rootDelta)]
    pub fn root_delta(&self) -> Vec<f32> {
        let [x, y, z] = self.root.offset.to_array();
        vec![x, y, z, self.root.yaw_radians]
    }
}

impl Figure {
    fn clip(&self, clip: usize) -> Result<ClipState> {
        let model: &FigureModel = self.player.model();
        let clip = index("clip", clip, model.clips().len())?;
        Ok(ClipState::new(model, clip))
    }

    fn first_pose(&self, clip: usize) -> LocalPose {
        let rig = &self.figure.asset.rig;
        let mut pose = rig.rest_pose().clone();
        let clip = &self.player.model().clips()[clip];
        sample(clip, 0.0, Wrap::Clamp, &rig.all(), &mut pose);
        pose
    }

    /// An error about the file.
    pub(crate) fn thrown(&self, error: impl Into<articula::Error>) -> Fault {
        Fault::of_file(&error.into(), self.figure.opened.name())
    }

    /// Poses for the cameras, and returns the number of joints renewed.
    pub(crate) fn evaluate(&mut self) -> usize {
        let seen = FigureViews::Cameras(&self.cameras);
        let updated = self
            .player
            .control(&mut self.controller, seen)
            .updated
            .len();
        let (posed, expressions) = (&self.posed, &self.expressions);
        self.player.edit(&mut |pose| {
            for (joint, turn) in posed {
                pose.rotations[*joint] = normalised(pose.rotations[*joint] * *turn);
            }
            expressions.pose(pose);
        });
        self.player.hierarchy();
        self.write();
        updated
    }

    /// Writes what JavaScript reads.
    fn write(&mut self) {
        let pose = self.player.model_pose();
        palette(&self.figure.asset.mesh, pose, &mut self.matrices);
        let written = self.palette.iter_mut().chain(&mut self.joints);
        let matrices = self.matrices.iter().chain(&pose.matrices);
        written.zip(matrices).for_each(|(to, m)| *to = rows(m));
        self.morphs.copy_from_slice(self.player.morph_weights());
        for (weight, own) in self.morphs.iter_mut().zip(&self.own_morphs) {
            *weight = own.unwrap_or(*weight);
        }
        self.expressions.add_to(&mut self.morphs);
    }
}
