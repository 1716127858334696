//! Distribution of a limb's twist about its length, so that the skin does not wrap.
//!
//! A rig that has twist joints along the limb, in line or as siblings, gives each its share: of the
//! upper arm and thigh the twist against the trunk, none at the top and all at the bottom; of
//! forearm and shin the twist of hand and foot, all at the bottom. A forearm without such joints
//! takes what exceeds the range of a wrist: beyond [`WRIST_RADIANS`] the skin of the wrist would
//! wrap. Joint positions do not change.
//!
//! Source: swing-twist decomposition of a rotation; the shares are by position along the limb.

use super::plan::{Drive, Plan, swing};
use super::pose::Pose;
use super::side::Side;
use articula_core::{Libm, LibmQuat};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Angle by which a hand turns against the forearm's joint before the forearm follows: 40 degrees.
const WRIST_RADIANS: f32 = 0.7;
/// Maximum distance of a sibling twist joint from the limb's axis, as a share of the segment.
const BESIDE: f32 = 0.25;

/// A joint that takes a share of a segment's twist.
#[derive(Debug, Clone, PartialEq)]
struct Part {
    joint: usize,
    /// Share of the segment's twist, 0 to 1.
    share: f32,
    /// Whether the segment's lower end hangs from it.
    in_line: bool,
}

/// One segment of a limb with the joints that share its twist.
#[derive(Debug, Clone, PartialEq)]
struct Segment {
    upper: usize,
    lower: usize,
    /// Reference of the twist: the joint above for an upper segment, the lower end itself for a
    /// lower one.
    against: Against,
    /// Share that stays in the upper joint itself, where others take the rest.
    own: f32,
    parts: Vec<Part>,
    /// Direction of the segment at rest, in model space.
    along: Vec3,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Against {
    /// The part of the body that the limb hangs from.
    Above(Option<usize>),
    /// The hand or foot.
    Below,
}

/// Distributes twist frame by frame; keeps the last angles so that none jumps by a full turn.
#[derive(Debug, Clone)]
pub(super) struct Twists {
    segments: Vec<Segment>,
    last: Vec<Option<f32>>,
}

impl Twists {
    /// Finds the joints of a target that share twist.
    pub(super) fn new(plan: &Plan, target: &Side) -> Self {
        let mut segments = Vec::new();
        for side in ['l', 'r'] {
            for names in [["shoulder", "elbow", "wrist"], ["hip", "knee", "ankle"]] {
                let [upper, middle, end] = names.map(|n| target.rest.sided(side, n));
                let above = Against::Above(upper.and_then(|u| target.rest.parents[u]));
                segments.extend(segment(plan, target, upper.zip(middle), above));
                segments.extend(segment(plan, target, middle.zip(end), Against::Below));
            }
        }
        Self {
            last: vec![None; segments.len()],
            segments,
        }
    }

    /// Joints that are rotated although the plan holds them.
    pub(super) fn joints(&self) -> Vec<usize> {
        let parts = self.segments.iter().flat_map(|s| &s.parts);
        parts.map(|p| p.joint).collect()
    }

    /// Each joint that shares twist, with the joint that provides the twist and its share.
    pub(super) fn shares(&self) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
        self.segments.iter().flat_map(|segment| {
            let turns = match segment.against {
                Against::Above(_) => segment.upper,
                Against::Below => segment.lower,
            };
            segment.parts.iter().map(move |p| (p.joint, turns, p.share))
        })
    }

    /// Distributes the twist of a pose whose limbs are bent.
    pub(super) fn spread(&mut self, plan: &Plan, target: &Side, pose: &mut Pose) {
        if self.segments.is_empty() {
            return;
        }
        for (segment, last) in self.segments.iter().zip(&mut self.last) {
            let twist = near(segment.twist(pose), *last);
            *last = Some(twist);
            segment.spread(target, pose, twist);
        }
        let parts = self.joints();
        for (j, drive) in plan.drives.iter().enumerate() {
            if let Some(p) = target.rest.parents[j]
                && *drive == Drive::Held
                && !parts.contains(&j)
            {
                pose.deltas[j] = pose.deltas[p];
            }
        }
        let root = pose.positions[target.body.root];
        pose.place(plan, target, root);
    }
}

