//! Correspondence between the vertices of the original and points of a coarser surface.
//!
//! The closest point at rest may lie on another part of the body: on the other lip, or on the arm
//! beside the hip. Therefore the closest point is looked for again in the pose in which the one found last is
//! farthest, as long as the maximum distance over all poses falls. Points lie on the same part of the mesh or on one of the same
//! material, which looks alike: a buckle that is left out is where the belt is. Where a stripe is left out in part, its
//! border has moved, by half of its width and not by the length that is missing: a point at the border of the material, on whatever
//! surface is there, is as good.

use super::borders::Borders;
use super::skin_point::SkinPoint;
use super::tree::SurfaceTree;
use articula_core::Part;
use glam::Vec3;

/// Returns, for each of the given vertices of the original, the corresponding point of a level's
/// surface: on the same part of the mesh or on another of its material, if the level has triangles of that
/// part, else on any; or the point of any that is closest to the nearest border of its material, if that is closer. A
/// vertex without a finite distance to the level corresponds to itself. `poses` are positions of all vertices;
/// without any, all vertices correspond to themselves. `borders` are those of the original. O(rounds · vertices · (poses +
/// log(triangles)) + poses · triangles).
///
/// # Panics
/// If a vertex or a triangle is out of range of the poses.
pub fn attach(
    triangles: &[[u32; 3]],
    vertices: &[u32],
    poses: &[Vec<Vec3>],
    parts: &[Part],
    borders: &Borders,
) -> Vec<SkinPoint> {
    let found = vertices.iter().map(|v| SkinPoint::at(*v)).collect();
    if poses.is_empty() {
        return found;
    }
    let tracks = Tracks::of(poses);
    let mut attached = Attached {
        vertices,
        poses,
        tracks,
        least: vec![Farthest::default(); vertices.len()],
        found,
    };
    for (surface, places) in searches(triangles, vertices, parts) {
        let own = places.iter().map(|place| (*place, vertices[*place]));
        attached.look(&surface, own.collect());
    }
    let at_borders = attached.at_borders(parts, borders);
    attached.look(triangles, at_borders);
    attached.found
}

/// Vertices and the points found so far.
struct Attached<'a> {
    vertices: &'a [u32],
    poses: &'a [Vec<Vec3>],
    tracks: Tracks,
    least: Vec<Farthest>,
    found: Vec<SkinPoint>,
}

impl Attached<'_> {
    /// Looks for closer points on a surface: for vertices, by their places, those that are closest to other vertices.
    fn look(&mut self, surface: &[[u32; 3]], places: Vec<(usize, u32)>) {
        if places.is_empty() {
            return;
        }
        let mut tree = SurfaceTree::new(surface, &self.poses[0]);
        let pose_of = |least: &[Farthest], place: usize| least[place].pose;
        let of_place = |(place, to)| (pose_of(&self.least, place), place, to);
        let mut open: Vec<(usize, usize, u32)> = places.into_iter().map(of_place).collect();
        for _ in 0..ROUNDS {
            open.sort_unstable();
            let mut again = Vec::new();
            for group in open.chunk_by(|a, b| a.0 == b.0) {
                let pose = group[0].0;
                tree.refit(&self.poses[pose]);
                for (_, place, to) in group {
                    if self.take_nearer(&tree, *place, *to, pose) {
                        again.push((pose_of(&self.least, *place), *place, *to));
                    }
                }
            }
            open = again;
        }
    }

    /// Takes the point that is closest to a vertex in one pose if its maximum distance over all poses is smaller than that
    /// of the point so far.
    fn take_nearer(&mut self, tree: &SurfaceTree, place: usize, to: u32, pose: usize) -> bool {
        let pose = &self.poses[pose];
        let at = pose[to as usize];
        let least = self.least[place].squared;
        if least == 0.0 || !at.is_finite() {
            return false;
        }
        let Some(found) = tree.closest_point(at, pose) else {
            return false;
        };
        match self.tracks.farthest(&found, self.vertices[place], least) {
            Some(farthest) => {
                (self.least[place], self.found[place]) = (farthest, found);
                true
            }
            None => false,
        }
    }

    /// The places of vertices that are farther from their points than from the border of their material, and the nearest
    /// vertex on that.
    fn at_borders(&self, parts: &[Part], borders: &Borders) -> Vec<(usize, u32)> {
        let of_vertex = parts_of_vertices(parts);
        let rest = &self.poses[0];
        let border = |(place, v): (usize, &u32)| {
            let part = parts.get(*of_vertex.get(*v as usize)?)?;
            let (at, least) = (rest[*v as usize], self.least[place].squared);
            if !(at.is_finite() && least.is_finite()) {
                return None;
            }
            Some((place, borders.nearest(part.material, at, least)?))
        };
        let all = self.vertices.iter().enumerate();
        all.filter_map(border).collect()
    }
}

/// How often the pose in which a point is farthest is looked at.
const ROUNDS: usize = 6;

/// The greatest distance of a point from its vertex, and the pose of it.
#[derive(Debug, Clone, Copy)]
struct Farthest {
    squared: f32,
    pose: usize,
}

