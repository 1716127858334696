//! Anatomical frames: the orientation of each part of a body at rest, derived from joint positions
//! alone.
//!
//! Two rigs are compared through these frames, never through the axes of their joints, so the axes
//! may be arbitrary, and the rest pose may be a T, an A, an I or any other. A frame's x axis runs
//! along the segment, its y axis to the front of the segment: the side to which elbows bend, to
//! which knees point, the thumb's side of hand and fingers, the top of the foot. Trunk, collars and
//! face have the frame of the body: their rest poses stand upright.

use super::body::Body;
use super::rest::Rest;
use articula_core::LibmQuat;
use glam::{Mat3, Quat, Vec3};
use std::collections::BTreeMap;

/// Fronts of the upper segments of limbs, at rest in model space, by upper joint.
pub(super) type Fronts = BTreeMap<usize, Vec3>;

/// Sines of the bend of an elbow or knee at rest below which it does not determine the hinge at
/// all, and above which it does so fully: 5 and 15 degrees.
const HINGE_SINES: [f32; 2] = [0.087, 0.26];
/// Minimum length of a segment that has a direction, as a share of the leg.
const SHORTEST: f32 = 0.004;
/// Angle by which the root of the thumb is offset towards the palm from the line of the knuckles,
/// seen along the hand: the median of ten rigs with all five fingers, whose values range from 0 to
/// 35 degrees.
const THUMB_RADIANS: f32 = 0.37;

/// Frames of all joints of one rig.
#[derive(Debug, Clone)]
pub(super) struct Frames {
    /// Frame of the segment; `None` if it has no direction.
    pub(super) own: Vec<Option<Quat>>,
    /// Frame of the part to which the joint belongs (body, hand, foot); every joint has one.
    pub(super) part: Vec<Quat>,
}

/// Direction and front of a segment.
#[derive(Debug, Clone, Copy)]
struct Axes {
    along: Vec3,
    front: Vec3,
}

impl Axes {
    fn frame(self) -> Quat {
        basis(self.along, self.front)
    }

    /// Blends the front with the one detected in a motion, by the uncertainty of the rest pose.
    fn corrected(self, seen: Option<&Vec3>, sure: f32) -> Self {
        let front = seen.map_or(self.front, |seen| self.front * sure + *seen * (1.0 - sure));
        let front = front - self.along * self.along.dot(front);
        Self {
            front: front.normalize_or(self.front),
            ..self
        }
    }

    /// The same axes, rotated by the shortest arc so that they run along another direction.
    fn turned(self, along: Vec3) -> Self {
        Self {
            along,
            front: Quat::from_rotation_arc(self.along, along) * self.front,
        }
    }
}

/// Computes the frames of a rig; `seen` are fronts of upper segments detected in a motion.
pub(super) fn frames(rest: &Rest, body: &Body, seen: &Fronts) -> Frames {
    let mut frames = Frames {
        own: vec![None; rest.len()],
        part: vec![body.axes; rest.len()],
    };
    let mut known: Vec<Option<(Quat, Option<Quat>)>> = vec![None; rest.len()];
    for side in ['l', 'r'] {
        arm((rest, body, seen), side, &mut known);
        leg((rest, body, seen), side, &mut known);
    }
    for (j, known) in known.into_iter().enumerate() {
        match known {
            Some((part, own)) => (frames.part[j], frames.own[j]) = (part, own),
            None if rest.hanim[j].is_some() && is_trunk(rest.title(j)) => {
                frames.own[j] = Some(body.axes);
            }
            None => {
                if let Some(p) = rest.parents[j] {
                    frames.part[j] = frames.own[p].unwrap_or(frames.part[p]);
                }
            }
        }
    }
    frames
}

/// Whether an H-Anim joint belongs to trunk or head, or is a collar.
fn is_trunk(title: &str) -> bool {
    let limb = ["index", "middle", "ring", "pinky", "thumb", "carpal"];
    let foot = ["tarsal", "metatars", "cuneonavicular", "calcaneo", "talo"];
    let bare = title
        .strip_prefix("l_")
        .or_else(|| title.strip_prefix("r_"));
    bare.is_none_or(|bare| !limb.iter().chain(&foot).any(|word| bare.contains(word)))
}

