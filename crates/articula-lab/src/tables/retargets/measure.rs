//! Quality of a motion measured from its poses alone, independently of the retargeting code.

use anyhow::Result;
use articula::CharacterFile;
use articula_build::source_rate_hz;
use articula_core::source::{RawClip, evaluate};
use articula_core::{LocalPose, ModelPose, Rig, angle_between, local_to_model};
use glam::Vec3;
use std::ops::Range;

/// Maximum speed of a planted foot, metres per second on a leg of one metre.
const REST_SPEED: f32 = 0.2;
/// Maximum height above its lowest position, metres on a leg of one metre.
const REST_HEIGHT: f32 = 0.06;
/// Maximum distance from its first position, metres on a leg of one metre: slow motion is no
/// contact.
const REST_METRES: f32 = 0.03;
/// Minimum duration of a contact, seconds.
const REST_SECS: f32 = 0.15;
/// Sine of the angle by which a straight knee may appear to bend forward.
const WRONG_SINE: f32 = 0.1;

/// Joints that can represent the toes, the best first.
const TOES: [&str; 3] = ["metatarsal", "midtarsal", "ankle"];

/// A clip, evaluated frame by frame.
pub(super) struct Played {
    pub(super) rig: Rig,
    pub(super) locals: Vec<LocalPose>,
    pub(super) models: Vec<ModelPose>,
    pub(super) rate_hz: f32,
}

/// A contact of a foot: name of the measured joint, and frames.
pub(super) type Contact = (String, Range<usize>);

impl Played {
    /// Evaluates a clip at a rate.
    pub(super) fn new(actor: &CharacterFile, clip: &RawClip, rate_hz: f32) -> Result<Self> {
        let skeleton = &actor.character().skeleton;
        let rig = Rig::new(skeleton, actor.articulation())?;
        let frames = (clip.duration_secs * rate_hz).round() as usize + 1;
        let (mut locals, mut models) = (Vec::new(), Vec::new());
        for frame in 0..frames {
            let mut local = rig.rest_pose().clone();
            evaluate::pose(clip, skeleton, frame as f32 / rate_hz, &mut local);
            let mut model = ModelPose::new(rig.len());
            local_to_model(&rig, &local, &mut model);
            locals.push(local);
            models.push(model);
        }
        Ok(Self {
            rig,
            locals,
            models,
            rate_hz,
        })
    }

    /// Evaluates a clip at its own rate.
    pub(super) fn of(actor: &CharacterFile, clip: &RawClip) -> Result<Self> {
        Self::new(actor, clip, source_rate_hz(clip))
    }

    /// Maximum angular speed of a mapped joint relative to its parent: its name, degrees per
    /// second.
    pub(super) fn fastest(&self) -> (String, f32) {
        let joints = &self.rig.articulation().joints;
        let mut worst = (String::new(), 0.0);
        for pair in self.locals.windows(2) {
            for (j, joint) in joints.iter().enumerate() {
                let Some(name) = &joint.hanim else { continue };
                let turn = angle_between(pair[0].rotations[j], pair[1].rotations[j]);
                let speed = turn.to_degrees() * self.rate_hz;
                if speed > worst.1 {
                    worst = (name.clone(), speed);
                }
            }
        }
        worst
    }

    /// Contacts of each foot, measured at the foremost joint that the other figure has too.
    pub(super) fn contacts(&self, other: &Self) -> Vec<Contact> {
        let mut contacts = Vec::new();
        let leg = self.leg_metres();
        let least = (REST_SECS * self.rate_hz).ceil() as usize;
        for side in 0..2 {
            let names = TOES.map(|name| named(side, name));
            let both = |name: &&String| other.joint(name).is_some() && self.joint(name).is_some();
            let Some(name) = names.iter().find(both) else {
                continue;
            };
            let Some(toe) = self.joint(name) else {
                continue;
            };
            let at = |f: usize| self.models[f].position(toe);
            let mut heights: Vec<f32> = (0..self.models.len()).map(|f| at(f).y).collect();
            heights.sort_by(f32::total_cmp);
            let low = heights[heights.len() / 20];
            let rests = |f: usize| {
                let next = (f + 1).min(self.models.len() - 1);
                let speed = at(f).distance(at(next)) * self.rate_hz;
                speed < REST_SPEED * leg && at(f).y < low + REST_HEIGHT * leg
            };
            let mut start = None;
            for f in 0..=self.models.len() {
                let on = f < self.models.len() && rests(f);
                match start {
                    None if on => start = Some(f),
                    Some(first) if !on => {
                        let far = (first..f).map(|g| at(g).distance(at(first)));
                        let far = far.fold(0.0, f32::max);
                        if f - first >= least && far < REST_METRES * leg {
                            contacts.push((name.clone(), first..f));
                        }
                        start = None;
                    }
                    _ => {}
                }
            }
        }
        contacts
    }

    /// Mean over contacts of the maximum distance of the toes from their first position, in
    /// millimetres over the ground; `None` without contacts.
    pub(super) fn slide_mm(&self, contacts: &[Contact]) -> Option<f32> {
        let slide = |(name, frames): &Contact| {
            let toe = self.joint(name)?;
            let at = |f: usize| self.models.get(f).map(|m| m.position(toe));
            let start = at(frames.start)?;
            let far = frames.clone().filter_map(at).map(|p| {
                let way = p - start;
                way.x.hypot(way.z)
            });
            far.reduce(f32::max)
        };
        let slides: Vec<f32> = contacts.iter().filter_map(slide).collect();
        let sum: f32 = slides.iter().sum();
        (!slides.is_empty()).then(|| 1000.0 * sum / slides.len() as f32)
    }

    /// Fraction of frames and sides in which a knee bends forward: the rotation of the shank
    /// against the thigh about the line from the right to the left hip.
    pub(super) fn knees_wrong_share(&self) -> f32 {
        let find = |name: &str| self.joint(name);
        let hips = find("l_hip").zip(find("r_hip"));
        let Some((left, right)) = hips else {
            return 0.0;
        };
        let (mut wrong, mut all) = (0, 0);
        for model in &self.models {
            let across = model.position(left) - model.position(right);
            let Some(across) = across.try_normalize() else {
                continue;
            };
            for side in 0..2 {
                let names = [
                    named(side, "hip"),
                    named(side, "knee"),
                    named(side, "ankle"),
                ];
                let [Some(hip), Some(knee), Some(ankle)] = names.map(|n| find(&n)) else {
                    continue;
                };
                let thigh = model.position(knee) - model.position(hip);
                let shank = model.position(ankle) - model.position(knee);
                let bend = thigh.normalize_or_zero().cross(shank.normalize_or_zero());
                wrong += usize::from(bend.dot(across) < -WRONG_SINE);
                all += 1;
            }
        }
        wrong as f32 / all.max(1) as f32
    }

    fn leg_metres(&self) -> f32 {
        let rest = &self.models[0];
        let place = |name: &str| self.joint(name).map(|j| rest.position(j));
        let length = |a: Option<Vec3>, b: Option<Vec3>| Some(a?.distance(b?));
        let thigh = length(place("l_hip"), place("l_knee"));
        let shank = length(place("l_knee"), place("l_ankle"));
        thigh.zip(shank).map_or(1.0, |(a, b)| a + b)
    }

    fn joint(&self, name: &str) -> Option<usize> {
        self.rig.articulation().find(name)
    }
}

fn named(side: usize, name: &str) -> String {
    format!("{}_{name}", ["l", "r"][side])
}
