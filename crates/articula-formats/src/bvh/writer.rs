//! Conversion of a character and one of its clips to the text of a BVH file.
//!
//! BVH has neither rest rotations nor scale. Offsets are therefore written in the orientation that
//! the rest pose has in model space, and rotations relative to the rest pose: joint positions match
//! the source at every frame, while the joints' local axes become those of the model. A joint whose
//! position moves against its parent gets position channels.

use crate::euler;
use crate::sampled::{self, Place};
use crate::written::WriteError;
use articula_core::source::{Character, RawClip, Skeleton};
use glam::{EulerRot, Quat, Vec3};
use std::fmt::Write as _;

/// The order in which the three rotations of a joint are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChannelOrder {
    /// X, then Y, then Z.
    Xyz,
    /// X, then Z, then Y.
    Xzy,
    /// Y, then X, then Z.
    Yxz,
    /// Y, then Z, then X.
    Yzx,
    /// Z, then X, then Y: the most common order.
    #[default]
    Zxy,
    /// Z, then Y, then X.
    Zyx,
}

/// Options of [`write()`].
#[derive(Debug, Clone, PartialEq)]
pub struct WriteOptions {
    /// Frames per second.
    pub rate_hz: f32,
    /// Order of the rotation channels.
    pub order: ChannelOrder,
    /// File units per metre; 100 writes centimetres.
    pub units_per_metre: f32,
    /// Joint and offset (metres, in the joint's space) of end sites, as the reader returns them; a
    /// leaf without one gets an end site of zero length.
    pub end_sites: Vec<(usize, Vec3)>,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            rate_hz: 30.0,
            order: ChannelOrder::Zxy,
            units_per_metre: 100.0,
            end_sites: Vec::new(),
        }
    }
}

/// Writes a clip, sampled at a uniform rate. Without a skin all joints are written, otherwise those
/// of the skin and their ancestors.
///
/// # Errors
/// [`WriteError`] if the clip does not exist, or an option is invalid.
pub fn write(
    character: &Character,
    clip: usize,
    options: &WriteOptions,
) -> Result<Vec<u8>, WriteError> {
    WriteError::check(&[
        ("rate_hz", options.rate_hz),
        ("units_per_metre", options.units_per_metre),
    ])?;
    let clip = WriteError::clip(character, clip)?;
    let skeleton = &character.skeleton;
    let order = sampled::depth_first(skeleton);
    if order.is_empty() {
        return Err(WriteError::NoJoint);
    }
    let figure = Figure::new(skeleton, clip, options, order);
    let mut text = String::from("HIERARCHY\n");
    figure.hierarchy(&mut text);
    figure.motion(&mut text);
    Ok(text.into_bytes())
}

/// Translation and rotation of a joint as BVH channels, at one frame.
type Channels = (Vec3, Quat);

struct Figure<'a> {
    skeleton: &'a Skeleton,
    options: &'a WriteOptions,
    order: Vec<usize>,
    rest: Vec<Place>,
    /// Frame by frame, one entry for each joint of `order`.
    frames: Vec<Vec<Channels>>,
    /// Whether a joint's position is written; one entry for each joint of `order`.
    moves: Vec<bool>,
}

impl<'a> Figure<'a> {
    fn new(
        skeleton: &'a Skeleton,
        clip: &RawClip,
        options: &'a WriteOptions,
        order: Vec<usize>,
    ) -> Self {
        let mut figure = Self {
            skeleton,
            options,
            rest: sampled::rest(skeleton),
            order,
            frames: Vec::new(),
            moves: Vec::new(),
        };
        sampled::each_frame(skeleton, clip, options.rate_hz, |places| {
            figure.frames.push(figure.channels(places));
        });
        figure.moves = figure.moving();
        figure
    }

    /// Returns rotations relative to rest, and positions in the parent's rotated space.
    fn channels(&self, places: &[Place]) -> Vec<Channels> {
        let turn = |joint: usize| places[joint].rotation * self.rest[joint].rotation.inverse();
        let place = |&joint: &usize| match self.skeleton.joints[joint].parent {
            None => (places[joint].position, turn(joint)),
            Some(parent) => {
                let back = turn(parent).inverse();
                let position = back * places[joint].from_parent;
                (position, (back * turn(joint)).normalize())
            }
        };
        self.order.iter().map(place).collect()
    }

    fn moving(&self) -> Vec<bool> {
        let positions = self.order.iter().map(|&j| self.rest[j].position);
        let still = sampled::still_metres(positions);
        let moves = |(slot, &joint): (usize, &usize)| {
            let offset = self.rest[joint].from_parent;
            let away = |frame: &Vec<Channels>| frame[slot].0.distance(offset) > still;
            self.skeleton.joints[joint].parent.is_none() || self.frames.iter().any(away)
        };
        self.order.iter().enumerate().map(moves).collect()
    }

