//! Ground contact of a source motion: floor height, contacts of feet and hands, orientation of flat
//! feet.

use super::body::Leg;
use super::contacts::{self, Contact};
use super::motion::Motion;
use super::side::Side;
use articula_core::LibmQuat;
use articula_core::rotation_vector;
use glam::{Quat, Vec3};

/// Length of a foot from ankle to toes where no joint determines it, in leg lengths.
const FOOT: f32 = 0.15;
/// Angles of a foot against flat during its contacts below which the rest pose is trusted and above
/// which the contacts are, radians. Feet of figures that stand at rest are within 5 degrees, those
/// of captures that spread their legs at rest are off by 15 to 25.
const UNEVEN_RADIANS: [f32; 2] = [0.07, 0.14];
/// A foot that is turned from flat by more than this during its contacts is not an error of the
/// rest pose: it stands on tiptoe, or on something else.
const LEVEL_RADIANS: f32 = 0.6;
/// Share of the frames in which a foot may be below the floor: noise, and feet that dip.
const BELOW_FLOOR: f32 = 0.05;

/// Minimum median distance of the feet from the floor of the rest pose, in leg lengths, for a
/// motion that may have another floor.
const OTHER_FLOOR: f32 = 0.1;
/// Minimum number of heel contacts of a walk, and their minimum extent in leg lengths.
const STEPS: usize = 4;
const STEP: f32 = 0.3;

/// A point that is fixed to an end joint: where a sole touches the floor, or the wrist itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sole {
    /// Offset from the end joint at rest, in model space; it turns with the joint.
    pub(super) offset: Vec3,
    /// Distance of the point below that offset, vertical regardless of the joint's rotation.
    pub(super) drop: f32,
}

impl Sole {
    /// Position of the point if the end joint is at `place` and turned by `delta` from rest.
    pub(super) fn at(self, place: Vec3, delta: Quat) -> Vec3 {
        place + delta * self.offset - Vec3::Y * self.drop
    }
}

/// Heel and toe of a foot; without a toe joint the usual length of a foot is assumed.
pub(super) fn soles(side: &Side, leg: &Leg) -> Option<[Sole; 2]> {
    let body = &side.body;
    let ankle = leg.ankle?;
    let heel = -body.up() * body.ankle_height;
    let toe = match leg.toe {
        Some(toe) => Sole {
            offset: side.rest.way(ankle, toe),
            // The toes stay flat while the foot rolls over them.
            drop: body.toe_height,
        },
        None => Sole {
            offset: heel + body.forward() * (FOOT * body.leg_metres),
            drop: 0.0,
        },
    };
    let heel = Sole {
        offset: heel,
        drop: 0.0,
    };
    Some([heel, toe])
}

/// Contacts of one foot.
#[derive(Debug, Clone, Default)]
pub(super) struct Foot {
    pub(super) heel: Vec<Contact>,
    pub(super) toe: Vec<Contact>,
}

/// Ground contact of one motion.
#[derive(Debug, Clone)]
pub(super) struct Steps {
    /// Height of the floor in the source's world, metres.
    pub(super) floor: f32,
    /// Contacts of the feet, left and right.
    pub(super) feet: [Foot; 2],
    /// Contacts of the wrists, left and right.
    pub(super) hands: [Vec<Contact>; 2],
    /// For each source joint, the rotation from its rest pose to a foot that is flat on the floor.
    pub(super) level: Vec<Quat>,
}

impl Steps {
    /// Analyses a whole motion; `floor` overrides the detected height, and joints for which `alike`
    /// holds need no levelling.
    pub(super) fn new(
        source: &Side,
        motion: &Motion,
        floor: Option<f32>,
        alike: &dyn Fn(usize) -> bool,
    ) -> Self {
        let floor = floor.unwrap_or_else(|| found_floor(source, motion));
        let leg_metres = source.body.leg_metres;
        let mut steps = Self {
            floor,
            feet: Default::default(),
            hands: Default::default(),
            level: vec![Quat::IDENTITY; source.rest.len()],
        };
        for (i, leg) in source.body.legs.iter().enumerate() {
            let Some((ankle, [heel, toe])) = leg.ankle.zip(soles(source, leg)) else {
                continue;
            };
            let find = |sole: Sole| {
                let path = path(motion, ankle, sole);
                contacts::contacts(&path, motion, leg_metres, floor)
            };
            steps.feet[i] = Foot {
                heel: find(heel),
                toe: find(toe),
            };
            if !alike(ankle) {
                steps.level(source, motion, leg, i);
            }
        }
        for (i, side) in ['l', 'r'].into_iter().enumerate() {
            if let Some(wrist) = source.rest.sided(side, "wrist") {
                let path = path(motion, wrist, Sole::default());
                steps.hands[i] = contacts::rests(&path, motion, leg_metres);
            }
        }
        steps
    }

