//! Feet in contact do not slide, and knees and elbows bend the right way.

use super::figure::retarget;
use super::figure::{Human, reference};
use articula_build::retarget::{ContactPinning, RetargetOptions};
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// The reference walk, moving forward instead of on the spot: the root moves while a foot is down.
pub(crate) fn walking() -> Human {
    let mut human = reference();
    let walk = human.clip("walk").clone();
    let ankles = [human.find("l_ankle"), human.find("r_ankle")];
    let times = walk.channels[0].times_secs.clone();
    let mut clip = RawClip {
        name: "forward".to_owned(),
        duration_secs: 3.0 * walk.duration_secs,
        channels: Vec::new(),
    };
    // The lower foot's speed backward is the body's speed forward.
    let lower = |t: f32| {
        let at = human.positions(&walk, t % walk.duration_secs);
        let [l, r] = ankles.map(|a| at[a]);
        usize::from(r.y < l.y)
    };
    let place = |t: f32, foot: usize| human.positions(&walk, t % walk.duration_secs)[ankles[foot]];
    let step = walk.duration_secs / (times.len() - 1) as f32;
    let count = 3 * (times.len() - 1);
    let mut forward = 0.0;
    let mut roots = Vec::new();
    let all: Vec<f32> = (0..=count).map(|i| i as f32 * step).collect();
    for t in &all {
        let at = human.positions(&walk, t % walk.duration_secs)[0];
        roots.extend((at + Vec3::Z * forward).to_array());
        let foot = lower(*t);
        forward += (place(*t, foot).z - place(t + step, foot).z).max(0.0);
    }
    for channel in &walk.channels {
        let repeat = |width: usize| {
            let once = &channel.values[..channel.values.len() - width];
            let mut values = once.repeat(3);
            values.extend_from_slice(&channel.values[..width]);
            values
        };
        clip.channels.push(Channel {
            times_secs: all.clone(),
            values: match channel.property {
                Property::Translation => roots.clone(),
                _ => repeat(4),
            },
            ..channel.clone()
        });
    }
    human.clips.push(clip);
    human
}

/// A figure with short thighs, wide hips and large feet.
fn stocky(human: &Human) -> Human {
    human.resized(0.8, |name, offset| match name {
        "l_knee" | "r_knee" => 0.75 * offset,
        "l_hip" | "r_hip" => Vec3::new(1.5 * offset.x, offset.y, offset.z),
        "l_metatarsal" | "r_metatarsal" => 1.2 * offset,
        _ => offset,
    })
}

#[test]
fn resting_feet_stay_where_they_are() {
    let human = walking();
    let other = stocky(&human);
    let clip = human.clip("forward");
    let options = RetargetOptions::default();
    let made = retarget(human.figure(), other.figure(), clip, &options).unwrap();
    let quality = made.report.quality;
    assert!(quality.slide.contacts >= 6, "{quality:?}");
    assert!(quality.slide.max_metres < 1e-3, "{quality:?}");
    assert!(quality.slide_before.max_metres > 5e-3, "{quality:?}");
    assert!(quality.below_floor_metres < 1e-3, "{quality:?}");
    assert_eq!(quality.hinge_wrong_share, 0.0);
    // The figure travels as far as its legs allow.
    let went = |h: &Human, clip: &RawClip| h.positions(clip, clip.duration_secs)[0].z;
    let ratio = went(&other, &made.clip) / went(&human, clip);
    assert!((ratio / made.report.scale - 1.0).abs() < 0.02, "{ratio}");
}

#[test]
fn pinning_can_be_left_out() {
    let human = walking();
    let options = RetargetOptions {
        pinning: ContactPinning::Nothing,
        ..RetargetOptions::default()
    };
    let clip = human.clip("forward");
    let made = retarget(human.figure(), stocky(&human).figure(), clip, &options).unwrap();
    let quality = made.report.quality;
    assert_eq!(quality.slide, quality.slide_before);
}

#[test]
fn resting_hands_stay_too_if_wanted() {
    let human = reference();
    let long_arms = human.resized(1.0, |name, offset| match name {
        "l_elbow" | "r_elbow" => 1.3 * offset,
        _ => offset,
    });
    // Both hands rest while the hips sway a little beneath.
    let mut swaying = human.clone();
    let times: Vec<f32> = (0..=60).map(|i| i as f32 / 30.0).collect();
    let rest = human.skeleton.joints[0].rest.translation;
    let values = times.iter().flat_map(|t| {
        let sway = 0.01 * (0.8 * t).sin();
        (rest + Vec3::X * sway).to_array()
    });
    swaying.clips = vec![RawClip {
        name: "sway".to_owned(),
        duration_secs: 2.0,
        channels: vec![Channel {
            target: 0,
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times_secs: times.clone(),
            values: values.collect(),
        }],
    }];
    let moved = |pinning: ContactPinning| {
        let options = RetargetOptions {
            pinning,
            ..RetargetOptions::default()
        };
        let clip = swaying.clip("sway");
        let made = retarget(swaying.figure(), long_arms.figure(), clip, &options).unwrap();
        let wrist = long_arms.find("l_wrist");
        let places = times
            .iter()
            .map(|t| long_arms.positions(&made.clip, *t)[wrist]);
        let places: Vec<Vec3> = places.collect();
        places
            .iter()
            .map(|p| p.distance(places[0]))
            .fold(0.0, f32::max)
    };
    assert!(moved(ContactPinning::Feet) > 8e-3);
    assert!(moved(ContactPinning::FeetAndHands) < 1e-3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever a capture does to straight limbs, none bends backward.
    #[test]
    fn hinges_never_invert(
        bends in prop::collection::vec(-0.35f32..1.5, 16),
        lifts in prop::collection::vec(-0.6f32..0.6, 16),
    ) {
        let human = reference();
        let mut bent = human.clone();
        let key = |name: &str, sign: f32, values: &[f32]| Channel {
            target: human.find(name),
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: (0..8).map(|i| i as f32 / 8.0).collect(),
            values: values
                .iter()
                .flat_map(|v| Quat::from_rotation_x(sign * v).to_array())
                .collect(),
        };
        bent.clips = vec![RawClip {
            name: "bends".to_owned(),
            duration_secs: 0.875,
            channels: vec![
                key("l_knee", 1.0, &bends[..8]),
                key("r_elbow", -1.0, &bends[8..]),
                key("l_hip", 1.0, &lifts[..8]),
                key("r_shoulder", 1.0, &lifts[8..]),
            ],
        }];
        let options = RetargetOptions {
            rate_hz: Some(30.0),
            ..RetargetOptions::default()
        };
        let other = stocky(&human);
        let made = retarget(bent.figure(), other.figure(), bent.clip("bends"), &options).unwrap();
        prop_assert_eq!(made.report.quality.hinge_wrong_share, 0.0);
        let frames = made.clip.channels.iter().flat_map(|c| &c.values);
        prop_assert!(frames.into_iter().all(|v| v.is_finite()));
    }
}
