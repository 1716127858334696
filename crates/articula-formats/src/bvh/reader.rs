//! Conversion of the text of a BVH file to a character in metres, +Y up.

use super::hierarchy::{self, Channel, Hierarchy, RawJoint};
use super::motion::{self, Motion};
use crate::capture_text::capture_text;
use crate::error::{Parsed, ReadError, Warning};
use crate::limits::Limits;
use crate::motion_file::{MotionFile, ReadOptions};
use crate::units;
use articula_core::LibmQuat;
use articula_core::source::{self, Character, Interpolation, Joint, Property, RawClip, Skeleton};
use articula_core::{Transform, same_hemisphere};
use glam::{Quat, Vec3};

/// Reads a BVH file. Rest rotations are the identity; rotations are keyed for every joint with
/// rotation channels, translations for every joint with position channels.
///
/// # Errors
/// [`ReadError::Malformed`] naming the line, what was found and what was expected;
/// [`ReadError::LimitExceeded`].
pub fn read(
    bytes: &[u8],
    options: &ReadOptions,
    limits: &Limits,
) -> Result<Parsed<MotionFile>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let mut warnings = Vec::new();
    let text = capture_text(bytes, |odd| warnings.push(odd));
    let (hierarchy, odd) = hierarchy::parse(&text, limits)?;
    warnings.extend(odd);
    let channels = hierarchy.joints.iter().map(|j| j.channels.len()).sum();
    let mut motion = Motion::default();
    if let Some(line) = hierarchy.motion_line {
        let (read, odd) = motion::parse(&text, line, channels, limits)?;
        motion = read;
        warnings.extend(odd);
    }
    let raw = Raw {
        first_value: first_values(&hierarchy.joints),
        hierarchy,
        motion,
        channels,
    };
    let basis = raw.basis(options, &mut warnings)?;
    Ok(Parsed {
        value: raw.file(&basis),
        warnings,
    })
}

/// A joint whose distance from its parent changes by more than this factor is not at the end of a
/// bone.
const MOVES: f32 = 1.1;

/// Conversion of file space to metres with +Y up.
struct Basis {
    scale: f32,
    /// Rotation of the figure, and of everything below the roots.
    figure: Quat,
    /// Rotation of the world that the roots move in.
    world: Quat,
}

struct Raw {
    hierarchy: Hierarchy,
    motion: Motion,
    channels: usize,
    /// Index of each joint's first value in a frame.
    first_value: Vec<usize>,
}

fn first_values(joints: &[RawJoint]) -> Vec<usize> {
    let mut next = 0;
    let mut first = Vec::with_capacity(joints.len());
    for joint in joints {
        first.push(next);
        next += joint.channels.len();
    }
    first
}

impl Raw {
    fn local(&self, frame: usize, joint: usize) -> (Vec3, Quat) {
        let raw = &self.hierarchy.joints[joint];
        let first = frame * self.channels + self.first_value[joint];
        let mut position = raw.offset;
        let mut rotation = Quat::IDENTITY;
        for (channel, value) in raw.channels.iter().zip(&self.motion.values[first..]) {
            match channel {
                Channel::Position(axis) => position[*axis] = *value,
                Channel::Rotation(axis) => {
                    rotation *= Quat::libm_axis_angle(Vec3::AXES[*axis], value.to_radians());
                }
            }
        }
        (position, rotation.normalize())
    }

    fn rest_positions(&self) -> Vec<Vec3> {
        let mut positions: Vec<Vec3> = Vec::with_capacity(self.hierarchy.joints.len());
        for joint in &self.hierarchy.joints {
            let parent = joint.parent.map_or(Vec3::ZERO, |p| positions[p]);
            positions.push(parent + joint.offset);
        }
        positions
    }

    /// Returns the length of the bone that leads to a joint; 0 if it is a root, or its position
    /// channels move it away from its parent. Such channels replace the offset, which may be zero.
    fn bone_length(&self, joint: usize) -> f32 {
        let raw = &self.hierarchy.joints[joint];
        let moves = |c: &Channel| matches!(c, Channel::Position(_));
        if raw.parent.is_none() {
            return 0.0;
        }
        if self.motion.frames == 0 || !raw.channels.iter().any(moves) {
            return raw.offset.length();
        }
        let frames = units::frames_looked_at(self.motion.frames);
        let lengths = frames.map(|frame| self.local(frame, joint).0.length());
        let (short, long) = lengths.fold((f32::MAX, 0.0_f32), |(s, l), v| (s.min(v), l.max(v)));
        if long > MOVES * short { 0.0 } else { short }
    }

