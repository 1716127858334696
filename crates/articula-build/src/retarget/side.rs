//! One of the two rigs, with its measurements.

use super::RetargetFigure;
use super::body::Body;
use super::chain::Chain;
use super::frames::{Frames, Fronts, frames};
use super::motion::Motion;
use super::rest::Rest;
use super::standing::stands;
use super::standing_pose::{self, StandingPose};
use articula_core::{Mismatch, angle_between};
use glam::Quat;

/// Frames per second at which the motions of a figure are read to find its standing pose, and the
/// number of frames after which no other clip is read.
const SAMPLE_HZ: f32 = 30.0;
const SAMPLE_FRAMES: usize = 6000;
/// Minimum share of the mapped joints that are alike in two figures of the same rig.
const SAME_RIG: f32 = 0.9;

/// A rig with the measurements that the plan uses.
#[derive(Debug, Clone)]
pub(super) struct Side {
    pub(super) rest: Rest,
    pub(super) body: Body,
    pub(super) frames: Frames,
    pub(super) spine: Chain,
    /// The standing pose that counts as the rest pose, if that of the file is none.
    pub(super) found: Option<StandingPose>,
}

impl Side {
    pub(super) fn new(figure: &RetargetFigure<'_>, which: &str) -> Result<Self, Mismatch> {
        Self::at_rest(Rest::new(figure, which)?, which)
    }

    /// Measures a figure in the pose that counts as its rest.
    fn at_rest(rest: Rest, which: &str) -> Result<Self, Mismatch> {
        let body = Body::new(&rest, which)?;
        Ok(Self {
            frames: frames(&rest, &body, &Fronts::new()),
            spine: Chain::new(&rest, &body),
            rest,
            body,
            found: None,
        })
    }

    /// Whether the rest pose is that of a standing figure.
    pub(super) fn stands(&self) -> bool {
        stands(&self.rest, &self.body)
    }

    /// The same figure in a standing pose, found from its motions or, if it has none, from the rest
    /// pose alone.
    pub(super) fn standing(
        &self,
        figure: &RetargetFigure<'_>,
        which: &str,
    ) -> Result<Self, Mismatch> {
        let read = |clip| Motion::new(clip, figure.skeleton, &self.rest, Some(SAMPLE_HZ)).ok();
        let mut motions = figure.clips.iter().filter_map(read);
        let mut motion = motions.next().unwrap_or_else(|| Motion::still(&self.rest));
        while motion.frames() < SAMPLE_FRAMES
            && let Some(next) = motions.next()
        {
            motion.append(next);
        }
        let found = standing_pose::from_motion(&self.rest, &self.body, &motion);
        let rest = self.rest.posed(&found.turns, &found.positions);
        Ok(Self {
            found: Some(found),
            ..Self::at_rest(rest, which)?
        })
    }

    /// Joints whose local rotation differs from that of the file's rest pose.
    pub(super) fn reposed(&self) -> impl Iterator<Item = usize> + '_ {
        let turns = self.found.as_ref().map_or(&[][..], |found| &found.turns);
        let above = |j: usize| self.rest.parents[j].map_or(Quat::IDENTITY, |p| turns[p]);
        let is_turned = move |j: &usize| angle_between(turns[*j], above(*j)) > 1e-6;
        (0..turns.len()).filter(is_turned)
    }

    /// Whether both figures have the same rig, with one rest pose: then whatever is unknown of one
    /// is so of the other.
    pub(super) fn is_of_rig(&self, other: &Self) -> bool {
        let mapped = |j: &usize| self.rest.hanim[*j].is_some();
        let joints: Vec<usize> = (0..self.rest.len()).filter(mapped).collect();
        let twin = |j: usize| other.rest.find(self.rest.title(j));
        let is_alike = |j: &&usize| twin(**j).is_some_and(|t| self.alike(**j, other, t));
        let alike = joints.iter().filter(is_alike).count();
        alike as f32 >= SAME_RIG * joints.len() as f32
    }

    /// The same figure with fronts of limbs detected in a motion.
    pub(super) fn with_fronts(&self, seen: &Fronts) -> Self {
        let mut side = self.clone();
        side.frames = frames(&self.rest, &self.body, seen);
        side
    }

    /// Whether a joint has the same name in both figures and, up to size, the same place at rest
    /// among its parent and children: then whatever is ambiguous in one is equally so in the other.
    pub(super) fn alike(&self, joint: usize, other: &Self, theirs: usize) -> bool {
        let (a, b) = (&self.rest, &other.rest);
        let near = |own: [usize; 2], their: [usize; 2]| {
            let own = self.body.axes.inverse() * a.way(own[0], own[1]).normalize_or_zero();
            let their = other.body.axes.inverse() * b.way(their[0], their[1]).normalize_or_zero();
            own.distance(their) < 1e-3
        };
        let parents = a.parents[joint].zip(b.parents[theirs]);
        let below = a.children(joint).all(|child| {
            let twin = b.children(theirs).find(|c| b.names[*c] == a.names[child]);
            twin.is_none_or(|twin| near([joint, child], [theirs, twin]))
        });
        a.names[joint] == b.names[theirs]
            && parents.is_none_or(|(p, q)| near([p, joint], [q, theirs]))
            && below
    }
}
