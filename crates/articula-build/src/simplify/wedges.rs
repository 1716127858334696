//! Images of the wedges of a vertex that is moved onto a neighbour.
//!
//! Source: `docs/methods/clustered-mesh.md` part 5. A wedge maps to the one that shares a removed
//! face with it, which keeps seams, creases and material borders. If there is none, it maps to the
//! wedge with the nearest normal among those with equal other attributes, at a cost; otherwise a
//! mesh with one normal per face could not be simplified at all. Wedges that differ in texture
//! coordinates or colour follow at a far higher cost, hence in coarse levels only; parts never mix.
//! A stored normal that leans away from its new face also adds to the cost.

use super::classes::Classes;
use super::ring::Ring;
use super::topology::Surface;
use articula_core::Mesh;

/// Squared change of a unit normal that a change of texture coordinates by 1 counts as.
const TEXCOORDS: f32 = 2500.0;
/// Squared change of a unit normal that a change of linear colour by 1 counts as.
const COLORS: f32 = 100.0;
/// Weight of a corner whose stored normal leans from its face, times the squared excess in cosine.
const LEANING: f32 = 8.0;
/// Cosine down to which a stored normal may lean from its face at no cost, as happens on coarse
/// faces with smooth normals.
const FREE_COSINE: f32 = 0.5;

/// The wedges of a mesh.
#[derive(Clone, Copy)]
pub(super) struct Wedges<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) classes: &'a Classes,
}

impl Wedges<'_> {
    /// Squared change of attributes between two wedges.
    fn change(&self, a: u32, b: u32) -> f32 {
        let (a, b) = (a as usize, b as usize);
        let mesh = self.mesh;
        let normals = mesh.normals[a].distance_squared(mesh.normals[b]);
        let texcoords = mesh.texcoords[a].distance_squared(mesh.texcoords[b]);
        let colors = mesh.colors[a].distance_squared(mesh.colors[b]);
        let sum = normals + TEXCOORDS * texcoords + COLORS * colors;
        if sum.is_finite() { sum } else { 0.0 }
    }
}

impl Wedges<'_> {
    /// Increase of the cost of leaning normals of a face when its corner `at` becomes the wedge
    /// `image`: a vertex from inside an eye socket or a lip would shade the skin black.
    fn leaning(&self, corners: [u32; 3], at: usize, image: u32) -> f32 {
        let mut moved = corners;
        moved[at] = image;
        let bends = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|w| self.mesh.positions[w as usize]);
            let face = (b - a).cross(c - a).normalize_or_zero();
            corners.map(|w| {
                let beyond = FREE_COSINE - face.dot(self.mesh.normals[w as usize]);
                let beyond = beyond.max(0.0);
                beyond * beyond
            })
        };
        let (before, after) = (bends(corners), bends(moved));
        let more = before.iter().zip(after).map(|(b, a)| (a - b).max(0.0));
        let sum = LEANING * more.sum::<f32>();
        if sum.is_finite() { sum } else { 0.0 }
    }
}

/// Images of the corners around a class. Reused for different collapses.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// New wedge of each remaining face around the class, in the order of the ring.
    pub(super) of_corners: Vec<u32>,
    /// Squared change of attributes at each of them, with the cost of leaning normals.
    pub(super) changes: Vec<f32>,
    /// Pairs of wedges that share a removed face.
    pairs: Vec<(u32, u32)>,
    /// All wedges around the target.
    targets: Vec<u32>,
}

impl Images {
    /// Finds the images of the wedges of `ring`'s class when it moves to `to`. Returns whether all
    /// have one.
    pub(super) fn find(
        &mut self,
        surface: &Surface,
        wedges: Wedges<'_>,
        ring: &Ring,
        to: u32,
    ) -> bool {
        self.of_corners.clear();
        self.changes.clear();
        self.pairs.clear();
        self.targets.clear();
        for (face, at, a, b) in &ring.faces {
            let target = match to {
                to if to == *a => (at + 1) % 3,
                to if to == *b => (at + 2) % 3,
                _ => continue,
            };
            let corners = surface.wedges[*face];
            self.pairs.push((corners[*at], corners[target]));
        }
        for (face, at, a, b) in &ring.faces {
            if *a == to || *b == to {
                continue;
            }
            let corners = surface.wedges[*face];
            let wedge = corners[*at];
            let (image, change) = if let Some(image) = self.strict(wedge) {
                (image, 0.0)
            } else if let Some(image) = self.nearest(surface, wedges, wedge, to) {
                (image, wedges.change(wedge, image))
            } else {
                return false;
            };
            self.of_corners.push(image);
            self.changes
                .push(change + wedges.leaning(corners, *at, image));
        }
        true
    }

