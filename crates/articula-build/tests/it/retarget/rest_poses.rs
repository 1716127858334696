//! Retargeting is independent of the rest pose and of the joints' axes.

use super::figure::retarget;
use super::figure::{Human, arms_up, as_it_is, farthest, reference};
use articula_build::retarget::{ContactPinning, RetargetOptions};
use articula_core::source::{Interpolation, Property, RawClip};
use glam::{Affine3A, Mat3, Quat, Vec3};
use proptest::prelude::*;

const AS_IT_IS: RetargetOptions = RetargetOptions {
    rate_hz: None,
    pinning: ContactPinning::Nothing,
    floor_metres: None,
    self_contact: false,
};

/// Maximum distance of any joint between a clip of one figure and the same clip retargeted to
/// another whose joints have the same positions.
fn error(source: &Human, target: &Human, clip: &str) -> f32 {
    let clip = source.clip(clip);
    let made = retarget(source.figure(), target.figure(), clip, &AS_IT_IS).unwrap();
    let times = [0.0, 0.21, 0.5, 0.77, 1.0].map(|t| t * clip.duration_secs);
    times
        .iter()
        .map(|t| {
            let was = source.positions(clip, *t);
            farthest(&was, &target.positions(&made.clip, *t))
        })
        .fold(0.0, f32::max)
}

#[test]
fn a_figure_gives_its_motion_to_itself() {
    let human = reference();
    for clip in ["idle", "walk", "wave"] {
        let error = error(&human, &human, clip);
        assert!(error < 1e-4, "{clip}: {error} m");
    }
}

#[test]
fn arms_may_hang_or_be_spread_at_rest() {
    let hanging = reference();
    for (a, b) in [(0.0, 84.0), (84.0, 0.0), (45.0, 84.0), (0.0, 45.0)] {
        let source = hanging.rebound(arms_up(a), as_it_is);
        let target = hanging.rebound(arms_up(b), as_it_is);
        for clip in ["walk", "wave"] {
            let error = error(&source, &target, clip);
            assert!(error < 1e-3, "{clip} from {a} to {b} degrees: {error} m");
        }
    }
}

#[test]
fn legs_and_elbows_may_be_bent_at_rest() {
    let straight = reference();
    let mut bent = straight.rebound(
        |name| match name {
            "l_elbow" | "r_elbow" => Quat::from_rotation_x(-0.8),
            // Legs apart, feet flat.
            "l_hip" | "r_ankle" => Quat::from_rotation_z(0.3),
            "r_hip" | "l_ankle" => Quat::from_rotation_z(-0.3),
            _ => Quat::IDENTITY,
        },
        as_it_is,
    );
    // With its legs apart it stands lower on the same floor.
    let height = |human: &Human| {
        let still = human.positions(&RawClip::default(), 0.0);
        still[human.find("l_ankle")].y
    };
    bent.skeleton.joints[0].rest.translation.y += height(&straight) - height(&bent);
    for (source, target) in [(&straight, &bent), (&bent, &straight)] {
        for clip in ["walk", "wave"] {
            let error = error(source, target, clip);
            assert!(error < 3e-3, "{clip}: {error} m");
        }
    }
}

#[test]
fn mirrored_joints_do_not_matter() {
    let human = reference();
    let mirrored = human.rebound(arms_up(84.0), |j| {
        let sign = if j % 3 == 1 { -1.0 } else { 1.0 };
        Affine3A::from_mat3(Mat3::from_diagonal(Vec3::new(1.0, sign, 1.0)))
    });
    for (source, target) in [(&human, &mirrored), (&mirrored, &human)] {
        let error = error(source, target, "walk");
        assert!(error < 1e-3, "{error} m");
    }
}

#[test]
fn a_figure_may_face_anywhere_at_rest() {
    let human = reference();
    for quarter in 1..4 {
        let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 * quarter as f32);
        let away = turned(&human, turn);
        let made = retarget(human.figure(), away.figure(), human.clip("walk"), &AS_IT_IS).unwrap();
        for t in [0.0, 0.4, 0.8] {
            let was = human.positions(human.clip("walk"), t);
            let was: Vec<Vec3> = was.iter().map(|p| turn * *p).collect();
            let error = farthest(&was, &away.positions(&made.clip, t));
            assert!(error < 1e-3, "{quarter}: {error} m");
        }
    }
}

/// The figure with its rest pose rotated about the origin of model space.
fn turned(human: &Human, turn: Quat) -> Human {
    let mut new = human.clone();
    new.clips.clear();
    let root = &mut new.skeleton.joints[0].rest;
    root.translation = turn * root.translation;
    root.rotation = turn * root.rotation;
    new
}

#[test]
fn keys_are_linear_regular_and_do_not_flip() {
    let human = reference();
    let clip = human.clip("walk");
    let made = retarget(
        human.figure(),
        human.figure(),
        clip,
        &RetargetOptions::default(),
    );
    let made = made.unwrap();
    assert_eq!(made.clip.duration_secs, clip.duration_secs);
    for channel in &made.clip.channels {
        assert_eq!(channel.interpolation, Interpolation::Linear);
        let times = &channel.times_secs;
        assert!(times.len() == 1 || times.len() == 32 + 1, "{}", times.len());
        if channel.property == Property::Rotation {
            let keys: Vec<Quat> = channel.values.chunks(4).map(Quat::from_slice).collect();
            assert!(keys.iter().all(|k| (k.length() - 1.0).abs() < 1e-5));
            assert!(keys.windows(2).all(|w| w[0].dot(w[1]) >= 0.0));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn local_axes_may_be_anything(
        seeds in prop::collection::vec((-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0), 89),
        spread in 0.0f32..95.0,
        target_spread in 0.0f32..95.0,
    ) {
        let axes = |j: usize| {
            let (x, y, z, w) = seeds[j];
            let q = Quat::from_xyzw(x, y, z, w);
            let q = if q.length() > 0.1 { q.normalize() } else { Quat::IDENTITY };
            Affine3A::from_quat(q)
        };
        let human = reference();
        let source = human.rebound(arms_up(spread), axes);
        let target = human.rebound(arms_up(target_spread), |j| axes(88 - j));
        let error = error(&source, &target, "wave");
        prop_assert!(error < 1e-3, "{error} m");
    }
}
