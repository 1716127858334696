//! Cost of moving a position class onto another one, over all poses.

use super::classes::{Classes, extent};
use super::quadric::Quadric;
use super::ring::Ring;
use super::topology::Surface;
use super::{ErrorWeighting, SimplifyOptions};
use articula_core::Mesh;
use glam::{DVec3, Vec3};

/// Weight of a border plane, relative to a face whose area is the squared edge length.
const BORDER: f64 = 1.0;
/// Weight of the plane of an edge at which texture coordinates, colours or parts differ.
const SEAM: f64 = 0.3;
/// Additional weight of an error at the vertex that a morph target moves furthest.
const MORPH: f32 = 3.0;
/// Largest displacement of a morph target, relative to the extent, below which it has no weight.
const STILL: f32 = 1e-4;
/// Number of faces around a class above which its edges get no planes and it is not collapsed.
pub(super) const MAX_FACES: usize = 64;

/// Points and quadrics of all classes in all poses.
#[derive(Debug, Clone, Default)]
pub(super) struct Costs {
    poses: usize,
    /// Points of each class in all poses, class by class.
    points: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    /// Weight of an error at each class.
    factors: Vec<f32>,
    /// Area around each class and all classes merged into it, averaged over poses.
    areas: Vec<f64>,
    /// Mean of these areas at the start.
    mean_area: f64,
    /// Classes without a finite point in some pose.
    pub(super) lost: Vec<bool>,
}

impl Costs {
    /// Computes the quadrics of faces, borders and seams.
    pub(super) fn new(
        mesh: &Mesh,
        poses: &[Vec<Vec3>],
        options: &SimplifyOptions,
        classes: &Classes,
        surface: &Surface,
    ) -> Self {
        let mut costs = Self {
            poses: poses.len(),
            quadrics: vec![Quadric::default(); classes.len() * poses.len()],
            lost: vec![false; classes.len()],
            points: Vec::with_capacity(classes.len() * poses.len()),
            ..Self::default()
        };
        for (class, v) in classes.first.iter().enumerate() {
            for pose in poses {
                let p = pose[*v as usize];
                costs.lost[class] |= !p.is_finite();
                costs
                    .points
                    .push(if p.is_finite() { p } else { Vec3::ZERO });
            }
        }
        costs.add_faces(surface);
        costs.scale();
        costs.hold_edges(surface, classes);
        costs.weigh(mesh, options, classes, STILL * extent(&poses[0]));
        costs
    }

    fn add_faces(&mut self, surface: &Surface) {
        for (f, face) in surface.faces.iter().enumerate() {
            if !surface.is_alive(f) {
                continue;
            }
            for pose in 0..self.poses {
                let [a, b, c] = face.map(|v| self.point(v, pose).as_dvec3());
                let normal = (b - a).cross(c - a);
                let area = 0.5 * normal.length();
                let plane = Quadric::plane(normal.normalize_or_zero(), a, area);
                for v in face {
                    self.quadrics[*v as usize * self.poses + pose].add(&plane);
                }
            }
        }
    }

    /// Adds planes along borders and seams, perpendicular to their faces.
    fn hold_edges(&mut self, surface: &Surface, classes: &Classes) {
        let mut ring = Ring::default();
        for class in 0..classes.len() as u32 {
            if surface.valence(class) > MAX_FACES {
                continue;
            }
            ring.look(surface, class);
            for place in 0..ring.neighbours.len() {
                let weight = match ring.degrees[place] {
                    2 if ring.is_seam(surface, classes, place) => SEAM,
                    2 => continue,
                    _ => BORDER,
                };
                let other = ring.neighbours[place];
                for (_, _, a, b) in ring.faces.iter().filter(|f| f.2 == other || f.3 == other) {
                    let third = if *a == other { *b } else { *a };
                    self.hold_edge([class, other, third], weight);
                }
            }
        }
    }

    fn hold_edge(&mut self, [class, other, third]: [u32; 3], weight: f64) {
        for pose in 0..self.poses {
            let [p, q, r] = [class, other, third].map(|v| self.point(v, pose).as_dvec3());
            let edge = q - p;
            let across = edge.cross(edge.cross(r - p)).normalize_or_zero();
            let plane = Quadric::plane(across, p, weight * edge.length_squared());
            self.quadrics[class as usize * self.poses + pose].add(&plane);
        }
    }