    /// The wedge that shares removed faces with `wedge`, if it is unique.
    fn strict(&self, wedge: u32) -> Option<u32> {
        let mut images = self.pairs.iter().filter(|p| p.0 == wedge).map(|p| p.1);
        let first = images.next()?;
        images.all(|i| i == first).then_some(first)
    }

    /// The wedge of the class `to` that differs least from `wedge`, among those in the chart given
    /// by removed faces or, without one, in the same part.
    fn nearest(
        &mut self,
        surface: &Surface,
        wedges: Wedges<'_>,
        wedge: u32,
        to: u32,
    ) -> Option<u32> {
        let classes = wedges.classes;
        let chart = self.chart_of_image(classes, wedge);
        if self.targets.is_empty() {
            let corners = surface.around(to);
            self.targets
                .extend(corners.map(|(face, at)| surface.wedges[face][at]));
            self.targets.sort_unstable();
            self.targets.dedup();
        }
        let part = classes.part[wedge as usize];
        let agrees = |w: &u32| match chart {
            Some(chart) => classes.chart[*w as usize] == chart,
            None => classes.part[*w as usize] == part,
        };
        let targets = self.targets.iter().copied().filter(agrees);
        let change = |w: &u32| wedges.change(wedge, *w);
        targets.min_by(|a, b| change(a).total_cmp(&change(b)))
    }

