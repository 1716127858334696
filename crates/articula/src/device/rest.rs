//! A figure at rest.

use crate::figure::Figure;
use articula_core::PosedMesh;
use glam::Vec3;

/// The vertices of a figure at rest.
pub(super) fn at_rest(figure: &Figure) -> Vec<Vec3> {
    let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
    let mut posed = PosedMesh::new(rig, mesh);
    let posed = posed.pose(rig.rest_pose());
    posed.skinned(&mesh.morph_weights).positions
}
