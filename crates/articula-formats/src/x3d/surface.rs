//! From corners to vertices: normals by crease angle, texture coordinates, colours, merging.
//!
//! Source: ISO/IEC 19775-1, 11.2.3 (common geometry fields) and 13.3.5 (crease angle, default
//! texture coordinates).

use super::corners::{Corner, Faces, NONE};
use super::fields::Reader;
use super::look::{ShapeAppearance, linear};
use super::scene::NodeId;
use crate::error::ReadError;
use articula_core::Libm;
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Maximum number of faces at a point for which the crease angle applies; with more, the point is
/// smooth.
const MAX_CREASED: usize = 64;

/// Vertices and triangles of one shape.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) texcoords: Vec<Vec2>,
    /// Linear RGBA.
    pub(super) colors: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The point of the file that each vertex comes from.
    pub(super) point_of_vertex: Vec<u32>,
}

/// Key by which corners are merged into vertices.
type Key = (u32, u32, u32, [u32; 3]);

/// Makes vertices of corners; `place` transforms the file's space to model space.
pub(super) fn surface(
    reader: &mut Reader<'_>,
    id: NodeId,
    faces: &Faces,
    place: &DAffine3,
    look: &ShapeAppearance,
) -> Result<Surface, ReadError> {
    reader.charge(id, 12 * faces.triangles.len())?;
    let texcoords = texcoords(faces, look);
    let own_texcoords = !faces.texcoords.is_empty();
    let normals = Normals::new(faces);
    let normal_matrix = place.matrix3.inverse().transpose();
    let turns = place.matrix3.determinant() < 0.0;
    let mut surface = Surface::default();
    let mut known: HashMap<Key, u32> = HashMap::new();
    for (triangle, &face) in faces.triangles.iter().zip(&faces.face_of_triangle) {
        let mut vertices = [0; 3];
        for (vertex, corner) in vertices.iter_mut().zip(triangle) {
            let normal = normals.at(faces, corner, face);
            let texcoord = match own_texcoords {
                true => corner.texcoord,
                false => corner.point,
            };
            let bits = normal.as_vec3().to_array().map(f32::to_bits);
            let key = (corner.point, texcoord, corner.color, bits);
            *vertex = *known.entry(key).or_insert_with(|| {
                let point = place.transform_point3(faces.points[corner.point as usize]);
                surface.positions.push(point.as_vec3());
                let normal = (normal_matrix * normal).normalize_or(DVec3::Y);
                surface.normals.push(normal.as_vec3());
                if let Some(list) = &texcoords {
                    let texcoord = list.get(texcoord as usize).copied();
                    surface
                        .texcoords
                        .push(texcoord.unwrap_or_default().as_vec2());
                }
                if !faces.colors.is_empty() {
                    surface.colors.push(color(faces, corner));
                }
                surface.point_of_vertex.push(corner.point);
                surface.point_of_vertex.len() as u32 - 1
            });
        }
        if faces.ccw == turns {
            vertices.swap(1, 2);
        }
        surface.triangles.push(vertices);
    }
    let sound = surface
        .positions
        .iter()
        .all(|p| p.abs().max_element() < 1e15);
    match sound {
        true => Ok(surface),
        false => Err(reader.malformed(id, "the positions of the shape are too large")),
    }
}

/// Returns a corner's colour, converted from the file's sRGB.
fn color(faces: &Faces, corner: &Corner) -> Vec4 {
    let given = faces.colors.get(corner.color as usize);
    let [r, g, b, a] = given.map_or([1.0; 4], |c| c.to_array());
    let [r, g, b] = [r, g, b].map(linear);
    Vec4::new(r, g, b, a.clamp(0.0, 1.0) as f32)
}

/// Returns texture coordinates with the origin at the top. If the file has none, the standard's
/// default applies: the longest side of the bounding box runs from 0 to 1.
fn texcoords(faces: &Faces, look: &ShapeAppearance) -> Option<Vec<DVec2>> {
    let down = |t: DVec2| {
        let moved = look.texture_move.map_or(t, |m| m.apply(t));
        DVec2::new(moved.x, 1.0 - moved.y)
    };
    if !faces.texcoords.is_empty() {
        return Some(faces.texcoords.iter().copied().map(down).collect());
    }
    if !look.textured {
        return None;
    }
    let low = faces.points.iter().fold(DVec3::MAX, |l, p| l.min(*p));
    let high = faces.points.iter().fold(DVec3::MIN, |h, p| h.max(*p));
    let size = (high - low).to_array();
    // Longest first; of equal sides X before Y before Z.
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a: &usize, &b: &usize| size[b].total_cmp(&size[a]));
    let [s, t, _] = axes;
    let length = size[s].max(1e-12);
    let of = |p: &DVec3| {
        let from = (*p - low).to_array();
        down(DVec2::new(from[s], from[t]) / length)
    };
    Some(faces.points.iter().map(of).collect())
}

