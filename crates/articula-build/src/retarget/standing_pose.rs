//! The standing pose of a figure whose rest pose is none, found from its motions.
//!
//! What a motion shows does not depend on the rest pose: where a joint's neighbours are in its own
//! space, to which side knees and elbows bend, how the joints of the trunk lie on average against
//! the line from hips to shoulders, and how a foot lies on the floor. The standing pose is a
//! T-pose in which all of these are what they are in a standing figure, facing +Z. Rotations are
//! then relative to it instead of to the rest pose.

use super::body::{Body, Leg};
use super::contacts;
use super::frames::basis;
use super::motion::Motion;
use super::rest::Rest;
use articula_core::LibmQuat;
use articula_core::same_hemisphere;
use glam::{Quat, Vec3};

/// Share of the greatest length of the trunk (95th percentile) from which it counts as straight.
const STRAIGHT: f32 = 0.98;
/// Minimum root mean square of the sine of a limb's bends: 5 degrees.
const ENOUGH: f32 = 0.087;
/// Minimum length of the mean bend over the mean length of the bends.
const STEADY: f32 = 0.5;
/// Minimum number of frames with a flat foot.
const FLAT_FRAMES: usize = 5;
/// Share of the frames in which an ankle or toe may be lower than what counts as its height on the
/// floor.
const LOWEST: f32 = 0.05;
/// Height above its lowest at which an ankle or toe counts as on the floor, in leg lengths.
const LOW: f32 = 0.04;
/// Slope of a foot from ankle to toes where no contact shows it: the usual heights over the usual
/// length.
const FOOT_SLOPE: f32 = 0.35;

/// Forward lean over the rise of the lowest bone of the spine, and of the neck with the bone below
/// it: about the middle of the rest poses of the test data, whose values are -0.2 to 0.2 and -0.2 to
/// 0.4.
const LUMBAR_LEAN: f32 = -0.06;
const NECK_LEAN: f32 = 0.1;
/// Maximum number of joints of a spine and of a neck whose bones are straight.
const SPINE_JOINTS: usize = 3;
const NECK_JOINTS: usize = 1;

/// What of a joint's orientation in the standing pose the motions of a figure do not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Assumed {
    /// The turn about the joint's bone: the limb never bends enough. The mean in the motions counts
    /// as neutral.
    Twist,
    /// The whole orientation: no mapped joint follows. Its mean in the motions counts as neutral.
    Orientation,
}

/// A standing pose.
#[derive(Debug, Clone)]
pub(super) struct StandingPose {
    /// Rotation of each joint from the rest pose, in model space.
    pub(super) turns: Vec<Quat>,
    /// Position of each joint, metres; the middle of the hips is at the origin.
    pub(super) positions: Vec<Vec3>,
    /// Joints whose orientation is assumed in part.
    pub(super) assumed: Vec<(usize, Assumed)>,
}

/// Finds the standing pose of a figure from its motions, whatever its rest pose is.
pub(super) fn from_motion(rest: &Rest, body: &Body, motion: &Motion) -> StandingPose {
    let mut finder = Finder {
        rest,
        body,
        motion,
        trunk: trunk_frames(rest, body, motion),
        turns: vec![None; rest.len()],
        assumed: Vec::new(),
    };
    finder.trunk();
    for side in ['l', 'r'] {
        finder.leg(side);
        finder.arm(side);
    }
    finder.finish()
}

struct Finder<'a> {
    rest: &'a Rest,
    body: &'a Body,
    motion: &'a Motion,
    /// Frames in which the trunk is straight, with its orientation: X to the left, Y from hips to
    /// shoulders.
    trunk: Vec<(usize, Quat)>,
    turns: Vec<Option<Quat>>,
    assumed: Vec<(usize, Assumed)>,
}

