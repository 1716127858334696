//! The queue of half-edge collapses and the conditions under which they are allowed.
//!
//! The queue holds the cheapest collapse of each vertex. Conditions are checked when an entry
//! reaches the front; a refused collapse is replaced with the next one of the same vertex.

use super::SimplifyOptions;
use super::classes::Classes;
use super::components::Components;
use super::cost::{Costs, MAX_FACES, area_vector};
use super::levels::{Notes, Sources};
use super::removed_vertices::RemovedVertices;
use super::ring::Ring;
use super::topology::Surface;
use super::wedges::{Images, Wedges};
use super::{LevelTriangles, classes};
use articula_core::Mesh;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cosine of the maximum angle by which a face may turn: 80 degrees.
const MIN_COSINE: f64 = 0.173_648;
/// Maximum number of faces around the target after a collapse.
const MAX_FACES_AFTER: usize = 40;
/// Length, relative to the extent, that weighs as much as a normal that is off by one radian.
const NORMAL_LENGTH: f64 = 0.01;

/// A collapse in the queue: bits of its cost, vertex, target, version, and whether the cost
/// includes the changes of attributes and the distance of removed vertices.
type Entry = Reverse<(u64, u32, u32, u32, bool)>;

/// Target of an entry that removes a whole component.
const WHOLE: u32 = u32::MAX;
/// Factor of the squared distance of removed vertices in the cost.
const REMOVED_WEIGHT: f64 = 2.0;

/// Greatest cost of the changes of attributes, relative to the square of the limit of distances.
const LIMIT_CHANGE: f64 = 4.0;

/// The queue is refilled only after more than one in this many faces was removed.
const LOOK_AGAIN: usize = 500;

/// Region of classes whose vertices lie in several regions.
const BETWEEN: u16 = u16::MAX;

/// State of a mesh during simplification.
pub(super) struct Simplifier<'a> {
    wedges: Wedges<'a>,
    surface: Surface,
    costs: Costs,
    components: Components,
    kept: Vec<bool>,
    /// Region of each class; empty if there is only one.
    regions: Vec<u16>,
    seams_open: bool,
    /// Whether each class lies on the border that the surface is mirrored at; empty if not
    /// mirrored. Collapses go along the border or inside, so no class changes sides.
    rim: Vec<bool>,
    versions: Vec<u32>,
    queue: BinaryHeap<Entry>,
    /// Length of the queue from which outdated entries are removed.
    crowded: usize,
    /// Squared length that a change of attributes is multiplied by.
    normal_weight: f64,
    ring: Ring,
    images: Images,
    /// Removed vertices; `None` if their distances do not count.
    removed_vertices: Option<RemovedVertices>,
    /// Square of the greatest distance of removed vertices; infinite without a limit.
    limit: f64,
    /// Greatest cost of a collapse; infinite without a limit.
    limit_cost: f64,
    /// Marks the neighbours of the current target.
    stamps: Vec<u32>,
    stamp: u32,
}

impl<'a> Simplifier<'a> {
    pub(super) fn new(
        mesh: &'a Mesh,
        poses: &[Vec<Vec3>],
        options: &SimplifyOptions,
        classes: &'a Classes,
        sources: &Sources,
    ) -> Self {
        let surface = Surface::new(&sources.triangles, classes);
        let costs = Costs::new(mesh, poses, options, classes, &surface);
        let mut kept = costs.lost.clone();
        for v in &options.locked {
            kept[classes.of_vertex[*v as usize] as usize] = true;
        }
        let extent = classes::extent(&poses[0]);
        let length = f64::from(extent) * NORMAL_LENGTH;
        let metres = options.limit.map(|limit| f64::from(limit.metres));
        let squared = metres.map_or(f64::INFINITY, |metres| metres * metres);
        let mut simplifier = Self {
            wedges: Wedges { mesh, classes },
            regions: regions(options, classes),
            seams_open: false,
            rim: if options.mirrored {
                rim(&surface, classes.len())
            } else {
                Vec::new()
            },
            versions: vec![0; classes.len()],
            queue: BinaryHeap::with_capacity(classes.len()),
            crowded: 2 * classes.len(),
            normal_weight: length * length * poses.len() as f64,
            ring: Ring::default(),
            images: Images::default(),
            removed_vertices: options
                .measured
                .then(|| RemovedVertices::new(sources.triangles.len(), classes.len())),
            limit: squared,
            limit_cost: options.limit.map_or(f64::INFINITY, |l| l.cost * squared),
            stamps: vec![0; classes.len()],
            stamp: 0,
            components: Components::new(&surface, &costs, &kept, extent),
            surface,
            costs,
            kept,
        };
        simplifier.fill();
        simplifier
    }