    /// `still` is the displacement below which a morph target has no weight.
    fn weigh(&mut self, mesh: &Mesh, options: &SimplifyOptions, classes: &Classes, still: f32) {
        let moved = moved_by_morphs(mesh, still);
        let mut factors = vec![0.0f32; classes.len()];
        for (v, class) in classes.of_vertex.iter().enumerate() {
            let mut factor = options.vertex_weights.get(v).copied().unwrap_or(1.0);
            if let ErrorWeighting::Joint { strength } = options.weighting {
                let most = mesh.influences_of(v).map(|i| i.1).fold(0.0, f32::max);
                factor *= 1.0 + strength * (1.0 - most);
            }
            let extent = options.extents.get(v).copied().unwrap_or(0.0);
            factor *= 1.0 + MORPH * moved[v].max(extent);
            let known = &mut factors[*class as usize];
            *known = known.max(factor);
        }
        self.factors = factors;
    }

    /// Computes the areas by which sums weighted by area are divided: the divisor is the geometric
    /// mean of the area of a class and the mean area. The area of the class alone would keep small
    /// faces of little value; a common one would remove dense parts such as faces and hands first.
    fn scale(&mut self) {
        let poses = self.poses as f64;
        let areas = self.quadrics.chunks_exact(self.poses);
        let area = |q: &[Quadric]| q.iter().map(|q| q.weight).sum::<f64>() / poses;
        self.areas = areas.map(area).collect();
        let used = self.areas.iter().filter(|a| **a > 0.0).count().max(1);
        self.mean_area = self.areas.iter().sum::<f64>() / used as f64;
    }

    /// Weight of an error at a class.
    pub(super) fn factor(&self, class: u32) -> f32 {
        self.factors[class as usize]
    }

    /// Converts a sum over poses of area times squared distance into a squared distance.
    pub(super) fn squared_distance(&self, class: u32, cost: f64) -> f64 {
        let area = (self.areas[class as usize] * self.mean_area).sqrt();
        if area > 0.0 {
            cost / (self.poses as f64 * area)
        } else {
            0.0
        }
    }

    /// Number of poses.
    pub(super) fn poses(&self) -> usize {
        self.poses
    }

    fn point(&self, class: u32, pose: usize) -> Vec3 {
        self.points[class as usize * self.poses + pose]
    }

    /// Points of a class in all poses.
    pub(super) fn points(&self, class: u32) -> &[Vec3] {
        let at = class as usize * self.poses;
        &self.points[at..at + self.poses]
    }

    /// Cost of a collapse; infinite instead of NaN.
    pub(super) fn of_move(&self, from: u32, to: u32) -> f64 {
        let at = from as usize * self.poses;
        let quadrics = &self.quadrics[at..at + self.poses];
        let pairs = quadrics.iter().zip(self.points(to));
        let sum: f64 = pairs.map(|(q, p)| q.at(p.as_dvec3())).sum();
        let sum = self.squared_distance(from, sum) * f64::from(self.factor(from));
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    /// Adds the quadrics and the area of one class to another.
    pub(super) fn merge(&mut self, from: u32, to: u32) {
        for pose in 0..self.poses {
            let moved = self.quadrics[from as usize * self.poses + pose];
            self.quadrics[to as usize * self.poses + pose].add(&moved);
        }
        self.areas[to as usize] += self.areas[from as usize];
    }
}

/// How far morph targets move each vertex, 0 to 1: the largest displacement over the targets, each
/// relative to the vertex that the target moves furthest. Targets that move no vertex by more than
/// `still` are left out.
///
/// Source: the level of animation of thesis 3.1.2, which states no formula.
fn moved_by_morphs(mesh: &Mesh, still: f32) -> Vec<f32> {
    let mut moved = vec![0.0f32; mesh.len()];
    for morph in &mesh.morphs {
        let lengths = || morph.positions.iter().map(|d| d.length());
        let most = lengths().filter(|l| l.is_finite()).fold(0.0, f32::max);
        if most <= still {
            continue;
        }
        for (v, length) in morph.vertices.iter().zip(lengths()) {
            let share = length / most;
            if share <= 1.0 {
                moved[*v as usize] = moved[*v as usize].max(share);
            }
        }
    }
    moved
}

/// Normal of a triangle with twice its area as length.
pub(super) fn area_vector([a, b, c]: [Vec3; 3]) -> DVec3 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::super::shapes::sheet;
    use super::super::test_surface::{TestSurface, charted, shaken};
    use super::*;
    use articula_core::Morph;
    use std::collections::BTreeSet;

