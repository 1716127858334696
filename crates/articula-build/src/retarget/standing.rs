//! Whether a rest pose is that of a standing figure.
//!
//! Rotations from rest mean something only if the rest pose does: legs below the hips, head above,
//! elbows and knees bent no other way than a body bends them. In captures and research exports the
//! zero pose is often none: bones along one axis, folded or in the pose of some frame.

use super::body::Body;
use super::rest::Rest;
use glam::{Quat, Vec3};

/// Minimum cosine between a segment of a leg and the trunk's line downward: legs may be spread or
/// bent by 66 degrees.
const LEG_COSINE: f32 = 0.4;
/// Minimum cosine between a segment of spine or neck and the line from hips to shoulders.
const SPINE_COSINE: f32 = 0.3;
/// Length in leg lengths below which a bone of the spine may have any direction.
const SHORT: f32 = 0.05;
/// Minimum cosine between the lines through the hips and through the shoulders.
const SIDE_COSINE: f32 = 0.6;
/// Maximum cosine between the line through the hips and the trunk's.
const ACROSS_COSINE: f32 = 0.5;
/// Sine of the bend of a knee or elbow above which its side counts: 15 degrees.
const BENT: f32 = 0.26;
/// Minimum cosine between the side to which a bent knee or elbow points and that of a body.
const HINGE_COSINE: f32 = -0.5;
/// Minimum cosine between upper arm and forearm: an elbow folds by 150 degrees at most.
const FOLDED_COSINE: f32 = -0.87;
/// Cosine of a foot with the trunk's line upward and minimum cosine with the front.
const FOOT_COSINES: [f32; 2] = [0.7, -0.5];

/// Returns whether a rest pose is that of a figure that stands, whichever direction of space is up
/// for it.
pub(super) fn stands(rest: &Rest, body: &Body) -> bool {
    let unit = |from: usize, to: usize| rest.way(from, to).try_normalize();
    let hips = unit(body.legs[1].hip, body.legs[0].hip);
    let shoulders = rest
        .sided('r', "shoulder")
        .zip(rest.sided('l', "shoulder"))
        .and_then(|(right, left)| unit(right, left));
    let twisted = hips
        .zip(shoulders)
        .is_some_and(|(h, s)| h.dot(s) < SIDE_COSINE);
    // The hip joints of some rigs are at one place.
    let Some(left) = hips.or(shoulders).filter(|_| !twisted) else {
        return false;
    };
    let middle = body.middle(&rest.positions);
    let tops = rest.trunk_top();
    let top = tops.iter().map(|j| rest.positions[*j]).sum::<Vec3>() / tops.len() as f32;
    let Some(up) = (top - middle).try_normalize() else {
        return false;
    };
    if left.dot(up).abs() > ACROSS_COSINE {
        return false;
    }
    let front = left.cross(up).normalize_or_zero();
    let legs = body.legs.iter().all(|leg| {
        let thigh = leg.knee.and_then(|knee| unit(leg.hip, knee));
        let shin = leg.knee.zip(leg.ankle).and_then(|(k, a)| unit(k, a));
        let foot = leg.ankle.zip(leg.toe).and_then(|(a, t)| unit(a, t));
        let down = |way: Option<Vec3>| way.is_none_or(|way| way.dot(up) < -LEG_COSINE);
        let ahead = foot
            .is_none_or(|foot| foot.dot(up) < FOOT_COSINES[0] && foot.dot(front) > FOOT_COSINES[1]);
        down(thigh) && down(shin) && ahead && bends_to(thigh, shin, -front)
    });
    legs && spine_rises(rest, body, up) && arms_bend(rest, [left, up, front])
}

/// Whether the lower segment of a limb is straight, or bends to one side of the upper one.
fn bends_to(upper: Option<Vec3>, lower: Option<Vec3>, side: Vec3) -> bool {
    let Some((upper, lower)) = upper.zip(lower) else {
        return true;
    };
    let bend = lower - upper * upper.dot(lower);
    let side = (side - upper * upper.dot(side)).normalize_or_zero();
    bend.length() < BENT || bend.normalize().dot(side) > HINGE_COSINE
}