    fn hierarchy(&self, text: &mut String) {
        let mut open: Vec<usize> = Vec::new();
        for (slot, &joint) in self.order.iter().enumerate() {
            let parent = self.skeleton.joints[joint].parent;
            while open.last().copied() != parent && !open.is_empty() {
                open.pop();
                line(text, open.len(), "}");
            }
            let keyword = if parent.is_none() { "ROOT" } else { "JOINT" };
            let depth = open.len();
            line(text, depth, &format!("{keyword} {}", self.name(joint)));
            line(text, depth, "{");
            line(
                text,
                depth + 1,
                &format!("OFFSET {}", self.triple(self.rest[joint].from_parent)),
            );
            let names = rotation_names(self.options.order);
            let channels = if self.moves[slot] {
                format!("CHANNELS 6 Xposition Yposition Zposition {names}")
            } else {
                format!("CHANNELS 3 {names}")
            };
            line(text, depth + 1, &channels);
            open.push(joint);
            self.ends(text, slot, depth + 1);
        }
        while open.pop().is_some() {
            line(text, open.len(), "}");
        }
    }

    fn ends(&self, text: &mut String, slot: usize, depth: usize) {
        let joint = self.order[slot];
        let given = self.options.end_sites.iter().filter(|(j, _)| *j == joint);
        let mut sites: Vec<Vec3> = given
            .map(|(_, offset)| self.rest[joint].rotation * *offset)
            .collect();
        let next = self.order.get(slot + 1);
        let is_leaf = next.is_none_or(|&n| self.skeleton.joints[n].parent != Some(joint));
        if sites.is_empty() && is_leaf {
            sites.push(Vec3::ZERO);
        }
        for site in sites {
            line(text, depth, "End Site");
            line(text, depth, "{");
            line(text, depth + 1, &format!("OFFSET {}", self.triple(site)));
            line(text, depth, "}");
        }
    }

    fn motion(&self, text: &mut String) {
        let frame_time_secs = 1.0 / f64::from(self.options.rate_hz);
        let _ = write!(
            text,
            "MOTION\nFrames: {}\nFrame Time: {frame_time_secs:.9}\n",
            self.frames.len()
        );
        let mut last = vec![[0.0_f32; 3]; self.order.len()];
        for frame in &self.frames {
            let mut values = Vec::new();
            for (slot, (position, rotation)) in frame.iter().enumerate() {
                if self.moves[slot] {
                    values.push(self.triple(*position));
                }
                let degrees = euler::degrees(*rotation, factors(self.options.order));
                let degrees = euler::near(degrees, last[slot]);
                last[slot] = degrees;
                values.push(triple(degrees));
            }
            line(text, 0, &values.join(" "));
        }
    }

    fn triple(&self, metres: Vec3) -> String {
        triple((metres * self.options.units_per_metre).to_array())
    }

    /// Returns a valid name: most readers end a name at a space or brace, and it must not be empty.
    fn name(&self, joint: usize) -> String {
        let name = &self.skeleton.joints[joint].name;
        let odd = |c: char| c.is_whitespace() || c.is_control() || matches!(c, '{' | '}');
        match name.trim() {
            "" => format!("joint_{joint}"),
            name => name.replace(odd, "_"),
        }
    }
}

fn rotation_names(order: ChannelOrder) -> &'static str {
    match order {
        ChannelOrder::Xyz => "Xrotation Yrotation Zrotation",
        ChannelOrder::Xzy => "Xrotation Zrotation Yrotation",
        ChannelOrder::Yxz => "Yrotation Xrotation Zrotation",
        ChannelOrder::Yzx => "Yrotation Zrotation Xrotation",
        ChannelOrder::Zxy => "Zrotation Xrotation Yrotation",
        ChannelOrder::Zyx => "Zrotation Yrotation Xrotation",
    }
}

fn factors(order: ChannelOrder) -> EulerRot {
    match order {
        ChannelOrder::Xyz => EulerRot::XYZ,
        ChannelOrder::Xzy => EulerRot::XZY,
        ChannelOrder::Yxz => EulerRot::YXZ,
        ChannelOrder::Yzx => EulerRot::YZX,
        ChannelOrder::Zxy => EulerRot::ZXY,
        ChannelOrder::Zyx => EulerRot::ZYX,
    }
}

fn triple(values: [f32; 3]) -> String {
    // Replaces a negative zero by zero.
    let [x, y, z] = values.map(|v| if v.abs() < 5e-7 { 0.0 } else { v });
    format!("{x:.6} {y:.6} {z:.6}")
}

fn line(text: &mut String, depth: usize, words: &str) {
    text.extend(std::iter::repeat_n('\t', depth));
    text.push_str(words);
    text.push('\n');
}
