//! Meshes of a stream as the primitives of a figure.

use crate::error::{Context, Error, Result};
use articula_core::ClusteredTriangles;
use articula_core::source::{MorphTarget, Primitive, RawMesh};
use articula_stream::StreamLimits;
use articula_stream::mesh::{Receiver, restore};
use glam::{Vec2, Vec3, Vec4};
use std::collections::BTreeMap;

/// A decoded object of a stream: a region of a primitive.
pub(super) struct DecodedObject {
    /// Index of its mesh in the figure.
    pub(super) mesh: usize,
    /// Index of its primitive in the mesh.
    pub(super) primitive: usize,
    /// Number of its region.
    pub(super) region: u32,
    /// Its first vertex among those of the primitive.
    pub(super) first_vertex: u32,
    /// Number, in the whole character, of the finest level that is there.
    pub(super) finest: usize,
    /// Its triangles, level 0 being `finest`, over its own vertices.
    pub(super) triangles: ClusteredTriangles,
}

/// Decoded meshes.
pub(super) struct DecodedMeshes {
    /// The primitives that a stream has something of, by mesh and primitive; triangles are those of
    /// the finest level of each object.
    pub(super) primitives: BTreeMap<(usize, usize), Primitive>,
    /// Their objects.
    pub(super) objects: Vec<DecodedObject>,
}

/// Returns what was received of a stream for the meshes of a figure.
pub(super) fn decoded(
    received: &Receiver,
    meshes: &[RawMesh],
    limits: &StreamLimits,
) -> Result<DecodedMeshes> {
    let stream = received.stream();
    let mut made = DecodedMeshes {
        primitives: BTreeMap::new(),
        objects: Vec::new(),
    };
    let mut vertices = 0_u64;
    for (o, object) in stream.objects.iter().enumerate() {
        let at = || format!("object {o}");
        let (mesh, primitive) = (object.mesh as usize, object.primitive as usize);
        let of_figure = meshes.get(mesh).and_then(|m| m.primitives.get(primitive));
        let Some(of_figure) = of_figure else {
            let what = format!("the figure has no primitive {primitive} of mesh {mesh}");
            return Err(Error::unsuited(what)).with_context(at);
        };
        let (Some(quantised), Some(finest)) = (received.mesh(o), received.finest_level(o)) else {
            continue;
        };
        let Some(triangles) = received.triangles(o) else {
            continue;
        };
        vertices += quantised.wedge_points.len() as u64;
        if vertices > limits.elements {
            let what = format!("more than {} vertices in all objects", limits.elements);
            return Err(Error::unsuited(what)).with_context(at);
        }
        let restored = restore(quantised, &object.layout, &object.scale);
        check(&restored, of_figure, &meshes[mesh]).with_context(at)?;
        let whole = made
            .primitives
            .entry((mesh, primitive))
            .or_insert_with(|| Primitive {
                influences: 1,
                material: of_figure.material,
                ..Primitive::default()
            });
        made.objects.push(DecodedObject {
            mesh,
            primitive,
            region: object.region,
            first_vertex: whole.positions.len() as u32,
            finest: stream.finest_level + finest,
            triangles,
        });
        append(whole, restored);
    }
    Ok(made)
}

/// Checks that an object fits the mesh of the figure.
fn check(object: &Primitive, of_figure: &Primitive, mesh: &RawMesh) -> Result<()> {
    let joints = mesh.skin.joints.len();
    if object.joints.iter().any(|j| usize::from(*j) >= joints) {
        let what =
            format!("a vertex follows a joint beyond the {joints} of its skin in the figure");
        return Err(Error::unsuited(what));
    }
    let (found, wanted) = (object.morphs.len(), of_figure.morphs.len());
    if found != wanted {
        let what = format!("{found} morph targets, the figure has {wanted}");
        return Err(Error::unsuited(what));
    }
    Ok(())
}

