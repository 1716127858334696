//! Geometry nodes as triangles of corners.
//!
//! Source: ISO/IEC 19775-1, clause 11 (rendering) and 13 (3D geometry).

use super::corners::{Corner, Faces, NONE};
use super::fields::Reader;
use super::polygon::{Cutter, newell};
use super::scene::NodeId;
use super::solids;
use crate::error::ReadError;
use glam::{DVec2, DVec3, DVec4};

/// Elements counted for each corner of a face while it is triangulated.
const CORNER_COST: usize = 16;

/// Returns whether a geometry node type is supported.
pub(super) fn is_read(kind: &str) -> bool {
    matches!(
        kind,
        "IndexedFaceSet"
            | "IndexedTriangleSet"
            | "IndexedTriangleStripSet"
            | "IndexedTriangleFanSet"
            | "IndexedQuadSet"
            | "TriangleSet"
            | "TriangleStripSet"
            | "TriangleFanSet"
            | "QuadSet"
    ) || solids::is_solid(kind)
}

/// Reads a geometry node of a supported type.
pub(super) fn read(
    reader: &mut Reader<'_>,
    id: NodeId,
    cutter: &mut Cutter,
) -> Result<Faces, ReadError> {
    let kind = reader.kind(id);
    if solids::is_solid(kind) {
        return solids::read(reader, id);
    }
    let mut faces = lists(reader, id)?;
    let polygons = match kind {
        "IndexedFaceSet" => {
            faces.crease = reader.number(id, "creaseAngle", 0.0)? * reader.scene.radians;
            indexed_polygons(reader, id)?
        }
        _ => Polygons::of_sets(reader, id, kind, faces.points.len())?,
    };
    let convex = reader.flag(id, "convex", true);
    let mut wrong = 0;
    for (face, polygon) in polygons.faces.iter().enumerate() {
        if !faces.add(&polygons, face, polygon, (convex, &mut *cutter)) {
            wrong += 1;
        }
    }
    if wrong > 0 {
        let what =
            format!("{wrong} faces have point indices out of range or too few points; left out");
        reader.warn(id, what);
    }
    Ok(faces)
}

/// Reads the value lists of a geometry node.
fn lists(reader: &mut Reader<'_>, id: NodeId) -> Result<Faces, ReadError> {
    let coord = reader.node(id, "coord");
    let points = match coord {
        Some(coord) => points(reader, coord)?,
        None => Vec::new(),
    };
    let mut texcoords = Vec::new();
    if let Some(mut node) = reader.node(id, "texCoord") {
        if reader.kind(node) == "MultiTextureCoordinate" {
            node = reader.node(node, "texCoord").unwrap_or(node);
        }
        texcoords = reader.tuples::<2>(node, "point")?;
    }
    let mut normals = Vec::new();
    if let Some(node) = reader.node(id, "normal") {
        normals = reader.tuples::<3>(node, "vector")?;
    }
    let mut colors = Vec::new();
    if let Some(node) = reader.node(id, "color") {
        colors = match reader.kind(node) {
            "ColorRGBA" => reader.tuples::<4>(node, "color")?,
            _ => {
                let opaque = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
                let colors = reader.tuples::<3>(node, "color")?;
                colors.into_iter().map(opaque).collect()
            }
        };
    }
    Ok(Faces {
        coord,
        points,
        texcoords: texcoords.into_iter().map(DVec2::from_array).collect(),
        normals: normals.into_iter().map(DVec3::from_array).collect(),
        colors: colors.into_iter().map(DVec4::from_array).collect(),
        ccw: reader.flag(id, "ccw", true),
        solid: reader.flag(id, "solid", true),
        ..Faces::default()
    })
}

/// Reads the points of a `Coordinate` node.
pub(super) fn points(reader: &mut Reader<'_>, coord: NodeId) -> Result<Vec<DVec3>, ReadError> {
    let points = reader.tuples::<3>(coord, "point")?;
    Ok(points.into_iter().map(DVec3::from_array).collect())
}

/// Faces as lists of corners, and the mapping from corners to values.
struct Polygons {
    /// Corners of each face: index in the file's list, and point.
    faces: Vec<Vec<(usize, i64)>>,
    texcoord: Values,
    normal: Values,
    color: Values,
}

/// Mapping from a corner to a value.
enum Values {
    /// By point.
    Point,
    /// By index in the list of corners.
    Corner(Vec<i64>),
    /// By face.
    Face,
    /// By face, through an index list.
    FaceList(Vec<i64>),
}

impl Values {
    fn of(list: Vec<i64>, per_vertex: bool) -> Self {
        match (list.is_empty(), per_vertex) {
            (true, true) => Self::Point,
            (true, false) => Self::Face,
            (false, true) => Self::Corner(list),
            (false, false) => Self::FaceList(list),
        }
    }

    /// Returns the index of the value, if it exists.
    fn find(&self, face: usize, (corner, point): (usize, i64), count: usize) -> u32 {
        let index = match self {
            Self::Point => Some(point),
            Self::Corner(list) => list.get(corner).copied(),
            Self::Face => i64::try_from(face).ok(),
            Self::FaceList(list) => list.get(face).copied(),
        };
        let known = index.filter(|i| (0..count as i64).contains(i));
        known.and_then(|i| u32::try_from(i).ok()).unwrap_or(NONE)
    }
}