/// Orientation of the trunk in the frames in which it is straight, from positions alone.
fn trunk_frames(rest: &Rest, body: &Body, motion: &Motion) -> Vec<(usize, Quat)> {
    let [left, right] = [body.legs[0].hip, body.legs[1].hip];
    let tops = rest.trunk_top();
    let frames: Vec<(f32, Quat)> = (0..motion.frames())
        .map(|f| {
            let at = motion.positions(f);
            let middle = 0.5 * (at[left] + at[right]);
            let mut across = (at[left] - at[right]).normalize_or_zero();
            if let [l, r] = tops[..] {
                across += (at[l] - at[r]).normalize_or_zero();
            }
            let top: Vec3 = tops.iter().map(|j| at[*j]).sum();
            let up = match tops.len() {
                0 => Vec3::Y,
                count => top / count as f32 - middle,
            };
            // `basis` keeps its first axis, which is the trunk's line.
            let turned = basis(up, -across);
            let from_up = Quat::libm_rotation_z(-std::f32::consts::FRAC_PI_2);
            (up.length(), turned * from_up)
        })
        .collect();
    let mut lengths: Vec<f32> = frames.iter().map(|f| f.0).collect();
    lengths.sort_by(f32::total_cmp);
    let long = lengths.get((0.95 * lengths.len() as f32) as usize);
    let least = STRAIGHT * long.copied().unwrap_or(0.0);
    let straight = frames.into_iter().enumerate();
    straight
        .filter(|(_, (length, _))| *length >= least)
        .map(|(f, (_, turn))| (f, turn))
        .collect()
}

/// Mean of rotations that are near to each other.
fn mean(turns: impl Iterator<Item = Quat> + Clone) -> Option<Quat> {
    let first = turns.clone().next()?;
    let about = |center: Quat| {
        let sum = turns.clone().fold(glam::Vec4::ZERO, |sum, turn| {
            sum + glam::Vec4::from(same_hemisphere(center, turn))
        });
        Quat::from_vec4(sum.try_normalize().unwrap_or(glam::Vec4::from(center)))
    };
    Some(about(about(first)))
}