impl Default for Farthest {
    fn default() -> Self {
        Self {
            squared: f32::INFINITY,
            pose: 0,
        }
    }
}

/// Positions of each vertex in all poses, vertex by vertex.
struct Tracks {
    poses: usize,
    points: Vec<Vec3>,
}

impl Tracks {
    fn of(poses: &[Vec<Vec3>]) -> Self {
        let vertices = poses.first().map_or(0, Vec::len);
        let of_vertex = |v: usize| poses.iter().map(move |pose| pose[v]);
        Self {
            poses: poses.len(),
            points: (0..vertices).flat_map(of_vertex).collect(),
        }
    }

    fn vertex(&self, v: u32) -> &[Vec3] {
        let first = v as usize * self.poses;
        &self.points[first..first + self.poses]
    }

    /// Where a point is farthest from a vertex; `None` if not below a limit. A distance that is not finite
    /// counts as 0.
    fn farthest(&self, point: &SkinPoint, vertex: u32, limit: f32) -> Option<Farthest> {
        let corners = point.corners.map(|corner| self.vertex(corner));
        let mut most = Farthest {
            squared: 0.0,
            pose: 0,
        };
        for (pose, truth) in self.vertex(vertex).iter().enumerate() {
            let shares = corners.iter().zip(point.weights);
            let at: Vec3 = shares.map(|(corner, weight)| corner[pose] * weight).sum();
            let squared = at.distance_squared(*truth);
            if squared > most.squared && squared.is_finite() {
                most = Farthest { squared, pose };
                if squared >= limit {
                    return None;
                }
            }
        }
        (most.squared < limit).then_some(most)
    }
}

/// Triangles, and the indices of the vertices that may correspond to a point on them.
type Search = (Vec<[u32; 3]>, Vec<usize>);

/// First each part for its own vertices, then the parts of each material for those of all of them, and all triangles for
/// the vertices of parts that have none.
fn searches(triangles: &[[u32; 3]], vertices: &[u32], parts: &[Part]) -> Vec<Search> {
    let mut own = vec![Search::default(); parts.len() + 1];
    let of_vertex = parts_of_vertices(parts);
    let part_of = |v: u32| of_vertex.get(v as usize).copied().unwrap_or(parts.len());
    for triangle in triangles {
        own[part_of(triangle[0])].0.push(*triangle);
    }
    for (place, v) in vertices.iter().enumerate() {
        own[part_of(*v)].1.push(place);
    }
    let alike = alike(&own, parts);
    let without = own.iter_mut().filter(|(surface, _)| surface.is_empty());
    let left_out = without.flat_map(|(_, places)| std::mem::take(places));
    let left_out = left_out.collect();
    own.extend(alike);
    own.push((triangles.to_vec(), left_out));
    own.retain(|(_, places)| !places.is_empty());
    own
}

/// The parts of each material that have triangles, where there are several.
fn alike(own: &[Search], parts: &[Part]) -> Vec<Search> {
    let shown = |part: usize| !own[part].0.is_empty();
    let shown: Vec<usize> = (0..parts.len()).filter(|part| shown(*part)).collect();
    let of_first = |at: usize| {
        let is_same = |part: &&usize| parts[**part].material == parts[shown[at]].material;
        let is_first = !shown[..at].iter().any(|part| is_same(&part));
        let same: Vec<usize> = shown.iter().filter(is_same).copied().collect();
        (is_first && same.len() > 1).then_some(same)
    };
    let joined = |same: Vec<usize>| {
        let surface = same.iter().flat_map(|part| own[*part].0.iter().copied());
        let places = same.iter().flat_map(|part| own[*part].1.iter().copied());
        (surface.collect(), places.collect())
    };
    (0..shown.len()).filter_map(of_first).map(joined).collect()
}