/// Computed normals where the file has none: faces around each point.
struct Normals {
    /// Start of each point's range in `around`, and the end of the last.
    starts: Vec<u32>,
    /// Faces, point by point.
    around: Vec<u32>,
    /// Unit normals of the faces.
    units: Vec<DVec3>,
    /// Sum of the face normals around each point.
    sums: Vec<DVec3>,
}

impl Normals {
    fn new(faces: &Faces) -> Self {
        let mut normals = Self {
            starts: Vec::new(),
            around: Vec::new(),
            units: Vec::new(),
            sums: Vec::new(),
        };
        if !faces.normals.is_empty() {
            return normals;
        }
        let of = |n: &DVec3| n.normalize_or_zero();
        normals.units = faces.face_normals.iter().map(of).collect();
        let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(3 * faces.triangles.len());
        for (triangle, &face) in faces.triangles.iter().zip(&faces.face_of_triangle) {
            pairs.extend(triangle.iter().map(|corner| (corner.point, face)));
        }
        pairs.sort_unstable();
        pairs.dedup();
        normals.starts = vec![0; faces.points.len() + 1];
        normals.sums = vec![DVec3::ZERO; faces.points.len()];
        for (point, face) in pairs {
            normals.starts[point as usize + 1] += 1;
            normals.sums[point as usize] += faces.face_normals[face as usize];
            normals.around.push(face);
        }
        for i in 1..normals.starts.len() {
            normals.starts[i] += normals.starts[i - 1];
        }
        normals
    }

