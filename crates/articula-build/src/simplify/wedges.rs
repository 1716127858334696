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
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_corner_may_not_get_a_normal_that_looks_away() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Y, Vec3::Y],
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
}
