//! Conversion of a character and one of its clips to the texts of a skeleton and a motion file.
//!
//! A bone's axes are those of the joint at rest in model space, so rest orientations survive; the
//! root's are those of the model, and the root is at the origin at rest, as in the CMU files.
//! Lengths are in the unit of those files (inch / 0.45), which most readers assume. The format has
//! no scale: its effect on joint positions is written, nothing else.

use super::amc::RATE;
use super::asf::ROOT_NAME;
use super::bones::{self, Bone, Bones};
use crate::euler;
use crate::sampled::{self, Place};
use crate::written::{WriteError, WrittenFile};
use articula_core::source::{Character, Property, RawClip, Skeleton};
use glam::{EulerRot, Quat, Vec3};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// `length` of the written units: file units per inch.
const LENGTH: f32 = 0.45;

/// File units per metre.
const UNITS_PER_METRE: f32 = LENGTH / 0.0254;

/// A scale closer to one than this counts as one.
const SCALED: f32 = 1e-4;

/// Options of [`write()`].
#[derive(Debug, Clone, PartialEq)]
pub struct WriteOptions {
    /// Frames per second; the format can state it only in a comment.
    pub rate_hz: f32,
    /// Joint and offset (metres, in the joint's space) of end sites, as the readers return them.
    pub end_sites: Vec<(usize, Vec3)>,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            rate_hz: 120.0,
            end_sites: Vec::new(),
        }
    }
}

/// Writes the skeleton and a clip, sampled at a uniform rate. Without a skin all joints are
/// written, otherwise those of the skin and their ancestors (except nodes above a single joint,
/// whose motion becomes that joint's).
///
/// # Errors
/// [`WriteError`] if the clip does not exist, there is no joint, or the rate is invalid.
pub fn write(
    character: &Character,
    clip: Option<usize>,
    options: &WriteOptions,
) -> Result<WrittenFile, WriteError> {
    WriteError::check(&[("rate_hz", options.rate_hz)])?;
    let clip = clip.map(|c| WriteError::clip(character, c)).transpose()?;
    let skeleton = &character.skeleton;
    let order = sampled::depth_first(skeleton);
    if order.is_empty() {
        return Err(WriteError::NoJoint);
    }
    let rest = sampled::rest(skeleton);
    let figure = Figure {
        bones: bones::build(skeleton, &order, &rest, &options.end_sites),
        skeleton,
        rest,
    };
    let frames = clip.map(|clip| figure.frames(clip, options.rate_hz));
    let moves = figure.moving(frames.as_deref().unwrap_or_default());
    let amc = frames.map(|frames| figure.motion(&frames, &moves, options.rate_hz));
    Ok(WrittenFile {
        bytes: figure.asf(&character.name, &moves).into_bytes(),
        motion: amc.map(String::into_bytes),
        left_out: figure.left_out(clip),
    })
}

/// Translation and rotation of a joint in the axes of its bone, at one frame.
type Channels = (Vec3, Quat);

struct Figure<'a> {
    skeleton: &'a Skeleton,
    rest: Vec<Place>,
    bones: Bones,
}

