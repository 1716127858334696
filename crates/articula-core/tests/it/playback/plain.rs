//! The player against a plain version that samples everything and steps the joint states.

use super::seen_at;
use crate::random_rig::{Options, figure};
use articula_core::crowd::{CharacterState, ClipState};
use articula_core::joint_state::{Ease, JointStates, LoaRange, PassivePolicy, TransitionOptions};
use articula_core::playback::{
    ControlResult, FigureModel, FigurePlayer, FrameContext, FullDetail, LayerMode, LoaController,
    MotionController, MotionLayer,
};
use articula_core::{
    Clip, JointSet, LocalPose, ModelPose, Rig, Wrap, blend, local_to_model, nlerp, sample,
};
use proptest::prelude::*;
use std::sync::Arc;

/// Samples every joint of a state by the plain functions.
fn sampled(rig: &Rig, clips: &[Clip], state: &CharacterState) -> LocalPose {
    let one = |clip_state: &ClipState| {
        let mut pose = rig.rest_pose().clone();
        let secs = f64::from(clip_state.secs());
        let clip = &clips[clip_state.clip()];
        sample(clip, secs, clip_state.wrap(), &rig.all(), &mut pose);
        pose
    };
    let mut pose = one(state.clip_state());
    if let Some(next) = state.next() {
        blend(&mut pose, &one(next), state.fade(), &rig.all());
    }
    pose
}

/// Poses agree within the rounding of a time in f32.
fn close(a: &LocalPose, b: &LocalPose) -> bool {
    let near = |x: f32, y: f32| (x - y).abs() <= 2e-3 * x.abs().max(1.0);
    let vectors = a.translations.iter().zip(&b.translations);
    let turns = a.rotations.iter().zip(&b.rotations);
    vectors
        .clone()
        .all(|(p, q)| near(p.x, q.x) && near(p.y, q.y) && near(p.z, q.z))
        && turns.clone().all(|(p, q)| p.dot(*q).abs() > 1.0 - 1e-4)
}

/// Checks that a controller is given what the trait promises, and passes it on.
struct Watched<C> {
    inner: C,
    truth: LocalPose,
    asked: JointSet,
}

impl<C: MotionController> MotionController for Watched<C> {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        self.asked = self.inner.due(frame);
        assert!(self.asked.difference(&frame.allowed).is_empty());
        self.asked
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        assert!(
            self.asked.difference(due).is_empty(),
            "all asked for are due"
        );
        for joint in due.iter() {
            self.truth.set(joint, wanted.get(joint));
        }
        self.inner.control(frame, due, wanted, shown)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any figure, steps, fades and changes of articulation: the pose is that of joint states
    /// stepped with the whole sampled pose, and the matrices are those of all joints.
    #[test]
    fn levels_show_what_joint_states_show(
        (rig, clips, sets) in figure(Options { scaled: true, steps: false }),
        steps in prop::collection::vec((0.0f32..0.2, 0usize..6, any::<bool>()), 1..25),
        linear in any::<bool>(),
        policy in 0usize..3,
        secs in prop_oneof![Just(0.0f32), 0.02f32..0.5],
    ) {
        let model = Arc::new(FigureModel::new(rig.clone(), clips.clone()).unwrap());
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let opts = TransitionOptions {
            secs,
            ease: if linear { Ease::Linear } else { Ease::Smoothstep },
            policy: [PassivePolicy::HoldLast, PassivePolicy::Rest, PassivePolicy::KeyPose][policy],
        };
        let mut levels = vec![rig.all()];
        levels.extend(sets.iter().copied());
        levels.push(JointSet::EMPTY);
        let range = LoaRange::new(levels.clone(), 0).unwrap();
        let mut loa = LoaController::new(&rig, range, opts, FullDetail::default());
        let mut states = JointStates::new(rig.rest_pose(), opts).with_travel(&rig);
        let (mut now, mut level) = (0.0f64, 0);
        let mut local = rig.rest_pose().clone();
        for (i, (dt, request, fades)) in steps.iter().enumerate() {
            player.advance(*dt, &mut |_| {});
            now += f64::from(*dt);
            if *fades {
                player.fade_to(ClipState::new(&*model, i % 2), 0.15);
            }
            if *request < levels.len() {
                level = *request;
                loa.request(level);
            }
            let report = *player.control(&mut loa, seen_at(100.0));
            let state = *player.state().unwrap();
            let truth = sampled(&rig, &clips, &state);
            // Bit by bit only where the sampled joints are; others are not needed.
            if i == 0 {
                states.start(&levels[level], now, &truth);
            } else {
                states.request(&levels[level], now, &truth);
                states.step(now, &truth);
            }
            prop_assert!(close(player.pose(), states.shown()), "frame {i}");
            prop_assert_eq!(report.in_transition, states.in_transition());
            let matrices = player.hierarchy();
            local.copy_from(player.pose());
            let mut plain = ModelPose::new(rig.len());
            local_to_model(&rig, &local, &mut plain);
            prop_assert_eq!(player.model_pose(), &plain);
            prop_assert!(matrices <= rig.len());
            prop_assert_eq!(player.hierarchy(), 0, "nothing changed since");
            prop_assert_eq!(report.held.union(&report.updated), rig.all());
            prop_assert!(report.held.intersection(&report.updated).is_empty());
        }
    }

