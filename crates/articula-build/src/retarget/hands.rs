//! Retargeting of hands alone: captures of one or two hands without a body, onto a whole figure.
//!
//! The hands are attached to the wrists of the target, which stands still, in the direction and size
//! of its own; that figure is retargeted as any other. Of the result only the hands are kept: the
//! motion of the wrists belongs to arms that the capture does not have.

use super::frames::basis;
use super::rest::Rest;
use super::{RetargetFigure, RetargetOptions, Retargeted, Retargeter, RotationOrigin};
use crate::clip::source_rate_hz;
use articula_core::source::{Channel, Interpolation, Joint, Property, RawClip, Skeleton, evaluate};
use articula_core::{Articulation, LocalPose, Mismatch, Transform, same_hemisphere};
use glam::{Affine3A, Mat4, Quat, Vec3};

/// Maximum number of frames that are read from a clip of hands.
const MAX_FRAMES: f32 = 100_000.0;

/// Returns whether a figure has a hand with knuckles and no body.
pub fn is_hands_alone(figure: &RetargetFigure<'_>) -> bool {
    let Ok(rest) = Rest::new(figure, "source") else {
        return false;
    };
    rest.find("humanoid_root").is_none() && sides(&rest).count() > 0
}

/// Retargets a clip of one or two hands alone to the hands of a whole figure.
///
/// # Errors
/// A [`Mismatch`] as from [`Retargeter::new`] and [`Retargeter::retarget`], or if the figures have no
/// hand in common.
pub fn retarget_hands(
    hands: &RetargetFigure<'_>,
    body: &RetargetFigure<'_>,
    clip: &RawClip,
    options: &RetargetOptions,
) -> Result<Retargeted, Mismatch> {
    let (own, target) = (Rest::new(hands, "source")?, Rest::new(body, "target")?);
    let graft = Graft::new(&own, &target, body)?;
    let moved = graft.clip(hands.skeleton, clip);
    let figure = RetargetFigure {
        skeleton: &graft.skeleton,
        articulation: &graft.articulation,
        clips: &[],
    };
    let mut made = Retargeter::new(figure, *body)?.retarget(&moved, options)?;
    let below = |joint: usize| {
        let wrists = graft.wrists.iter();
        wrists
            .into_iter()
            .any(|wrist| target.between(*wrist, joint).is_some())
    };
    made.clip.channels.retain(|channel| below(channel.target));
    made.clip.name.clone_from(&clip.name);
    made.report.scale = graft.joints[0].scale;
    for report in &mut made.report.joints {
        report.moved &= below(report.joint);
        let origin = std::mem::replace(&mut report.origin, RotationOrigin::Held);
        report.origin = graft.origin(origin);
    }
    let dropped = std::mem::take(&mut made.report.dropped);
    let dropped = dropped.into_iter().filter_map(|joint| graft.of_hand(joint));
    made.report.dropped = dropped.collect();
    Ok(made)
}

/// Sides whose hand has at least two knuckles.
fn sides(rest: &Rest) -> impl Iterator<Item = char> + '_ {
    ['l', 'r']
        .into_iter()
        .filter(|side| palm(rest, *side).is_some())
}

/// Orientation and length of a hand at rest: X from the wrist to the knuckles, Y to the thumb's
/// side.
fn palm(rest: &Rest, side: char) -> Option<(Quat, f32)> {
    let wrist = rest.sided(side, "wrist")?;
    let knuckles = ["index", "middle", "ring", "pinky"].map(|name| {
        [1, 2, 0]
            .iter()
            .find_map(|digit| rest.sided(side, &format!("{name}{digit}")))
    });
    let ways: Vec<Vec3> = knuckles
        .into_iter()
        .flatten()
        .map(|joint| rest.way(wrist, joint))
        .collect();
    let ahead = ways.iter().sum::<Vec3>() / ways.len().max(1) as f32;
    let across = *ways.first()? - *ways.last()?;
    let enough = ahead.length() > 1e-5 && across.length() > 0.05 * ahead.length();
    enough.then(|| (basis(ahead, across), ahead.length()))
}

/// The target's body with the hands of the source.
struct Graft {
    skeleton: Skeleton,
    articulation: Articulation,
    /// For each joint from `first` on, its index in the source.
    joints: Vec<Attached>,
    first: usize,
    /// Wrists of the target that got a hand.
    wrists: Vec<usize>,
}

/// A joint of a hand, attached to the body.
struct Attached {
    /// Index in the source.
    joint: usize,
    /// The joint that it hangs from in the source: the nearest one of the hand, or the wrist.
    above: usize,
    /// Rotation and scale from the source's wrist to the target's, for joints on the wrist.
    turn: Quat,
    scale: f32,
}

impl Graft {
    fn new(own: &Rest, target: &Rest, body: &RetargetFigure<'_>) -> Result<Self, Mismatch> {
        let mut graft = Self {
            skeleton: body.skeleton.clone(),
            articulation: body.articulation.clone(),
            joints: Vec::new(),
            first: target.len(),
            wrists: Vec::new(),
        };
        for side in sides(own) {
            graft.attach(own, target, side);
        }
        if graft.wrists.is_empty() {
            let what = "no hand of the source has a hand with knuckles in the target";
            return Err(Mismatch::new("source", what));
        }
        Ok(graft)
    }