    /// Returns the normal of a corner, on the side of its face's normal.
    fn at(&self, faces: &Faces, corner: &Corner, face: u32) -> DVec3 {
        if corner.normal != NONE {
            return faces.normals[corner.normal as usize].normalize_or(DVec3::Y);
        }
        if self.units.is_empty() {
            return faces.face_normals[face as usize].normalize_or(DVec3::Y);
        }
        let turned = if faces.ccw { 1.0 } else { -1.0 };
        let (own, point) = (self.units[face as usize], corner.point as usize);
        let around = &self.around[self.starts[point] as usize..self.starts[point + 1] as usize];
        let smooth = faces.crease >= std::f64::consts::PI - 1e-3 || around.len() > MAX_CREASED;
        let sum = if faces.crease <= 0.0 {
            own
        } else if smooth {
            self.sums[point]
        } else {
            let least = faces.crease.libm_cos();
            let near = around
                .iter()
                .filter(|&&f| f == face || self.units[f as usize].dot(own) > least);
            near.map(|&f| faces.face_normals[f as usize]).sum()
        };
        sum.normalize_or(own) * turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::notes::Notes;
    use crate::x3d::polygon::Cutter;
    use crate::x3d::{classic, faces};

    fn of(geometry: &str, place: DAffine3) -> Surface {
        let text = format!("#X3D V3.3 utf8\n{geometry}");
        let limits = Limits::default();
        let scene = classic::parse(&text, &limits).unwrap().scene;
        let mut reader = Reader::new(&scene, &limits, Notes::default());
        let root = scene.roots[0];
        let faces = faces::read(&mut reader, root, &mut Cutter::default()).unwrap();
        let look = ShapeAppearance {
            material: 0,
            textured: false,
            texture_move: None,
        };
        surface(&mut reader, root, &faces, &place, &look).unwrap()
    }

    /// Two squares that meet at the Y axis in a right angle.
    const BENT: &str = "coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 -1, 0 1 -1 ] }
        coordIndex [ 0 1 2 3 -1 4 0 3 5 -1 ]";

    #[test]
    fn creases_part_vertices() {
        let flat = of(&format!("IndexedFaceSet {{ {BENT} }}"), DAffine3::IDENTITY);
        assert_eq!((flat.positions.len(), flat.triangles.len()), (8, 4));
        assert_eq!(flat.normals[0], Vec3::Z);
        let smooth = "IndexedFaceSet { creaseAngle 3.2 ";
        let smooth = of(&format!("{smooth} {BENT} }}"), DAffine3::IDENTITY);
        assert_eq!(smooth.positions.len(), 6);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        assert!(smooth.normals[0].distance(Vec3::new(-half, 0.0, half)) < 1e-6);
        let sharp = "IndexedFaceSet { creaseAngle 1.5 ";
        assert_eq!(
            of(&format!("{sharp} {BENT} }}"), DAffine3::IDENTITY)
                .positions
                .len(),
            8
        );
    }

    #[test]
    fn mirrors_and_clockwise_faces_keep_their_outside() {
        let outward = |s: &Surface| {
            s.triangles.iter().all(|t| {
                let [a, b, c] = t.map(|i| s.positions[i as usize]);
                let normal = s.normals[t[0] as usize];
                (b - a).cross(c - a).dot(normal) > 0.0
            })
        };
        for mirror in [1.0, -1.0] {
            let place = DAffine3::from_scale(DVec3::new(mirror, 2.0, 1.0));
            assert!(outward(&of(&format!("IndexedFaceSet {{ {BENT} }}"), place)));
            let turned = "IndexedFaceSet { ccw FALSE ";
            assert!(outward(&of(&format!("{turned} {BENT} }}"), place)));
            for solid in ["Box {}", "Sphere {}", "Cylinder {}", "Cone {}"] {
                assert!(outward(&of(solid, place)), "{solid}");
            }
        }
    }

    #[test]
    fn sets_and_strips_are_cut_as_the_standard_says() {
        let points = "coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0, 1 1 0, 0 2 0, 1 2 0 ] }";
        let count = |node: &str| {
            let surface = of(&format!("{node} {points} }}"), DAffine3::IDENTITY);
            let up = surface.normals.iter().all(|n| *n == Vec3::Z);
            assert!(up, "{node}");
            surface.triangles.len()
        };
        assert_eq!(count("TriangleStripSet { stripCount [ 4 ]"), 2);
        assert_eq!(
            count("IndexedTriangleStripSet { index [ 0 1 2 3 4 5 -1 ]"),
            4
        );
        assert_eq!(
            count("IndexedTriangleFanSet { index [ 0 1 3 2 -1 2 3 5 4 ]"),
            4
        );
        assert_eq!(count("IndexedTriangleSet { index [ 0 1 2 1 3 2 9 9 ]"), 2);
        assert_eq!(count("IndexedQuadSet { index [ 0 1 3 2 ]"), 2);
        // A face with a missing point is left out, the others stay.
        assert_eq!(count("IndexedFaceSet { coordIndex [ 0 1 7 -1 0 1 3 2 ]"), 2);
        assert_eq!(count("IndexedFaceSet { coordIndex [ 0 1 -1 0 -1 -1 ]"), 0);
    }

    #[test]
    fn values_are_found_by_corner_face_and_point() {
        let colored = |fields: &str| {
            let color = "color Color { color [ 1 0 0, 0 1 0 ] }";
            of(
                &format!("IndexedFaceSet {{ {BENT} {color} {fields} }}"),
                DAffine3::IDENTITY,
            )
        };
        let by_face = colored("colorPerVertex FALSE colorIndex [ 1 0 ]");
        let green = Vec4::new(0.0, 1.0, 0.0, 1.0);
        assert!(by_face.colors[..4].iter().all(|c| *c == green));
        assert_eq!(by_face.colors[4], Vec4::new(1.0, 0.0, 0.0, 1.0));
        let by_corner = colored("colorIndex [ 0 1 0 1 -1 1 1 1 1 -1 ]");
        assert_eq!(by_corner.colors[1], green);
        // A corner without a colour is white.
        assert_eq!(colored("").colors[2], Vec4::ONE);
        let textured = of(
            &format!(
                "IndexedFaceSet {{ {BENT} texCoord TextureCoordinate {{ point [ 0 0, 1 0.25 ] }}
                 texCoordIndex [ 0 1 1 0 -1 0 1 1 0 -1 ] }}"
            ),
            DAffine3::IDENTITY,
        );
        assert_eq!(textured.texcoords[1], Vec2::new(1.0, 0.75));
    }
}