    /// Full detail with layers: every joint is the plain blend of all motions.
    #[test]
    fn layers_are_blended_by_mask_and_weight(
        (rig, clips, _) in figure(Options { scaled: false, steps: false }),
        mask in prop::collection::vec(prop_oneof![Just(0.0f32), Just(1.0), 0.0f32..1.0], 24),
        weight in 0.0f32..1.0,
        dt in 0.01f32..0.3,
    ) {
        let model = Arc::new(FigureModel::new(rig.clone(), clips.clone()).unwrap());
        let mut player = FigurePlayer::new(model.clone(), &[]);
        let mask = mask[..rig.len()].to_vec();
        let over = CharacterState::from(ClipState::new(&*model, 1).at_speed(0.5));
        let mut layer = MotionLayer::new(over, mask.clone(), LayerMode::Override).unwrap();
        layer.weight = weight;
        let layer = player.add_layer(layer).unwrap();
        let mut control = Watched {
            inner: FullDetail::default(),
            truth: rig.rest_pose().clone(),
            asked: JointSet::EMPTY,
        };
        for _ in 0..3 {
            player.advance(dt, &mut |_| {});
            player.control(&mut control, seen_at(100.0));
            let base = sampled(&rig, &clips, player.state().unwrap());
            let state = player.layer_mut(layer).unwrap().state;
            let top = sampled(&rig, &clips, &state);
            let mut plain = base.clone();
            for (joint, masked) in mask.iter().enumerate() {
                let w = weight * masked;
                plain.rotations[joint] = nlerp(base.rotations[joint], top.rotations[joint], w);
                plain.translations[joint] =
                    base.translations[joint].lerp(top.translations[joint], w);
            }
            prop_assert!(close(player.pose(), &plain));
            prop_assert!(close(&control.truth, &plain));
        }
    }
}

#[test]
fn a_clip_frame_is_shown_bit_for_bit() {
    // The time i / rate in f32 is that frame, whatever the rate.
    for rate in [24.0f32, 29.97, 30.0, 60.0, 119.88] {
        let clip = Clip::new("c", rate, 1001, 1, super::by_hand::counting(1001)).unwrap();
        let rig = super::by_hand::chain(1);
        let clips = [clip];
        let model = Arc::new(FigureModel::new(rig.clone(), clips.clone()).unwrap());
        let mut player = FigurePlayer::new(model.clone(), &[]);
        for frame in [0, 1, 7, 333, 999] {
            let secs = frame as f32 / rate;
            player.play(ClipState::new(&*model, 0).at_secs(&*model, secs));
            player.control(&mut FullDetail::default(), seen_at(1.0));
            let mut plain = rig.rest_pose().clone();
            let exact = f64::from(frame) / f64::from(rate);
            sample(&clips[0], exact, Wrap::Loop, &rig.all(), &mut plain);
            assert_eq!(player.pose(), &plain, "frame {frame} at {rate} Hz");
        }
    }
}