type Known = [Option<(Quat, Option<Quat>)>];
type Figure<'a> = (&'a Rest, &'a Body, &'a Fronts);

fn arm((rest, body, seen): Figure<'_>, side: char, known: &mut Known) {
    let Some(shoulder) = rest.sided(side, "shoulder") else {
        return;
    };
    let outward = if side == 'l' {
        body.left()
    } else {
        -body.left()
    };
    let spread = Axes {
        along: outward,
        front: body.forward(),
    };
    let elbow = rest.sided(side, "elbow");
    let wrist = rest.sided(side, "wrist");
    let upper = segment(rest, body, Some(shoulder), elbow.or(wrist));
    let fore = segment(rest, body, elbow, wrist);
    let mut axes = spread.turned(upper.unwrap_or(outward));
    let mut shown = axes;
    if let (Some(u), Some(f)) = (upper, fore) {
        let (front, sure) = hinged(axes, f - u * u.dot(f), u.dot(f));
        axes.front = front;
        shown = axes.corrected(seen.get(&shoulder), sure);
    }
    known[shoulder] = Some((body.axes, upper.map(|_| shown.frame())));
    let mut lower = axes;
    if let Some(elbow) = elbow {
        let along = fore.unwrap_or(axes.along);
        lower = axes.turned(along);
        let frame = shown.turned(along).frame();
        known[elbow] = Some((shown.frame(), fore.map(|_| frame)));
    }
    hand(rest, body, side, lower, known);
}

/// The front of a limb from the bend of its lower part, or from `axes` if it is straight; and the
/// reliability of it, from 0 to 1.
fn hinged(axes: Axes, bend: Vec3, cosine: f32) -> (Vec3, f32) {
    let [none, all] = HINGE_SINES;
    let sine = bend.length();
    let t = ((sine - none) / (all - none)).clamp(0.0, 1.0);
    let sure = if cosine < 0.0 {
        1.0
    } else {
        t * t * (3.0 - 2.0 * t)
    };
    let bend = bend.normalize_or_zero();
    // A slight bend to the wrong side is noise; a strong one is intended by the author of the
    // figure.
    if bend == Vec3::ZERO || (bend.dot(axes.front) < 0.2 && sine < 2.0 * all) {
        return (axes.front, 0.0);
    }
    let front = axes.front * (1.0 - sure) + bend * sure;
    (front.normalize_or(axes.front), sure)
}

fn hand(rest: &Rest, body: &Body, side: char, lower: Axes, known: &mut Known) {
    let knuckles = rest.knuckles(side);
    let thumb = (1..=3).find_map(|d| rest.sided(side, &format!("thumb{d}")));
    let wrist = rest.sided(side, "wrist");
    let center = |joints: &[usize]| -> Option<Vec3> {
        let sum: Vec3 = joints.iter().map(|j| rest.positions[*j]).sum();
        (!joints.is_empty()).then(|| sum / joints.len() as f32)
    };
    let start = wrist.map(|w| rest.positions[w]);
    let ahead = center(&knuckles).or_else(|| {
        let children: Vec<usize> = rest.children(wrist?).collect();
        center(&children)
    });
    let along = start
        .zip(ahead)
        .map(|(from, to)| to - from)
        .filter(|v| v.length() > SHORTEST * body.leg_metres)
        .map(Vec3::normalize);
    let mut axes = lower.turned(along.unwrap_or(lower.along));
    let across = |v: Vec3| v - axes.along * axes.along.dot(v);
    let enough = 0.02 * body.leg_metres;
    let palm = knuckles
        .first()
        .zip(knuckles.last())
        .map(|(a, b)| across(rest.way(*b, *a)))
        .filter(|v| v.length() > enough);
    let from_thumb = || {
        let way = across(rest.positions[thumb?] - start?);
        let turn = if side == 'l' {
            -THUMB_RADIANS
        } else {
            THUMB_RADIANS
        };
        (way.length() > enough).then(|| Quat::libm_axis_angle(axes.along, turn) * way)
    };
    if let Some(front) = palm.or_else(from_thumb) {
        axes.front = front.normalize();
    }
    let frame = axes.frame();
    if let Some(wrist) = wrist {
        known[wrist] = Some((lower.frame(), Some(frame)));
    }
    for name in ["thumb", "index", "middle", "ring", "pinky"] {
        finger(rest, body, (side, name), axes, known);
    }
}

