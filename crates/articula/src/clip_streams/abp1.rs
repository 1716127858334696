//! The motion of a character as ABP-1, and back.
//!
//! Form: `docs/formats/abp1.md`. In ABP-1 all joints have the axes of the figure at rest, as in
//! H-Anim, so that joint centres alone describe the skeleton. A rotation there is that of the joint
//! against its rest, seen in these axes.

use crate::error::{Error, Result};
use articula_build::sampling_rate_hz;
use articula_core::LibmQuat;
use articula_core::loa::MAX_LEVEL;
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, Skeleton, evaluate,
};
use articula_core::{Articulation, LocalPose, Region, Transform};
use articula_formats::Warning;
use articula_stream::FrameRate;
use articula_stream::abp1::{Abp1Clip, Abp1Options, Bone, BoneTracks, Track, TrackKind};
use glam::{Affine3A, Quat, Vec3};
use std::f32::consts::TAU;

/// Difference from rest below which nothing is written: half the finest step.
const STILL: f32 = 0.5e-4;
/// Ratio of two scales of a joint below which they count as equal.
const EVEN: f32 = 1e-4;
/// Angle of axes of scale beyond which they count as turned, in radians: ten times the finest step.
const TURNED: f32 = 1e-3;
/// Maximum number of frames.
const MAX_FRAMES: f64 = (1 << 20) as f64;

/// Returns a clip of a character in the form of ABP-1, sampled at a rate that follows its keys.
///
/// Bones are the joints of the skeleton, with the same numbers. Motion of morph targets and
/// expressions is left out. Joints below one whose rest pose is scaled differently along its axes
/// move only approximately as in the character.
///
/// # Errors
/// An [`Error`] if the clip does not exist, or its rate or length cannot be written.
pub fn from_character(
    character: &Character,
    articulation: &Articulation,
    clip: usize,
) -> Result<Abp1Clip> {
    let skeleton = &character.skeleton;
    let Some(clip) = character.clips.get(clip) else {
        return Err(Error::unsuited("clips: the file has no clip to write"));
    };
    let hz = f64::from(sampling_rate_hz(clip, skeleton));
    let rate = FrameRate::nearest(hz).ok_or_else(|| {
        Error::unsuited(format!(
            "clip \"{}\": {hz} frames per second; ABP-1 holds 1/16 to 255, resample the clip",
            clip.name
        ))
    })?;
    let frames = (f64::from(clip.duration_secs.max(0.0)) * rate.hz()).round() + 1.0;
    if frames > MAX_FRAMES {
        let what = format!("clip \"{}\": more than 2^20 frames", clip.name);
        return Err(Error::unsuited(what));
    }
    let frames = frames as usize;
    let rest = RestAxes::of(skeleton);
    let mut sampled: Vec<[Track; 3]> = vec![Default::default(); skeleton.joints.len()];
    let mut pose = rest_pose(skeleton);
    for frame in 0..frames {
        let secs = (frame as f64 / rate.hz()) as f32;
        evaluate::pose(clip, skeleton, secs, &mut pose);
        for (joint, tracks) in sampled.iter_mut().enumerate() {
            let value = rest.relative(skeleton, joint, pose.get(joint));
            let before = tracks[1].last().copied().unwrap_or_default();
            tracks[0].push(value.translation.to_array());
            tracks[1].push(unwrapped(value.rotation, before.into()).to_array());
            tracks[2].push(value.scale.to_array());
        }
    }
    let tracks = sampled.into_iter().enumerate();
    Ok(Abp1Clip {
        name: clip.name.clone(),
        bones: bones(skeleton, articulation, &rest),
        rate,
        frames,
        tracks: tracks
            .map(|(joint, tracks)| moving(tracks, rest.turns[joint]))
            .collect(),
    })
}

/// Encodes a clip of a character as an ABP-1 file.
///
/// # Errors
/// As [`from_character`], and if a value is not finite or too great for the step.
pub fn write(
    character: &Character,
    articulation: &Articulation,
    clip: usize,
    options: &Abp1Options,
) -> Result<Vec<u8>> {
    let clip = from_character(character, articulation, clip)?;
    Ok(articula_stream::abp1::write(&clip, options)?)
}

/// The frames of joints at rest in the axes of the figure.
struct RestAxes {
    model: Vec<Affine3A>,
    /// Rotation of each joint.
    turns: Vec<Quat>,
}

impl RestAxes {
    fn of(skeleton: &Skeleton) -> Self {
        let model = skeleton.model_rest();
        let turn = |m: &Affine3A| {
            let (_, turn, _) = m.to_scale_rotation_translation();
            let is_whole = turn.is_finite() && turn.length() > 0.5;
            if is_whole {
                turn.normalize()
            } else {
                Quat::IDENTITY
            }
        };
        Self {
            turns: model.iter().map(turn).collect(),
            model,
        }
    }

