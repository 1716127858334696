//! Where the wedges of a vertex go when it is moved onto a neighbour.
//!
//! Source: `docs/methods/clustered-mesh.md` 5: a wedge goes to the one that shares a removed face with
//! it, which keeps seams, creases and material borders. Differs: where that gives none but the
//! two agree in all but normals, the nearest normal is taken, at a cost; otherwise meshes whose
//! every face has normals of its own could not be simplified at all. Seams of texture coordinates
//! and colours go the same way at a far higher cost, so in coarse levels only; parts never mix.
//! A wedge whose normal looks away from the faces that it comes to costs more too.

use super::classes::Classes;
use super::ring::Ring;
use super::topology::Surface;
use articula_core::Mesh;

/// A change of texture coordinates by 1 counts as much as this change of a unit normal, squared.
const TEXCOORDS: f32 = 2500.0;
/// The same of linear colours.
const COLORS: f32 = 100.0;
/// The same of a corner whose stored normal leans away from its face, squared beyond the free part.
const LEANING: f32 = 8.0;
/// Cosine up to which a stored normal may lean from its face for nothing: coarse faces under smooth
/// normals do.
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
    /// How much more the stored normals of a face lean away from it once its corner `at` is the
    /// wedge `image`: a vertex that was inside an eye socket or a lip shades the skin black.
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

/// Images of the corners around a class, refilled for each collapse looked at.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// New wedge of each face around the class that stays, in the ring's order.
    pub(super) of_corners: Vec<u32>,
    /// Squared change of attributes at each of them beyond what the shape asks for.
    pub(super) changes: Vec<f32>,
    /// Wedges that share a removed face.
    pairs: Vec<(u32, u32)>,
    /// All wedges around the target.
    targets: Vec<u32>,
}

impl Images {
    /// Finds the images for the class that `ring` is of moved to `to`; whether there are all.
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

    /// The one wedge that shares removed faces with `wedge`.
    fn strict(&self, wedge: u32) -> Option<u32> {
        let mut images = self.pairs.iter().filter(|p| p.0 == wedge).map(|p| p.1);
        let first = images.next()?;
        images.all(|i| i == first).then_some(first)
    }

    /// The wedge of the class `to` that differs least from `wedge` among those that removed faces
    /// tell to agree with it in all but normals or, if none does, of its part.
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

    /// The one chart that shares removed faces with that of `wedge`.
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
        // The face looks along +Z, the new normal along -Z: its cosine is -1.
        let beyond = FREE_COSINE + 1.0;
        let expected = LEANING * beyond * beyond;
        assert_eq!(wedges.leaning([0, 1, 2], 2, 3), expected);
        // Leaning by 53 degrees is free, and what leans already costs nothing more.
        assert_eq!(wedges.leaning([0, 1, 2], 2, 4), 0.0);
        assert_eq!(wedges.leaning([0, 1, 3], 1, 1), 0.0);
        // Getting better is no credit.
        assert_eq!(wedges.leaning([0, 1, 3], 2, 2), 0.0);
    }
}
