//! Retargeting to other sizes, other proportions, fewer and more joints.

use super::figure::retarget;
use super::figure::{Human, arms_up, as_it_is, reference, rotation};
use articula_build::retarget::{ContactPinning, RetargetOptions, Retargeted, RotationOrigin};
use articula_core::angle_between;
use articula_core::source::RawClip;
use glam::{Quat, Vec3};

const AS_IT_IS: RetargetOptions = RetargetOptions {
    rate_hz: None,
    pinning: ContactPinning::Nothing,
    floor_metres: None,
    self_contact: false,
};

fn carried(source: &Human, target: &Human, clip: &str) -> Retargeted {
    retarget(
        source.figure(),
        target.figure(),
        source.clip(clip),
        &AS_IT_IS,
    )
    .unwrap()
}

/// Unit direction from one H-Anim joint to another.
fn way(human: &Human, clip: &RawClip, time: f32, names: (&str, &str)) -> Vec3 {
    let at = human.positions(clip, time);
    (at[human.find(names.1)] - at[human.find(names.0)]).normalize()
}

const LIMBS: [(&str, &str); 6] = [
    ("l_shoulder", "l_elbow"),
    ("l_elbow", "l_wrist"),
    ("r_elbow", "r_wrist"),
    ("l_hip", "l_knee"),
    ("l_knee", "l_ankle"),
    ("r_knee", "r_ankle"),
];

/// Maximum angle between the limbs of both figures, radians.
fn limbs_off(source: &Human, target: &Human, clip: &str) -> f32 {
    let made = carried(source, target, clip);
    let mut worst = 0.0f32;
    for limb in LIMBS {
        for t in [0.0, 0.3, 0.9] {
            let was = way(source, source.clip(clip), t, limb);
            let is = way(target, &made.clip, t, limb);
            worst = worst.max(was.angle_between(is));
        }
    }
    worst
}

#[test]
fn a_child_moves_as_its_parent_but_smaller() {
    let human = reference();
    let child = human.resized(0.5, |_, offset| offset);
    let made = carried(&human, &child, "walk");
    assert!((made.report.scale - 0.5).abs() < 1e-5);
    for t in [0.0, 0.3, 0.7] {
        let was = human.positions(human.clip("walk"), t);
        let is = child.positions(&made.clip, t);
        let error = was.iter().zip(&is).map(|(a, b)| (0.5 * *a).distance(*b));
        assert!(error.fold(0.0, f32::max) < 1e-4);
    }
}

#[test]
fn limbs_of_other_lengths_point_the_same_way() {
    let human = reference();
    let other = human.resized(1.0, |name, offset| match name {
        "l_knee" | "r_knee" => 0.7 * offset,
        "l_elbow" | "r_elbow" => 1.3 * offset,
        "l_wrist" | "r_wrist" => 0.8 * offset,
        "l_hip" | "r_hip" => offset + Vec3::new(0.05f32.copysign(offset.x), 0.0, 0.0),
        _ => offset,
    });
    let off = limbs_off(&human, &other, "walk");
    assert!(off < 1e-3, "{off} rad");
}

#[test]
fn missing_joints_leave_the_ends_as_they_were() {
    let human = reference().rebound(arms_up(60.0), as_it_is);
    let few = human.without(|name| {
        let spine = name.starts_with('v') && !["vl5", "vt10", "vt1", "vc4"].contains(&name);
        let gone = [
            "sternoclav",
            "acromio",
            "subtalar",
            "midtarsal",
            "sacroiliac",
        ];
        spine || gone.iter().any(|g| name.contains(g))
    });
    let made = carried(&human, &few, "wave");
    assert!(limbs_off(&human, &few, "wave") < 1e-3);
    let rest = |h: &Human, name: &str| {
        let still = RawClip::default();
        rotation(&h.matrices(&still, 0.0)[h.find(name)])
    };
    for name in ["skullbase", "r_wrist", "l_wrist", "l_ankle"] {
        for t in [0.1, 0.9, 1.7] {
            let now = |h: &Human, clip: &RawClip| {
                let now = rotation(&h.matrices(clip, t)[h.find(name)]);
                now * rest(h, name).inverse()
            };
            let off = angle_between(now(&human, human.clip("wave")), now(&few, &made.clip));
            assert!(off < 2e-3, "{name} at {t}: {off} rad");
        }
    }
    let dropped = made.report.dropped.iter();
    let dropped: Vec<&str> = dropped
        .map(|j| human.skeleton.joints[*j].name.as_str())
        .collect();
    assert!(dropped.contains(&"l_sternoclavicular"), "{dropped:?}");
}

#[test]
fn more_joints_than_the_source_share_its_bend() {
    let human = reference();
    let few = human.without(|name| name.starts_with('v') && !["vl5", "vt6", "vc4"].contains(&name));
    // A motion of the figure with fewer joints: bend forward at both joints of the spine.
    let mut few = few;
    few.clips = vec![bend(&few, &[("vl5", 0.3), ("vt6", 0.4)])];
    let made = carried(&few, &human, "bend");
    let turn = |name: &str| {
        let now = human.matrices(&made.clip, 1.0);
        let still = human.matrices(&RawClip::default(), 1.0);
        let j = human.find(name);
        (rotation(&now[j]) * rotation(&still[j]).inverse())
            .to_axis_angle()
            .1
    };
    let spine = [
        "vl5", "vl3", "vl1", "vt12", "vt10", "vt8", "vt6", "vt3", "vt1",
    ];
    let turns: Vec<f32> = spine.iter().map(|n| turn(n)).collect();
    assert!(turns.windows(2).all(|w| w[0] <= w[1] + 1e-4), "{turns:?}");
    assert!(turns[0] < 0.2 && (turns[8] - 0.7).abs() < 1e-3, "{turns:?}");
    let steps = turns.windows(2).map(|w| w[1] - w[0]);
    assert!(steps.fold(0.0, f32::max) < 0.2, "no kink: {turns:?}");
    let shared = |name: &str| {
        let origin = &made.report.joints[human.find(name)].origin;
        matches!(origin, RotationOrigin::Shared { sources } if sources.len() == 2)
    };
    assert!(shared("vt12") && shared("vl1"));
}