    /// A local transform against that at rest, in the axes of the figure; the scale is along the
    /// joint's own axes.
    fn relative(&self, skeleton: &Skeleton, joint: usize, local: Transform) -> Transform {
        let Joint { parent, rest, .. } = skeleton.joints[joint];
        let moved = local.translation - rest.translation;
        let turned = local.rotation * rest.rotation.conjugate();
        let (moved, turned) = match parent {
            None => (moved, turned),
            Some(parent) => {
                let axes = self.turns[parent];
                (
                    self.model[parent].transform_vector3(moved),
                    axes * turned * axes.conjugate(),
                )
            }
        };
        let ratio = local.scale / rest.scale;
        Transform {
            translation: moved,
            rotation: turned.normalize(),
            scale: if ratio.is_finite() { ratio } else { Vec3::ONE },
        }
    }
}

fn rest_pose(skeleton: &Skeleton) -> LocalPose {
    skeleton.joints.iter().map(|joint| joint.rest).collect()
}

/// Of the rotation vectors of a rotation, the one nearest to another vector.
fn unwrapped(rotation: Quat, before: Vec3) -> Vec3 {
    let shortest = articula_core::rotation_vector(Quat::IDENTITY, rotation);
    let angle = shortest.length();
    let axis = if angle > 1e-6 {
        shortest / angle
    } else {
        before.normalize_or_zero()
    };
    let turns = ((before.dot(axis) - angle) / TAU).round();
    shortest + axis * (turns * TAU)
}

/// The tracks of a joint that differ from rest; `turn` is its orientation at rest.
fn moving([translation, rotation, scale]: [Track; 3], turn: Quat) -> BoneTracks {
    let differs = |track: &Track, rest: f32| {
        let mut values = track.iter().flatten();
        values.any(|value| (value - rest).abs() > STILL)
    };
    let mut tracks = BoneTracks::default();
    if differs(&translation, 0.0) {
        tracks = tracks.with(TrackKind::Translation, translation);
    }
    if differs(&rotation, 0.0) {
        tracks = tracks.with(TrackKind::Rotation, rotation);
    }
    if differs(&scale, 1.0) {
        let axes = unwrapped(turn, Vec3::ZERO);
        if !scale.iter().all(|s| is_even((*s).into())) && axes.length() > STILL {
            let axes = vec![axes.to_array(); scale.len()];
            tracks = tracks.with(TrackKind::ScaleOrientation, axes);
        }
        tracks = tracks.with(TrackKind::Scale, scale);
    }
    tracks
}

/// Whether a scale is the same along all axes.
fn is_even(scale: Vec3) -> bool {
    scale.max_element() - scale.min_element() <= EVEN * scale.abs().max_element()
}

fn bones(skeleton: &Skeleton, articulation: &Articulation, rest: &RestAxes) -> Vec<Bone> {
    let joints = skeleton.joints.iter().zip(&articulation.joints);
    let joints = joints.zip(&rest.model);
    joints
        .map(|((joint, of_joint), model)| Bone {
            name: joint.name.clone(),
            parent: joint.parent.map(|p| p as u16),
            center: model.translation.to_array(),
            loa: of_joint.level,
            // Regions are numbered from 1.
            region: of_joint.region as u8 + 1,
        })
        .collect()
}

/// Returns the character of an ABP-1 clip: the skeleton of its bone table, and the clip. Joints have
/// the axes of the figure at rest, those that are scaled the axes of scale. Warnings name what a joint
/// cannot do.
pub fn to_character(clip: &Abp1Clip) -> (Character, Vec<Warning>) {
    let bones = &clip.bones;
    let axes: Vec<Quat> = clip.tracks.iter().map(scale_axes).collect();
    let above = |bone: &Bone| match bone.parent.map(usize::from) {
        None => (Vec3::ZERO, Quat::IDENTITY),
        Some(p) => (bones[p].center.into(), axes[p].conjugate()),
    };
    let joint = |(bone, own): (&Bone, &Quat)| {
        let (from, into_parent) = above(bone);
        Joint {
            name: bone.name.clone(),
            parent: bone.parent.map(usize::from),
            rest: Transform {
                translation: into_parent * (Vec3::from(bone.center) - from),
                rotation: into_parent * *own,
                scale: Vec3::ONE,
            },
            in_skin: true,
        }
    };
    let skeleton = Skeleton {
        joints: bones.iter().zip(&axes).map(joint).collect(),
    };
    let secs = |frame: usize| (frame as f64 / clip.rate.hz()) as f32;
    let times_secs: Vec<f32> = (0..clip.frames).map(secs).collect();
    let mut raw = RawClip {
        name: clip.name.clone(),
        duration_secs: times_secs.last().copied().unwrap_or(0.0),
        channels: Vec::new(),
    };
    let mut turning = 0;
    if clip.frames > 0 {
        for (target, tracks) in clip.tracks.iter().enumerate() {
            let bone = &bones[target];
            let joint = Moving {
                bone,
                into_parent: above(bone).1,
                axes: axes[target],
                rest: skeleton.joints[target].rest.translation,
                tracks,
            };
            turning += usize::from(joint.has_turning_axes());
            raw.channels.extend(joint.channels(target, &times_secs));
        }
    }
    let warning = |what: String| Warning {
        at: "bones".to_owned(),
        what,
        guess: None,
    };
    let warnings = (turning > 0).then(|| {
        warning(format!(
            "{turning} are scaled along axes that turn, which a joint cannot be; they are scaled \
             along the first ones"
        ))
    });
    let character = Character {
        name: clip.name.clone(),
        skeleton,
        clips: vec![raw],
        ..Character::default()
    };
    (character, warnings.into_iter().collect())
}

