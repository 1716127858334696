//! Meshes: corners merged to vertices, one primitive for each material.

use super::influences::{self, Influences};
use super::look::Looks;
use super::scene::Mesh;
use super::shapes::{self, Target};
use super::skeleton::{Bones, named};
use super::source::Reader;
use crate::error::ReadError;
use articula_core::source::{Primitive, RawMesh, Skin};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Meshes of a character.
pub(super) struct Shown {
    pub(super) meshes: Vec<RawMesh>,
    /// Which channel drives each morph target, by mesh.
    pub(super) targets: Vec<Vec<Target>>,
}

/// Reads the mesh of every node that has one; `geometric` are the numbers of models with a transform of their
/// geometry alone.
pub(super) fn meshes(
    reader: &mut Reader<'_>,
    bones: &Bones,
    geometric: &HashSet<i64>,
    looks: &mut Looks<'_, '_>,
) -> Result<Shown, ReadError> {
    let mut shown = Shown {
        meshes: Vec::new(),
        targets: Vec::new(),
    };
    let mut geometric: Vec<i64> = geometric.iter().copied().collect();
    geometric.sort_unstable();
    for (index, node) in reader.scene.nodes.iter().enumerate() {
        let Some((mesh, joint)) = node.mesh.zip(bones.joint_of_node[index]) else {
            continue;
        };
        let source = reader.scene.mesh(mesh);
        if source.corners().is_empty() {
            continue;
        }
        let at = || format!("node \"{}\"", node.name);
        if source.instances() > 1 && reader.scene.is_called(index, &geometric) {
            let what = "a mesh is shown by several nodes and has a transform of its own, which is lost; \
                        make the nodes single";
            reader.kinds.note(at, what);
        }
        let bind = influences::read(reader, bones, index, mesh)?;
        let place = match bind {
            Some(_) => DAffine3::IDENTITY,
            None => node.geometry,
        };
        let targets = shapes::targets(reader, mesh);
        let mut made = RawMesh {
            name: match node.is_helper {
                true => node
                    .parent
                    .map_or_else(String::new, |p| named(reader.scene, p)),
                false => node.name.clone(),
            },
            skin: match &bind {
                Some(bind) => bind.skin.clone(),
                None => Skin {
                    joints: vec![joint],
                    inverse_bind: vec![glam::Affine3A::IDENTITY],
                },
            },
            morph_names: targets.iter().map(|t| t.name.clone()).collect(),
            morph_weights: targets.iter().map(|t| t.stored).collect(),
            ..RawMesh::default()
        };
        if made.name.is_empty() {
            source.name().clone_into(&mut made.name);
        }
        for (slot, corners) in corners_of_slots(source) {
            let (mut primitive, points) = merged(reader, source, &corners, &place)?;
            primitive.material = match reader.scene.material(index, mesh, slot) {
                Some(material) => Some(looks.material(reader, material)?),
                None => None,
            };
            influence(reader, bind.as_ref(), &points, &mut primitive)?;
            shapes::apply(reader, &targets, &place, &points, &mut primitive)?;
            made.primitives.push(primitive);
        }
        shown.meshes.push(made);
        shown.targets.push(targets);
    }
    Ok(shown)
}

/// Corners of triangles by material slot.
fn corners_of_slots(mesh: Mesh<'_>) -> BTreeMap<usize, Vec<u32>> {
    let mut slots: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    // Triangles stand in the order of their polygons.
    let mut polygons = mesh.polygons().peekable();
    for triangle in mesh.corners().chunks_exact(3) {
        let first = triangle[0] as usize;
        while polygons
            .next_if(|(begin, count, _)| first >= begin + count)
            .is_some()
        {}
        let slot = polygons.peek().map_or(0, |polygon| polygon.2);
        slots.entry(slot).or_default().extend(triangle);
    }
    slots
}

/// What tells vertices apart: point, normal, texture coordinates and colour, as bits.
type Key = (u32, [u32; 3], [u32; 2], [u32; 4]);

/// Merges corners to vertices; returns the control point of each vertex too.
fn merged(
    reader: &mut Reader<'_>,
    mesh: Mesh<'_>,
    corners: &[u32],
    place: &DAffine3,
) -> Result<(Primitive, Vec<u32>), ReadError> {
    let at = || format!("mesh \"{}\"", mesh.name());
    reader.charge(&at(), 13 * corners.len())?;
    let normal_matrix = place.matrix3.inverse().transpose();
    let mut made = Primitive::default();
    let mut points = Vec::new();
    let mut known: HashMap<Key, u32> = HashMap::new();
    for triangle in corners.chunks_exact(3) {
        let mut vertices = [0; 3];
        let mut is_whole = true;
        for (vertex, corner) in vertices.iter_mut().zip(triangle) {
            let corner = *corner as usize;
            let Some(point) = mesh.point(corner) else {
                is_whole = false;
                break;
            };
            let normal = DVec3::from(mesh.normal(corner).unwrap_or_default());
            let normal = (normal_matrix * normal).normalize_or(DVec3::Y).as_vec3();
            let [u, v] = mesh.texcoord(corner).unwrap_or_default().map(|x| x as f32);
            let texcoord = Vec2::new(u, 1.0 - v);
            let color = mesh.color(corner).unwrap_or([1.0; 4]).map(|x| x as f32);
            let key = (
                point,
                normal.to_array().map(f32::to_bits),
                texcoord.to_array().map(f32::to_bits),
                color.map(f32::to_bits),
            );
            *vertex = *known.entry(key).or_insert_with(|| {
                let stored = DVec3::from(mesh.points()[point as usize]);
                made.positions
                    .push(place.transform_point3(stored).as_vec3());
                if mesh.has_normals() {
                    made.normals.push(normal);
                }
                if mesh.has_texcoords() {
                    made.texcoords.push(texcoord);
                }
                if mesh.has_colors() {
                    made.colors.push(Vec4::from_array(color));
                }
                points.push(point);
                points.len() as u32 - 1
            });
        }
        if !is_whole {
            continue;
        }
        if place.matrix3.determinant() < 0.0 {
            vertices.swap(1, 2);
        }
        made.triangles.push(vertices);
    }
    let is_sound = |p: &Vec3| p.is_finite() && p.abs().max_element() < 1e15;
    let is_finite = made.positions.iter().all(is_sound)
        && made.texcoords.iter().all(|t| t.is_finite())
        && made.colors.iter().all(|c| c.is_finite());
    match is_finite {
        true => Ok((made, points)),
        false => Err(ReadError::malformed(
            at(),
            "the mesh has numbers that are too large or none",
        )),
    }
}

fn influence(
    reader: &mut Reader<'_>,
    bind: Option<&Influences<'_>>,
    points: &[u32],
    primitive: &mut Primitive,
) -> Result<(), ReadError> {
    if let Some(bind) = bind {
        return bind.apply(reader, points, primitive);
    }
    reader.charge("mesh", 2 * points.len())?;
    primitive.influences = 1;
    primitive.joints = vec![0; points.len()];
    primitive.weights = vec![1.0; points.len()];
    Ok(())
}
