//! Retargeting of hands alone: captures of one or two hands without a body, onto a whole figure.
//!
//! The hands are attached to the wrists of the target, which stands still, in the direction and size
//! of its own; that figure is retargeted as any other. Of the result only the hands are kept: the
//! motion of the wrists belongs to arms that the capture does not have.

use super::frames::basis;
use super::motion::Motion;
use super::rest::Rest;
use super::{RetargetFigure, RetargetOptions, Retargeted, Retargeter, RotationOrigin};
use articula_core::source::{Channel, Interpolation, Joint, Property, RawClip, Skeleton};
use articula_core::{Articulation, Mismatch, Transform, same_hemisphere};
use glam::{Quat, Vec3};

/// Joints of an arm, without the letter of its side.
const ARM: [&str; 5] = [
    "_sternoclavicular",
    "_acromioclavicular",
    "_shoulder",
    "_elbow",
    "_wrist",
];

/// Returns whether a figure has a hand with knuckles and no body.
pub fn is_hands_alone(figure: &RetargetFigure<'_>) -> bool {
    let Ok(rest) = Rest::new(figure, "source") else {
        return false;
    };
    rest.find("humanoid_root").is_none() && sides(&rest).count() > 0
}

/// Retargets a clip of one or two hands alone to the hands of a whole figure. Only joints below the
/// wrists have channels in the result; [`RetargetReport::scale`](super::RetargetReport::scale) is
/// the size of the target's hand over that of the source.
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
    let motion = Motion::new(clip, hands.skeleton, &own, options.rate_hz)?;
    let moved = graft.clip(&own, &motion, clip.duration_secs);
    let figure = RetargetFigure {
        skeleton: &graft.skeleton,
        articulation: &graft.articulation,
        clips: &[],
    };
    let mut made = Retargeter::new(figure, *body)?.retarget(&moved, options)?;
    let below = |joint: usize| {
        let mut wrists = graft.wrists.iter();
        wrists.any(|wrist| target.between(*wrist, joint).is_some())
    };
    made.clip.channels.retain(|channel| below(channel.target));
    made.clip.name.clone_from(&clip.name);
    made.report.scale = graft.scale;
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
    let knuckles = rest.knuckles(side).into_iter();
    let ways: Vec<Vec3> = knuckles.map(|joint| rest.way(wrist, joint)).collect();
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
    /// Size of the target's hand over that of the source; of the last hand, if there are two.
    scale: f32,
    /// Wrists of the target that got a hand.
    wrists: Vec<usize>,
}

/// A joint of a hand, attached to the body.
struct Attached {
    /// Index in the source.
    joint: usize,
    /// The joint that it hangs from in the source: the nearest one of the hand, or the wrist.
    above: usize,
    /// Rotation from the source's wrist to the target's, for joints on the wrist.
    turn: Quat,
}

impl Graft {
    fn new(own: &Rest, target: &Rest, body: &RetargetFigure<'_>) -> Result<Self, Mismatch> {
        let mut graft = Self {
            skeleton: body.skeleton.clone(),
            articulation: body.articulation.clone(),
            joints: Vec::new(),
            first: target.len(),
            scale: 1.0,
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
        // A rig of hands may have arms, and the joints of a hand need not be below its wrist.
        let is_of_hand = |joint: usize| {
            let name = own.title(joint).strip_prefix(side);
            name.is_some_and(|name| !ARM.contains(&name))
        };
        self.scale = scale;
        let start = self.joints.len();
        for joint in (0..own.len()).filter(|j| is_of_hand(*j)) {
            let mut above = own.parents[joint];
            while let Some(j) = above.filter(|j| *j != wrist && !is_of_hand(*j)) {
                above = own.parents[j];
            }
            let hung = &self.joints[start..];
            let at = hung.iter().position(|a| Some(a.joint) == above);
            let at = at.map(|at| start + at);
            let attached = Attached {
                joint,
                above: above.unwrap_or(wrist),
                turn: if at.is_some() { Quat::IDENTITY } else { turn },
            };
            let local = own.rotations[attached.above].inverse() * own.rotations[joint];
            let place = own.matrices[attached.above].inverse() * own.matrices[joint];
            self.skeleton.joints.push(Joint {
                name: own.names[joint].clone(),
                parent: Some(at.map_or(onto, |at| self.first + at)),
                rest: Transform {
                    rotation: (attached.turn * local).normalize(),
                    translation: attached.turn * (scale * Vec3::from(place.translation)),
                    ..Transform::IDENTITY
                },
                in_skin: false,
            });
            let mut known = self.articulation.joints[onto].clone();
            known.hanim.clone_from(&own.hanim[joint]);
            self.articulation.joints.push(known);
            self.joints.push(attached);
        }
    }

    /// A motion of the source as a clip of the attached joints.
    fn clip(&self, own: &Rest, motion: &Motion, duration_secs: f32) -> RawClip {
        let turn = |frame: usize, joint: usize| motion.deltas(frame)[joint] * own.rotations[joint];
        let channel = |(i, attached): (usize, &Attached)| {
            let mut last = Quat::IDENTITY;
            let keys = (0..motion.frames()).flat_map(|frame| {
                let local = turn(frame, attached.above).inverse() * turn(frame, attached.joint);
                last = same_hemisphere(last, (attached.turn * local).normalize());
                last.to_array()
            });
            Channel {
                target: self.first + i,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                values: keys.collect(),
                times_secs: motion.times_secs.clone(),
            }
        };
        RawClip {
            name: String::new(),
            duration_secs,
            channels: self.joints.iter().enumerate().map(channel).collect(),
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