fn finger(rest: &Rest, body: &Body, (side, name): (char, &str), hand: Axes, known: &mut Known) {
    let joints: Vec<(usize, usize)> = (0..=3)
        .filter_map(|d| Some((d, rest.sided(side, &format!("{name}{d}"))?)))
        .collect();
    let mut last: Option<Vec3> = None;
    for (i, &(digit, joint)) in joints.iter().enumerate() {
        let next = joints.get(i + 1).map(|n| n.1);
        let tip = || rest.children(joint).next();
        let along = segment(rest, body, Some(joint), next.or_else(tip)).or(last);
        // The bones of the palm have the hand's frame, wherever a rig starts them.
        let own = along.filter(|_| digit > 0).map(|a| hand.turned(a).frame());
        known[joint] = Some((hand.frame(), own));
        last = along;
    }
}

fn leg((rest, body, seen): Figure<'_>, side: char, known: &mut Known) {
    let leg = body.legs[usize::from(side == 'r')];
    let (up, forward) = (body.up(), body.forward());
    let flat = |v: Vec3| v - up * up.dot(v);
    let to_toe = leg.ankle.zip(leg.toe).map(|(a, t)| rest.way(a, t));
    // A foot that points down at rest has no direction on the floor.
    let ahead = to_toe
        .filter(|v| flat(*v).length() > 0.5 * v.length())
        .map(|v| flat(v).normalize_or_zero())
        .filter(|v| v.dot(forward) > 0.3)
        .unwrap_or(forward);
    let foot = Axes {
        along: ahead,
        front: up,
    };
    // Knees point half as far outward as the toes.
    let knee_front = (forward + ahead).normalize_or(forward);
    let hanging = Axes {
        along: -up,
        front: knee_front,
    };
    let thigh = segment(rest, body, Some(leg.hip), leg.knee.or(leg.ankle));
    let shin = segment(rest, body, leg.knee, leg.ankle);
    let mut axes = hanging.turned(thigh.unwrap_or(-up));
    if let (Some(u), Some(f)) = (thigh, shin) {
        let (front, sure) = hinged(axes, u * u.dot(f) - f, u.dot(f));
        axes.front = front;
        axes = axes.corrected(seen.get(&leg.hip), sure);
    }
    known[leg.hip] = Some((body.axes, thigh.map(|_| axes.frame())));
    if let Some(knee) = leg.knee {
        let lower = axes.turned(shin.unwrap_or(axes.along));
        known[knee] = Some((axes.frame(), shin.map(|_| lower.frame())));
    }
    for (j, known) in known.iter_mut().enumerate() {
        let title = rest.title(j);
        if title.starts_with(side) && (Some(j) == leg.ankle || !is_trunk(title)) {
            let below = leg
                .ankle
                .is_some_and(|a| a == j || rest.between(a, j).is_some());
            if below || title.contains("tars") {
                *known = Some((foot.frame(), Some(foot.frame())));
            }
        }
    }
}

/// Unit direction from one joint to another, if they are far enough apart.
fn segment(rest: &Rest, body: &Body, from: Option<usize>, to: Option<usize>) -> Option<Vec3> {
    let way = rest.way(from?, to?);
    (way.length() > SHORTEST * body.leg_metres).then(|| way.normalize())
}

/// The rotation whose x axis is `x`, and whose y axis is the direction nearest to `y`.
pub(super) fn basis(x: Vec3, y: Vec3) -> Quat {
    let x = x.normalize_or(Vec3::X);
    let y = (y - x * x.dot(y)).normalize_or(x.any_orthonormal_vector());
    Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))).normalize()
}