/// Appends a region to a primitive. What one of them lacks is filled with neutral values.
fn append(whole: &mut Primitive, region: Primitive) {
    let before = whole.positions.len();
    let after = before + region.positions.len();
    let first = before as u32;
    let triangles = region.triangles.iter().map(|t| t.map(|v| v + first));
    whole.triangles.extend(triangles);
    whole.positions.extend(region.positions);
    filled(&mut whole.normals, region.normals, (before, after), Vec3::Y);
    filled(
        &mut whole.texcoords,
        region.texcoords,
        (before, after),
        Vec2::ZERO,
    );
    filled(&mut whole.colors, region.colors, (before, after), Vec4::ONE);
    let influences = whole.influences.max(region.influences);
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for (part, count) in [
        (&*whole, before),
        (
            &Primitive {
                joints: region.joints,
                weights: region.weights,
                influences: region.influences,
                ..Primitive::default()
            },
            after - before,
        ),
    ] {
        for v in 0..count {
            for k in 0..influences {
                let at = v * part.influences + k;
                let own =
                    (k < part.influences).then(|| (part.joints.get(at), part.weights.get(at)));
                let (joint, weight) = match own {
                    Some((Some(joint), Some(weight))) => (*joint, *weight),
                    // Without influences, a vertex follows the first joint.
                    Some(_) => (0, if k == 0 { 1.0 } else { 0.0 }),
                    None => (0, 0.0),
                };
                joints.push(joint);
                weights.push(weight);
            }
        }
    }
    (whole.joints, whole.weights, whole.influences) = (joints, weights, influences);
    let targets = whole.morphs.len().max(region.morphs.len());
    whole.morphs.resize_with(targets, MorphTarget::default);
    let mut of_region = region.morphs.into_iter();
    for target in &mut whole.morphs {
        let more = of_region.next().unwrap_or_default();
        target.positions.resize(before, Vec3::ZERO);
        target.positions.extend(more.positions);
        target.positions.resize(after, Vec3::ZERO);
        filled(
            &mut target.normals,
            more.normals,
            (before, after),
            Vec3::ZERO,
        );
    }
}

/// Appends values of an attribute that may be absent, so that it is absent or has `after` values.
fn filled<T: Copy>(values: &mut Vec<T>, more: Vec<T>, (before, after): (usize, usize), neutral: T) {
    if values.is_empty() && more.is_empty() {
        return;
    }
    values.resize(before, neutral);
    values.extend(more);
    values.resize(after, neutral);
}

impl DecodedObject {
    /// Triangles at a level of the whole character, over the vertices of the primitive; the finest
    /// that is there for a finer one.
    pub(super) fn at_level(&self, level: usize) -> impl Iterator<Item = [u32; 3]> + '_ {
        let own = level.saturating_sub(self.finest);
        let shown = self.triangles.clusters.ranges(own).flat_map(|range| {
            let range = range.start as usize..range.end as usize;
            self.triangles.triangles.get(range).unwrap_or_default()
        });
        shown.map(|t| t.map(|v| v + self.first_vertex))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(count: usize, influences: usize) -> Primitive {
        Primitive {
            positions: vec![Vec3::ONE; count],
            influences,
            joints: vec![3; count * influences],
            weights: vec![1.0 / influences as f32; count * influences],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        }
    }

    #[test]
    fn regions_with_different_influences_and_attributes_are_joined() {
        let mut whole = Primitive {
            influences: 1,
            ..Primitive::default()
        };
        append(&mut whole, part(3, 1));
        append(
            &mut whole,
            Primitive {
                normals: vec![Vec3::X; 4],
                morphs: vec![MorphTarget {
                    positions: vec![Vec3::Z; 4],
                    normals: Vec::new(),
                }],
                ..part(4, 2)
            },
        );
        assert_eq!(whole.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!((whole.influences, whole.joints.len()), (2, 14));
        assert_eq!(whole.weights[..8], [1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.5, 0.5]);
        assert_eq!(
            whole.normals,
            [[Vec3::Y; 3].as_slice(), &[Vec3::X; 4]].concat()
        );
        assert_eq!(whole.morphs[0].positions[2..4], [Vec3::ZERO, Vec3::Z]);
        assert!(whole.morphs[0].normals.is_empty() && whole.texcoords.is_empty());
    }
}
