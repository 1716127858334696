//! Meshes: segments that follow one joint, and skin that follows many.
//!
//! A displacer becomes a morph target. One of a segment moves the points of the segment's
//! coordinates, one of a joint those of the skin; displacers of the skin that share a name form one
//! target, as one expression may move points on several joints.
//!
//! Source: ISO/IEC 19774-1, 6.2 (skin), 6.4 (segment), 6.6 (displacer); 19775-1, 26.3. Differs:
//! displacements are applied before skinning, where the standard adds those of a joint after it,
//! rotated by that joint alone. The two agree where one joint moves the point.

use super::corners::Faces;
use super::faces;
use super::fields::Reader;
use super::figure::{Figure, Part, PlacedShape, SkinGroup};
use super::frames::Frames;
use super::influences::Influences;
use super::look::Looks;
use super::polygon::Cutter;
use super::scene::NodeId;
use super::surface::surface;
use crate::error::ReadError;
use articula_core::source::{MorphTarget, Primitive, RawMesh, Skin};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Meshes, and the morph targets of each displacer.
#[derive(Debug, Default)]
pub(super) struct X3dMeshes {
    pub(super) meshes: Vec<RawMesh>,
    /// Mesh and morph target; one displacer may move points of several meshes.
    pub(super) targets_of_displacer: HashMap<NodeId, Vec<(usize, usize)>>,
}

/// Data shared by all groups of the skin.
struct SkinBodies {
    influences: Influences,
    moves: Vec<Move>,
    coord: Option<NodeId>,
    points: usize,
}

/// Content of one displacer.
#[derive(Debug)]
struct Move {
    id: NodeId,
    /// Whether it has a name in the file.
    is_named: bool,
    name: String,
    weight: f32,
    offsets: Vec<(u32, DVec3)>,
}

/// A morph target under construction.
#[derive(Debug)]
struct Target {
    name: String,
    weight: f32,
    displacers: Vec<NodeId>,
    /// Offset of each point that moves, in the space of the coordinates.
    offsets: BTreeMap<u32, DVec3>,
}

/// Reads the meshes of a figure: its segments in the order of the file, then its skin.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    figure: &Figure,
    frames: &Frames,
    looks: &mut Looks<'_, '_>,
) -> Result<X3dMeshes, ReadError> {
    let mut maker = Maker {
        looks,
        cutter: Cutter::default(),
        shown: X3dMeshes::default(),
        unread: BTreeMap::new(),
    };
    for part in &figure.parts {
        maker.part(reader, figure, frames, part)?;
    }
    maker.skin(reader, figure, frames)?;
    for (kind, count) in &maker.unread {
        let what = format!("{count} shapes of {kind} are left out");
        reader.notes.add("humanoid", what);
    }
    Ok(maker.shown)
}

struct Maker<'m, 'r, 'f> {
    looks: &'m mut Looks<'r, 'f>,
    cutter: Cutter,
    shown: X3dMeshes,
    /// Unsupported geometry types, with their counts.
    unread: BTreeMap<String, usize>,
}

/// A shape with its geometry.
struct Solid {
    shape: PlacedShape,
    geometry: NodeId,
    faces: Faces,
}

