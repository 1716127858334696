//! What it costs to move a position class onto another one, over all poses.

use super::classes::Classes;
use super::quadric::Quadric;
use super::ring::Ring;
use super::topology::Surface;
use super::{SimplifyOptions, Weighting};
use articula_core::mesh::Mesh;
use glam::{DVec3, Vec3};

/// Weight of a border plane over that of a face of the edge's squared length.
const BORDER: f64 = 10.0;
/// The same of an edge at which texture coordinates, colours or parts differ.
const SEAM: f64 = 0.3;
/// Faces around a class beyond which its edges are not looked at.
pub(super) const MOST_FACES: usize = 64;

/// Points and quadrics of all classes in all poses.
#[derive(Debug, Clone, Default)]
pub(super) struct Costs {
    poses: usize,
    /// Class by class, its point in each pose.
    points: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    /// Classes without a finite point in some pose.
    pub(super) lost: Vec<bool>,
}

impl Costs {
    /// Quadrics of the faces, their borders and seams.
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
        costs.hold_edges(surface, classes);
        costs.weigh(mesh, options, classes);
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

    /// Planes along borders and seams, upright on their faces.
    fn hold_edges(&mut self, surface: &Surface, classes: &Classes) {
        let mut ring = Ring::default();
        for class in 0..classes.len() as u32 {
            if surface.valence(class) > MOST_FACES {
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

    fn weigh(&mut self, mesh: &Mesh, options: &SimplifyOptions, classes: &Classes) {
        let mut factors = vec![0.0f64; classes.len()];
        for (v, class) in classes.of_vertex.iter().enumerate() {
            let mut factor = options.vertex_weights.get(v).map_or(1.0, |w| f64::from(*w));
            if let Weighting::Joint { strength } = options.weighting {
                let most = mesh.influences_of(v).map(|i| i.1).fold(0.0, f32::max);
                factor *= f64::from(1.0 + strength * (1.0 - most));
            }
            let known = &mut factors[*class as usize];
            *known = known.max(factor);
        }
        for (quadrics, factor) in self.quadrics.chunks_exact_mut(self.poses).zip(factors) {
            for q in quadrics.iter_mut().filter(|_| factor != 1.0) {
                *q = q.scaled(factor);
            }
        }
    }

    fn point(&self, class: u32, pose: usize) -> Vec3 {
        self.points[class as usize * self.poses + pose]
    }

    /// Points of a class in all poses.
    pub(super) fn points(&self, class: u32) -> &[Vec3] {
        let at = class as usize * self.poses;
        &self.points[at..at + self.poses]
    }

    /// The cost of a move; infinite instead of no number.
    pub(super) fn of_move(&self, from: u32, to: u32) -> f64 {
        let at = from as usize * self.poses;
        let quadrics = &self.quadrics[at..at + self.poses];
        let pairs = quadrics.iter().zip(self.points(to));
        let sum: f64 = pairs.map(|(q, p)| q.at(p.as_dvec3())).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }

    /// What one class stands for, another one stands for from now on.
    pub(super) fn merge(&mut self, from: u32, to: u32) {
        for pose in 0..self.poses {
            let moved = self.quadrics[from as usize * self.poses + pose];
            self.quadrics[to as usize * self.poses + pose].add(&moved);
        }
    }
}

/// Doubled area vector of a triangle.
pub(super) fn area_vector([a, b, c]: [Vec3; 3]) -> DVec3 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a)
}
