//! The greatest distance between the surfaces of two characters in motion, as their files are read.

use crate::surface_distance::TwoSurfaces;
use crate::vertex_error::PosedVertices;
use crate::watched_poses::moments;
use articula_core::{Mesh, Mismatch};
use foldhash::HashSet;
use glam::Vec3;

/// Triangles of two meshes that the other has not, by part and positions of their corners.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChangedTriangles {
    /// Those of the first mesh.
    pub first: Vec<[u32; 3]>,
    /// Those of the second.
    pub second: Vec<[u32; 3]>,
}

impl ChangedTriangles {
    /// Compares two meshes of the same parts.
    pub fn between(first: &Mesh, second: &Mesh) -> Self {
        let changed = |of: &Mesh, other: &Mesh| -> Vec<[u32; 3]> {
            let known: HashSet<Key> = keys(other).map(|(key, _)| key).collect();
            let changed = keys(of).filter(|(key, _)| !known.contains(key));
            changed.map(|(_, triangle)| triangle).collect()
        };
        Self {
            first: changed(first, second),
            second: changed(second, first),
        }
    }
}

/// Part, and positions of the corners, the least first.
type Key = (usize, [[u32; 3]; 3]);

fn keys(mesh: &Mesh) -> impl Iterator<Item = (Key, [u32; 3])> + '_ {
    let parts = mesh.parts.iter().enumerate();
    parts.flat_map(move |(p, part)| {
        mesh.triangles[part.triangles.clone()].iter().map(move |t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize].to_array().map(f32::to_bits));
            let turned = [[a, b, c], [b, c, a], [c, a, b]];
            let least = turned.into_iter().min().unwrap_or([a, b, c]);
            ((p, least), *t)
        })
    })
}

/// Greatest distance between the surfaces of two characters in metres, in both directions, in the poses of
/// [`watched_poses`](crate::watched_poses): from vertices, middles of edges and centres of changed
/// triangles to the other surface.
///
/// # Errors
/// A [`Mismatch`] if a triangle indexes a vertex that does not exist.
pub fn greatest_surface_error(
    wanted: &mut PosedVertices<'_>,
    shown: &mut PosedVertices<'_>,
    changed: &ChangedTriangles,
    seed: u64,
) -> Result<f32, Mismatch> {
    let moments = moments(wanted, seed);
    let offset = wanted.mesh().len() as u32;
    let moved =
        |of: &[[u32; 3]]| -> Vec<[u32; 3]> { of.iter().map(|t| t.map(|v| v + offset)).collect() };
    let surfaces = [
        wanted.mesh().triangles.clone(),
        moved(&shown.mesh().triangles),
    ];
    let second = moved(&changed.second);
    let mut pose: Vec<Vec3> = Vec::new();
    let mut found: Option<TwoSurfaces> = None;
    let mut greatest = 0.0;
    for moment in moments {
        pose.clear();
        pose.extend(wanted.in_moment(moment));
        pose.extend(shown.in_moment(moment));
        if found.is_none() {
            let all = [surfaces[0].as_slice(), &surfaces[1]];
            found = Some(TwoSurfaces::new(all, [&changed.first, &second], &pose)?);
        }
        if let Some(surfaces) = &mut found {
            surfaces.raise(&pose, &mut greatest);
        }
    }
    Ok(greatest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{
        Character, Joint, MorphTarget, Primitive, RawMesh, Skeleton, Skin,
    };
    use glam::Affine3A;

    /// A square of four triangles with its middle at a height, which a morph target raises by 1.
    fn square(height: f32, triangles: &[[u32; 3]]) -> Character {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
        let mut positions: Vec<Vec3> = corners
            .iter()
            .map(|(x, z)| Vec3::new(*x, 0.0, *z))
            .collect();
        positions.push(Vec3::new(1.0, height, 1.0));
        let mut raised = vec![Vec3::ZERO; 5];
        raised[4] = Vec3::Y;
        let primitive = Primitive {
            positions,
            influences: 1,
            joints: vec![0; 5],
            weights: vec![1.0; 5],
            triangles: triangles.to_vec(),
            morphs: vec![MorphTarget {
                positions: raised,
                normals: Vec::new(),
            }],
            ..Primitive::default()
        };
        Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "root".into(),
                    parent: None,
                    rest: Transform::IDENTITY,
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                name: "square".into(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![primitive],
                morph_names: vec!["up".into()],
                morph_weights: vec![0.0],
                ..RawMesh::default()
            }],
            ..Character::default()
        }
    }

    #[test]
    fn what_a_morph_target_raises_counts_although_it_is_flat_at_rest() {
        let sides = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let (fine, coarse) = (square(0.25, &sides), square(0.25, &[[1, 0, 2], [0, 3, 2]]));
        let mut from = PosedVertices::new(&fine).unwrap();
        let mut to = PosedVertices::new(&coarse).unwrap();
        let changed = ChangedTriangles::between(from.mesh(), to.mesh());
        assert_eq!((changed.first.len(), changed.second.len()), (4, 2));
        let found = greatest_surface_error(&mut from, &mut to, &changed, 1).unwrap();
        assert!((found - 1.25).abs() < 1e-6, "{found}");
        let same = ChangedTriangles::between(from.mesh(), from.mesh());
        assert_eq!(same, ChangedTriangles::default());
        // A turned triangle is the same.
        let turned = square(0.25, &[[4, 0, 1], [1, 2, 4], [2, 3, 4], [3, 0, 4]]);
        let turned = PosedVertices::new(&turned).unwrap();
        assert_eq!(ChangedTriangles::between(from.mesh(), turned.mesh()), same);
    }
}
