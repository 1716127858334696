//! Source meshes with their vertices in the order of the mesh levels.

use crate::clusters::Clustered;
use articula_core::source::RawMesh;
use articula_core::{ClusteredTriangles, Mismatch};

/// Reorders the primitives of `meshes`, counted over all meshes, by the objects of their levels.
pub(super) fn meshes(meshes: &[RawMesh], objects: &[Clustered]) -> Result<Vec<RawMesh>, Mismatch> {
    let primitives: usize = meshes.iter().map(|m| m.primitives.len()).sum();
    if primitives != objects.len() {
        let what = format!(
            "levels for {} primitives, the meshes have {primitives}",
            objects.len()
        );
        return Err(Mismatch::new("meshes", what));
    }
    let mut objects = objects.iter();
    let mut out = Vec::with_capacity(meshes.len());
    for (m, mesh) in meshes.iter().enumerate() {
        let objects: Vec<&Clustered> = objects.by_ref().take(mesh.primitives.len()).collect();
        let mut primitives = Vec::with_capacity(objects.len());
        for (primitive, object) in mesh.primitives.iter().zip(&objects) {
            let count = primitive.positions.len();
            if let Some(v) = object.vertices.iter().find(|v| **v as usize >= count) {
                let what =
                    format!("vertex {v} is out of range: the primitive has {count} vertices");
                return Err(Mismatch::new(format!("meshes[{m}]"), what));
            }
            // The finest level comes first, in one range.
            let finest = object.clusters.triangles(0) as usize;
            let triangles = object.triangles[..finest].to_vec();
            primitives.push(primitive.reordered(&object.vertices, triangles));
        }
        let stored = objects.iter().map(|object| ClusteredTriangles {
            clusters: object.clusters.clone(),
            triangles: object.triangles.clone(),
        });
        out.push(RawMesh {
            name: mesh.name.clone(),
            skin: mesh.skin.clone(),
            morph_names: mesh.morph_names.clone(),
            morph_weights: mesh.morph_weights.clone(),
            screen_coverage: None,
            levels: Vec::new(),
            clustered: stored.collect(),
            primitives,
        });
    }
    Ok(out)
}
