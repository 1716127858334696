//! What decides which joints of a figure move, and what that shows.

use crate::error::{Fault, Result, index};
use crate::figure::Figure;
use crate::metric::{Metric, StoredErrors};
use crate::view::cameras;
use articula::LoaRange;
use articula::core::JointSet;
use articula::core::joint_state::{Ease, PassivePolicy, TransitionOptions};
use articula::core::playback::{ErrorMatrix, LoaController, Threshold, ThresholdCurve};
use articula::evaluate::ShownErrorMeter;
use wasm_bindgen::prelude::*;

/// States of a joint, as `jointStates` numbers them.
const PASSIVE: u8 = 0;
const ACTIVE: u8 = 1;
const IN_TRANSITION: u8 = 2;

#[wasm_bindgen]
impl Figure {
    /// Lets these joints move and no others, in a transition.
    ///
    /// Throws if there is no such joint.
    pub fn articulate(&mut self, joints: &[u32]) -> Result<()> {
        let count = self.figure.asset.rig.len();
        let joints = joints.iter().map(|j| index("joint", *j as usize, count));
        self.controller
            .articulate(joints.collect::<Result<JointSet>>()?);
        Ok(())
    }

    /// Sets how joints change between moving and held: the seconds, 0 for at once; "smooth" or "linear"; and what
    /// held joints show, "hold" for the last transform or "rest". The next frame begins anew, without a transition.
    ///
    /// Throws for another word.
    #[wasm_bindgen(js_name = setTransition)]
    pub fn set_transition(&mut self, secs: f32, ease: &str, passive: &str) -> Result<()> {
        self.transition = TransitionOptions {
            secs: if secs.is_nan() { 0.0 } else { secs.max(0.0) },
            ease: match ease {
                "smooth" => Ease::Smoothstep,
                "linear" => Ease::Linear,
                _ => return Err(unknown("ease", ease, "\"smooth\" and \"linear\"")),
            },
            policy: match passive {
                "hold" => PassivePolicy::HoldLast,
                "rest" => PassivePolicy::Rest,
                _ => return Err(unknown("passive", passive, "\"hold\" and \"rest\"")),
            },
        };
        let rig = &self.figure.asset.rig;
        let inner = std::mem::replace(&mut self.controller.inner, Metric::full());
        let joints = *self.controller.articulation();
        let range = LoaRange::named(rig, 0);
        self.controller = LoaController::new(rig, range, self.transition, inner);
        self.controller.articulate(joints);
        Ok(())
    }

    /// Holds each joint whose stored error is below the threshold of the distance, as the thesis does: `initial` at
    /// the viewer, `farthest` at `farthestMetres`, looked up in every n-th frame. `rising` takes the curve that never
    /// falls. A file that is not prepared has no errors, and all joints move.
    #[wasm_bindgen(js_name = setThreshold)]
    pub fn set_threshold(
        &mut self,
        initial: f32,
        farthest: f32,
        #[wasm_bindgen(js_name = farthestMetres)] farthest_metres: f32,
        #[wasm_bindgen(js_name = lookupEvery)] lookup_every: usize,
        rising: bool,
    ) {
        let threshold = Threshold {
            thr_init: initial,
            thr_max: farthest,
            d_max_metres: farthest_metres,
            curve: match rising {
                true => ThresholdCurve::Fixed,
                false => ThresholdCurve::Literal,
            },
            ..Threshold::default()
        };
        let figure = &self.figure;
        let errors = self
            .errors
            .get_or_insert_with(|| StoredErrors::read(figure));
        let rig = &figure.asset.rig;
        self.controller.inner =
            Metric::thesis(rig, errors, threshold, lookup_every, self.transition);
    }

    /// Sets the errors of a clip by which thresholds decide, for each of its keys one number for each joint, as
    /// `Publisher.errorMatrix` returns them; without, those of the file again, for all clips. `setThreshold` then takes
    /// them over.
    ///
    /// Throws if there is no such clip or the numbers are not those of its keys.
    #[wasm_bindgen(js_name = setErrors)]
    pub fn set_errors(&mut self, clip: usize, errors: Option<Vec<f32>>) -> Result<()> {
        let asset = &self.figure.asset;
        let clip = index("clip", clip, asset.clips.len())?;
        let mut stored = StoredErrors::read(&self.figure);
        if let Some(errors) = errors {
            let of = &asset.clips[clip];
            let (joints, keys) = (asset.rig.len(), (of.frames() - 1) / of.frames_per_key() + 1);
            if errors.len() != joints * keys {
                let found = errors.len();
                let what = format!("errors: {found} numbers, {joints} × {keys} are expected");
                return Err(Fault::argument(what));
            }
            let errors = ErrorMatrix::new(joints, errors).map_err(|error| self.thrown(error))?;
            stored.put(clip, errors);
        }
        self.errors = Some(stored);
        Ok(())
    }

    /// Evaluates at a time of the page's clock, in place of `frame`: the clip that is played shows `clipSecs`, and
    /// transitions go by `nowSecs`. Figures with the same times show the same moment. Returns the number of joints
    /// whose transforms were renewed.
    ///
    /// Throws if the numbers are not whole views.
    #[wasm_bindgen(js_name = frameAt)]
    pub fn frame_at(
        &mut self,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
        #[wasm_bindgen(js_name = clipSecs)] clip_secs: f32,
        views: &[f32],
    ) -> Result<usize> {
        self.cameras.clear();
        self.cameras.extend(cameras(views)?);
        self.root = Default::default();
        self.player.advance_to(now_secs, clip_secs);
        Ok(self.evaluate())
    }

    /// State of each joint in the last frame: 0 passive, 1 active, 2 in transition.
    #[wasm_bindgen(getter, js_name = jointStates)]
    pub fn joint_states(&self) -> Vec<u8> {
        let report = self.player.report();
        let state = |joint| match joint {
            j if report.in_transition.contains(j) => IN_TRANSITION,
            j if report.held.contains(j) => PASSIVE,
            _ => ACTIVE,
        };
        (0..self.figure.asset.rig.len()).map(state).collect()
    }

    /// Work of the last frame: joints renewed, joints in transition, transforms sampled, matrices computed.
    #[wasm_bindgen(getter)]
    pub fn work(&self) -> Vec<u32> {
        let report = self.player.report();
        [
            report.updated.len(),
            report.in_transition.len(),
            report.transforms_sampled,
            report.matrices,
        ]
        .map(|count| count as u32)
        .to_vec()
    }

    /// Error of the last frame against all joints of its clip in a view of ten numbers, in pixels: the 95th percentile
    /// over a sample of the skin, and its maximum.
    ///
    /// Throws if the numbers are not one view.
    #[wasm_bindgen(js_name = errorPx)]
    pub fn error_px(&mut self, view: &[f32]) -> Result<Vec<f32>> {
        let mut views = cameras(view)?;
        let (Some(camera), None) = (views.next(), views.next()) else {
            return Err(Fault::argument("views: give one"));
        };
        let figure = &self.figure;
        let meter = self
            .meter
            .get_or_insert_with(|| ShownErrorMeter::new(&figure.asset.mesh));
        let error = meter.measure(figure, &self.player, &camera);
        Ok(vec![error.p95_px, error.worst_px])
    }
}

fn unknown(what: &str, word: &str, known: &str) -> Fault {
    Fault::argument(format!("{what}: \"{word}\"; known are {known}"))
}