impl Figure<'_> {
    /// Returns, per frame, the root (its position and rotation in model space), then every bone.
    fn frames(&self, clip: &RawClip, rate_hz: f32) -> Vec<Vec<Channels>> {
        let mut frames = Vec::new();
        sampled::each_frame(self.skeleton, clip, rate_hz, |places| {
            let turn = |joint: usize| places[joint].rotation * self.rest[joint].rotation.inverse();
            let root = self.bones.root;
            let root = root.map_or((Vec3::ZERO, Quat::IDENTITY), |r| {
                (places[r].position, turn(r).normalize())
            });
            let bone = |bone: &Bone| match bone.joint {
                None => (Vec3::ZERO, Quat::IDENTITY),
                Some(joint) => {
                    let axes = self.rest[joint].rotation;
                    let (way, rest_way, above) = match self.bones.joint_above[joint] {
                        Some(above) => (
                            places[joint].from_parent,
                            self.rest[joint].from_parent,
                            turn(above),
                        ),
                        None => (
                            places[joint].position,
                            self.rest[joint].position,
                            Quat::IDENTITY,
                        ),
                    };
                    let back = above.inverse();
                    let shift = axes.inverse() * (back * way - rest_way);
                    let turn = axes.inverse() * back * turn(joint) * axes;
                    (shift, turn.normalize())
                }
            };
            let bones = self.bones.list.iter().map(bone);
            frames.push(std::iter::once(root).chain(bones).collect());
        });
        frames
    }

    /// Returns whether each bone's translation is written.
    fn moving(&self, frames: &[Vec<Channels>]) -> Vec<bool> {
        let still = sampled::still_metres(self.rest.iter().map(|p| p.position));
        let moves = |bone: usize| frames.iter().any(|f| f[bone + 1].0.length() > still);
        (0..self.bones.list.len()).map(moves).collect()
    }

    fn asf(&self, name: &str, moves: &[bool]) -> String {
        let name: Vec<&str> = name.split_whitespace().collect();
        let name = name.join("_").replace(['#', ':', ',', '(', ')'], "_");
        let name = if name.is_empty() { "figure" } else { &name };
        let mut text = format!(
            ":version 1.10\n:name {name}\n:units\n  mass 1.0\n  length {LENGTH}\n  angle deg\n\
             :documentation\n   Lengths are inches / {LENGTH}: one unit is {} m.\n",
            1.0 / UNITS_PER_METRE
        );
        let root = self.bones.root.map(|r| &self.skeleton.joints[r].name);
        if let Some(name) = root.filter(|name| !name.is_empty()) {
            let _ = writeln!(text, "   {ROOT_NAME} {}", name.replace(odd_in_words, "_"));
        }
        text.push_str(
            ":root\n   order TX TY TZ RX RY RZ\n   axis XYZ\n   position 0 0 0\n   \
             orientation 0 0 0\n:bonedata\n",
        );
        for (index, bone) in self.bones.list.iter().enumerate() {
            self.bone(&mut text, index, bone, moves[index]);
        }
        text.push_str(":hierarchy\n  begin\n");
        self.links(&mut text);
        text.push_str("  end\n");
        text
    }

    fn bone(&self, text: &mut String, index: usize, bone: &Bone, moves: bool) {
        let length = bone.way.length() * UNITS_PER_METRE;
        let way = bone.way.as_dvec3().normalize_or(glam::DVec3::Y);
        let axes = bone.joint.map_or(Quat::IDENTITY, |j| self.rest[j].rotation);
        let [z, y, x] = euler::degrees(axes, EulerRot::ZYX).map(plain);
        let [dx, dy, dz] = way.to_array();
        let _ = write!(
            text,
            "  begin\n     id {}\n     name {}\n     direction {dx:.9} {dy:.9} {dz:.9}\n     \
             length {length}\n     axis {x} {y} {z} XYZ\n",
            index + 1,
            bone.name
        );
        match (bone.joint, moves) {
            (None, _) => {}
            (Some(_), false) => text.push_str("    dof rx ry rz\n"),
            (Some(_), true) => text.push_str("    dof tx ty tz rx ry rz\n"),
        }
        text.push_str("  end\n");
    }

    /// Writes the hierarchy, the root first.
    fn links(&self, text: &mut String) {
        let mut children = vec![Vec::new(); self.bones.list.len() + 1];
        for bone in &self.bones.list {
            let parent = bone.parent.map_or(0, |p| p + 1);
            children[parent].push(bone.name.as_str());
        }
        let names = self.bones.list.iter().map(|b| b.name.as_str());
        for (name, children) in std::iter::once("root").chain(names).zip(children) {
            if !children.is_empty() {
                let _ = writeln!(text, "    {name} {}", children.join(" "));
            }
        }
    }

    fn motion(&self, frames: &[Vec<Channels>], moves: &[bool], rate_hz: f32) -> String {
        let mut text = format!("# {RATE} {rate_hz}\n:FULLY-SPECIFIED\n:DEGREES\n");
        let mut last = vec![[0.0; 3]; self.bones.list.len() + 1];
        for (number, frame) in frames.iter().enumerate() {
            let _ = writeln!(text, "{}", number + 1);
            row(&mut text, "root", frame[0], true, &mut last[0]);
            for (index, bone) in self.bones.list.iter().enumerate() {
                if bone.joint.is_some() {
                    let (own, last) = (frame[index + 1], &mut last[index + 1]);
                    row(&mut text, &bone.name, own, moves[index], last);
                }
            }
        }
        text
    }

    fn left_out(&self, clip: Option<&RawClip>) -> Vec<String> {
        let mut list = Vec::new();
        let mut say = |count: usize, one: &str, many: &str| {
            if count > 0 {
                list.push(format!("{count} {}", if count == 1 { one } else { many }));
            }
        };
        let joints = &self.skeleton.joints;
        let at_rest = self.bones.list.iter().filter_map(|b| b.joint);
        let at_rest = at_rest.filter(|&j| joints[j].rest.scale.distance(Vec3::ONE) > SCALED);
        let animated = clip.into_iter().flat_map(|c| &c.channels);
        let scaling = |v: &f32| (v - 1.0).abs() > SCALED;
        let animated =
            animated.filter(|c| c.property == Property::Scale && c.values.iter().any(scaling));
        let scaled: BTreeSet<usize> = at_rest.chain(animated.map(|c| c.target)).collect();
        say(
            scaled.len(),
            "scale of a joint (its effect on positions is kept)",
            "scales of joints (their effect on positions is kept)",
        );
        say(
            self.bones.sites_left_out,
            "end site (a bone has one end)",
            "end sites (a bone has one end)",
        );
        say(
            self.bones.renamed,
            "name that the format cannot store (it was replaced)",
            "names that the format cannot store (they were replaced)",
        );
        list
    }
}

fn odd_in_words(c: char) -> bool {
    c.is_control() || matches!(c, '#' | ',' | '(' | ')')
}

fn row(text: &mut String, name: &str, (place, turn): Channels, moves: bool, last: &mut [f32; 3]) {
    text.push_str(name);
    if moves {
        for value in (place * UNITS_PER_METRE).to_array() {
            let _ = write!(text, " {:.6}", plain(value));
        }
    }
    *last = euler::near(euler::degrees(turn, EulerRot::ZYX), *last);
    let [z, y, x] = *last;
    for value in [x, y, z] {
        let _ = write!(text, " {:.6}", plain(value));
    }
    text.push('\n');
}

/// Returns the value, with negative zero replaced by zero.
fn plain(value: f32) -> f32 {
    if value.abs() < 5e-7 { 0.0 } else { value }
}