    /// A sheet of two charts with uneven heights, in two poses.
    fn uneven() -> TestSurface {
        let mut mesh = charted(4, 2.0);
        let at = |p: &Vec3| p.x as usize + 5 * p.z as usize;
        let heights = shaken(&[Vec3::ZERO; 25], 0.4);
        let pose = shaken(&[Vec3::ZERO; 25], 0.7);
        let other = mesh
            .positions
            .iter()
            .map(|p| Vec3::new(p.z, p.x * 2.0, p.y) + pose[24 - at(p)]);
        let other = other.collect();
        for p in &mut mesh.positions {
            *p += heights[at(p)];
        }
        TestSurface::new(mesh, &[other])
    }

    fn points(of: &TestSurface, pose: usize, class: u32) -> DVec3 {
        of.poses[pose][of.classes.first[class as usize] as usize].as_dvec3()
    }

    /// Sum of the areas of the faces around a class, averaged over poses.
    fn area(of: &TestSurface, class: u32) -> f64 {
        let faces = of.surface.faces.iter().filter(|f| f.contains(&class));
        let twice = faces.map(|f| {
            let all = (0..of.poses.len()).map(|pose| {
                let [a, b, c] = f.map(|c| points(of, pose, c));
                (b - a).cross(c - a).length()
            });
            all.sum::<f64>()
        });
        twice.sum::<f64>() / 2.0 / of.poses.len() as f64
    }

    /// Sum over poses and over the faces, borders and seams around a class of the squared distance
    /// of another class to their planes, each with its weight.
    fn slow(of: &TestSurface, class: u32, to: u32) -> f64 {
        let mut sum = 0.0;
        let faces = || of.surface.faces.iter().zip(&of.surface.wedges);
        for pose in 0..of.poses.len() {
            let at = |c: u32| points(of, pose, c);
            for (face, wedges) in faces().filter(|(f, _)| f.contains(&class)) {
                let [a, b, c] = face.map(at);
                let normal = (b - a).cross(c - a);
                let distance = (at(to) - a).dot(normal.normalize());
                sum += 0.5 * normal.length() * distance * distance;
                let k = face.iter().position(|c| *c == class).unwrap();
                for (other, third) in [(1, 2), (2, 1)].map(|(i, j)| ((k + i) % 3, (k + j) % 3)) {
                    let chart = |f: &[u32; 3], w: &[u32; 3]| {
                        let of_class = |c: u32| {
                            of.mesh.texcoords[w[f.iter().position(|d| *d == c).unwrap()] as usize]
                        };
                        [class, face[other]].map(of_class)
                    };
                    let beside: Vec<_> = faces()
                        .filter(|(f, _)| f.contains(&class) && f.contains(&face[other]))
                        .map(|(f, w)| chart(f, w))
                        .collect();
                    let weight = match beside[..] {
                        [one, two] if one == two => continue,
                        [_, _] => SEAM,
                        _ => BORDER,
                    };
                    assert!(beside.contains(&chart(face, wedges)));
                    // The plane through the edge, perpendicular to the face.
                    let edge = at(face[other]) - at(class);
                    let plane = edge.cross(normal).normalize();
                    assert!(plane.dot(at(face[third]) - at(class)).abs() > 1e-6);
                    let distance = plane.dot(at(to) - at(class));
                    sum += weight * edge.length_squared() * distance * distance;
                }
            }
        }
        sum
    }

    #[test]
    fn a_move_costs_the_squared_distances_to_all_planes_around_it() {
        let of = uneven();
        let weights = (0..of.mesh.len()).map(|v| 0.5 + (v % 25) as f32);
        let options = SimplifyOptions {
            vertex_weights: weights.collect(),
            ..SimplifyOptions::default()
        };
        let mut costs = of.costs(&options);
        let count = of.classes.len() as u32;
        assert_eq!(count, 25);
        assert_eq!(costs.poses(), 2);
        let mean = (0..count).map(|c| area(&of, c)).sum::<f64>() / f64::from(count);
        for from in 0..count {
            let factor = 0.5 + f64::from(of.classes.first[from as usize] % 25);
            for to in (0..count).filter(|to| *to != from) {
                let divisor = 2.0 * (area(&of, from) * mean).sqrt();
                let expected = slow(&of, from, to) / divisor * factor;
                let found = costs.of_move(from, to);
                assert!(
                    (found - expected).abs() < 1e-6 * expected + 1e-9,
                    "{found}, {expected}"
                );
            }
        }
        // What was moved counts at its new place, with the areas of both.
        costs.merge(7, 12);
        let sum = slow(&of, 7, 3) + slow(&of, 12, 3);
        let divisor = 2.0 * ((area(&of, 7) + area(&of, 12)) * mean).sqrt();
        let factor = 0.5 + f64::from(of.classes.first[12] % 25);
        let expected = sum / divisor * factor;
        assert!((costs.of_move(12, 3) - expected).abs() < 1e-6 * expected + 1e-9);
    }

