//! From the text of a BVH file to a character in metres, +Y up.

use super::hierarchy::{self, Channel, Hierarchy, RawJoint};
use super::motion::{self, Motion};
use super::units::{self, Up};
use crate::error::{Read, ReadError, Warning};
use crate::limits::Limits;
use articula_core::math::{Transform, same_hemisphere};
use articula_core::source::{self, Character, Clip, Interpolation, Joint, Property, Skeleton};
use glam::{Quat, Vec3};

/// Frames that are looked at to tell which way is up.
const FRAMES_LOOKED_AT: usize = 32;

/// What the file does not say.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadOptions {
    /// Metres of one unit; guessed from the figure's height without it.
    pub scale_to_metres: Option<f32>,
    /// The axis that points up.
    pub up: Up,
}

/// What a BVH file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BvhFile {
    /// Skeleton and at most one clip, called `motion`; every joint is `in_skin`.
    pub character: Character,
    /// Joint and offset of each end site, in metres of the joint's space.
    pub end_sites: Vec<(usize, Vec3)>,
    /// Seconds from frame to frame; 0 without motion.
    pub frame_time_secs: f32,
}

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
) -> Result<Read<BvhFile>, ReadError> {
    Limits::check("file", "bytes", bytes.len() as u64, limits.bytes)?;
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let (hierarchy, mut warnings) = hierarchy::parse(text, limits)?;
    let channels = hierarchy.joints.iter().map(|j| j.channels.len()).sum();
    let mut motion = Motion::default();
    if let Some(line) = hierarchy.motion_line {
        let (read, odd) = motion::parse(text, line, channels, limits)?;
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
    Ok(Read {
        value: raw.file(&basis),
        warnings,
    })
}

/// How file space becomes metres with +Y up.
struct Basis {
    scale: f32,
    /// Turns the figure, and everything below the roots.
    figure: Quat,
    /// Turns the world that the roots move in.
    world: Quat,
}

struct Raw {
    hierarchy: Hierarchy,
    motion: Motion,
    channels: usize,
    /// Of each joint, in a frame's values.
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
                    rotation *= Quat::from_axis_angle(Vec3::AXES[*axis], value.to_radians());
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

    fn basis(
        &self,
        options: &ReadOptions,
        warnings: &mut Vec<Warning>,
    ) -> Result<Basis, ReadError> {
        let z_up = |z: bool| if z { units::y_from_z() } else { Quat::IDENTITY };
        let (figure, world) = match options.up {
            Up::Y => (false, false),
            Up::Z => (true, true),
            Up::Auto => self.stands_along_z(),
        };
        if options.up == Up::Auto && world {
            let which = if figure {
                "the figure and its world"
            } else {
                "the world of the motion"
            };
            let what =
                format!("+Z is up; {which} were turned to +Y; give the up axis if that is wrong");
            warnings.push(Warning::new("file", what));
        }
        let scale = match options.scale_to_metres {
            Some(scale) if scale > 0.0 && scale <= hierarchy::MAX_NUMBER => scale,
            Some(scale) => {
                let what = format!("a scale of {scale} m was asked for; more than 0 expected");
                return Err(ReadError::malformed("options", what));
            }
            None => {
                let (scale, how) = units::scale(self.height(if figure { 2 } else { 1 }));
                warnings.extend(how.map(|what| Warning::new("file", what)));
                scale
            }
        };
        Ok(Basis {
            scale,
            figure: z_up(figure),
            world: z_up(world),
        })
    }

    /// Of joints and end sites at rest, along an axis, in file units.
    fn height(&self, axis: usize) -> f32 {
        let joints = self.rest_positions();
        let sites = &self.hierarchy.end_sites;
        let ends = sites.iter().map(|(joint, offset)| joints[*joint] + *offset);
        let heights = joints.iter().copied().chain(ends).map(|p| p[axis]);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    }

    /// Whether the rest figure, and whether the motion, has +Z up.
    fn stands_along_z(&self) -> (bool, bool) {
        let joints = &self.hierarchy.joints;
        let is_head = |j: &RawJoint| j.name.to_ascii_lowercase().contains("head");
        let Some(head) = joints.iter().position(is_head) else {
            return (false, false);
        };
        let mut chain = vec![head];
        while let Some(parent) = joints[chain[chain.len() - 1]].parent {
            chain.push(parent);
        }
        let root = chain[chain.len() - 1];
        let rest = self.rest_positions();
        if units::points_along_z(rest[head] - rest[root]) {
            return (true, true);
        }
        let turns = |c: &Channel| matches!(c, Channel::Rotation(_));
        if self.motion.frames == 0 || !joints[root].channels.iter().any(turns) {
            return (false, false);
        }
        let lowest = rest.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        let (head_from_root, place) = self.mean_stand(&chain);
        let stands = units::motion_stands_along_z(head_from_root, place, rest[root].y - lowest);
        (false, stands)
    }

    /// Mean way from root to head, and mean place of the root; `chain` leads from head to root.
    fn mean_stand(&self, chain: &[usize]) -> (Vec3, Vec3) {
        let step = self.motion.frames.div_ceil(FRAMES_LOOKED_AT);
        let looked_at = (0..self.motion.frames).step_by(step);
        let share = 1.0 / looked_at.len() as f32;
        let mut head_from_root = Vec3::ZERO;
        let mut place = Vec3::ZERO;
        for frame in looked_at {
            let (mut point, mut root) = (Vec3::ZERO, Vec3::ZERO);
            for &joint in chain {
                let (position, rotation) = self.local(frame, joint);
                point = position + rotation * point;
                root = position;
            }
            head_from_root += (point - root) * share;
            place += root * share;
        }
        (head_from_root, place)
    }

    fn file(&self, basis: &Basis) -> BvhFile {
        let offset = |v: Vec3| basis.figure * v * basis.scale;
        let joint = |raw: &RawJoint| Joint {
            name: raw.name.clone(),
            parent: raw.parent,
            rest: Transform::from_translation(offset(raw.offset)),
            in_skin: true,
        };
        let sites = self.hierarchy.end_sites.iter();
        BvhFile {
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

    fn clip(&self, basis: &Basis) -> Option<Clip> {
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
        Some(Clip {
            name: "motion".to_owned(),
            duration_secs,
            channels,
        })
    }

    /// A joint's translations and rotations, flat, frame by frame.
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
