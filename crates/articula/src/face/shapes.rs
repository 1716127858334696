//! Blend shapes for a face without them, made from its feature points.

use super::stored::found;
use super::surface::HeadSurface;
use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use crate::open::CharacterFile;
use articula_build::face::{FacePoints, FaceTable, blend_shape, normal_offsets};
use articula_core::arkit_table::BLEND_SHAPES;
use articula_core::feature_points::PointId;
use articula_core::source::{Character, MorphTarget, Primitive, RawMesh, Skin};
use glam::{Affine3A, Quat, Vec3};
use serde::Serialize;

/// Share of the values of `cheekPuff` that its shape shows. They are 24 mm on an average face; the own
/// shapes of faces puff the cheeks by 4 to 6 mm.
const PUFF: f32 = 0.25;

/// Blend shapes that were made for a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceShapes {
    /// Names in ARKit of the shapes that were made.
    pub made: Vec<&'static str>,
    /// Names of those that nothing of the face shows.
    pub not_made: Vec<&'static str>,
    /// Number of vertices that any of them moves.
    pub vertices: usize,
    /// Units of the face that may be wrong.
    pub doubtful: Vec<String>,
}

/// Adds the blend shapes of ARKit to a character whose meshes have no morph targets, made by the
/// face animation table of its feature points (`docs/methods/faces.md`). `given` are points that are
/// known, with their places in model space.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if a mesh of the head has morph targets, or the figure
/// shows too little of a face; the character is then unchanged.
pub fn add_face_shapes(
    opened: &mut CharacterFile,
    given: &[(PointId, Vec3)],
) -> Result<FaceShapes> {
    made(opened, given).with_context(|| opened.name.clone())
}

fn made(opened: &mut CharacterFile, given: &[(PointId, Vec3)]) -> Result<FaceShapes> {
    let figure = Figure::new(opened.clone())?;
    let head = HeadSurface::of(&figure);
    let no_face = |e: &dyn std::fmt::Display| {
        Error::unsuited(format!(
            "face: {e}; blend shapes are made for a closed face with nose and mouth"
        ))
    };
    let points = found(&figure, &head, given).map_err(|e| no_face(&e))?;
    let table = FaceTable::new(&head.surface, &points);
    let table = table.ok_or_else(|| no_face(&"its feature points lie in a plane"))?;

    let mut report = FaceShapes {
        made: Vec::new(),
        not_made: Vec::new(),
        vertices: 0,
        doubtful: doubtful(&points),
    };
    // Offsets in the frame of the head, of places and of normals.
    let mut shapes: Vec<[Vec<Vec3>; 2]> = Vec::new();
    let mut moves = vec![false; head.vertices.len()];
    for shape in &BLEND_SHAPES {
        let mut values = blend_shape(shape.name).unwrap_or_default();
        if shape.name == "cheekPuff" {
            values.0.iter_mut().for_each(|v| *v *= PUFF);
        }
        let offsets = table.displacements(&values);
        if offsets.iter().all(|o| *o == Vec3::ZERO) {
            report.not_made.push(shape.name);
            continue;
        }
        for (moves, offset) in moves.iter_mut().zip(&offsets) {
            *moves |= *offset != Vec3::ZERO;
        }
        let normals = normal_offsets(&head.surface, &offsets);
        report.made.push(shape.name);
        shapes.push([offsets, normals]);
    }
    report.vertices = moves.iter().filter(|m| **m).count();

    let mut meshes = opened.character.meshes.clone();
    let places = places_of(&meshes);
    let rest = opened.character.skeleton.model_rest();
    let mut touched = vec![false; meshes.len()];
    for (vertex, _) in head.vertices.iter().zip(&moves).filter(|(_, m)| **m) {
        touched[places[*vertex as usize].0] = true;
    }
    let of_touched = |mesh: usize| touched[mesh];
    if let Some(mesh) =
        (0..meshes.len()).find(|m| of_touched(*m) && !meshes[*m].morph_names.is_empty())
    {
        let what = format!(
            "face: mesh \"{}\" has morph targets; blend shapes are made for faces without any",
            meshes[mesh].name
        );
        return Err(Error::unsuited(what));
    }
    for mesh in (0..meshes.len()).filter(|m| of_touched(*m)) {
        prepare(&mut meshes[mesh], &report.made);
    }
    for (index, vertex) in head.vertices.iter().enumerate().filter(|(i, _)| moves[*i]) {
        let (mesh, primitive, v) = places[*vertex as usize];
        let mesh = &mut meshes[mesh];
        let skin = skin_rotation(&mesh.skin, &mesh.primitives[primitive], v, &rest);
        let turn = skin.rotation.inverse() * head.model_from_head;
        for (target, [offsets, normals]) in
            mesh.primitives[primitive].morphs.iter_mut().zip(&shapes)
        {
            target.positions[v] = turn * offsets[index] / skin.scale;
            target.normals[v] = turn * normals[index];
        }
    }
    put(opened, meshes, &touched)?;
    Ok(report)
}

