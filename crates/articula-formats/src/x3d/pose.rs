//! `HAnimPose`: a named pose, as a clip that ends in it.
//!
//! The clip runs from the pose of the file's fields to the named pose, over the transition time
//! that the pose defines, as a player does. Joints that the pose does not name stay as they are; a
//! pose without any returns all joints to rest.
//!
//! Source: X3D 4.1 (draft ISO/IEC 19775-1), HAnimPose.

use super::draft::{Draft, Stage};
use super::fields::Reader;
use super::placement::Placement;
use super::scene::NodeId;
use crate::error::ReadError;

/// Maximum transition time, in seconds.
const LONGEST_SECS: f64 = 1e4;

/// Reads all poses of a humanoid.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
) -> Result<Vec<Draft>, ReadError> {
    let fields = ["children", "poses"];
    let nodes = fields.map(|field| reader.nodes(stage.figure.id, field));
    let mut drafts = Vec::new();
    for id in nodes.concat() {
        if reader.kind(id) != "HAnimPose" {
            continue;
        }
        if reader.flag(id, "enabled", true) {
            drafts.push(read(reader, stage, id)?);
        } else {
            reader.warn(id, "the pose is disabled; left out");
        }
    }
    Ok(drafts)
}

fn read(reader: &mut Reader<'_>, stage: &Stage<'_>, id: NodeId) -> Result<Draft, ReadError> {
    let given = reader.number(id, "transitionDuration", 0.0)?;
    let duration_secs = given.clamp(0.0, LONGEST_SECS) as f32;
    let mut draft = Draft {
        name: reader.name(id),
        duration_secs,
        channels: Vec::new(),
        weights: Vec::new(),
    };
    let mut named = Vec::new();
    for child in [reader.nodes(id, "children"), reader.nodes(id, "poseJoints")].concat() {
        if reader.kind(child) != "HAnimJoint" {
            continue;
        }
        reader.visit(child, 0)?;
        let name = reader.name(child);
        match stage.joint_called(&name) {
            Some(joint) => named.push((joint, Placement::read(reader, child)?)),
            None => reader.warn(child, "no joint of the figure has this name; left out"),
        }
    }
    if named.is_empty() {
        let joints = stage.figure.joints.iter().enumerate();
        let rest = joints.map(|(joint, own)| (joint, own.stored.at_rest()));
        named.extend(rest.filter(|(j, _)| *j == 0 || !stage.figure.joints[*j].stored.is_at_rest()));
    }
    for (joint, pose) in named {
        let stored = &stage.figure.joints[joint].stored;
        reader.charge(id, 20)?;
        let (times, from_to): (Vec<f32>, Vec<&Placement>) = match duration_secs > 0.0 {
            true => (vec![0.0, duration_secs], vec![stored, &pose]),
            false => (vec![0.0], vec![&pose]),
        };
        let is_moved = stored.translation != pose.translation;
        if is_moved {
            let values = from_to.iter().map(|p| p.translation);
            draft
                .channels
                .push(stage.translations(joint, times.clone(), values));
        }
        if stored.scale != pose.scale {
            let values = from_to.iter().map(|p| p.scale);
            draft
                .channels
                .push(stage.scales(joint, times.clone(), values));
        }
        let values = from_to.iter().map(|p| p.rotation);
        draft.channels.push(stage.rotations(joint, times, values));
    }
    Ok(draft)
}