/// Whether the joints of spine, neck and head lie one above the other.
fn spine_rises(rest: &Rest, body: &Body, up: Vec3) -> bool {
    let Some(top) = rest.spine_top() else {
        return true;
    };
    let path = rest.between(body.root, top).unwrap_or_default();
    let mapped = path.into_iter().filter(|j| rest.hanim[*j].is_some());
    let chain: Vec<usize> = mapped.chain([top]).collect();
    let least = SHORT * body.leg_metres;
    chain.windows(2).all(|pair| {
        let way = rest.way(pair[0], pair[1]);
        way.length() < least || way.normalize().dot(up) > SPINE_COSINE
    })
}

/// Whether elbows are straight or bend as elbows do.
fn arms_bend(rest: &Rest, [left, up, front]: [Vec3; 3]) -> bool {
    ['l', 'r'].iter().all(|side| {
        let [shoulder, elbow, wrist] =
            ["shoulder", "elbow", "wrist"].map(|name| rest.sided(*side, name));
        let unit = |from: Option<usize>, to: Option<usize>| rest.way(from?, to?).try_normalize();
        let (upper, lower) = (unit(shoulder, elbow), unit(elbow, wrist));
        let Some((u, l)) = upper.zip(lower) else {
            return true;
        };
        if u.dot(l) < FOLDED_COSINE {
            return false;
        }
        // The front of an arm in a T-pose, turned along with it; beside the body it is ambiguous.
        let outward = if *side == 'l' { left } else { -left };
        let turned = Quat::from_rotation_arc(outward, u) * front;
        let inward = u.dot(up) < 0.0 && l.dot(outward) < 0.0;
        inward || bends_to(upper, lower, turned)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::retarget::RetargetFigure;
    use articula_core::hanim_table::JOINTS;
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{Articulation, JointArticulation, Transform};

    /// Whether the figure of the standard stands with some of its joints turned.
    fn stands_with(turn: impl Fn(&str) -> Quat) -> bool {
        let above = |j: usize| JOINTS[j].parent.map_or(Vec3::ZERO, |p| JOINTS[p].center);
        let joints = JOINTS.iter().enumerate().map(|(j, row)| Joint {
            name: row.name.to_owned(),
            parent: row.parent,
            rest: Transform {
                rotation: turn(row.name),
                ..Transform::from_translation(row.center - above(j))
            },
            in_skin: true,
        });
        let known = JOINTS.iter().map(|row| JointArticulation {
            hanim: Some(row.name.to_owned()),
            level: row.level,
            region: row.region,
        });
        let skeleton = Skeleton {
            joints: joints.collect(),
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: known.collect(),
        };
        let figure = RetargetFigure {
            skeleton: &skeleton,
            articulation: &articulation,
            clips: &[],
        };
        let rest = Rest::new(&figure, "figure").unwrap();
        let body = Body::new(&rest, "figure").unwrap();
        stands(&rest, &body)
    }

    #[test]
    fn the_standard_figure_stands_and_may_lie_down() {
        assert!(stands_with(|_| Quat::IDENTITY));
        let lies = Quat::from_rotation_x(-1.5);
        assert!(stands_with(|name| if name == "humanoid_root" {
            lies
        } else {
            Quat::IDENTITY
        }));
    }

    #[test]
    fn arms_and_legs_may_be_spread_and_slightly_bent() {
        assert!(stands_with(|name| match name {
            "l_shoulder" => Quat::from_rotation_z(1.5),
            "r_shoulder" => Quat::from_rotation_z(-0.8),
            "l_hip" => Quat::from_rotation_z(0.3),
            "r_knee" => Quat::from_rotation_x(0.4),
            "l_elbow" => Quat::from_rotation_x(-0.8),
            _ => Quat::IDENTITY,
        }));
    }

    #[test]
    fn what_no_standing_body_does_is_found() {
        for (joint, turn) in [
            ("l_hip", Quat::from_rotation_x(-1.6)),
            ("r_knee", Quat::from_rotation_x(-0.6)),
            ("vl5", Quat::from_rotation_x(1.6)),
            ("vl5", Quat::from_rotation_y(1.2)),
            ("l_ankle", Quat::from_rotation_y(2.5)),
            ("r_elbow", Quat::from_rotation_x(-2.9)),
        ] {
            let stands = stands_with(|name| if name == joint { turn } else { Quat::IDENTITY });
            assert!(!stands, "{joint} {turn}");
        }
    }
}