    fn basis(
        &self,
        options: &ReadOptions,
        warnings: &mut Vec<Warning>,
    ) -> Result<Basis, ReadError> {
        let rest = self.rest_positions();
        let joints = &self.hierarchy.joints;
        let chain_at = |frame: usize, chain: &[usize]| {
            let (mut point, mut root) = (Vec3::ZERO, Vec3::ZERO);
            for &joint in chain {
                let (position, rotation) = self.local(frame, joint);
                point = position + rotation * point;
                root = position;
            }
            (point, root)
        };
        let turns = |c: &Channel| matches!(c, Channel::Rotation(_));
        let turns = |j: &RawJoint| j.parent.is_none() && j.channels.iter().any(turns);
        let motion = joints.iter().any(turns).then_some(units::Motion {
            frames: self.motion.frames,
            head_and_root: &chain_at,
        });
        let figure = units::Figure {
            names: joints.iter().map(|j| j.name.as_str()).collect(),
            parents: joints.iter().map(|j| j.parent).collect(),
            places: rest,
            lengths: (0..joints.len()).map(|j| self.bone_length(j)).collect(),
            ends: self.hierarchy.end_sites.clone(),
        };
        let (figure_z, world_z) = figure.has_z_up(options.up, motion, warnings);
        let guess = || units::scale(figure.size(figure_z));
        let scale = units::scale_to_metres(options.scale_to_metres, guess, warnings)?;
        let z_up = |z: bool| if z { units::y_from_z() } else { Quat::IDENTITY };
        Ok(Basis {
            scale,
            figure: z_up(figure_z),
            world: z_up(world_z),
        })
    }

    fn file(&self, basis: &Basis) -> MotionFile {
        let offset = |v: Vec3| basis.figure * v * basis.scale;
        let joint = |raw: &RawJoint| Joint {
            name: raw.name.clone(),
            parent: raw.parent,
            rest: Transform::from_translation(offset(raw.offset)),
            in_skin: true,
        };
        let sites = self.hierarchy.end_sites.iter();
        MotionFile {
            character: Character {
                skeleton: Skeleton {
                    joints: self.hierarchy.joints.iter().map(joint).collect(),
                },
                clips: self.clip(basis).into_iter().collect(),
                ..Character::default()
            },
            end_sites: sites.map(|(j, v)| (*j, offset(*v))).collect(),
            frame_time_secs: self.motion.frame_time_secs,
        }
    }

    fn clip(&self, basis: &Basis) -> Option<RawClip> {
        let time = |frame: usize| (frame as f64 * f64::from(self.motion.frame_time_secs)) as f32;
        let times_secs: Vec<f32> = (0..self.motion.frames).map(time).collect();
        let duration_secs = *times_secs.last()?;
        let mut channels = Vec::new();
        for joint in 0..self.hierarchy.joints.len() {
            let keyed = |property, values: Vec<f32>| source::Channel {
                target: joint,
                property,
                interpolation: Interpolation::Linear,
                times_secs: times_secs.clone(),
                values,
            };
            let (translations, rotations) = self.keys(basis, joint);
            let has = |wanted: fn(&Channel) -> bool| {
                self.hierarchy.joints[joint].channels.iter().any(wanted)
            };
            if has(|c| matches!(c, Channel::Position(_))) {
                channels.push(keyed(Property::Translation, translations));
            }
            if has(|c| matches!(c, Channel::Rotation(_))) {
                channels.push(keyed(Property::Rotation, rotations));
            }
        }
        Some(RawClip {
            name: "motion".to_owned(),
            duration_secs,
            channels,
        })
    }

    /// Returns a joint's translations and rotations, flattened, frame by frame.
    fn keys(&self, basis: &Basis, joint: usize) -> (Vec<f32>, Vec<f32>) {
        let is_root = self.hierarchy.joints[joint].parent.is_none();
        let above = if is_root { basis.world } else { basis.figure };
        let mut last = Quat::IDENTITY;
        let mut translations = Vec::with_capacity(3 * self.motion.frames);
        let mut rotations = Vec::with_capacity(4 * self.motion.frames);
        for frame in 0..self.motion.frames {
            let (position, rotation) = self.local(frame, joint);
            translations.extend((above * position * basis.scale).to_array());
            last = same_hemisphere(
                last,
                (above * rotation * basis.figure.inverse()).normalize(),
            );
            rotations.extend(last.to_array());
        }
        (translations, rotations)
    }
}