    #[test]
    fn vertices_without_faces_are_left_out_of_the_mean_area() {
        let mut mesh = sheet(2);
        mesh.triangles.truncate(1);
        mesh.parts[0].triangles = 0..1;
        let of = TestSurface::new(mesh, &[]);
        let costs = of.costs(&SimplifyOptions::default());
        // One face of 0.5 m², so both areas are 0.5 m².
        assert_eq!(costs.squared_distance(0, 3.0), 6.0);
        assert_eq!(costs.squared_distance(8, 3.0), 0.0);
    }

    #[test]
    fn points_that_are_not_finite_are_lost() {
        let mut mesh = sheet(2);
        mesh.positions[5].y = f32::INFINITY;
        let mut pose = mesh.positions.clone();
        pose[2].x = f32::NAN;
        let of = TestSurface::new(mesh, &[pose]);
        let costs = of.costs(&SimplifyOptions::default());
        let lost: BTreeSet<usize> = (0..9).filter(|c| costs.lost[*c]).collect();
        assert_eq!(lost, BTreeSet::from([2, 5]));
        assert_eq!(costs.points(2), [Vec3::new(2.0, 0.0, 0.0), Vec3::ZERO]);
        assert_eq!(costs.points(3), [Vec3::new(0.0, 0.0, 1.0); 2]);
    }

    #[test]
    fn joints_morphs_and_given_weights_multiply() {
        let mut mesh = sheet(1);
        mesh.influences = 2;
        mesh.bindings.push(mesh.bindings[0]);
        mesh.bindings[1].joint = 1;
        mesh.binding_indices = [0, 1].repeat(4);
        mesh.weights = vec![1.0, 0.0, 0.75, 0.25, 0.25, 0.75, 0.5, 0.5];
        mesh.morphs = vec![Morph {
            slot: 0,
            vertices: vec![1, 3],
            positions: vec![Vec3::Y, Vec3::Y * 2.0],
            normals: vec![Vec3::ZERO; 2],
        }];
        let of = TestSurface::new(mesh, &[]);
        let options = SimplifyOptions {
            weighting: ErrorWeighting::Joint { strength: 2.0 },
            vertex_weights: vec![1.0, 3.0, 1.0, 0.5],
            ..SimplifyOptions::default()
        };
        let costs = of.costs(&options);
        // Given weight, times 1 + 2 (1 - heaviest), times 1 + 3 times the share of the morph.
        let expected = [1.0, 3.0 * 1.5 * 2.5, 1.5, 0.5 * 2.0 * 4.0];
        assert_eq!([0, 1, 2, 3].map(|c| costs.factor(c)), expected);
    }

    #[test]
    fn the_largest_weight_of_a_place_counts() {
        let mesh = charted(2, 1.0);
        let of = TestSurface::new(mesh, &[]);
        let options = SimplifyOptions {
            vertex_weights: (0..18).map(|v| if v == 13 { 5.0 } else { 2.0 }).collect(),
            ..SimplifyOptions::default()
        };
        let costs = of.costs(&options);
        // Vertex 13 is the copy of vertex 4.
        let expected = |c: u32| if c == 4 { 5.0 } else { 2.0 };
        assert!((0..9).all(|c| costs.factor(c) == expected(c)));
    }

    #[test]
    fn each_morph_counts_relative_to_its_own_largest_displacement() {
        let mut mesh = sheet(2);
        let morph = |vertices: &[u32], lengths: &[f32]| Morph {
            slot: 0,
            vertices: vertices.to_vec(),
            positions: lengths.iter().map(|l| Vec3::Z * *l).collect(),
            normals: vec![Vec3::ZERO; lengths.len()],
        };
        mesh.morphs = vec![
            morph(&[0, 1, 2], &[8.0, 2.0, 4.0]),
            morph(&[1, 2, 3], &[0.375, 0.125, 0.5]),
            // No vertex by more than 0.1.
            morph(&[4, 5], &[0.1, 0.05]),
            morph(&[6, 7], &[f32::NAN, 1.0]),
        ];
        let moved = moved_by_morphs(&mesh, 0.1);
        assert_eq!(moved, [1.0, 0.75, 0.5, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    }
}
