//! The vertices of a face by what its controls move, for heads without a head joint.

use super::controls::FaceControls;
use crate::figure::Figure;

/// Smallest displacement that counts, as a share of the longest of the same morph target: shapes
/// made from scans fade out over the whole head.
const MOVED_SHARE: f32 = 0.05;

/// Vertices, ascending, that some known control of the face moves: a morph target of a face animation
/// table, a blend shape of ARKit or an expression of VRM. Empty without such controls.
pub(crate) fn face_vertices(figure: &Figure) -> Vec<u32> {
    let mesh = &figure.asset.mesh;
    let driven = FaceControls::morphs_of(figure.opened.character());
    let slots: Vec<usize> = driven
        .iter()
        .filter_map(|(of_mesh, target)| Some(mesh.morph_slots.get(*of_mesh)? + target))
        .collect();
    let mut is_face = vec![false; mesh.len()];
    for slot in slots {
        let parts = || mesh.morphs.iter().filter(|m| usize::from(m.slot) == slot);
        let lengths = parts().flat_map(|m| m.positions.iter().map(|d| d.length()));
        let least = MOVED_SHARE * lengths.fold(0.0, f32::max);
        for (v, offset) in parts().flat_map(|m| m.vertices.iter().zip(&m.positions)) {
            is_face[*v as usize] |= offset.length() > least;
        }
    }
    let vertices = is_face.iter().enumerate().filter(|(_, is)| **is);
    vertices.map(|(v, _)| v as u32).collect()
}
