//! Conversion of any humanoid's motion to body animation parameters.
//!
//! The target of each standard joint is the model-space rotation of the rig's joint since rest.
//! From parents to children it is split into the rotations that the joint has: three represent it
//! exactly, two or one approximate it as closely as possible. A child starts from its parent's
//! actual rotation, so it compensates for the parent's residual, and an ankle leaves the foot's
//! roll to the subtalar joint. For knees and elbows positions take precedence over rotations, see
//! `bap_limb`.
//!
//! A rotation since rest means the same on two bodies only if their rest poses agree, so figures
//! whose limbs do not hang like the standard's are an error.

use super::bap::{BAPS, BapClip, BapFrame};
use super::bap_body::{METRES, RADIANS, rotation, shifts};
use super::bap_limb::{Limb, limbs};
use super::bap_split::{near, split};
use super::bap_table;
use crate::Limits;
use crate::sampled::{self, Place};
use crate::written::WriteError;
use articula_core::Articulation;
use articula_core::Libm;
use articula_core::hanim_table::{BODY_JOINTS, JOINTS, find};
use articula_core::source::Character;
use glam::{DQuat, Vec3};
use thiserror::Error;

/// Maximum angle between a limb at rest and the standard's.
const APART_DEGREES: f32 = 30.0;
/// Residuals below this are rounding.
const ROUNDING_RADIANS: f32 = 1e-4;
/// Ends of the limbs whose directions are compared.
const LIMBS: [(&str, &str); 8] = [
    ("l_shoulder", "l_elbow"),
    ("l_elbow", "l_wrist"),
    ("l_hip", "l_knee"),
    ("l_knee", "l_ankle"),
    ("r_shoulder", "r_elbow"),
    ("r_elbow", "r_wrist"),
    ("r_hip", "r_knee"),
    ("r_knee", "r_ankle"),
];

/// Joints that rotate the foot together: the ankle bends and twists it, the other one rolls it.
const FEET: [(&str, &str); 2] = [("l_ankle", "l_subtalar"), ("r_ankle", "r_subtalar")];

/// Difference between a joint's rotation and its target, due to missing parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BapResidual {
    /// H-Anim name of the joint.
    pub joint: &'static str,
    /// Largest angle over the frames.
    pub max_radians: f32,
    /// Mean angle over the frames.
    pub mean_radians: f32,
}

/// A motion as parameters, and the rotations that they could not represent.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledBap {
    /// The motion, 186 values per frame, numbered from 0.
    pub clip: BapClip,
    /// Joints with a residual above rounding, the largest first.
    pub residuals: Vec<BapResidual>,
}

/// Reason why a motion cannot be expressed as body animation parameters.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BapError {
    /// The clip does not exist, or the rate is not a positive number.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The clip has more frames than a reader accepts.
    #[error("{found} frames, the limit is {limit}")]
    TooLong {
        /// Number of frames at the requested rate.
        found: u64,
        /// Maximum number of frames.
        limit: u64,
    },
    /// No joint is known to be the root of the humanoid.
    #[error("no joint is mapped to humanoid_root; BAP animates humanoids only")]
    NoRoot,
    /// The articulation belongs to another skeleton.
    #[error("{found} joints in the articulation, {expected} in the skeleton")]
    Articulation {
        /// Number of joints of the articulation.
        found: usize,
        /// Number of joints of the skeleton.
        expected: usize,
    },
    /// The rest pose of the figure differs from the standard's.
    #[error(
        "the rest rotation of {joint} differs by {degrees:.0} degrees from the standard humanoid \
         with hanging arms, to which BAP angles are relative"
    )]
    Rest {
        /// H-Anim name of the joint above the limb.
        joint: &'static str,
        /// Angle between the limb and the standard's.
        degrees: f32,
    },
}