/// A clip of one second that turns joints about the axis from right to left.
fn bend(human: &Human, joints: &[(&str, f32)]) -> RawClip {
    use articula_core::source::{Channel, Interpolation, Property};
    let channels = joints.iter().map(|(name, radians)| Channel {
        target: human.find(name),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0, 0.5, 1.0],
        values: [0.0, 0.5, 1.0]
            .iter()
            .flat_map(|t| Quat::from_rotation_x(t * radians).to_array())
            .collect(),
    });
    RawClip {
        name: "bend".to_owned(),
        duration_secs: 1.0,
        channels: channels.collect(),
    }
}

#[test]
fn twist_joints_take_their_share_and_move_nothing() {
    let human = reference();
    let mut turning = human.clone();
    // The left hand turned about the forearm by 80 degrees.
    let way = human.skeleton.joints[human.find("l_wrist")]
        .rest
        .translation;
    let axis = way.normalize();
    turning.clips = vec![bend(&human, &[("l_wrist", 0.0)])];
    let values = [0.0, 0.7, 1.4].map(|a| Quat::from_axis_angle(axis, a).to_array());
    turning.clips[0].channels[0].values = values.concat();
    let target_rest = |h: &Human| h.positions(&RawClip::default(), 0.0);
    for in_line in [true, false] {
        let target = human.with_joint("forearm_twist", "l_elbow", "l_wrist", in_line);
        let made = carried(&turning, &target, "bend");
        let at = |name: &str| target.skeleton.find(name).unwrap();
        let now = target.matrices(&made.clip, 1.0);
        let angle = |j: usize| rotation(&now[j]).to_axis_angle().1;
        let share = angle(at("forearm_twist"));
        let wanted = if in_line { 0.75 * 1.4 } else { 0.5 * 1.4 };
        assert!((share - wanted).abs() < 1e-3, "{in_line}: {share}");
        assert!(angle(at("l_elbow")) < 1e-3, "the forearm itself stays");
        assert!((angle(at("l_wrist")) - 1.4).abs() < 1e-3);
        let moved = super::figure::farthest(
            &target_rest(&target)[..at("l_wrist")],
            &target.positions(&made.clip, 1.0)[..at("l_wrist")],
        );
        assert!(moved < 1e-4, "{moved} m");
    }
    // Without such a joint the forearm takes what exceeds the wrist.
    let made = carried(&turning, &human, "bend");
    let now = human.matrices(&made.clip, 1.0);
    let elbow = rotation(&now[human.find("l_elbow")]).to_axis_angle().1;
    assert!((elbow - 0.7).abs() < 1e-3, "{elbow}");
}

#[test]
fn one_finger_leads_the_others() {
    let human = reference();
    let mitten = human.without(|name| {
        let other = ["middle", "ring", "pinky"].iter().any(|f| name.contains(f));
        other || name.contains("index0")
    });
    let mut mitten = mitten;
    mitten.clips = vec![bend(&mitten, &[("l_index1", 0.8)])];
    let made = carried(&mitten, &human, "bend");
    let now = human.matrices(&made.clip, 1.0);
    for finger in ["l_index1", "l_middle1", "l_ring1", "l_pinky1"] {
        let angle = rotation(&now[human.find(finger)]).to_axis_angle().1;
        assert!((angle - 0.8).abs() < 0.35, "{finger}: {angle}");
    }
    let still = rotation(&now[human.find("r_middle1")]).to_axis_angle().1;
    assert!(still < 0.35, "{still}");
}

#[test]
fn legs_that_hang_beside_the_hips_follow_them() {
    let human = reference();
    let mut beside = human.clone();
    beside.clips.clear();
    // A new root above all, from which the thighs hang as well as the hips.
    for joint in &mut beside.skeleton.joints {
        joint.parent = joint.parent.map(|p| p + 1);
    }
    let mut base = beside.skeleton.joints[0].clone();
    base.name = "base".to_owned();
    base.rest = articula_core::Transform::IDENTITY;
    base.parent = None;
    let mut unmapped = beside.articulation.joints[0].clone();
    unmapped.hanim = None;
    beside.skeleton.joints.insert(0, base);
    beside.articulation.joints.insert(0, unmapped);
    beside.skeleton.joints[1].parent = Some(0);
    let at = human.positions(&RawClip::default(), 0.0);
    for hip in ["l_hip", "r_hip"] {
        let place = at[human.find(hip)];
        let j = beside.find(hip);
        beside.skeleton.joints[j].parent = Some(0);
        beside.skeleton.joints[j].rest.translation = place;
    }
    let made = carried(&human, &beside, "walk");
    for t in [0.0, 0.4, 0.8] {
        let was = human.positions(human.clip("walk"), t);
        let is = beside.positions(&made.clip, t);
        let error = super::figure::farthest(&was, &is[1..]);
        assert!(error < 1e-3, "{error} m");
    }
}