/// The first axes of scale that are not those of the figure.
fn scale_axes(tracks: &BoneTracks) -> Quat {
    let track = tracks.get(TrackKind::ScaleOrientation);
    let mut values = track.into_iter().flatten().map(|axes| Vec3::from(*axes));
    let first = values.find(|axes| axes.length() > STILL);
    first.map_or(Quat::IDENTITY, LibmQuat::libm_scaled_axis)
}

/// Sets level and region of joints as the bone table has them; other region numbers than 1 to 7
/// change nothing.
pub(crate) fn set_articulation(bones: &[Bone], articulation: &mut Articulation) {
    for (bone, joint) in bones.iter().zip(&mut articulation.joints) {
        joint.level = bone.loa.min(MAX_LEVEL);
        let number = usize::from(bone.region);
        let region = number.checked_sub(1).and_then(|n| Region::ALL.get(n));
        joint.region = region.copied().unwrap_or(joint.region);
    }
}

/// A bone whose tracks become channels.
struct Moving<'a> {
    bone: &'a Bone,
    /// Rotation from the axes of the figure into those of the parent at rest.
    into_parent: Quat,
    /// Its own axes at rest.
    axes: Quat,
    /// Translation at rest.
    rest: Vec3,
    tracks: &'a BoneTracks,
}

impl Moving<'_> {
    fn value(&self, kind: TrackKind, frame: usize) -> Vec3 {
        let track = self.tracks.get(kind);
        let value = track.map_or(kind.rest(self.bone), |track| track[frame]);
        value.into()
    }

    fn has(&self, kind: TrackKind) -> bool {
        self.tracks.get(kind).is_some()
    }

    /// Whether it is scaled differently along axes that are not always the same.
    fn has_turning_axes(&self) -> bool {
        let Some(track) = self.tracks.get(TrackKind::ScaleOrientation) else {
            return false;
        };
        (0..track.len()).any(|frame| {
            let axes = Quat::libm_scaled_axis(self.value(TrackKind::ScaleOrientation, frame));
            let turned = articula_core::angle_between(self.axes, axes);
            turned > TURNED && !is_even(self.value(TrackKind::Scale, frame))
        })
    }

    fn channels(&self, target: usize, times_secs: &[f32]) -> Vec<Channel> {
        let mut channels = Vec::new();
        let mut add = |property, value: &dyn Fn(Transform) -> Vec<f32>| {
            let frames = 0..times_secs.len();
            channels.push(Channel {
                target,
                property,
                interpolation: Interpolation::Linear,
                times_secs: times_secs.to_vec(),
                values: frames.flat_map(|f| value(self.local(f))).collect(),
            });
        };
        if self.has(TrackKind::Translation) || self.has(TrackKind::Center) {
            add(Property::Translation, &|t| {
                t.translation.to_array().to_vec()
            });
        }
        if self.has(TrackKind::Rotation) {
            add(Property::Rotation, &|t| t.rotation.to_array().to_vec());
        }
        if self.has(TrackKind::Scale) {
            add(Property::Scale, &|t| t.scale.to_array().to_vec());
        }
        channels
    }

    /// The local transform in a frame.
    fn local(&self, frame: usize) -> Transform {
        let turn = Quat::libm_scaled_axis(self.value(TrackKind::Rotation, frame));
        let rotation = turn * self.axes;
        let scale = self.value(TrackKind::Scale, frame);
        // About another centre than that of the table, rotation and scale also move the joint.
        let center = self.value(TrackKind::Center, frame) - Vec3::from(self.bone.center);
        let scaled = rotation * (scale * (self.axes.conjugate() * center));
        let moved = self.value(TrackKind::Translation, frame) + center - scaled;
        Transform {
            translation: self.rest + self.into_parent * moved,
            rotation: (self.into_parent * rotation).normalize(),
            scale,
        }
    }
}