    fn attach(&mut self, own: &Rest, target: &Rest, side: char) {
        let palms = palm(own, side).zip(palm(target, side));
        let wrists = own.sided(side, "wrist").zip(target.sided(side, "wrist"));
        let (Some(((a, a_length), (b, b_length))), Some((wrist, onto))) = (palms, wrists) else {
            return;
        };
        self.wrists.push(onto);
        // The target's own hand is no longer the hand of that side.
        for joint in 0..target.len() {
            if target.between(onto, joint).is_some() {
                self.articulation.joints[joint].hanim = None;
            }
        }
        // Both palms in the spaces of their wrists.
        let a = own.rotations[wrist].inverse() * a;
        let b = target.rotations[onto].inverse() * b;
        let (turn, scale) = (b * a.inverse(), b_length / a_length);
        let is_of_hand = |joint: usize| {
            let title = own.title(joint);
            title.starts_with(side) && joint != wrist
        };
        for joint in (0..own.len()).filter(|j| is_of_hand(*j)) {
            let mut above = own.parents[joint];
            while let Some(j) = above.filter(|j| !is_of_hand(*j)) {
                above = own.parents[j];
            }
            let at = above.and_then(|above| self.joints.iter().position(|a| a.joint == above));
            let attached = Attached {
                joint,
                above: above.unwrap_or(wrist),
                turn: if at.is_some() { Quat::IDENTITY } else { turn },
                scale,
            };
            let rest = attached.local(&own.matrices);
            self.skeleton.joints.push(Joint {
                name: own.names[joint].clone(),
                parent: Some(at.map_or(onto, |at| self.first + at)),
                rest,
                in_skin: false,
            });
            let mut known = self.articulation.joints[onto].clone();
            known.hanim.clone_from(&own.hanim[joint]);
            self.articulation.joints.push(known);
            self.joints.push(attached);
        }
    }

    /// The clip of the source on the attached joints.
    fn clip(&self, skeleton: &Skeleton, clip: &RawClip) -> RawClip {
        let steps = (clip.duration_secs * source_rate_hz(clip)).round();
        let steps = if steps.is_finite() {
            steps.clamp(0.0, MAX_FRAMES)
        } else {
            0.0
        };
        let times: Vec<f32> = (0..=steps as usize)
            .map(|i| clip.duration_secs * (i as f32 / steps.max(1.0)))
            .collect();
        let mut local: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
        let mut model = vec![Affine3A::IDENTITY; skeleton.joints.len()];
        let mut keys = vec![Vec::with_capacity(4 * times.len()); self.joints.len()];
        let mut last = vec![Quat::IDENTITY; self.joints.len()];
        for time in &times {
            evaluate::pose(clip, skeleton, *time, &mut local);
            for (j, joint) in skeleton.joints.iter().enumerate() {
                let own = local.get(j).to_affine();
                model[j] = joint.parent.map_or(own, |p| model[p] * own);
            }
            for (i, attached) in self.joints.iter().enumerate() {
                last[i] = same_hemisphere(last[i], attached.local(&model).rotation);
                keys[i].extend(last[i].to_array());
            }
        }
        let channel = |(i, values): (usize, Vec<f32>)| Channel {
            target: self.first + i,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: times.clone(),
            values,
        };
        RawClip {
            name: clip.name.clone(),
            duration_secs: clip.duration_secs,
            channels: keys.into_iter().enumerate().map(channel).collect(),
        }
    }

    /// Index in the source of a joint of the grafted figure; `None` for the body.
    fn of_hand(&self, joint: usize) -> Option<usize> {
        let at = joint.checked_sub(self.first)?;
        self.joints.get(at).map(|attached| attached.joint)
    }

    fn origin(&self, origin: RotationOrigin) -> RotationOrigin {
        match origin {
            RotationOrigin::Mapped { source } => match self.of_hand(source) {
                Some(source) => RotationOrigin::Mapped { source },
                None => RotationOrigin::Held,
            },
            RotationOrigin::Shared { sources } => {
                let of_hand = |(joint, share)| Some((self.of_hand(joint)?, share));
                let sources: Vec<(usize, f32)> = sources.into_iter().filter_map(of_hand).collect();
                if sources.is_empty() {
                    RotationOrigin::Held
                } else {
                    RotationOrigin::Shared { sources }
                }
            }
            RotationOrigin::Held => RotationOrigin::Held,
        }
    }
}

impl Attached {
    /// Transform relative to what the joint hangs from, given the source's model-space matrices.
    fn local(&self, model: &[Affine3A]) -> Transform {
        let local = model[self.above].inverse() * model[self.joint];
        let local = Transform::from_matrix(Mat4::from(local)).unwrap_or(Transform::IDENTITY);
        Transform {
            rotation: (self.turn * local.rotation).normalize(),
            translation: self.turn * (self.scale * local.translation),
            ..Transform::IDENTITY
        }
    }
}