/// Reads the faces of an `IndexedFaceSet`, separated by -1.
fn indexed_polygons(reader: &mut Reader<'_>, id: NodeId) -> Result<Polygons, ReadError> {
    let indices = reader.indices(id, "coordIndex")?;
    reader.charge(id, CORNER_COST * indices.len())?;
    let mut faces = Vec::new();
    let mut open = Vec::new();
    for (corner, &point) in indices.iter().enumerate() {
        match point {
            -1 => faces.push(std::mem::take(&mut open)),
            point => open.push((corner, point)),
        }
    }
    if !open.is_empty() {
        faces.push(open);
    }
    let normal_per_vertex = reader.flag(id, "normalPerVertex", true);
    let color_per_vertex = reader.flag(id, "colorPerVertex", true);
    Ok(Polygons {
        faces,
        texcoord: Values::of(reader.indices(id, "texCoordIndex")?, true),
        normal: Values::of(reader.indices(id, "normalIndex")?, normal_per_vertex),
        color: Values::of(reader.indices(id, "colorIndex")?, color_per_vertex),
    })
}

impl Polygons {
    /// Reads the faces of triangle and quad sets, indexed or not.
    fn of_sets(
        reader: &mut Reader<'_>,
        id: NodeId,
        kind: &str,
        points: usize,
    ) -> Result<Self, ReadError> {
        let order = match kind.starts_with("Indexed") {
            true => reader.indices(id, "index")?,
            false => (0..points as i64).collect(),
        };
        reader.charge(id, 2 * CORNER_COST * order.len())?;
        let split = || order.split(|i| *i == -1);
        let faces = match kind {
            "TriangleSet" | "IndexedTriangleSet" => chunks(&order, 3),
            "QuadSet" | "IndexedQuadSet" => chunks(&order, 4),
            "IndexedTriangleStripSet" => split().flat_map(strip).collect(),
            "IndexedTriangleFanSet" => split().flat_map(fan).collect(),
            "TriangleStripSet" => {
                let counts = reader.indices(id, "stripCount")?;
                runs(&order, &counts).into_iter().flat_map(strip).collect()
            }
            _ => {
                let counts = reader.indices(id, "fanCount")?;
                runs(&order, &counts).into_iter().flat_map(fan).collect()
            }
        };
        let per_vertex = |of: &str| reader.flag(id, of, true);
        Ok(Self {
            faces,
            texcoord: Values::Point,
            normal: Values::of(Vec::new(), per_vertex("normalPerVertex")),
            // Colours of these sets are always per point.
            color: Values::Point,
        })
    }
}

type Polygon = Vec<(usize, i64)>;

fn corners(points: impl IntoIterator<Item = i64>) -> Polygon {
    points.into_iter().enumerate().collect()
}

fn chunks(points: &[i64], size: usize) -> Vec<Polygon> {
    let whole = points.chunks_exact(size);
    whole.map(|c| corners(c.iter().copied())).collect()
}

/// Splits a list into runs of the given lengths.
fn runs<'p>(points: &'p [i64], counts: &[i64]) -> Vec<&'p [i64]> {
    let mut rest = points;
    let mut list = Vec::new();
    for count in counts {
        let length = usize::try_from(*count).unwrap_or(0).min(rest.len());
        let (run, after) = rest.split_at(length);
        list.push(run);
        rest = after;
    }
    list
}

/// Every second triangle of a strip has opposite orientation.
fn strip(points: &[i64]) -> Vec<Polygon> {
    let triangles = points.windows(3).enumerate();
    let turned = |(i, t): (usize, &[i64])| match i % 2 {
        0 => corners([t[0], t[1], t[2]]),
        _ => corners([t[1], t[0], t[2]]),
    };
    triangles.map(turned).collect()
}

fn fan(points: &[i64]) -> Vec<Polygon> {
    let pairs = points.windows(2).skip(1);
    pairs.map(|p| corners([points[0], p[0], p[1]])).collect()
}

impl Faces {
    /// Triangulates one face; returns whether it was valid.
    fn add(
        &mut self,
        polygons: &Polygons,
        face: usize,
        polygon: &[(usize, i64)],
        (convex, cutter): (bool, &mut Cutter),
    ) -> bool {
        let count = self.points.len() as i64;
        let good = polygon.iter().all(|(_, point)| (0..count).contains(point));
        if !good || polygon.len() < 3 {
            return false;
        }
        let points: Vec<DVec3> = polygon
            .iter()
            .map(|(_, point)| self.points[*point as usize])
            .collect();
        let corner = |i: usize| {
            let at = polygon[i];
            Corner {
                point: u32::try_from(at.1).unwrap_or(NONE),
                texcoord: polygons.texcoord.find(face, at, self.texcoords.len()),
                normal: polygons.normal.find(face, at, self.normals.len()),
                color: polygons.color.find(face, at, self.colors.len()),
            }
        };
        let own_face = u32::try_from(self.face_normals.len()).unwrap_or(NONE);
        let triangles = cutter.triangles(&points, convex);
        for triangle in triangles {
            let [a, b, c] = triangle.map(corner);
            // A triangle with two equal points has no area.
            if a.point != b.point && b.point != c.point && c.point != a.point {
                self.triangles.push([a, b, c]);
                self.face_of_triangle.push(own_face);
            }
        }
        self.face_normals.push(newell(&points));
        true
    }
}
