//! Where the wedges of a vertex go when it is moved onto a neighbour.
//!
//! Source: `spec/clustered-mesh.md` 5: a wedge goes to the one that shares a removed face with
//! it, which keeps seams, creases and material borders. Differs: where that gives none but the
//! two agree in all but normals, the nearest normal is taken, at a cost. Otherwise meshes whose
//! every face has normals of its own could not be simplified at all.

use super::classes::Classes;
use super::ring::Ring;
use super::topology::Surface;
use glam::Vec3;

/// Images of the corners around a class, refilled for each collapse looked at.
#[derive(Debug, Default)]
pub(super) struct Images {
    /// New wedge of each face around the class that stays, in the ring's order.
    pub(super) of_corners: Vec<u32>,
    /// Squared change of normal at each of them beyond what the shape asks for.
    pub(super) turns: Vec<f32>,
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
        classes: &Classes,
        normals: &[Vec3],
        ring: &Ring,
        to: u32,
    ) -> bool {
        self.of_corners.clear();
        self.turns.clear();
        self.pairs.clear();
        self.targets.clear();
        for (face, at, a, b) in &ring.faces {
            let target = match to {
                to if to == *a => (at + 1) % 3,
                to if to == *b => (at + 2) % 3,
                _ => continue,
            };
            let wedges = surface.wedges[*face];
            self.pairs.push((wedges[*at], wedges[target]));
        }
        for (face, at, a, b) in &ring.faces {
            if *a == to || *b == to {
                continue;
            }
            let wedge = surface.wedges[*face][*at];
            if let Some(image) = self.strict(wedge) {
                self.of_corners.push(image);
                self.turns.push(0.0);
                continue;
            }
            let Some(image) = self.nearest(surface, classes, normals, (wedge, to)) else {
                return false;
            };
            self.of_corners.push(image);
            let turn = normals[wedge as usize].distance_squared(normals[image as usize]);
            self.turns.push(if turn.is_finite() { turn } else { 0.0 });
        }
        true
    }

    /// The one wedge that shares removed faces with `wedge`.
    fn strict(&self, wedge: u32) -> Option<u32> {
        let mut images = self.pairs.iter().filter(|p| p.0 == wedge).map(|p| p.1);
        let first = images.next()?;
        images.all(|i| i == first).then_some(first)
    }

    /// The wedge of the class `to` with the nearest normal among those that removed faces tell
    /// to agree with `wedge` in all else.
    fn nearest(
        &mut self,
        surface: &Surface,
        classes: &Classes,
        normals: &[Vec3],
        (wedge, to): (u32, u32),
    ) -> Option<u32> {
        let chart = classes.chart[wedge as usize];
        let mut charts = self
            .pairs
            .iter()
            .filter(|p| classes.chart[p.0 as usize] == chart)
            .map(|p| classes.chart[p.1 as usize]);
        let image = charts.next()?;
        if !charts.all(|c| c == image) {
            return None;
        }
        if self.targets.is_empty() {
            let corners = surface.around(to);
            self.targets
                .extend(corners.map(|(face, at)| surface.wedges[face][at]));
            self.targets.sort_unstable();
            self.targets.dedup();
        }
        let normal = normals[wedge as usize];
        let far = |w: u32| normal.distance_squared(normals[w as usize]);
        self.targets
            .iter()
            .copied()
            .filter(|w| classes.chart[*w as usize] == image)
            .min_by(|a, b| far(*a).total_cmp(&far(*b)))
    }
}
