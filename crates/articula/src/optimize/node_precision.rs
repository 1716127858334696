//! How far the transforms of nodes at rest may be rounded.

use crate::error::Result;
use articula_build::clip_edit::{EditSubject, value_tolerances};
use articula_core::Articulation;
use articula_core::source::{Channel, Character, Interpolation, Joint, Property, RawClip};
use articula_formats::gltf::NodeTolerance;

/// For each node of a document, by the joints of a body that have nodes, the changes that each by itself move no vertex by more than `metres`; `None` for
/// nodes that are no joints.
pub(super) fn node_tolerances(
    character: &Character,
    nodes: &[usize],
    metres: f32,
) -> Result<Vec<Option<NodeTolerance>>> {
    let joints = &character.skeleton.joints;
    let subject = EditSubject::new(character, Articulation::unmapped(joints.len()), &[])?;
    let channels = joints
        .iter()
        .enumerate()
        .flat_map(|(j, joint)| at_rest(j, joint));
    let rest = RawClip {
        name: "rest".into(),
        duration_secs: 0.0,
        channels: channels.collect(),
    };
    let found = value_tolerances(&subject, &rest, metres)?;
    let count = nodes.iter().map(|node| node + 1).max().unwrap_or(0);
    let mut out = vec![None; count];
    for (node, tolerances) in nodes.iter().zip(found.as_chunks::<3>().0) {
        let [translation, rotation, scale] = *tolerances;
        out[*node] = Some(NodeTolerance {
            translation,
            rotation,
            scale,
        });
    }
    Ok(out)
}

/// Channels with one key that hold a joint at rest: translation, rotation, scale.
fn at_rest(target: usize, joint: &Joint) -> [Channel; 3] {
    let rest = &joint.rest;
    let channel = |property, values: &[f32]| Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0],
        values: values.to_vec(),
    };
    [
        channel(Property::Translation, &rest.translation.to_array()),
        channel(Property::Rotation, &rest.rotation.to_array()),
        channel(Property::Scale, &rest.scale.to_array()),
    ]
}
