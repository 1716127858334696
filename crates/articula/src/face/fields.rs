//! How far each control of a face moves the vertices of its figure.

use super::controls::FaceControls;
use crate::error::Result;
use crate::figure::Figure;
use articula_build::bake;
use articula_core::source::{Property, RawClip, evaluate};
use articula_core::{LocalPose, PosedMesh, SkinnedMesh};
use glam::Vec3;

/// Displacement of each vertex of the figure's mesh from its place at rest, in metres in model space,
/// for each control alone at weight 1.
pub(super) fn control_fields(controls: &FaceControls, figure: &Figure) -> Result<Vec<Vec<Vec3>>> {
    let (asset, character) = (&figure.asset, figure.opened.character());
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    let mut local: LocalPose = asset.rig.rest_pose().clone();
    let rest = posed.pose(&local).skinned(&asset.mesh.morph_weights);
    let mut moved = SkinnedMesh::new(&asset.mesh);
    let mut fields = Vec::with_capacity(controls.len());
    for control in 0..controls.len() {
        let mut weights = vec![0.0; controls.len()];
        weights[control] = 1.0;
        let alone = RawClip {
            name: String::new(),
            duration_secs: 0.0,
            channels: controls.channels(character, &[0.0], &[weights]),
        };
        let alone = bake(character, &alone)?;
        let mut morphs = asset.mesh.morph_weights.clone();
        for channel in &alone.channels {
            if channel.property == Property::Weights {
                let first = asset.mesh.morph_slots[channel.target];
                let count = character.meshes[channel.target].morph_weights.len();
                morphs[first..first + count].copy_from_slice(&channel.values[..count]);
            }
        }
        evaluate::pose(&alone, &character.skeleton, 0.0, &mut local);
        posed.pose(&local).skin(&morphs, &mut moved);
        let offsets = moved.positions.iter().zip(&rest.positions);
        fields.push(offsets.map(|(a, b)| *a - *b).collect());
    }
    Ok(fields)
}