    /// Sets whether vertices between regions may be removed from now on.
    pub(super) fn open_seams(&mut self, open: bool) {
        if open && !self.regions.is_empty() {
            self.seams_open = true;
            self.fill();
        }
    }

    /// The remaining triangles.
    pub(super) fn level(&mut self, sources: &Sources) -> LevelTriangles {
        sources.left(&mut self.surface)
    }

    /// Collapses until at most `target` faces are left or no collapse is allowed.
    pub(super) fn run(&mut self, target: usize, notes: &mut Notes<'_>) {
        let mut filled = self.surface.live;
        while self.surface.live > target {
            notes.take(&self.surface);
            self.forget_stale();
            let Some(Reverse((bits, from, to, version, priced))) = self.queue.pop() else {
                // Refused collapses may be allowed by now; a refill must have enough progress
                // behind it.
                if filled - self.surface.live <= filled / LOOK_AGAIN {
                    return;
                }
                filled = self.surface.live;
                self.fill();
                continue;
            };
            if f64::from_bits(bits) > self.limit_cost {
                return;
            }
            if to == WHOLE {
                self.vanish(from);
                continue;
            }
            if self.versions[from as usize] != version {
                continue;
            }
            if !self.is_allowed(from, to) {
                if !priced {
                    self.push_next(from, Some((bits, to)));
                }
                continue;
            }
            let removed = self.removed_distance(from, to);
            let change = self.change_cost(from, to);
            if removed > self.limit || change > LIMIT_CHANGE * self.limit {
                if !priced {
                    self.push_next(from, Some((bits, to)));
                }
                continue;
            }
            let further = change + REMOVED_WEIGHT * removed;
            if !priced && further > 0.0 {
                let bits_now = (f64::from_bits(bits) + further).to_bits();
                self.queue
                    .push(Reverse((bits_now, from, to, version, true)));
                self.push_next(from, Some((bits, to)));
                continue;
            }
            self.apply(from, to);
        }
    }

    /// Squared distance that removed vertices would have after a collapse that was just checked.
    fn removed_distance(&mut self, from: u32, to: u32) -> f64 {
        let (costs, ring) = (&self.costs, &self.ring);
        let removed_vertices = self.removed_vertices.as_mut();
        removed_vertices.map_or(0.0, |s| {
            f64::from(s.distance_squared(costs, ring, (from, to)))
        })
    }

    /// Removes entries with outdated versions once the queue mostly consists of them. They would be
    /// skipped anyway, but a large queue is slow.
    fn forget_stale(&mut self) {
        if self.queue.len() < self.crowded {
            return;
        }
        let versions = &self.versions;
        self.queue.retain(|Reverse((_, from, to, version, _))| {
            *to == WHOLE || versions[*from as usize] == *version
        });
        self.crowded = 2 * self.queue.len() + versions.len();
    }

    /// Fills the queue with the cheapest collapse of each vertex.
    fn fill(&mut self) {
        self.queue.clear();
        for class in 0..self.versions.len() as u32 {
            self.versions[class as usize] += 1;
            self.push_next(class, None);
        }
        if self.limit.is_finite() {
            // A component may lie within the limit of another and still be seen, as an iris is.
            return;
        }
        for (component, size) in self.components.tiny() {
            let bits = (size * REMOVED_WEIGHT).to_bits();
            self.queue.push(Reverse((bits, component, WHOLE, 0, true)));
        }
    }

