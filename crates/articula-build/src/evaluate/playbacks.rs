//! Playback of each method: the rotations that it shows at every frame of one pass.
//!
//! Source: `docs/methods/motion-lod.md` 3 (thesis, Ahn), 4 (ours), 11 (baselines).

use super::baselines::ahn;
use super::baselines::thesis::radii;
use super::baselines::thesis_metric::{ErrorMatrix, switch};
use super::method::{Method, Playback, SkinPxVariant};
use super::stage::{ClipEvaluator, MethodRun};
use crate::motion_error::closed_loop;
use crate::motion_error::contacts::attention;
use crate::motion_error::keys::{Segment, central_rotation, linear_keys, pose_segments};
use articula_core::joint_state::{JointState, JointStates, PassivePolicy, TransitionOptions};
use articula_core::{JointSet, nlerp};
use glam::{Quat, Vec3};

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
    match method {
        Method::SkinPx(SkinPxVariant::View) => stage
            .view_directions()
            .map(|view| held_in_view(stage, parameter, view))
            .collect(),
        Method::SkinPx(variant) => vec![skin_px(stage, *variant, parameter)],
        Method::Thesis => vec![thesis(stage, parameter)],
        Method::Ahn => {
            let radii = radii(&stage.asset.rig, stage.options.thesis.radius);
            let alpha = stage.options.thesis.alpha;
            vec![segmented(stage, |joint, values| {
                ahn::clusters(values, alpha, radii[joint], parameter)
            })]
        }
        Method::SkipHold => vec![skipped(stage, parameter, false)],
        Method::SkipLerp => vec![skipped(stage, parameter, true)],
        Method::Loa(levels) => {
            let at = (parameter.max(0.0) as usize).min(levels.len().saturating_sub(1));
            let set = levels.get(at).copied().unwrap_or(stage.asset.rig.all());
            vec![fixed(stage, &set)]
        }
    }
}

fn skin_px(stage: &ClipEvaluator<'_>, variant: SkinPxVariant, tolerance: f32) -> Playback {
    let radians = |joint: usize| tolerance / stage.levers[joint].rest_metres;
    match variant {
        SkinPxVariant::Hold | SkinPxVariant::View => held(stage, tolerance),
        SkinPxVariant::KeyPose => {
            segmented(stage, |joint, values| pose_segments(values, radians(joint)))
        }
        SkinPxVariant::ClosedLoop => {
            let limits: Vec<f32> = (0..stage.asset.rig.len()).map(radians).collect();
            let truth: Vec<&[Quat]> = stage.truth.iter().map(|p| p.rotations.as_slice()).collect();
            let played = closed_loop::closed_loop(&stage.asset.rig, &truth, &stage.moving, &limits);
            Playback {
                in_transition: vec![JointSet::EMPTY; truth.len()],
                shown: played.shown,
                updated: played.renewed,
            }
        }
        SkinPxVariant::Linear => linear(stage, tolerance),
    }
}

/// Starts from the true motion; `rewrite` then replaces the moving joints one by one.
fn per_joint(
    stage: &ClipEvaluator<'_>,
    mut rewrite: impl FnMut(usize, &[Quat], &mut Playback),
) -> Playback {
    let mut out = stage.true_playback();
    for joint in stage.moving.iter() {
        let values: Vec<Quat> = stage.truth.iter().map(|p| p.rotations[joint]).collect();
        rewrite(joint, &values, &mut out);
    }
    out
}

fn held(stage: &ClipEvaluator<'_>, tolerance: f32) -> Playback {
    let mut care = vec![1.0; stage.asset.rig.len()];
    let mut out = stage.true_playback();
    for frame in 1..stage.truth.len() {
        if stage.options.protect_contacts {
            attention(stage.asset, &stage.contacts, frame, &mut care);
        }
        for joint in stage.moving.iter() {
            let (before, wanted) = (out.shown[frame - 1][joint], out.shown[frame][joint]);
            if stage.levers[joint].held_error(before, wanted) > tolerance * care[joint] {
                out.updated[frame].insert(joint);
            } else {
                out.shown[frame][joint] = before;
            }
        }
    }
    out
}