    /// The chart that shares removed faces with that of `wedge`, if it is unique.
    fn chart_of_image(&self, classes: &Classes, wedge: u32) -> Option<u32> {
        let chart = |w: u32| classes.chart[w as usize];
        let beside = self.pairs.iter().filter(|p| chart(p.0) == chart(wedge));
        let mut images = beside.map(|p| chart(p.1));
        let first = images.next()?;
        images.all(|i| i == first).then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surface::{TestSurface, charted};
    use super::*;
    use articula_core::Part;
    use glam::{Vec2, Vec3, Vec4};

    #[test]
    fn a_corner_may_not_get_a_normal_that_looks_away() {
        let mesh = Mesh {
            positions: [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Y, Vec3::Y]
                .map(|p| p + Vec3::new(-3.0, 5.0, 2.0))
                .to_vec(),
            normals: vec![
                Vec3::Z,
                Vec3::Z,
                Vec3::Z,
                Vec3::NEG_Z,
                Vec3::new(0.8, 0.0, 0.6),
            ],
            ..Mesh::default()
        };
        let classes = Classes::default();
        let wedges = Wedges {
            mesh: &mesh,
            classes: &classes,
        };
        // The face points along +Z, the new normal along -Z: its cosine is -1.
        let beyond = FREE_COSINE + 1.0;
        let expected = LEANING * beyond * beyond;
        assert_eq!(wedges.leaning([0, 1, 2], 2, 3), expected);
        // Leaning by 53 degrees is free, and an existing lean costs nothing more.
        assert_eq!(wedges.leaning([0, 1, 2], 2, 4), 0.0);
        assert_eq!(wedges.leaning([0, 1, 3], 1, 1), 0.0);
        // An improvement is no credit.
        assert_eq!(wedges.leaning([0, 1, 3], 2, 2), 0.0);
    }

    #[test]
    fn changes_of_normals_texcoords_and_colours_add_up() {
        let mut mesh = Mesh {
            normals: vec![Vec3::X, Vec3::Y],
            texcoords: vec![Vec2::new(0.5, 0.25), Vec2::new(0.5, 0.5)],
            colors: vec![Vec4::ONE, Vec4::new(1.0, 0.5, 1.0, 1.0)],
            ..Mesh::default()
        };
        let classes = Classes::default();
        let change = |mesh: &Mesh| {
            let classes = &classes;
            Wedges { mesh, classes }.change(0, 1)
        };
        assert_eq!(change(&mesh), 2.0 + 2500.0 / 16.0 + 100.0 / 4.0);
        mesh.texcoords[1].x = f32::NAN;
        assert_eq!(change(&mesh), 0.0);
    }

    /// Images of the corners around a class that moves, as (vertex, change), and whether all have
    /// one.
    fn images(of: &TestSurface, from: u32, to: u32) -> (bool, Vec<(u32, f32)>) {
        let wedges = Wedges {
            mesh: &of.mesh,
            classes: &of.classes,
        };
        let mut ring = Ring::default();
        ring.look(&of.surface, from);
        let mut images = Images::default();
        let found = images.find(&of.surface, wedges, &ring, to);
        let all = images.of_corners.into_iter().zip(images.changes);
        (found, all.collect())
    }

    /// Two charts left and right of x = 1, their normals across the faces. The middle is vertex 4
    /// on the left and 13 on the right.
    fn two_charts() -> Mesh {
        let mut mesh = charted(2, 1.0);
        mesh.normals.fill(Vec3::Y);
        mesh
    }

    #[test]
    fn each_side_of_a_seam_moves_along_it() {
        let of = TestSurface::new(two_charts(), &[]);
        let (found, mut all) = images(&of, 4, 1);
        assert!(found);
        all.sort_by_key(|a| a.0);
        // Six faces less two; two of them are left of the seam, two right of it.
        assert_eq!(all, [(1, 0.0), (1, 0.0), (10, 0.0), (10, 0.0)]);
    }

    #[test]
    fn a_wedge_without_its_chart_at_the_target_changes_at_a_cost() {
        let of = TestSurface::new(two_charts(), &[]);
        // Vertex 3 is on the left alone.
        let (found, mut all) = images(&of, 4, 3);
        assert!(found);
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let change = 2500.0 * (0.25 * 0.25 + 0.5 * 0.5);
        assert_eq!(all, [(3, 0.0), (3, change), (3, change), (3, change)]);
        // A normal that looks away costs in addition: 2 off, and a cosine of -1 for one of 0.5.
        let mut away = two_charts();
        away.normals[3] = Vec3::NEG_Y;
        let (_, mut all) = images(&TestSurface::new(away, &[]), 4, 3);
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let leaning = 8.0 * 1.5 * 1.5;
        let both = change + 4.0 + leaning;
        assert_eq!(all, [(3, leaning), (3, both), (3, both), (3, both)]);
    }

    #[test]
    fn a_wedge_never_moves_to_another_part() {
        let mut mesh = two_charts();
        let right = |t: &[u32; 3]| t[0] >= 9;
        mesh.triangles.sort_by_key(right);
        let split = mesh.triangles.partition_point(|t| !right(t));
        let part = mesh.parts[0].clone();
        mesh.parts = vec![
            Part {
                vertices: 0..9,
                triangles: 0..split,
                ..part.clone()
            },
            Part {
                vertices: 9..18,
                triangles: split..8,
                ..part
            },
        ];
        let of = TestSurface::new(mesh, &[]);
        assert!(!images(&of, 4, 3).0);
        assert!(images(&of, 4, 1).0);
    }

    /// The sheet of two charts, with three vertices of each triangle that have its own normal.
    fn creased() -> Mesh {
        let smooth = two_charts();
        let corners: Vec<usize> = smooth
            .triangles
            .iter()
            .flatten()
            .map(|v| *v as usize)
            .collect();
        let pick = |v: &usize| smooth.positions[*v];
        let triangles = (0..8).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let mut mesh = super::super::shapes::mesh(corners.iter().map(pick).collect(), triangles);
        for (v, corner) in corners.iter().enumerate() {
            mesh.texcoords[v] = smooth.texcoords[*corner];
            let angle = (v / 3) as f32 * 0.1;
            mesh.normals[v] = Vec3::new(angle.sin(), angle.cos(), 0.0);
        }
        mesh
    }

    #[test]
    fn a_crease_moves_to_the_nearest_normal_of_its_chart() {
        let of = TestSurface::new(creased(), &[]);
        let class = |x: f32, z: f32| {
            let at = of
                .mesh
                .positions
                .iter()
                .position(|p| *p == Vec3::new(x, 0.0, z));
            of.classes.of_vertex[at.unwrap()]
        };
        let (from, to) = (class(1.0, 1.0), class(1.0, 0.0));
        let (found, all) = images(&of, from, to);
        assert!(found);
        let faces: Vec<(usize, usize)> = of.surface.around(from).collect();
        let removed = |f: usize| of.surface.faces[f].contains(&to);
        let around: Vec<u32> = of
            .surface
            .around(to)
            .map(|(f, at)| of.surface.wedges[f][at])
            .collect();
        let stay = faces.iter().filter(|(f, _)| !removed(*f));
        let mut count = 0;
        for ((f, at), (image, change)) in stay.zip(&all) {
            let wedge = of.surface.wedges[*f][*at] as usize;
            let [uv, normal] = [of.mesh.texcoords[wedge].x, of.mesh.normals[wedge].x];
            let off = |v: &u32| (of.mesh.normals[*v as usize].x - normal).abs();
            let same = around
                .iter()
                .filter(|v| of.mesh.texcoords[**v as usize].x == uv);
            let nearest = same.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
            assert_eq!(image, nearest);
            let expected =
                of.mesh.normals[wedge].distance_squared(of.mesh.normals[*nearest as usize]);
            assert!((change - expected).abs() < 1e-6);
            count += 1;
        }
        assert_eq!((count, all.len()), (4, 4));
    }
}