    /// Computes the orientation of a foot when heel and toe are both on the floor.
    fn level(&mut self, source: &Side, motion: &Motion, leg: &Leg, i: usize) {
        let rest = &source.rest;
        let foot = &self.feet[i];
        let on = |contacts: &[Contact], f: usize| {
            contacts.iter().any(|c| c.on_floor && c.frames.contains(&f))
        };
        let flat: Vec<usize> = (0..motion.frames())
            .filter(|f| on(&foot.heel, *f) && on(&foot.toe, *f))
            .collect();
        for part in [leg.ankle, leg.toe].into_iter().flatten() {
            let up: Vec3 = flat
                .iter()
                .map(|f| motion.deltas(*f)[part].inverse() * Vec3::Y)
                .sum();
            let up = up.normalize_or_zero();
            if up == Vec3::ZERO {
                continue;
            }
            let level = Quat::from_rotation_arc(source.body.up(), up);
            let angle = rotation_vector(Quat::IDENTITY, level).length();
            if angle > LEVEL_RADIANS {
                continue;
            }
            let [even, uneven] = UNEVEN_RADIANS;
            let share = ((angle - even) / (uneven - even)).clamp(0.0, 1.0);
            let level = Quat::IDENTITY.libm_slerp(level, share);
            for j in 0..rest.len() {
                if j == part || rest.between(part, j).is_some() {
                    self.level[j] = level;
                }
            }
        }
    }
}

/// Path of a point that is fixed to a joint.
fn path(motion: &Motion, joint: usize, sole: Sole) -> Vec<Vec3> {
    (0..motion.frames())
        .map(|f| sole.at(motion.positions(f)[joint], motion.deltas(f)[joint]))
        .collect()
}

/// Height of the floor under a motion: that of the rest pose if it stands on one, unless the motion
/// contradicts it; otherwise the height of the soles when they are lowest.
fn found_floor(source: &Side, motion: &Motion) -> f32 {
    let body = &source.body;
    let feet: Vec<(usize, [Sole; 2])> = body
        .legs
        .iter()
        .filter_map(|leg| leg.ankle.zip(soles(source, leg)))
        .collect();
    let lowest = |f: usize| {
        let (places, deltas) = (motion.positions(f), motion.deltas(f));
        let points = feet
            .iter()
            .flat_map(|(ankle, soles)| soles.map(|s| s.at(places[*ankle], deltas[*ankle]).y));
        points.reduce(f32::min)
    };
    let mut lows: Vec<f32> = (0..motion.frames()).filter_map(lowest).collect();
    lows.sort_by(f32::total_cmp);
    let at = |share: f32| lows.get((lows.len() as f32 * share) as usize).copied();
    let (Some(found), Some(usual)) = (at(BELOW_FLOOR), at(0.5)) else {
        return 0.0;
    };
    if !body.stands_on_floor {
        return found;
    }
    // A figure that rises out of the ground, lies or sits does not have its floor at its feet; one
    // that mostly stands does; and above the floor of the rest pose only one that takes steps
    // there.
    let far = OTHER_FLOOR * body.leg_metres;
    let mostly_there = usual - found < far;
    let steps = || walks(source, motion, &feet, found);
    if mostly_there && (found < -far || (found > far && steps())) {
        return found;
    }
    0.0
}

/// Whether a figure takes steps on a floor.
fn walks(source: &Side, motion: &Motion, feet: &[(usize, [Sole; 2])], floor: f32) -> bool {
    let leg = source.body.leg_metres;
    let mut places: Vec<Vec3> = Vec::new();
    for (ankle, [heel, _]) in feet {
        let path = path(motion, *ankle, *heel);
        let found = contacts::contacts(&path, motion, leg, floor);
        let on_floor = found.iter().filter(|c| c.on_floor);
        places.extend(on_floor.map(|c| path[c.frames.start]));
    }
    let low = places.iter().copied().reduce(Vec3::min);
    let high = places.iter().copied().reduce(Vec3::max);
    let spread = low.zip(high).map_or(Vec3::ZERO, |(l, h)| h - l);
    places.len() >= STEPS && spread.x.max(spread.z) > STEP * leg
}

/// Height of the floor under a figure at rest.
pub(super) fn rest_floor(side: &Side) -> f32 {
    if side.body.stands_on_floor {
        return 0.0;
    }
    let ankles = side.body.legs.iter().filter_map(|l| l.ankle);
    let lowest = ankles.map(|j| side.rest.positions[j].y).reduce(f32::min);
    lowest.map_or(0.0, |y| y - side.body.ankle_height)
}