impl Maker<'_, '_, '_> {
    fn part(
        &mut self,
        reader: &mut Reader<'_>,
        figure: &Figure,
        frames: &Frames,
        part: &Part,
    ) -> Result<(), ReadError> {
        let solids = self.solids(reader, &part.shapes)?;
        let displacers = match reader.kind(part.id) {
            "HAnimSegment" => reader.nodes(part.id, "displacers"),
            _ => Vec::new(),
        };
        // Without a coordinate field, the displacers refer to the only geometry present.
        let coord = reader.node(part.id, "coord");
        let coord = coord.or_else(|| solids.first().and_then(|s| s.faces.coord));
        let targets = targets(read_moves(reader, &displacers)?.iter());
        let name = match reader.spelled_name(part.id) {
            name if name.is_empty() => figure.joints[part.joint].name.clone(),
            name => name,
        };
        let mut mesh = RawMesh {
            name,
            skin: Skin {
                joints: vec![part.joint + frames.first],
                inverse_bind: vec![frames.rigid[part.joint]],
            },
            ..RawMesh::default()
        };
        for solid in &solids {
            let moved = (solid.faces.coord == coord).then_some(&targets[..]);
            let made = self.primitive(reader, figure, solid, (moved, targets.len()))?;
            mesh.primitives.extend(made.map(|(mut primitive, points)| {
                primitive.influences = 1;
                primitive.joints = vec![0; points.len()];
                primitive.weights = vec![1.0; points.len()];
                primitive
            }));
        }
        self.push(mesh, targets);
        Ok(())
    }

    fn skin(
        &mut self,
        reader: &mut Reader<'_>,
        figure: &Figure,
        frames: &Frames,
    ) -> Result<(), ReadError> {
        let groups = figure.skin(reader)?;
        let mut displacers = reader.nodes(figure.id, "displacers");
        for joint in &figure.joints {
            displacers.extend(reader.nodes(joint.id, "displacers"));
        }
        if groups.iter().all(|group| group.shapes.is_empty()) {
            if !displacers.is_empty() {
                let what = format!("{} displacers affect no displayed mesh", displacers.len());
                reader.warn(figure.id, what);
            }
            return Ok(());
        }
        let coord = reader.node(figure.id, "skinCoord");
        let points = match coord {
            Some(coord) => faces::points(reader, coord)?.len(),
            None => 0,
        };
        let bodies = SkinBodies {
            influences: Influences::read(reader, figure, points)?,
            moves: read_moves(reader, &displacers)?,
            coord,
            points,
        };
        for group in &groups {
            self.skin_group(reader, (figure, frames), &bodies, group)?;
        }
        Ok(())
    }

    fn skin_group(
        &mut self,
        reader: &mut Reader<'_>,
        (figure, frames): (&Figure, &Frames),
        bodies: &SkinBodies,
        group: &SkinGroup,
    ) -> Result<(), ReadError> {
        let solids = self.solids(reader, &group.shapes)?;
        let skinned: Vec<bool> = solids
            .iter()
            .map(|solid| self.is_skin(reader, solid, bodies.coord, bodies.points))
            .collect();
        let searched: usize = bodies.moves.iter().map(|m| m.offsets.len()).sum();
        reader.charge(figure.id, searched + bodies.points)?;
        // A displacer belongs to the group if it moves one of its points.
        let mut used = vec![false; bodies.points];
        let own = solids.iter().zip(&skinned).filter(|(_, skinned)| **skinned);
        for corner in own.flat_map(|(solid, _)| solid.faces.triangles.iter().flatten()) {
            used[corner.point as usize] = true;
        }
        let is_used = |point: &u32| used.get(*point as usize) == Some(&true);
        let moves = bodies.moves.iter();
        let moves = moves.filter(|m| m.offsets.iter().any(|(point, _)| is_used(point)));
        let targets = targets(moves);
        let mut mesh = RawMesh {
            name: match group.name.as_str() {
                "" => "skin".to_owned(),
                name => name.to_owned(),
            },
            skin: Skin {
                joints: (0..figure.joints.len()).map(|j| j + frames.first).collect(),
                inverse_bind: frames.bind.clone(),
            },
            ..RawMesh::default()
        };
        for (solid, skinned) in solids.iter().zip(skinned) {
            let moved = skinned.then_some(&targets[..]);
            let made = self.primitive(reader, figure, solid, (moved, targets.len()))?;
            if let Some((mut primitive, of_vertex)) = made {
                let of_vertex = skinned.then_some(&of_vertex[..]);
                let influences = &bodies.influences;
                influences.apply(reader, solid.geometry, of_vertex, &mut primitive)?;
                mesh.primitives.push(primitive);
            }
        }
        self.push(mesh, targets);
        Ok(())
    }

    /// Returns whether a shape uses the points of the skin.
    fn is_skin(
        &self,
        reader: &mut Reader<'_>,
        solid: &Solid,
        coord: Option<NodeId>,
        points: usize,
    ) -> bool {
        if coord.is_some() && solid.faces.coord == coord {
            return true;
        }
        let copied = coord.is_some() && solid.faces.points.len() == points;
        let what = match copied {
            true => {
                "the coordinates are not a USE of skinCoord but have the same number; read as \
                 skinCoord"
            }
            false => "the coordinates are not those of skinCoord; the shape is bound to the root",
        };
        reader.warn(solid.geometry, what);
        copied
    }

    fn push(&mut self, mut mesh: RawMesh, targets: Vec<Target>) {
        if mesh.primitives.is_empty() {
            return;
        }
        let index = self.shown.meshes.len();
        for (slot, target) in targets.into_iter().enumerate() {
            for id in target.displacers {
                let targets = self.shown.targets_of_displacer.entry(id);
                targets.or_default().push((index, slot));
            }
            mesh.morph_names.push(target.name);
            mesh.morph_weights.push(target.weight);
        }
        self.shown.meshes.push(mesh);
    }

    /// Returns the shapes with supported geometry.
    fn solids(
        &mut self,
        reader: &mut Reader<'_>,
        shapes: &[PlacedShape],
    ) -> Result<Vec<Solid>, ReadError> {
        let mut solids = Vec::new();
        for &shape in shapes {
            let Some(geometry) = reader.node(shape.id, "geometry") else {
                continue;
            };
            let kind = reader.kind(geometry);
            if !faces::is_read(kind) {
                *self.unread.entry(kind.to_owned()).or_default() += 1;
                continue;
            }
            let faces = faces::read(reader, geometry, &mut self.cutter)?;
            solids.push(Solid {
                shape,
                geometry,
                faces,
            });
        }
        Ok(solids)
    }

    /// Converts a shape to a primitive without influences, and the point of each vertex; `None` if
    /// it has no triangle. The number of morph targets is kept even if none moves it.
    fn primitive(
        &mut self,
        reader: &mut Reader<'_>,
        figure: &Figure,
        solid: &Solid,
        (moved, targets): (Option<&[Target]>, usize),
    ) -> Result<Option<(Primitive, Vec<u32>)>, ReadError> {
        let id = solid.geometry;
        let look = self.looks.of(reader, solid.shape.id, solid.faces.solid)?;
        let place = figure.world * solid.shape.place;
        let surface = surface(reader, id, &solid.faces, &place, &look)?;
        if surface.triangles.is_empty() {
            return Ok(None);
        }
        let vertices = surface.positions.len();
        reader.charge(id, (3 * vertices).saturating_mul(targets))?;
        let morph = |target: usize| MorphTarget {
            positions: match moved {
                Some(all) => offsets(&all[target], &surface.point_of_vertex, &place),
                None => vec![Vec3::ZERO; vertices],
            },
            normals: Vec::new(),
        };
        let primitive = Primitive {
            positions: surface.positions,
            normals: surface.normals,
            texcoords: surface.texcoords,
            colors: surface.colors,
            morphs: (0..targets).map(morph).collect(),
            triangles: surface.triangles,
            material: Some(look.material),
            ..Primitive::default()
        };
        Ok(Some((primitive, surface.point_of_vertex)))
    }
}