impl Finder<'_> {
    /// Mean offset from one joint to another in the space of the first.
    fn way(&self, from: usize, to: usize) -> Option<Vec3> {
        let sum: Vec3 = (0..self.motion.frames())
            .map(|f| {
                let at = self.motion.positions(f);
                self.motion.deltas(f)[from].inverse() * (at[to] - at[from])
            })
            .sum();
        let way = sum / self.motion.frames().max(1) as f32;
        (way.length() > 1e-3 * self.body.leg_metres).then_some(way)
    }

    /// Mean rotation of a joint against another one.
    fn relative(&self, above: usize, joint: usize) -> Quat {
        let turns = (0..self.motion.frames()).map(|f| {
            let turns = self.motion.deltas(f);
            turns[above].inverse() * turns[joint]
        });
        mean(turns).unwrap_or_default()
    }

    /// Mean rotation of a joint against the trunk, where that is straight.
    fn in_trunk(&self, joint: usize) -> Quat {
        let turns = self.trunk.iter();
        mean(turns.map(|(f, trunk)| trunk.inverse() * self.motion.deltas(*f)[joint]))
            .unwrap_or_default()
    }

    /// Trunk, head and collars: the mean against the trunk, corrected by what a body at rest has in
    /// common with others.
    fn trunk(&mut self) {
        for joint in 0..self.rest.len() {
            let title = self.rest.title(joint);
            let bare = title
                .strip_prefix("l_")
                .or_else(|| title.strip_prefix("r_"));
            let collar = matches!(bare, Some("sternoclavicular" | "acromioclavicular"));
            let middle = !title.is_empty() && bare.is_none() && title != "temporomandibular";
            if collar || middle {
                self.turns[joint] = Some(self.in_trunk(joint));
            }
        }
        self.pelvis();
        self.spine();
        self.collars();
    }

    /// The hips are level and look ahead.
    fn pelvis(&mut self) {
        let [left, right] = [self.body.legs[0].hip, self.body.legs[1].hip];
        for joint in [self.body.root, self.body.pelvis] {
            let ways = [left, right].map(|hip| self.way(joint, hip));
            if let [Some(left), Some(right)] = ways {
                self.set(joint, left - right, None, [Vec3::X, Vec3::Z]);
            }
        }
    }

    /// Spines and necks of few joints rise as in rest poses of other figures; the curve of one of
    /// many joints is a matter of the rig.
    fn spine(&mut self) {
        let Some(top) = self.rest.spine_top() else {
            return;
        };
        let path = self.rest.between(self.body.root, top).unwrap_or_default();
        let is_vertebra = |j: &usize| self.rest.title(*j).starts_with('v');
        let chain: Vec<usize> = path.into_iter().filter(is_vertebra).chain([top]).collect();
        let is_of_neck = |j: usize| self.rest.title(j).starts_with("vc");
        for (i, pair) in chain.windows(2).enumerate() {
            let [joint, next] = [pair[0], pair[1]];
            let same = |j: &&usize| is_of_neck(**j) == is_of_neck(joint);
            let most = if is_of_neck(joint) {
                NECK_JOINTS
            } else {
                SPINE_JOINTS
            };
            if chain[..chain.len() - 1].iter().filter(same).count() > most {
                continue;
            }
            let lean = if is_of_neck(joint) || is_of_neck(next) {
                NECK_LEAN
            } else if i == 0 {
                LUMBAR_LEAN
            } else {
                0.0
            };
            if let Some(along) = self.way(joint, next) {
                self.set(joint, along, None, [Vec3::new(0.0, 1.0, lean), Vec3::Z]);
            }
        }
    }

    /// Collars rise with the arms, so that their mean is not neutral; at rest they are level.
    fn collars(&mut self) {
        for (side, outward) in [('l', Vec3::X), ('r', -Vec3::X)] {
            let [collar, second, shoulder] = ["sternoclavicular", "acromioclavicular", "shoulder"]
                .map(|name| self.rest.sided(side, name));
            let Some((first, next)) = collar
                .or(second)
                .zip(second.filter(|_| collar.is_some()).or(shoulder))
            else {
                continue;
            };
            if let Some(along) = self.way(first, next) {
                self.set(first, along, None, [outward, Vec3::Z]);
            }
            if let (Some(collar), Some(second)) = (collar, second) {
                let turn = self.turns[collar].unwrap_or_default();
                self.turns[second] = Some((turn * self.relative(collar, second)).normalize());
            }
        }
    }

    /// Sets a joint of a limb so that `along` and `front`, directions in its own space, point where
    /// they do in the standing pose; without a front the joint keeps its mean twist.
    fn set(&mut self, joint: usize, along: Vec3, front: Option<Vec3>, to: [Vec3; 2]) {
        let turn = match front {
            Some(front) => basis(to[0], to[1]) * basis(along, front).inverse(),
            None => {
                let near = self.in_trunk(joint);
                Quat::from_rotation_arc(
                    (near * along).normalize_or(to[0]),
                    to[0].normalize_or(Vec3::Y),
                ) * near
            }
        };
        self.turns[joint] = Some(turn.normalize());
    }

    fn leg(&mut self, side: char) {
        let leg = self.body.legs[usize::from(side == 'r')];
        let Some((knee, ankle)) = leg.knee.zip(leg.ankle) else {
            self.straight(leg.hip, leg.knee.or(leg.ankle), -Vec3::Y);
            return;
        };
        let to = [-Vec3::Y, Vec3::Z];
        let by_toes = self.toe_fronts(leg);
        let bent = self.hinge([leg.hip, knee, ankle], -1.0);
        // Knees that are overstretched seem to bend forward.
        let agrees = |bent: &[Vec3; 2]| by_toes.is_none_or(|toes| bent[0].dot(toes[0]) > 0.0);
        let fronts = bent.filter(agrees).or(by_toes);
        self.hinged([leg.hip, knee, ankle], fronts, to);
        self.foot(leg, ankle);
    }

    /// A foot as it lies on the floor, with its toes ahead.
    fn foot(&mut self, leg: Leg, ankle: usize) {
        let ahead = leg.toe.and_then(|toe| Some((toe, self.way(ankle, toe)?)));
        let Some((toe, ahead)) = ahead else {
            // Without toes, the mean on the shin is all there is.
            let above = leg.knee.unwrap_or(leg.hip);
            let turn = self.turns[above].unwrap_or_default() * self.relative(above, ankle);
            self.turns[ankle] = Some(turn);
            self.assumed.push((ankle, Assumed::Orientation));
            return;
        };
        let flat = self.flat_frames(ankle, toe);
        let up: Vec3 = flat
            .iter()
            .map(|f| self.motion.deltas(*f)[ankle].inverse() * Vec3::Y)
            .sum();
        let shown = up.try_normalize().filter(|_| flat.len() >= FLAT_FRAMES);
        let (turn, frames) = match shown {
            Some(up) => (basis(Vec3::Y, Vec3::Z) * basis(up, ahead).inverse(), flat),
            None => {
                let slope = Vec3::new(0.0, -FOOT_SLOPE, 1.0);
                let shin = leg.knee.and_then(|knee| self.way(ankle, knee));
                let up = shin.unwrap_or(Vec3::Y);
                let turn = basis(slope, Vec3::Y) * basis(ahead, up).inverse();
                (turn, (0..self.motion.frames()).collect())
            }
        };
        let relative = frames.iter().map(|f| {
            let turns = self.motion.deltas(*f);
            turns[ankle].inverse() * turns[toe]
        });
        let relative = mean(relative).unwrap_or_default();
        self.turns[ankle] = Some(turn.normalize());
        self.turns[toe] = Some((turn * relative).normalize());
    }

    /// Frames in which ankle and toes both rest at their lowest, or at least are there.
    fn flat_frames(&self, ankle: usize, toe: usize) -> Vec<usize> {
        let resting = |joint: usize| {
            let path: Vec<Vec3> = (0..self.motion.frames())
                .map(|f| self.motion.positions(f)[joint])
                .collect();
            contacts::contacts(&path, self.motion, self.body.leg_metres, self.low(joint))
        };
        let on = [resting(ankle), resting(toe)];
        let rests = |f: &usize| {
            on.iter()
                .all(|c| c.iter().any(|c| c.on_floor && c.frames.contains(f)))
        };
        let resting: Vec<usize> = (0..self.motion.frames()).filter(rests).collect();
        if resting.len() >= FLAT_FRAMES {
            return resting;
        }
        // A walk in place drags its feet along the floor.
        let most = LOW * self.body.leg_metres;
        let [low_ankle, low_toe] = [ankle, toe].map(|joint| self.low(joint));
        let is_low = |f: &usize| {
            let at = self.motion.positions(*f);
            at[ankle].y < low_ankle + most && at[toe].y < low_toe + most
        };
        (0..self.motion.frames()).filter(is_low).collect()
    }

    /// Height of a joint when it is lowest.
    fn low(&self, joint: usize) -> f32 {
        let frames = 0..self.motion.frames();
        let mut heights: Vec<f32> = frames.map(|f| self.motion.positions(f)[joint].y).collect();
        heights.sort_by(f32::total_cmp);
        let at = (LOWEST * heights.len() as f32) as usize;
        heights.get(at).copied().unwrap_or(0.0)
    }

    fn arm(&mut self, side: char) {
        let outward = if side == 'l' { Vec3::X } else { -Vec3::X };
        let [shoulder, elbow, wrist] =
            ["shoulder", "elbow", "wrist"].map(|name| self.rest.sided(side, name));
        let to = [outward, Vec3::Z];
        match [shoulder, elbow, wrist] {
            [Some(shoulder), Some(elbow), Some(wrist)] => {
                let joints = [shoulder, elbow, wrist];
                self.hinged(joints, self.hinge(joints, 1.0), to);
                self.hand(side, elbow, wrist, to);
            }
            [Some(shoulder), next, other] => self.straight(shoulder, next.or(other), outward),
            _ => {}
        }
    }

    /// The hand by its knuckles, or by its mean on the forearm; fingers straight ahead.
    fn hand(&mut self, side: char, elbow: usize, wrist: usize, to: [Vec3; 2]) {
        let knuckles = self.rest.knuckles(side).into_iter();
        let places: Vec<Vec3> = knuckles
            .filter_map(|joint| self.way(wrist, joint))
            .collect();
        let ahead = places.iter().sum::<Vec3>();
        let on_forearm = self.turns[elbow].unwrap_or_default() * self.relative(elbow, wrist);
        let turn = if places.len() > 1 {
            let thumb_side = places[0] - places[places.len() - 1];
            basis(to[0], to[1]) * basis(ahead, thumb_side).inverse()
        } else if let Some(ahead) = ahead.try_normalize() {
            self.assumed.push((wrist, Assumed::Twist));
            Quat::from_rotation_arc(on_forearm * ahead, to[0]) * on_forearm
        } else {
            self.assumed.push((wrist, Assumed::Orientation));
            on_forearm
        };
        self.turns[wrist] = Some(turn.normalize());
        for name in ["thumb", "index", "middle", "ring", "pinky"] {
            let along = if name == "thumb" {
                (to[0] + to[1]).normalize()
            } else {
                to[0]
            };
            let joints: Vec<usize> = (1..=3)
                .filter_map(|d| self.rest.sided(side, &format!("{name}{d}")))
                .collect();
            for pair in joints.windows(2) {
                self.finger(wrist, pair[0], pair[1], along);
            }
        }
    }

    fn finger(&mut self, wrist: usize, joint: usize, next: usize, to: Vec3) {
        let near = self.turns[wrist].unwrap_or_default() * self.relative(wrist, joint);
        let along = self.way(joint, next).map(|way| near * way);
        let arc = along.and_then(Vec3::try_normalize);
        let turn = arc.map_or(near, |is| Quat::from_rotation_arc(is, to) * near);
        self.turns[joint] = Some(turn.normalize());
    }

    /// A limb without its middle or its end.
    fn straight(&mut self, joint: usize, next: Option<usize>, to: Vec3) {
        self.assumed.push((joint, Assumed::Twist));
        if let Some(along) = next.and_then(|next| self.way(joint, next)) {
            self.set(joint, along, None, [to, Vec3::Z]);
        }
    }

    fn hinged(&mut self, joints: [usize; 3], fronts: Option<[Vec3; 2]>, to: [Vec3; 2]) {
        let [upper, middle, end] = joints;
        for (i, (joint, next)) in [(upper, middle), (middle, end)].into_iter().enumerate() {
            let Some(along) = self.way(joint, next) else {
                continue;
            };
            if fronts.is_none() {
                self.assumed.push((joint, Assumed::Twist));
            }
            self.set(joint, along, fronts.map(|fronts| fronts[i]), to);
        }
    }

    /// Fronts of both segments of a limb, in the spaces of their joints, from the bends of the
    /// motion; `None` if these are too slight or point everywhere.
    fn hinge(&self, [upper, middle, end]: [usize; 3], sign: f32) -> Option<[Vec3; 2]> {
        let (mut sums, mut total) = ([Vec3::ZERO; 2], 0.0);
        for f in 0..self.motion.frames() {
            let (at, turns) = (self.motion.positions(f), self.motion.deltas(f));
            let first = (at[middle] - at[upper]).normalize_or_zero();
            let second = (at[end] - at[middle]).normalize_or_zero();
            let cosine = first.dot(second);
            let bends = [second - first * cosine, second * cosine - first];
            for (sum, (bend, joint)) in sums.iter_mut().zip(bends.into_iter().zip([upper, middle]))
            {
                *sum += sign * (turns[joint].inverse() * bend) * bend.length();
            }
            total += bends[0].length_squared();
        }
        let frames = self.motion.frames() as f32;
        let enough = total > ENOUGH * ENOUGH * frames;
        let steady = sums.iter().all(|sum| sum.length() > STEADY * total);
        (enough && steady).then_some(sums)
    }

    /// Fronts of both segments of a leg by the direction of its foot.
    fn toe_fronts(&self, leg: Leg) -> Option<[Vec3; 2]> {
        let (knee, ankle, toe) = (leg.knee?, leg.ankle?, leg.toe?);
        let mut sums = [Vec3::ZERO; 2];
        for f in 0..self.motion.frames() {
            let (at, turns) = (self.motion.positions(f), self.motion.deltas(f));
            let shin = (at[ankle] - at[knee]).normalize_or_zero();
            let foot = (at[toe] - at[ankle]).normalize_or_zero();
            let front = foot - shin * shin.dot(foot);
            for (sum, joint) in sums.iter_mut().zip([leg.hip, knee]) {
                *sum += turns[joint].inverse() * front;
            }
        }
        sums.iter().all(|s| s.length() > 1e-3).then_some(sums)
    }

    /// Gives every other joint its mean against its parent, and places all.
    fn finish(mut self) -> StandingPose {
        let count = self.rest.len();
        let mut turns: Vec<Quat> = Vec::with_capacity(count);
        let mut positions: Vec<Vec3> = Vec::with_capacity(count);
        for joint in 0..count {
            let parent = self.rest.parents[joint];
            let turn = self.turns[joint].unwrap_or_else(|| match parent {
                Some(parent) => turns[parent] * self.relative(parent, joint),
                None => self.in_trunk(joint),
            });
            turns.push(turn.normalize());
            let place = parent.map_or(Vec3::ZERO, |parent| {
                let way = self.way(parent, joint).unwrap_or_default();
                positions[parent] + turns[parent] * way
            });
            positions.push(place);
        }
        let middle = self.body.middle(&positions);
        for place in &mut positions {
            *place -= middle;
        }
        self.assumed.sort_by_key(|u| u.0);
        StandingPose {
            turns,
            positions,
            assumed: self.assumed,
        }
    }
}