fn held_in_view(stage: &ClipEvaluator<'_>, tolerance: f32, view: Vec3) -> Playback {
    let mut out = stage.true_playback();
    for frame in 1..stage.truth.len() {
        for joint in stage.moving.iter() {
            let (before, wanted) = (out.shown[frame - 1][joint], out.shown[frame][joint]);
            let lever = &stage.levers[joint];
            let in_joint = stage.true_models[frame][joint].conjugate() * view;
            let error = lever.projected_error(before, wanted, in_joint);
            if error > tolerance {
                out.updated[frame].insert(joint);
            } else {
                out.shown[frame][joint] = before;
            }
        }
    }
    out
}

fn segmented(
    stage: &ClipEvaluator<'_>,
    mut cut: impl FnMut(usize, &[Quat]) -> Vec<Segment>,
) -> Playback {
    per_joint(stage, |joint, values, out| {
        let segments = cut(joint, values);
        for (s, segment) in segments.iter().enumerate() {
            let end = segments.get(s + 1).map_or(values.len(), |next| next.start);
            for frame in segment.start..end {
                out.shown[frame][joint] = segment.key;
            }
            if segment.start > 0 {
                out.updated[segment.start].insert(joint);
            }
        }
    })
}

fn linear(stage: &ClipEvaluator<'_>, tolerance: f32) -> Playback {
    per_joint(stage, |joint, values, out| {
        let all: Vec<u32> = (0..values.len() as u32).collect();
        let keys = linear_keys(values, tolerance / stage.levers[joint].rest_metres, &all);
        for span in keys.windows(2) {
            let (from, to) = (span[0] as usize, span[1] as usize);
            for frame in from..to {
                let u = (frame - from) as f32 / (to - from) as f32;
                out.shown[frame][joint] = nlerp(values[from], values[to], u);
            }
            out.updated[to].insert(joint);
        }
    })
}

fn thesis(stage: &ClipEvaluator<'_>, threshold: f32) -> Playback {
    let matrix: &ErrorMatrix = stage.thesis_matrix();
    let hold_last = TransitionOptions {
        policy: PassivePolicy::HoldLast,
        ..stage.options.transition
    };
    let mut states = JointStates::new(&stage.truth[0], hold_last);
    let mut out = stage.true_playback();
    for (frame, pose) in stage.truth.iter().enumerate() {
        let secs = frame as f64 / f64::from(stage.clip.rate_hz());
        if frame > 0 {
            switch(matrix, frame, threshold, &mut states, secs, pose);
        }
        let shown = states.step(secs, pose);
        for joint in stage.moving.iter() {
            out.shown[frame][joint] = shown.rotations[joint];
        }
        for joint in stage.moving.iter().filter(|_| frame > 0) {
            let state = states.state(joint);
            if state != JointState::Passive {
                out.updated[frame].insert(joint);
            }
            if matches!(state, JointState::ToActive | JointState::ToPassive) {
                out.in_transition[frame].insert(joint);
            }
        }
    }
    out
}

fn skipped(stage: &ClipEvaluator<'_>, every: f32, blended: bool) -> Playback {
    let every = (every.max(1.0) as usize).min(stage.truth.len());
    let last = stage.truth.len() - 1;
    let mut out = stage.true_playback();
    for frame in 1..=last {
        let key = frame - frame % every;
        let next = (key + every).min(last);
        if frame == key || (blended && frame == last) {
            out.updated[frame] = stage.moving;
            continue;
        }
        let u = if blended {
            (frame - key) as f32 / (next - key) as f32
        } else {
            0.0
        };
        for joint in stage.moving.iter() {
            let [from, to] = [key, next].map(|f| stage.truth[f].rotations[joint]);
            out.shown[frame][joint] = if blended { nlerp(from, to, u) } else { from };
        }
    }
    out
}

fn fixed(stage: &ClipEvaluator<'_>, level: &JointSet) -> Playback {
    let mut out = per_joint(stage, |joint, values, out| {
        if level.contains(joint) {
            return;
        }
        let rest = stage.asset.rig.rest_pose().rotations[joint];
        let key = match stage.options.transition.policy {
            PassivePolicy::KeyPose => central_rotation(values).unwrap_or(rest),
            PassivePolicy::HoldLast => values[0],
            PassivePolicy::Rest | PassivePolicy::BlendToRest { .. } => rest,
        };
        for frame in &mut out.shown {
            frame[joint] = key;
        }
    });
    for frame in out.updated.iter_mut().skip(1) {
        *frame = stage.moving.intersection(level);
    }
    out
}
