//! The feature points of a figure as an FDP file, and the points of such a file on a figure.

use super::found::FoundFace;
use super::points::named;
use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use crate::open::CharacterFile;
use articula_build::face::{FaceTable, FapValues};
use articula_core::PosedMesh;
use articula_core::fap_table::{LOW_FAPS, TABLE};
use articula_core::feature_points::{PointId, feature_point_index};
use articula_core::source::RawMesh;
use articula_formats::mpeg4::fdp::{self, FapInfluence, Fapu, FdpFile, MeshSource};
use glam::{Quat, Vec3};

/// Displacement of a vertex in a zone, by the greatest one in it.
const IN_ZONE: f32 = 0.02;
/// Falloff that Xface uses for most of its own points.
const FALLOFF: &str = "RaisedCosInfluenceSph";

/// The feature points of a figure's face as an FDP file for its meshes, with the units of the face and the
/// zone of each point: the vertices of its mesh that its parameters move by the face animation table.
/// Lengths are metres. `given` are points that are known, with their places in model space. Points
/// inside the head, for which no vertex stands, are left out.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if it shows too little of a face.
pub fn face_fdp(figure: &Figure, given: &[(PointId, Vec3)]) -> Result<FdpFile> {
    let face = FoundFace::of(figure, given).context(figure.opened.name())?;
    let table = face.table().context(figure.opened.name())?;
    let vertices = figure
        .in_character(&face.head.vertices)
        .context(figure.opened.name())?;
    let points = face.points;
    let units = points.units();
    let meshes = &figure.opened.character().meshes;
    let firsts: Vec<usize> = meshes
        .iter()
        .scan(0, |next, mesh| {
            let first = *next;
            *next += vertices_of(mesh);
            Some(first)
        })
        .collect();
    let mesh_of = |vertex: usize| firsts.partition_point(|first| *first <= vertex) - 1;
    let mut file = FdpFile {
        fapu: Fapu {
            irisd0: units.iris_diameter,
            es0: units.eye_separation,
            ens0: units.eye_nose,
            mns0: units.mouth_nose,
            mw0: units.mouth_width,
        },
        rotation: Quat::IDENTITY,
        sources: vec![MeshSource {
            alias: "Rest".to_owned(),
            category: "Expression".to_owned(),
            meshes: vec![figure.opened.name().to_owned()],
            parts: Vec::new(),
        }],
        ..FdpFile::default()
    };
    for point in &points.points {
        let Some(vertex) = point.vertex else { continue };
        let vertex = vertices[vertex as usize] as usize;
        let mesh = mesh_of(vertex);
        let (moved_by, in_zone) = zone(&table, point.point, vertices.len());
        let zone = vertices.iter().zip(in_zone).filter(|(_, inside)| *inside);
        let zone = zone
            .map(|(v, _)| *v as usize)
            .filter(|v| mesh_of(*v) == mesh);
        let influence = |fap| FapInfluence {
            fap,
            kind: FALLOFF.to_owned(),
            weight: 1.0,
        };
        file.points.push(fdp::FeaturePoint {
            point: point.point,
            mesh: meshes[mesh].name.clone(),
            vertex: (vertex - firsts[mesh]) as u32,
            zone: zone.map(|v| (v - firsts[mesh]) as u32).collect(),
            influences: moved_by.into_iter().map(influence).collect(),
        });
    }
    Ok(file)
}

/// The parameters that move a point, and whether they move each vertex of the head.
fn zone(table: &FaceTable, point: PointId, vertices: usize) -> (Vec<usize>, Vec<bool>) {
    let of_point = |fap: &usize| TABLE[fap - 1].action.is_some_and(|a| a.point == point);
    let moved_by: Vec<usize> = LOW_FAPS
        .filter(of_point)
        .filter(|f| table.moves(*f))
        .collect();
    let mut in_zone = vec![false; vertices];
    for fap in &moved_by {
        let offsets = table.displacements(&FapValues::alone(*fap, 100.0));
        let most = offsets.iter().map(|o| o.length()).fold(0.0, f32::max);
        for (inside, offset) in in_zone.iter_mut().zip(&offsets) {
            *inside |= most > 0.0 && offset.length() > IN_ZONE * most;
        }
    }
    (moved_by, in_zone)
}

fn vertices_of(mesh: &RawMesh) -> usize {
    mesh.primitives.iter().map(|p| p.positions.len()).sum()
}

/// Returns the places of the feature points of an FDP file on a figure, whose mesh it is made for:
/// it names a mesh and a vertex for each.
///
/// # Errors
/// [`Error::Argument`] that names the point, if the figure lacks its vertex or the standard the
/// point.
pub fn fdp_points(character: &CharacterFile, file: &FdpFile) -> Result<Vec<(PointId, Vec3)>> {
    let figure = Figure::new(character.clone())?;
    let asset = &figure.asset;
    let still = vec![0.0; asset.mesh.morph_weights.len()];
    let places = PosedMesh::new(&asset.rig, &asset.mesh)
        .pose(asset.rig.rest_pose())
        .skinned(&still)
        .positions;
    let meshes = &character.character().meshes;
    let place = |point: &fdp::FeaturePoint| {
        feature_point_index(point.point)?;
        // The only mesh of a figure may have another name.
        let named = meshes.iter().position(|m| m.name == point.mesh);
        let mesh = named.or_else(|| (meshes.len() == 1).then_some(0))?;
        let vertex = point.vertex as usize;
        let first: usize = meshes[..mesh].iter().map(vertices_of).sum();
        (vertex < vertices_of(&meshes[mesh])).then(|| places[first + vertex])
    };
    let points = file.points.iter().map(|point| {
        let found = place(point).map(|at| (point.point, at));
        found.ok_or_else(|| {
            Error::argument(format!(
                "point {}: the figure has no vertex {} of a mesh \"{}\"; give the FDP file made for it",
                named(point.point),
                point.vertex,
                point.mesh
            ))
        })
    });
    points.collect()
}