/// Converts a clip to body animation parameters at a rate.
///
/// # Errors
/// [`BapError`] if the clip does not exist, the character is not a humanoid, or its rest pose
/// differs from the standard's.
pub fn sample(
    character: &Character,
    articulation: &Articulation,
    clip: usize,
    rate_hz: f32,
) -> Result<SampledBap, BapError> {
    let clip = WriteError::clip(character, clip)?;
    WriteError::check(&[("rate_hz", rate_hz)])?;
    let last = (f64::from(clip.duration_secs.max(0.0)) * f64::from(rate_hz)).round() as u64;
    let limit = Limits::default().frames;
    if last >= limit {
        let found = last.saturating_add(1);
        return Err(BapError::TooLong { found, limit });
    }
    let body = Body::new(character, articulation)?;
    let mut state = State::default();
    let mut frames = Vec::new();
    sampled::each_frame(&character.skeleton, clip, rate_hz, |places| {
        let number = frames.len() as u32;
        let values = body.values(places, &mut state);
        frames.push(BapFrame { number, values });
    });
    let clip = BapClip {
        name: clip.name.clone(),
        rate_hz,
        coded: vec![true; BAPS],
        frames,
    };
    Ok(SampledBap {
        residuals: state.residuals(clip.frames.len()),
        clip,
    })
}

/// A joint to convert: its rotation parameters, and the rig's joint that gives the target.
struct Told {
    turns: Vec<(usize, Vec3)>,
    source: Option<usize>,
}

/// The humanoid of a character.
struct Body {
    /// Transforms of the rig's joints at rest.
    rest: Vec<Place>,
    root: usize,
    /// One entry for each body joint of the standard.
    joints: Vec<Told>,
    /// Limbs of which the rig has both joints.
    limbs: Vec<Limb>,
    /// Ankles, and the joint that rolls the foot of each.
    feet: Vec<(usize, usize)>,
    shifts: Vec<(usize, Vec3)>,
}

impl Body {
    fn new(character: &Character, articulation: &Articulation) -> Result<Self, BapError> {
        let joints = &character.skeleton.joints;
        let (found, expected) = (articulation.joints.len(), joints.len());
        if found != expected {
            return Err(BapError::Articulation { found, expected });
        }
        let source = |name: &str| {
            let mut names = articulation.joints.iter().map(|j| j.hanim.as_deref());
            names.position(|known| known == Some(name))
        };
        let root = source(JOINTS[0].name).ok_or(BapError::NoRoot)?;
        let rest = sampled::rest(&character.skeleton);
        for (above, below) in LIMBS {
            let (Some(a), Some(b)) = (source(above), source(below)) else {
                continue;
            };
            let degrees = apart_degrees(rest[b].position - rest[a].position, limb(above, below));
            if degrees > APART_DEGREES {
                let joint = above;
                return Err(BapError::Rest { joint, degrees });
            }
        }
        let told = JOINTS[..BODY_JOINTS].iter().map(|joint| Told {
            turns: bap_table::turns(joint.name),
            source: source(joint.name),
        });
        let joints: Vec<Told> = told.collect();
        let has = |joint: usize| joints[joint].source.is_some();
        let limbs = limbs().into_iter();
        Ok(Self {
            limbs: limbs.filter(|l| has(l.upper) && has(l.hinge)).collect(),
            feet: FEET
                .iter()
                .filter_map(|(ankle, roll)| Some((find(ankle)?, find(roll)?)))
                .collect(),
            joints,
            shifts: shifts(JOINTS[0].name),
            rest,
            root,
        })
    }

    /// Returns the parameters of one frame from the transforms of its joints.
    fn values(&self, places: &[Place], state: &mut State) -> Vec<i32> {
        let mut values = vec![0; BAPS];
        let moved = places[self.root].position - self.rest[self.root].position;
        for (index, axis) in &self.shifts {
            values[*index] = (f64::from(moved.dot(*axis)) / METRES).round() as i32;
        }
        let wanted = self.wanted(places);
        let mut goals = wanted.clone();
        for limb in &self.limbs {
            goals[limb.upper] = limb.aimed(wanted[limb.upper], wanted[limb.hinge]);
        }
        let mut shown: Vec<DQuat> = Vec::with_capacity(BODY_JOINTS);
        for (joint, told) in self.joints.iter().enumerate() {
            let parent = JOINTS[joint].parent.map_or(DQuat::IDENTITY, |p| shown[p]);
            let angles = self.angles(joint, parent, (&wanted, &goals), state);
            state.last[joint] = angles;
            for ((index, _), angle) in told.turns.iter().zip(angles) {
                values[*index] = (angle / RADIANS).round() as i32;
            }
            let turned = (parent * rotation(&told.turns, &values)).normalize();
            if told.source.is_some() {
                state.off[joint].add(turned.angle_between(wanted[joint]) as f32);
            }
            shown.push(turned);
        }
        values
    }

