//! `HAnimMotion`: frames of joint angles, as in BVH but with the joints of the figure.
//!
//! Source: ISO/IEC 19774-2 (motion data animation); ISO/IEC 19775-1, 26.3.5. Angles are in degrees
//! regardless of the unit statement; rotations multiply in the order of the channels; position
//! channels are the joint's field `translation`, which is an offset from its center.

use super::draft::{Draft, Stage};
use super::fields::{Reader, words};
use super::scene::{NodeId, shortened};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::LibmQuat;
use articula_core::source::Channel;
use glam::{DQuat, DVec3};

/// Name in the joint list that denotes no joint.
const IGNORED: &str = "ignored";

/// Accepted range of seconds per frame.
const FRAME_SECS: std::ops::RangeInclusive<f64> = 1e-6..=1e4;

/// Target of one channel, with its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drives {
    Position(usize),
    Rotation(usize),
    Scale(usize),
    Nothing,
}

/// The channels of one joint.
#[derive(Debug)]
struct Group {
    joint: Option<usize>,
    /// Index of the first channel in a frame's values.
    first: usize,
    channels: Vec<Drives>,
}

/// Reads each motion of a humanoid as a clip.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
) -> Result<Vec<Draft>, ReadError> {
    let fields = ["motions", "children"];
    let nodes = fields.map(|field| reader.nodes(stage.figure.id, field));
    let mut drafts = Vec::new();
    for id in nodes.concat() {
        if reader.kind(id) == "HAnimMotion" {
            drafts.extend(read(reader, stage, id)?);
        }
    }
    Ok(drafts)
}

fn read(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
    id: NodeId,
) -> Result<Option<Draft>, ReadError> {
    let groups = groups(reader, stage, id)?;
    let width: usize = groups.iter().map(|g| g.channels.len()).sum();
    let values = reader.numbers(id, "values")?;
    if width == 0 || values.len() < width {
        reader.warn(id, "the motion has no frame; left out");
        return Ok(None);
    }
    if values.len() % width != 0 {
        let what = format!(
            "{} values are not a multiple of {width} channels; the rest is left out",
            values.len()
        );
        reader.warn(id, what);
    }
    let all: Vec<&[f64]> = values.chunks_exact(width).collect();
    let at = reader.scene.at(id);
    Limits::check(&at, "frames", all.len() as u64, reader.limits.frames)?;
    let frames = chosen(reader, id, &all)?;
    let frame_secs = reader.number(id, "frameDuration", 0.1)?;
    if !FRAME_SECS.contains(&frame_secs) {
        let what = format!("frameDuration is {frame_secs} s, expected 0.000001 to 10000");
        return Err(reader.malformed(id, what));
    }
    let times: Vec<f32> = (0..frames.len())
        .map(|f| (f as f64 * frame_secs) as f32)
        .collect();
    let mut channels = Vec::new();
    for group in &groups {
        reader.charge(id, 10 * frames.len())?;
        channels.extend(group.channels(stage, &times, frames));
    }
    warn_if_lifted(reader, stage, id, &groups, frames);
    Ok(Some(Draft {
        name: reader.name(id),
        duration_secs: times.last().copied().unwrap_or(0.0),
        channels,
        weights: Vec::new(),
    }))
}

/// Returns the frames from `startFrame` to `endFrame`; all, if the fields are absent.
fn chosen<'v>(
    reader: &mut Reader<'_>,
    id: NodeId,
    all: &'v [&'v [f64]],
) -> Result<&'v [&'v [f64]], ReadError> {
    let mut frame = |field: &str| {
        let given = reader.indices(id, field)?;
        let given = given.first().copied().unwrap_or(0);
        Ok::<_, ReadError>(usize::try_from(given).unwrap_or(0))
    };
    let (start, end) = (frame("startFrame")?, frame("endFrame")?);
    Ok(match end > start && end < all.len() {
        true => &all[start..=end],
        false => all,
    })
}

fn groups(reader: &mut Reader<'_>, stage: &Stage<'_>, id: NodeId) -> Result<Vec<Group>, ReadError> {
    let names: Vec<&str> = words(reader.text(id, "joints").unwrap_or("")).collect();
    let enabled = reader.strings(id, "channelsEnabled")?;
    let enabled: Vec<bool> = enabled
        .iter()
        .flat_map(|text| text.split([' ', ',']))
        .filter(|word| !word.is_empty())
        .map(|word| !word.eq_ignore_ascii_case("false"))
        .collect();
    let mut groups: Vec<Group> = Vec::new();
    let mut first = 0;
    for channels in channel_lists(reader, id)? {
        let name = names.get(groups.len()).copied().unwrap_or("");
        let on = enabled.get(groups.len()).copied().unwrap_or(true);
        let joint = stage.joint_called(name).filter(|_| on);
        if joint.is_none() && on && !name.eq_ignore_ascii_case(IGNORED) {
            let name = shortened(name);
            reader.warn(
                id,
                format!("there is no joint \"{name}\"; its channels are left out"),
            );
        }
        let count = channels.len();
        groups.push(Group {
            joint,
            first,
            channels,
        });
        first += count;
    }
    if groups.len() != names.len() {
        let what = format!(
            "{} joints, but channel lists for {}",
            names.len(),
            groups.len()
        );
        reader.warn(id, what);
    }
    Ok(groups)
}