/// Mesh, primitive and vertex of each vertex of a figure.
fn places_of(meshes: &[RawMesh]) -> Vec<(usize, usize, usize)> {
    let mut places = Vec::new();
    for (m, mesh) in meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            places.extend((0..primitive.positions.len()).map(|v| (m, p, v)));
        }
    }
    places
}

/// Gives a mesh empty morph targets with these names.
fn prepare(mesh: &mut RawMesh, names: &[&str]) {
    mesh.morph_names = names.iter().map(|n| (*n).to_owned()).collect();
    mesh.morph_weights = vec![0.0; names.len()];
    for primitive in &mut mesh.primitives {
        let count = primitive.positions.len();
        let target = MorphTarget {
            positions: vec![Vec3::ZERO; count],
            normals: vec![Vec3::ZERO; count],
        };
        primitive.morphs = vec![target; names.len()];
    }
}

/// Rotation and uniform scale from mesh space to model space.
struct SkinTurn {
    rotation: Quat,
    scale: f32,
}

/// How the joints at rest place a vertex.
fn skin_rotation(skin: &Skin, primitive: &Primitive, vertex: usize, rest: &[Affine3A]) -> SkinTurn {
    let range = vertex * primitive.influences..(vertex + 1) * primitive.influences;
    let influences = primitive.joints[range.clone()]
        .iter()
        .zip(&primitive.weights[range]);
    let heaviest = influences.max_by(|a, b| a.1.total_cmp(b.1));
    let joint = heaviest.map_or(0, |(joint, _)| usize::from(*joint));
    let matrix = match (skin.joints.get(joint), skin.inverse_bind.get(joint)) {
        (Some(joint), Some(bind)) => rest[*joint] * *bind,
        _ => Affine3A::IDENTITY,
    };
    let (scale, rotation, _) = matrix.to_scale_rotation_translation();
    SkinTurn {
        rotation,
        scale: (scale.element_sum() / 3.0).max(1e-9),
    }
}

/// Stores the meshes in the character and in the document behind it.
fn put(opened: &mut CharacterFile, meshes: Vec<RawMesh>, touched: &[bool]) -> Result<()> {
    if let Some(behind) = &mut opened.gltf {
        let mut document = behind.document.clone();
        for mesh in (0..meshes.len()).filter(|m| touched[*m]) {
            document.add_morph_targets(behind.node_of_mesh[mesh], &meshes[mesh])?;
        }
        behind.document = document;
    }
    let Character { meshes: own, .. } = &mut opened.character;
    *own = meshes;
    Ok(())
}

fn doubtful(points: &FacePoints) -> Vec<String> {
    let ratios = points.units().ratios(points.height());
    let doubtful = ratios.into_iter().filter(|(_, r)| r.doubtful);
    doubtful.map(|(unit, _)| unit.to_string()).collect()
}
