//! Draft glTF extensions for characters in a GLB.

use super::pose_kind::pose_kind;
use crate::error::Result;
use crate::open::CharacterFile;
use articula_formats::gltf::Document;
use articula_formats::joint_map::vrm_bones;

/// Writes the extensions into a document; `node_of_joint` has the node of each joint.
pub(super) fn write(
    opened: &CharacterFile,
    document: &mut Document,
    node_of_joint: &[usize],
) -> Result<()> {
    let given = opened.gltf().and_then(|b| b.humanoid.clone());
    let bones = given.unwrap_or_else(|| vrm_bones(&opened.articulation()));
    let character = opened.character();
    let kind = pose_kind(&character.skeleton, &bones);
    let nodes = bones.into_iter();
    let nodes: Vec<(usize, String)> = nodes
        .map(|(joint, bone)| (node_of_joint[joint], bone))
        .collect();
    document.set_khr_character(&nodes, kind, character.credits.as_ref())?;
    Ok(())
}