/// Parses `6 Xposition … 3 Zrotation …`: joint by joint, a count and that number of words.
fn channel_lists(reader: &mut Reader<'_>, id: NodeId) -> Result<Vec<Vec<Drives>>, ReadError> {
    let text = reader.text(id, "channels").unwrap_or("");
    let mut lists: Vec<Vec<Drives>> = Vec::new();
    let mut total = 0;
    for word in words(text) {
        if word.bytes().all(|b| b.is_ascii_digit()) {
            lists.push(Vec::new());
            continue;
        }
        let Some(list) = lists.last_mut() else {
            return Err(reader.malformed(id, "channels: expected a count first, such as 3"));
        };
        list.push(drives(word));
        total += 1;
    }
    reader.charge(id, total)?;
    Ok(lists)
}

fn drives(word: &str) -> Drives {
    let axis = match word.as_bytes().first() {
        Some(b'X' | b'x') => 0,
        Some(b'Y' | b'y') => 1,
        Some(b'Z' | b'z') => 2,
        _ => return Drives::Nothing,
    };
    match &word[1..].to_ascii_lowercase()[..] {
        "position" => Drives::Position(axis),
        "rotation" => Drives::Rotation(axis),
        "scale" => Drives::Scale(axis),
        _ => Drives::Nothing,
    }
}

impl Group {
    fn channels(&self, stage: &Stage<'_>, times: &[f32], frames: &[&[f64]]) -> Vec<Channel> {
        let Some(joint) = self.joint else {
            return Vec::new();
        };
        let any = |wanted: fn(&Drives) -> bool| self.channels.iter().any(wanted);
        let locals = frames.iter().map(|frame| self.placement(frame));
        let mut channels = Vec::new();
        if any(|d| matches!(d, Drives::Position(_))) {
            let values = locals.clone().map(|(position, _, _)| position);
            channels.push(stage.translations(joint, times.to_vec(), values));
        }
        if any(|d| matches!(d, Drives::Rotation(_))) {
            let values = locals.clone().map(|(_, rotation, _)| rotation);
            channels.push(stage.rotations(joint, times.to_vec(), values));
        }
        if any(|d| matches!(d, Drives::Scale(_))) {
            let values = locals.map(|(_, _, scale)| scale);
            channels.push(stage.scales(joint, times.to_vec(), values));
        }
        channels
    }

    fn placement(&self, frame: &[f64]) -> (DVec3, DQuat, DVec3) {
        let (mut position, mut rotation, mut scale) = (DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE);
        for (channel, &value) in self.channels.iter().zip(&frame[self.first..]) {
            match *channel {
                Drives::Position(axis) => position[axis] = value,
                Drives::Rotation(axis) => {
                    rotation *= DQuat::libm_axis_angle(DVec3::AXES[axis], value.to_radians());
                }
                Drives::Scale(axis) => scale[axis] = value,
                Drives::Nothing => {}
            }
        }
        (position, rotation, scale)
    }
}

/// Warns about a root that never comes near its rest height. Motions copied from BVH hold the
/// position of the root instead of its offset from the center; players take them for offsets all
/// the same, and the figure floats.
fn warn_if_lifted(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
    id: NodeId,
    groups: &[Group],
    frames: &[&[f64]],
) {
    let is_root = |g: &&Group| {
        g.joint
            .is_some_and(|j| stage.figure.joints[j].parent.is_none())
    };
    let Some(root) = groups.iter().find(is_root) else {
        return;
    };
    let Some(joint) = root.joint else { return };
    let center = stage.figure.joints[joint].stored.center.y;
    let lowest = frames
        .iter()
        .map(|frame| root.placement(frame).0.y)
        .fold(f64::MAX, f64::min);
    if root.channels.contains(&Drives::Position(1)) && center > 0.0 && lowest > 0.5 * center {
        let what = format!(
            "the root is always at least {lowest} above its rest height of {center}: its channels \
             seem to be positions, not offsets; read as offsets, as in other players"
        );
        reader.warn(id, what);
    }
}