fn offsets(target: &Target, point_of_vertex: &[u32], place: &DAffine3) -> Vec<Vec3> {
    let of = |point: &u32| target.offsets.get(point).copied().unwrap_or_default();
    let moved = point_of_vertex.iter().map(of);
    moved
        .map(|o| place.transform_vector3(o).as_vec3())
        .collect()
}

/// Reads displacers.
fn read_moves(reader: &mut Reader<'_>, displacers: &[NodeId]) -> Result<Vec<Move>, ReadError> {
    let mut moves = Vec::new();
    for &id in displacers {
        if reader.kind(id) != "HAnimDisplacer" {
            continue;
        }
        reader.visit(id, 0)?;
        let indices = reader.indices(id, "coordIndex")?;
        let displacements = reader.tuples::<3>(id, "displacements")?;
        if indices.len() != displacements.len() {
            let (indices, given) = (indices.len(), displacements.len());
            let what =
                format!("{indices} points and {given} displacements; the excess is left out");
            reader.warn(id, what);
        }
        reader.charge(id, 8 * indices.len())?;
        let known = |(index, offset): (&i64, &[f64; 3])| {
            let point = u32::try_from(*index).ok()?;
            Some((point, DVec3::from_array(*offset)))
        };
        moves.push(Move {
            id,
            is_named: reader
                .text(id, "name")
                .is_some_and(|n| !n.trim().is_empty()),
            name: reader.spelled_name(id),
            weight: reader.number(id, "weight", 0.0)? as f32,
            offsets: indices
                .iter()
                .zip(&displacements)
                .filter_map(known)
                .collect(),
        });
    }
    Ok(moves)
}

/// Makes morph targets of displacers; those of one name are merged.
fn targets<'m>(moves: impl Iterator<Item = &'m Move>) -> Vec<Target> {
    let mut targets: Vec<Target> = Vec::new();
    let mut of_name: HashMap<&str, usize> = HashMap::new();
    for own in moves {
        let next = targets.len();
        let slot = match own.is_named {
            true => *of_name.entry(&own.name).or_insert(next),
            false => next,
        };
        if slot == next {
            targets.push(Target {
                name: own.name.clone(),
                weight: own.weight,
                displacers: Vec::new(),
                offsets: BTreeMap::new(),
            });
        }
        let target = &mut targets[slot];
        target.displacers.push(own.id);
        for (point, offset) in &own.offsets {
            *target.offsets.entry(*point).or_default() += *offset;
        }
    }
    targets
}