    /// Adds the collapse of a vertex that follows the given cost and target to the queue.
    fn push_next(&mut self, from: u32, after: Option<(u64, u32)>) {
        let valence = self.surface.valence(from);
        if self.kept[from as usize] || valence == 0 || valence > MAX_FACES {
            return;
        }
        let mut best = None;
        self.stamp += 1;
        for (face, at) in self.surface.around(from) {
            let corners = self.surface.faces[face];
            for to in [corners[(at + 1) % 3], corners[(at + 2) % 3]] {
                if self.stamps[to as usize] == self.stamp {
                    continue;
                }
                self.stamps[to as usize] = self.stamp;
                let cost = self.costs.of_move(from, to);
                let key = (cost.to_bits(), to);
                let later = after.is_none_or(|a| key > a);
                if cost.is_finite() && later && best.is_none_or(|b| key < b) {
                    best = Some(key);
                }
            }
        }
        if let Some((bits, to)) = best {
            let version = self.versions[from as usize];
            self.queue.push(Reverse((bits, from, to, version, false)));
        }
    }

    /// Whether a collapse keeps the surface intact. Leaves the images of the wedges in `images`.
    fn is_allowed(&mut self, from: u32, to: u32) -> bool {
        if !self.within_region(from) {
            return false;
        }
        self.ring.look(&self.surface, from);
        let Some(place) = self.ring.neighbours.iter().position(|n| *n == to) else {
            return false;
        };
        let around_target = self.surface.valence(to);
        if around_target > 256
            || around_target + self.ring.faces.len() > MAX_FACES_AFTER + 4
            || !self.ring.keeps_border(place)
            || !self.ring.is_one_fan()
            || !self.keeps_links(to)
            || !self.keeps_rim(from, to)
        {
            return false;
        }
        self.images.find(&self.surface, self.wedges, &self.ring, to) && !self.turns_over(from, to)
    }

    fn within_region(&self, from: u32) -> bool {
        if self.regions.is_empty() || self.seams_open {
            return true;
        }
        let region = self.regions[from as usize];
        let inside = |v: &u32| self.regions[*v as usize] == region;
        let mut faces = self.surface.around(from);
        region != BETWEEN && faces.all(|(f, _)| self.surface.faces[f].iter().all(inside))
    }

    /// The link condition: all common neighbours lie opposite to the edge, and no face comes to
    /// coincide with another.
    fn keeps_links(&mut self, to: u32) -> bool {
        self.stamp += 1;
        let stamp = self.stamp;
        for (face, at) in self.surface.around(to) {
            let corners = self.surface.faces[face];
            for k in 1..3 {
                self.stamps[corners[(at + k) % 3] as usize] = stamp;
            }
        }
        let near = |v: u32| self.stamps[v as usize] == stamp;
        let has = |f: &(usize, usize, u32, u32), v: u32| f.2 == v || f.3 == v;
        let opposite = |v: u32| self.ring.faces.iter().any(|f| has(f, to) && has(f, v));
        let common = |v: &&u32| **v != to && near(**v);
        if !self
            .ring
            .neighbours
            .iter()
            .filter(common)
            .all(|v| opposite(*v))
        {
            return false;
        }
        let exists = |a: u32, b: u32| {
            let mut around = self.surface.around(to);
            around.any(|(f, _)| {
                let corners = self.surface.faces[f];
                corners.contains(&a) && corners.contains(&b)
            })
        };
        let mut stay = self.ring.faces.iter().filter(|f| !has(f, to));
        !stay.any(|f| near(f.2) && near(f.3) && exists(f.2, f.3))
    }

    /// Whether no inner edge would join two vertices of the mirrored border. Uses the stamps that
    /// [`Self::keeps_links`] leaves at the neighbours of `to`.
    fn keeps_rim(&self, from: u32, to: u32) -> bool {
        let on_rim = |v: u32| self.rim.get(v as usize).copied().unwrap_or(false);
        if !on_rim(to) || on_rim(from) {
            return true;
        }
        let near = |v: u32| self.stamps[v as usize] == self.stamp;
        let mut others = self.ring.neighbours.iter().filter(|n| **n != to);
        others.all(|n| !on_rim(*n) || near(*n))
    }