/// A segment, if it has joints that share its twist.
fn segment(
    plan: &Plan,
    target: &Side,
    ends: Option<(usize, usize)>,
    against: Against,
) -> Option<Segment> {
    let (upper, lower) = ends?;
    let rest = &target.rest;
    let way = rest.way(upper, lower);
    let along = way.try_normalize()?;
    let in_line = rest.between(upper, lower)?;
    // Joints that copy a twin of the source have their share already.
    let free = |j: &usize| plan.drives[*j] == Drive::Held;
    if !in_line.iter().all(free) {
        return None;
    }
    let place = |j: usize| rest.way(upper, j).dot(along) / way.length();
    let mut places: Vec<f32> = vec![0.0];
    places.extend(in_line.iter().map(|j| place(*j)));
    places.push(1.0);
    let middle = |i: usize| 0.5 * (places[i] + places[i + 1]);
    // The last joint in line carries all, so that what hangs below is not turned back.
    let whole = match against {
        Against::Above(_) => middle(places.len() - 2),
        Against::Below => 1.0,
    };
    let mut parts: Vec<Part> = in_line
        .iter()
        .enumerate()
        .map(|(i, joint)| Part {
            joint: *joint,
            share: (middle(i + 1) / whole).clamp(0.0, 1.0),
            in_line: true,
        })
        .collect();
    let beside = |j: &usize| {
        let off = rest.way(upper, *j) - along * rest.way(upper, *j).dot(along);
        is_twist(&rest.names[*j])
            && free(j)
            && !in_line.contains(j)
            && (-0.05..=1.0).contains(&place(*j))
            && off.length() < BESIDE * way.length()
    };
    parts.extend(rest.children(upper).filter(beside).map(|joint| Part {
        joint,
        share: place(joint).clamp(0.0, 1.0),
        in_line: false,
    }));
    let own = match against {
        Against::Above(_) if !in_line.is_empty() => (middle(0) / whole).clamp(0.0, 1.0),
        Against::Above(_) => 1.0,
        Against::Below => 0.0,
    };
    let is_forearm = rest.title(upper).ends_with("elbow");
    let needed = !parts.is_empty() || (is_forearm && against == Against::Below);
    needed.then_some(Segment {
        upper,
        lower,
        against,
        own,
        parts,
        along,
    })
}

/// Whether the name of a joint marks it as a twist joint.
fn is_twist(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.contains("twist") || name.contains("roll")
}

impl Segment {
    /// The twist of a segment in a pose, radians: of the segment against its parent, or of its
    /// lower end against the segment.
    fn twist(&self, pose: &Pose) -> f32 {
        let own = pose.deltas[self.upper];
        let relative = match self.against {
            Against::Above(above) => {
                above.map_or(Quat::IDENTITY, |a| pose.deltas[a]).inverse() * own
            }
            Against::Below => own.inverse() * pose.deltas[self.lower],
        };
        twist_about(relative, self.along)
    }

    fn spread(&self, target: &Side, pose: &mut Pose, twist: f32) {
        let rest = &target.rest;
        let full = pose.deltas[self.upper];
        let about = |radians: f32| Quat::libm_axis_angle(self.along, radians);
        let end = pose.positions[self.lower];
        // An upper segment contains all of its twist already; a lower one, none.
        let given = match self.against {
            Against::Above(_) => 1.0,
            Against::Below => 0.0,
        };
        let mut own = about((self.own - given) * twist);
        if self.parts.is_empty() {
            own = about(twist - twist.clamp(-WRIST_RADIANS, WRIST_RADIANS));
        }
        pose.deltas[self.upper] = full * own;
        let mut above = self.upper;
        for part in &self.parts {
            let turned = full * about((part.share - given) * twist);
            let way = rest.way(above, part.joint);
            if part.in_line {
                // A joint slightly off the axis must still lead to the segment's end.
                let place = pose.positions[above] + pose.deltas[above] * way;
                pose.positions[part.joint] = place;
                let to_end = rest.way(part.joint, self.lower);
                pose.deltas[part.joint] = swing(turned, to_end, end - place);
                above = part.joint;
            } else {
                pose.deltas[part.joint] = turned;
            }
        }
    }
}

/// The angle of a rotation about an axis, between -pi and pi.
fn twist_about(rotation: Quat, axis: Vec3) -> f32 {
    let along = Vec3::new(rotation.x, rotation.y, rotation.z).dot(axis);
    if along.libm_hypot(rotation.w) < 1e-6 {
        return 0.0;
    }
    let angle = 2.0 * along.libm_atan2(rotation.w);
    angle - TAU * (angle / TAU).round()
}

/// The angle equal to `angle` up to full turns that is nearest to the last one.
fn near(angle: f32, last: Option<f32>) -> f32 {
    let near = last.map_or(angle, |last| angle - TAU * ((angle - last) / TAU).round());
    // No limb is wound up; a large angle is caused by a jump of the source.
    if near.abs() > 0.75 * TAU { angle } else { near }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twist_is_the_turn_about_the_axis() {
        let swing = Quat::from_rotation_y(0.8);
        let twist = Quat::from_rotation_x(0.5);
        assert!((twist_about(swing * twist, Vec3::X) - 0.5).abs() < 1e-5);
        assert!((twist_about(-(swing * twist), Vec3::X) - 0.5).abs() < 1e-5);
        assert_eq!(
            twist_about(Quat::from_rotation_y(std::f32::consts::PI), Vec3::X),
            0.0
        );
    }

    #[test]
    fn a_turn_goes_on_where_it_was() {
        assert!((near(-3.0, Some(3.0)) - (TAU - 3.0)).abs() < 1e-5);
        assert_eq!(near(0.5, None), 0.5);
    }
}