/// The part of each vertex, the first of several; the number of parts if it belongs to none.
fn parts_of_vertices(parts: &[Part]) -> Vec<usize> {
    let end = parts.iter().map(|part| part.vertices.end).max();
    let mut of_vertex = vec![parts.len(); end.unwrap_or(0)];
    for (index, part) in parts.iter().enumerate().rev() {
        of_vertex[part.vertices.clone()].fill(index);
    }
    of_vertex
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_distance::corners;
    use articula_core::Mesh;

    /// Points of surfaces without borders.
    fn by_parts(
        triangles: &[[u32; 3]],
        vertices: &[u32],
        poses: &[Vec<Vec3>],
        parts: &[Part],
    ) -> Vec<SkinPoint> {
        attach(triangles, vertices, poses, parts, &Borders::default())
    }

    #[test]
    fn the_other_lip_is_closer_at_rest_but_not_for_long() {
        // Two sheets a millimetre apart; the level lacks the middle vertex 3 of the upper one.
        let mut rest: Vec<Vec3> = [[0, 0], [2, 0], [0, 2]]
            .iter()
            .map(|[x, z]| Vec3::new(*x as f32, 0.010, *z as f32))
            .collect();
        rest.push(Vec3::new(0.5, 0.002, 0.5));
        rest.extend([[0, 0], [2, 0], [0, 2]].map(|[x, z]| Vec3::new(x as f32, 0.0, z as f32)));
        let level = [[0, 1, 2], [4, 5, 6]];
        let mut open = rest.clone();
        for upper in &mut open[..4] {
            upper.y += 0.1;
        }
        let alone = by_parts(&level, &[3, 0], std::slice::from_ref(&rest), &[]);
        assert_eq!(
            alone[0].corners,
            [4, 5, 6],
            "2 mm to the lower sheet, 8 mm to its own"
        );
        assert_eq!(
            alone[1].posed(&rest),
            rest[0],
            "a corner of the level is itself"
        );
        let both = by_parts(&level, &[3], &[rest.clone(), open.clone()], &[]);
        assert_eq!(both[0].corners, [0, 1, 2]);
        // The lower sheet as a part of another material is ignored, except for a part without triangles.
        let part = |vertices, material| Part {
            name: String::new(),
            mesh: 0,
            material,
            draw_material: material,
            vertices,
            triangles: 0..0,
        };
        let mut sheets = [part(0..4, Some(0)), part(4..7, None)];
        let apart = by_parts(&level, &[3], std::slice::from_ref(&rest), &sheets);
        assert_eq!(apart[0].corners, [0, 1, 2]);
        let gone = by_parts(&level[1..], &[3], std::slice::from_ref(&rest), &sheets);
        assert_eq!(gone[0].corners, [4, 5, 6]);
        sheets[1].material = Some(0);
        let alike = by_parts(&level, &[3], std::slice::from_ref(&rest), &sheets);
        assert_eq!(alike[0].corners, [4, 5, 6], "of one material");
        let in_motion = by_parts(&level, &[3], &[rest.clone(), open.clone()], &sheets);
        assert_eq!(in_motion[0].corners, [0, 1, 2]);
        let few = corners(&alone);
        assert_eq!(few, [0, 1, 2, 4, 5, 6]);
        assert_eq!(alone[0].among(&few).corners, [3, 4, 5]);
        let sum: f32 = both[0].weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-6);
        assert!((both[0].posed(&open) - Vec3::new(0.5, 0.11, 0.5)).length() < 1e-6);
    }

    #[test]
    fn a_stripe_of_which_one_end_is_left_is_off_by_half_of_its_width() {
        // A stripe of 2 cm and eleven columns lies 1 mm above a sheet of a metre; the level has its first square alone.
        let corner = |x: u32, y: f32| Vec3::new(0.1 * x as f32, y, 0.001);
        let rows = [-0.01, 0.0, 0.01];
        let mut rest: Vec<Vec3> = (0..11).flat_map(|x| rows.map(|y| corner(x, y))).collect();
        let quad = |a: u32, b: u32| [[a, a + 1, b + 1], [a, b + 1, b]];
        let columns = (0..10).map(|x| 3 * x);
        let stripe: Vec<[u32; 3]> = columns
            .flat_map(|a| [quad(a, a + 3), quad(a + 1, a + 4)].concat())
            .collect();
        rest.extend(
            [[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]].map(|[x, y]| Vec3::new(x, y, 0.0)),
        );
        let sheet = [[33, 34, 35], [33, 35, 36]];
        let part = |material, vertices, triangles| Part {
            name: String::new(),
            mesh: 0,
            material: Some(material),
            draw_material: Some(material),
            vertices,
            triangles,
        };
        let mesh = Mesh {
            positions: rest.clone(),
            triangles: [&stripe[..], &sheet].concat(),
            parts: vec![part(0, 0..33, 0..40), part(1, 33..37, 40..42)],
            ..Mesh::default()
        };
        let level = [&stripe[..4], &sheet].concat();
        let borders = Borders::of(&mesh, &rest);
        let distance = |v: u32, borders: &Borders| {
            let found = attach(
                &level,
                &[v],
                std::slice::from_ref(&rest),
                &mesh.parts,
                borders,
            );
            found[0].posed(&rest).distance(rest[v as usize])
        };
        // The middle of the eighth column.
        assert!((distance(22, &Borders::default()) - 0.6).abs() < 1e-6);
        assert!((distance(22, &borders) - 0.01f32.hypot(0.001)).abs() < 1e-6);
        // A corner of the end is at the border already.
        assert!((distance(30, &borders) - 0.001).abs() < 1e-6);
        // The sheet is as it was.
        assert_eq!(distance(33, &borders), 0.0);
    }

    #[test]
    fn nothing_to_stand_on() {
        let points = vec![Vec3::ZERO, Vec3::NAN];
        assert_eq!(
            attach(
                &[],
                &[0],
                std::slice::from_ref(&points),
                &[],
                &Borders::default()
            ),
            [SkinPoint::at(0)]
        );
        assert_eq!(
            attach(&[[0, 0, 0]], &[1], &[points], &[], &Borders::default()),
            [SkinPoint::at(1)]
        );
        assert_eq!(
            attach(&[], &[7], &[], &[], &Borders::default()),
            [SkinPoint::at(7)]
        );
    }
}