    /// Whether a remaining face would turn by too much or vanish in some pose.
    fn turns_over(&self, from: u32, to: u32) -> bool {
        let (start, end) = (self.costs.points(from), self.costs.points(to));
        for (_, _, a, b) in &self.ring.faces {
            if *a == to || *b == to {
                continue;
            }
            let (a, b) = (self.costs.points(*a), self.costs.points(*b));
            for pose in 0..start.len() {
                let before = area_vector([start[pose], a[pose], b[pose]]);
                let after = area_vector([end[pose], a[pose], b[pose]]);
                let (l, m) = (before.length(), after.length());
                if l > 0.0 && before.dot(after) <= MIN_COSINE * l * m {
                    return true;
                }
            }
        }
        false
    }

    /// Cost of changes of attributes.
    fn change_cost(&self, from: u32, to: u32) -> f64 {
        if self.images.changes.iter().all(|c| *c == 0.0) {
            return 0.0;
        }
        let stays = |f: &&(usize, usize, u32, u32)| f.2 != to && f.3 != to;
        let faces = self.ring.faces.iter().filter(stays);
        let mut sum = 0.0;
        for ((face, ..), change) in faces.zip(&self.images.changes) {
            let corners = self.surface.faces[*face].map(|c| self.costs.points(c)[0]);
            sum += 0.5 * area_vector(corners).length() * f64::from(*change);
        }
        let cost = sum * self.normal_weight / 3.0;
        self.costs.squared_distance(from, cost) * f64::from(self.costs.factor(from))
    }

    /// Removes a whole component.
    fn vanish(&mut self, component: u32) {
        let within = |face: &u32| {
            let classes = self.surface.faces[*face as usize];
            let first = self.regions[classes[0] as usize];
            first != BETWEEN && classes.iter().all(|c| self.regions[*c as usize] == first)
        };
        let faces = self.components.faces(component);
        let mut alive = faces.iter().filter(|f| self.surface.is_alive(**f as usize));
        if !self.regions.is_empty() && !self.seams_open && !alive.all(within) {
            return;
        }
        for face in faces {
            if self.surface.is_alive(*face as usize) {
                self.surface.kill(*face as usize);
            }
        }
    }

    fn apply(&mut self, from: u32, to: u32) {
        if let Some(removed_vertices) = &mut self.removed_vertices {
            removed_vertices.apply(&self.ring);
        }
        self.surface.collapse(from, to, &self.images.of_corners);
        self.costs.merge(from, to);
        self.versions[from as usize] += 1;
        let neighbours = std::mem::take(&mut self.ring.neighbours);
        for n in &neighbours {
            self.versions[*n as usize] += 1;
            self.push_next(*n, None);
        }
        self.ring.neighbours = neighbours;
    }
}

/// Whether each class lies on an open border.
fn rim(surface: &Surface, classes: usize) -> Vec<bool> {
    let mut ring = Ring::default();
    (0..classes as u32)
        .map(|class| {
            ring.look(surface, class);
            ring.degrees.contains(&1)
        })
        .collect()
}

fn regions(options: &SimplifyOptions, classes: &Classes) -> Vec<u16> {
    let Some(first) = options.regions.first() else {
        return Vec::new();
    };
    if options.regions.iter().all(|r| r == first) {
        return Vec::new();
    }
    let mut regions: Vec<u16> = classes
        .first
        .iter()
        .map(|v| u16::from(options.regions[*v as usize]))
        .collect();
    for (v, class) in classes.of_vertex.iter().enumerate() {
        let known = &mut regions[*class as usize];
        if *known != u16::from(options.regions[v]) {
            *known = BETWEEN;
        }
    }
    regions
}

#[cfg(test)]
mod tests;
