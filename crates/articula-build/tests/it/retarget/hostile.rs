//! Malformed figures and clips: an error with the reason, or finite floats.

use super::figure::retarget;
use super::figure::{Human, reference};
use articula_build::retarget::{ContactPinning, RetargetOptions, Retargeter};
use articula_core::source::{Property, RawClip};
use articula_core::{Articulation, Transform};
use glam::{Quat, Vec3};
use proptest::prelude::*;

const EVERYTHING: RetargetOptions = RetargetOptions {
    rate_hz: None,
    pinning: ContactPinning::FeetAndHands,
    floor_metres: None,
    self_contact: true,
};

fn finite(source: &Human, target: &Human, clip: &RawClip) {
    let made = retarget(source.figure(), target.figure(), clip, &EVERYTHING).unwrap();
    for channel in &made.clip.channels {
        assert!(channel.values.iter().all(|v| v.is_finite()), "{channel:?}");
    }
    let quality = format!("{:?}", made.report.quality);
    assert!(
        !quality.contains("NaN") && !quality.contains("inf"),
        "{quality}"
    );
}

#[test]
fn figures_of_one_point_or_without_limbs_give_finite_poses() {
    let human = reference();
    let clip = human.clip("walk");
    let point = human.resized(0.0, |_, offset| offset);
    let flat = human.resized(1.0, |_, offset| Vec3::new(offset.x, 0.0, 0.0));
    let limbless = human.resized(1.0, |name, offset| {
        let limb = ["knee", "ankle", "elbow", "wrist"];
        if limb.iter().any(|l| name.contains(l)) {
            Vec3::ZERO
        } else {
            offset
        }
    });
    let upside = human.resized(1.0, |_, offset| -offset);
    let hips_only = human.without(|name| {
        let kept = ["humanoid_root", "sacroiliac", "l_hip", "r_hip"];
        !kept.contains(&name)
    });
    for odd in [point, flat, limbless, upside, hips_only] {
        finite(&human, &odd, clip);
        let still = RawClip::default();
        let own = odd.clips.iter().find(|c| c.name == "walk");
        finite(&odd, &human, own.unwrap_or(&still));
        finite(&odd, &odd, own.unwrap_or(&still));
    }
}

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    let human = reference();
    let clip = human.clip("walk");
    let refusal = |change: &dyn Fn(&mut Human)| {
        let mut odd = human.clone();
        change(&mut odd);
        let error = Retargeter::new(odd.figure(), human.figure());
        let error = error.err().or_else(|| {
            let clip = odd.clip("walk");
            retarget(odd.figure(), human.figure(), clip, &EVERYTHING).err()
        });
        error.unwrap().to_string()
    };
    assert!(refusal(&|h| h.articulation = Articulation::default()).starts_with("source: 89"));
    let hip = human.find("l_hip");
    let no_hip = refusal(&|h| h.articulation.joints[hip].hanim = None);
    assert_eq!(no_hip, "source: no joint is mapped to l_hip");
    let nan = refusal(&|h| h.skeleton.joints[3].rest.translation.x = f32::NAN);
    assert!(nan.starts_with("source.joints[3]"), "{nan}");
    let above = refusal(&|h| h.skeleton.joints[3].parent = Some(7));
    assert!(above.starts_with("source.joints[3]"), "{above}");
    let target = refusal(&|h| h.clips[1].channels[0].target = 99);
    assert!(
        target.contains("channels[0]: joint 99 is out of range"),
        "{target}"
    );
    let short = refusal(&|h| h.clips[1].channels[0].values.truncate(5));
    assert!(short.contains("5 values"), "{short}");
    let wild = refusal(&|h| h.clips[1].channels[0].values[3] = f32::INFINITY);
    assert!(wild.contains("not finite"), "{wild}");
    let long = refusal(&|h| h.clips[1].duration_secs = 1e9);
    assert!(long.contains("exceed the limit"), "{long}");
    for rate in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e9] {
        let options = RetargetOptions {
            rate_hz: Some(rate),
            ..EVERYTHING
        };
        assert!(retarget(human.figure(), human.figure(), clip, &options).is_err());
    }
}

#[test]
fn a_clip_without_channels_is_one_rest_pose() {
    let human = reference();
    let made = retarget(
        human.figure(),
        human.figure(),
        &RawClip::default(),
        &EVERYTHING,
    )
    .unwrap();
    assert_eq!(made.clip.duration_secs, 0.0);
    assert!(made.clip.channels.iter().all(|c| c.times_secs == [0.0]));
}

#[test]
fn channels_of_faces_are_left_to_others() {
    let mut human = reference();
    let walk = human.clips.iter_mut().find(|c| c.name == "walk").unwrap();
    let mut morph = walk.channels[0].clone();
    morph.property = Property::Weights;
    morph.target = 5;
    walk.channels.push(morph);
    finite(&human, &human, human.clip("walk"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn random_rigs_never_give_nan(
        offsets in prop::collection::vec((-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0), 89),
        turns in prop::collection::vec((-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0), 89),
        scales in prop::collection::vec(prop::sample::select(vec![1.0f32, -1.0, 0.01, 100.0]), 89),
        kept in prop::collection::vec(prop::bool::weighted(0.8), 89),
        wildness in 0.0f32..1.0,
    ) {
        let human = reference();
        let mut odd = human.clone();
        for (j, joint) in odd.skeleton.joints.iter_mut().enumerate() {
            let (x, y, z) = offsets[j];
            let (a, b, c, d) = turns[j];
            let q = Quat::from_xyzw(a, b, c, d);
            let q = if q.length() > 0.1 { q.normalize() } else { Quat::IDENTITY };
            joint.rest = Transform {
                translation: joint.rest.translation.lerp(Vec3::new(x, y, z), wildness),
                rotation: Quat::IDENTITY.slerp(q, wildness),
                scale: if j % 20 == 7 { Vec3::new(scales[j], 1.0, 1.0) } else { Vec3::ONE },
            };
        }
        let needed = ["humanoid_root", "l_hip", "r_hip"];
        for (j, joint) in odd.articulation.joints.iter_mut().enumerate() {
            let name = joint.hanim.as_deref().unwrap_or("");
            if !kept[j] && !needed.contains(&name) {
                joint.hanim = None;
            }
        }
        finite(&human, &odd, human.clip("walk"));
        finite(&odd, &human, odd.clip("wave"));
    }
}