    /// Returns the angles of one joint, given its parent's actual rotation.
    fn angles(
        &self,
        joint: usize,
        parent: DQuat,
        (wanted, goals): (&[DQuat], &[DQuat]),
        state: &State,
    ) -> [f64; 3] {
        let last = state.last[joint];
        let turns = &self.joints[joint].turns;
        if let Some((_, roll)) = self.feet.iter().find(|(ankle, _)| *ankle == joint) {
            let all = [&turns[..], &self.joints[*roll].turns].concat();
            let last = [last[0], last[1], state.last[*roll][0]];
            let [bend, twist, _] = split(parent.inverse() * wanted[*roll], &all, last);
            return [bend, twist, 0.0];
        }
        let target = parent.inverse() * goals[joint];
        let [bend, twist, third] = split(target, turns, last);
        match self.limbs.iter().find(|limb| limb.hinge == joint) {
            Some(limb) => near([limb.bend_angle(target, twist), twist, third], last),
            None => [bend, twist, third],
        }
    }

    /// Returns the target rotation since rest of each joint, in model space; a joint that the rig
    /// lacks follows its parent.
    fn wanted(&self, places: &[Place]) -> Vec<DQuat> {
        let mut wanted: Vec<DQuat> = Vec::with_capacity(BODY_JOINTS);
        for (joint, told) in self.joints.iter().enumerate() {
            let parent = JOINTS[joint].parent.map_or(DQuat::IDENTITY, |p| wanted[p]);
            let own = told.source.map(|source| {
                let turn = places[source].rotation * self.rest[source].rotation.inverse();
                turn.as_dquat().normalize()
            });
            wanted.push(own.unwrap_or(parent));
        }
        wanted
    }
}

/// State carried from frame to frame, for each body joint of the standard.
struct State {
    /// Angles of the previous frame, to which the next ones stay close.
    last: Vec<[f64; 3]>,
    off: Vec<Off>,
}

/// Residual angles of a joint.
#[derive(Debug, Clone, Copy, Default)]
struct Off {
    max: f32,
    sum: f64,
}

impl Off {
    fn add(&mut self, angle: f32) {
        self.max = self.max.max(angle);
        self.sum += f64::from(angle);
    }
}

impl Default for State {
    fn default() -> Self {
        Self {
            last: vec![[0.0; 3]; BODY_JOINTS],
            off: vec![Off::default(); BODY_JOINTS],
        }
    }
}

impl State {
    fn residuals(&self, frames: usize) -> Vec<BapResidual> {
        let all = JOINTS
            .iter()
            .zip(&self.off)
            .map(|(joint, off)| BapResidual {
                joint: joint.name,
                max_radians: off.max,
                mean_radians: (off.sum / frames.max(1) as f64) as f32,
            });
        let mut list: Vec<BapResidual> = all.filter(|r| r.max_radians > ROUNDING_RADIANS).collect();
        list.sort_by(|a, b| b.max_radians.total_cmp(&a.max_radians));
        list
    }
}

/// Returns the direction of a limb of the standard humanoid.
fn limb(above: &str, below: &str) -> Vec3 {
    let center = |name: &str| find(name).map_or(Vec3::ZERO, |j| JOINTS[j].center);
    center(below) - center(above)
}

fn apart_degrees(a: Vec3, b: Vec3) -> f32 {
    let (Some(a), Some(b)) = (a.try_normalize(), b.try_normalize()) else {
        return 0.0;
    };
    a.dot(b).clamp(-1.0, 1.0).libm_acos().to_degrees()
}

#[cfg(test)]
#[allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a test reads files and prints what it skips"
)]
mod tests;
