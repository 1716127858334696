//! Polygonisation of a distance field: dual surface nets over the half space x >= 0.
//!
//! Source: S. Gibson, *Constrained elastic surface nets* (1998), with each vertex then moved onto
//! the surface along the gradient of the field. A cell that two sheets cross has a vertex for each
//! (after G. Nielson, *Dual marching cubes*, 2004). Only the half with x >= 0 is meshed, on a grid
//! whose first cells straddle the mirror plane.

use glam::Vec3;
use std::collections::HashMap;

/// A closed surface, or half of one whose open rim lies in the plane x = 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Surface {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Tone of each triangle, by number; empty if there is only one.
    pub(crate) tones: Vec<u8>,
}

/// Sample coordinates along each axis; the first two of x are mirror images.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    pub(crate) axes: [Vec<f32>; 3],
}

/// Edge length in samples of the smallest block that is skipped as a whole.
const BLOCK: usize = 4;

impl Grid {
    /// A grid over a box with spacing `step`; if the box reaches x = 0, it straddles that plane.
    pub(crate) fn uniform(low: Vec3, high: Vec3, step: f32) -> Self {
        Self::banded(low, high, |_, _| step)
    }

    /// The same with a spacing given by axis and coordinate.
    pub(crate) fn banded(low: Vec3, high: Vec3, step: impl Fn(usize, f32) -> f32) -> Self {
        let first = step(0, 0.0);
        let start = if low.x <= first { -0.5 * first } else { low.x };
        let from = [start, low.y, low.z];
        let axes = std::array::from_fn(|axis| {
            let mut samples = vec![from[axis]];
            let mut last = from[axis];
            while last < high[axis] {
                last += step(axis, last);
                samples.push(last);
            }
            samples
        });
        Self { axes }
    }

    fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| self.axes[a].len())
    }

    fn at(&self, i: [usize; 3]) -> Vec3 {
        Vec3::new(self.axes[0][i[0]], self.axes[1][i[1]], self.axes[2][i[2]])
    }
}

/// Field values at all samples of a grid; far from the surface only the sign is correct.
struct Samples<'a> {
    grid: &'a Grid,
    values: Vec<f32>,
}

impl<'a> Samples<'a> {
    fn new(grid: &'a Grid, field: &impl Fn(Vec3) -> f32) -> Self {
        let [nx, ny, nz] = grid.counts();
        let mut samples = Self {
            grid,
            values: vec![0.0; nx * ny * nz],
        };
        for k in (0..nz).step_by(4 * BLOCK) {
            for j in (0..ny).step_by(4 * BLOCK) {
                for i in (0..nx).step_by(4 * BLOCK) {
                    samples.fill([i, j, k], 4 * BLOCK, field);
                }
            }
        }
        samples
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.grid.counts();
        (k * ny + j) * nx + i
    }

    /// Fills a block with edges of `size` samples, subdivided where the surface may come near.
    fn fill(&mut self, low: [usize; 3], size: usize, field: &impl Fn(Vec3) -> f32) {
        let counts = self.grid.counts();
        if (0..3).any(|a| low[a] >= counts[a]) {
            return;
        }
        let end: [usize; 3] = std::array::from_fn(|a| (low[a] + size).min(counts[a]));
        // One sample beyond the block, since cells extend past its rim.
        let last: [usize; 3] = std::array::from_fn(|a| end[a].min(counts[a] - 1));
        let (a, b) = (self.grid.at(low), self.grid.at(last));
        let middle = field(0.5 * (a + b));
        // Gradients stay below 1.5 outside of creases, so this is conservative.
        if middle.abs() > 0.8 * (b - a).length() {
            self.each(low, end, |_| middle);
        } else if size > BLOCK {
            for corner in 0..8_usize {
                let half = size / 2;
                let sub = std::array::from_fn(|a| low[a] + half * ((corner >> a) & 1));
                self.fill(sub, half, field);
            }
        } else {
            self.each(low, end, field);
        }
    }

    fn each(&mut self, low: [usize; 3], end: [usize; 3], value: impl Fn(Vec3) -> f32) {
        for k in low[2]..end[2] {
            for j in low[1]..end[1] {
                for i in low[0]..end[0] {
                    let at = self.index([i, j, k]);
                    self.values[at] = value(self.grid.at([i, j, k]));
                }
            }
        }
    }

    fn inside(&self, i: [usize; 3]) -> bool {
        self.values[self.index(i)] < 0.0
    }

    /// The point at which the surface crosses an edge of a cell, if it does.
    fn crossing(&self, cell: [usize; 3], edge: usize) -> Option<Vec3> {
        let (low, high) = (edge % 8, (edge % 8) | (1 << (edge / 8)));
        if low == high {
            return None;
        }
        let corner = |c: usize| std::array::from_fn(|a| cell[a] + ((c >> a) & 1));
        let (i, j): ([usize; 3], [usize; 3]) = (corner(low), corner(high));
        let (a, b) = (self.values[self.index(i)], self.values[self.index(j)]);
        let crossed = (a < 0.0) != (b < 0.0);
        crossed.then(|| self.grid.at(i).lerp(self.grid.at(j), a / (a - b)))
    }

    /// For each sheet of the surface in a cell, the edges it crosses and the mean of the crossing
    /// points.
    fn cell_sheets(&self, cell: [usize; 3]) -> Vec<(Vec<usize>, Vec3)> {
        let inside: [bool; 8] =
            std::array::from_fn(|c| self.inside(std::array::from_fn(|a| cell[a] + ((c >> a) & 1))));
        if inside.iter().all(|i| *i == inside[0]) {
            return Vec::new();
        }
        let labels = sheets(inside);
        let mut found: Vec<(Vec<usize>, Vec3)> = Vec::new();
        for edge in 0..EDGES {
            let Some(point) = self.crossing(cell, edge) else {
                continue;
            };
            match found.iter_mut().find(|(e, _)| labels[e[0]] == labels[edge]) {
                Some((edges, sum)) => {
                    edges.push(edge);
                    *sum += point;
                }
                None => found.push((vec![edge], point)),
            }
        }
        for (edges, sum) in &mut found {
            *sum /= edges.len() as f32;
        }
        found
    }
}

/// Edges of a cell are numbered by their axis times 8 plus their lower corner.
const EDGES: usize = 24;

/// Returns the sheet that each crossed edge of a cell belongs to.
///
/// Two sheets pass where a face has diagonally opposite inside corners; each such corner keeps its
/// own sheet. The rule depends on the face alone, so that neighbouring cells agree and the surface
/// is a manifold.
fn sheets(inside: [bool; 8]) -> [usize; EDGES] {
    let mut sheet: [usize; EDGES] = std::array::from_fn(|e| e);
    for axis in 0..3 {
        let (u, v) = (1_usize << ((axis + 1) % 3), 1_usize << ((axis + 2) % 3));
        for side in [0, 1 << axis] {
            let ring = [side, side | u, side | u | v, side | v];
            let edge = |i: usize| {
                let (c, d) = (ring[i % 4], ring[(i + 1) % 4]);
                (c ^ d).ilog2() as usize * 8 + c.min(d)
            };
            let crossed: Vec<usize> = (0..4)
                .filter(|i| inside[ring[*i]] != inside[ring[(*i + 1) % 4]])
                .collect();
            for pair in crossed.windows(2).chain([&[3, 0][..]]) {
                let corner = ring[(pair[0] + 1) % 4];
                let two = crossed.len() == 2 && pair == crossed;
                if two || crossed.len() == 4 && inside[corner] {
                    let (from, to) = (sheet[edge(pair[0])], sheet[edge(pair[1])]);
                    for s in sheet.iter_mut().filter(|s| **s == from) {
                        *s = to;
                    }
                }
            }
        }
    }
    sheet
}

/// Extracts the surface where `field` is zero. The grid must enclose it, except at the mirror
/// plane.
pub(crate) fn polygonise(grid: &Grid, field: &impl Fn(Vec3) -> f32) -> Surface {
    let samples = Samples::new(grid, field);
    let counts = grid.counts();
    let mut surface = Surface::default();
    let mut vertices = HashMap::<usize, u32>::new();
    // Cells with several sheets have a vertex for each, keyed by the crossed edge.
    let mut split = HashMap::<(usize, usize), u32>::new();
    for k in 0..counts[2] - 1 {
        for j in 0..counts[1] - 1 {
            for i in 0..counts[0] - 1 {
                let cell = [i, j, k];
                let sheets = samples.cell_sheets(cell);
                let single = sheets.len() == 1;
                for (edges, vertex) in sheets {
                    let number = surface.positions.len() as u32;
                    let at = samples.index(cell);
                    if single {
                        vertices.insert(at, number);
                    } else {
                        split.extend(edges.iter().map(|e| ((at, *e), number)));
                    }
                    let mirrored = i == 0 && grid.axes[0][0] < 0.0;
                    surface.positions.push(onto(field, vertex, mirrored, 2));
                }
            }
        }
    }
    let vertex = |cell: [usize; 3], edge: usize| {
        let at = samples.index(cell);
        vertices
            .get(&at)
            .copied()
            .unwrap_or_else(|| split[&(at, edge)])
    };
    for k in 1..counts[2] - 1 {
        for j in 1..counts[1] - 1 {
            for i in 1..counts[0] - 1 {
                for axis in 0..3 {
                    quad(&samples, [i, j, k], axis, &vertex, &mut surface);
                }
            }
        }
    }
    surface
}

/// Adds the two triangles around a grid edge that the surface crosses.
fn quad(
    samples: &Samples<'_>,
    from: [usize; 3],
    axis: usize,
    vertex: &impl Fn([usize; 3], usize) -> u32,
    out: &mut Surface,
) {
    let mut to = from;
    to[axis] += 1;
    let inside = samples.inside(from);
    if inside == samples.inside(to) {
        return;
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let around = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(du, dv)| {
        let mut cell = from;
        cell[u] -= du;
        cell[v] -= dv;
        vertex(cell, axis * 8 + (du << u) + (dv << v))
    });
    let [a, b, c, d] = if inside {
        around
    } else {
        [around[3], around[2], around[1], around[0]]
    };
    let p = |i: u32| out.positions[i as usize];
    // The shorter diagonal bends less.
    let halves = if p(a).distance_squared(p(c)) <= p(b).distance_squared(p(d)) {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    };
    out.triangles.extend(halves);
}

/// Moves a point onto the surface in `steps` steps of at most 2 mm; `mirrored` keeps it in the
/// plane x = 0.
pub(crate) fn onto(field: &impl Fn(Vec3) -> f32, from: Vec3, mirrored: bool, steps: usize) -> Vec3 {
    let flat = if mirrored {
        Vec3::new(0.0, 1.0, 1.0)
    } else {
        Vec3::ONE
    };
    let mut p = from * flat;
    for _ in 0..steps {
        let here = field(p);
        let slope = forward_gradient(field, p, here) * flat;
        let step = slope * (here / slope.length_squared().max(0.05));
        p -= step.clamp_length_max(0.002);
    }
    p
}

/// Half the cost of central differences and accurate enough to step along.
fn forward_gradient(field: &impl Fn(Vec3) -> f32, p: Vec3, here: f32) -> Vec3 {
    const STEP: f32 = 2e-4;
    let along = |axis: Vec3| field(p + axis * STEP) - here;
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / STEP
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Number of triangles at each edge.
    pub(crate) fn edge_uses(surface: &Surface) -> HashMap<(u32, u32), usize> {
        let mut uses = HashMap::new();
        for [a, b, c] in &surface.triangles {
            for (u, v) in [(a, b), (b, c), (c, a)] {
                *uses.entry((*u.min(v), *u.max(v))).or_insert(0) += 1;
            }
        }
        uses
    }

    /// A ball of radius 1 around the origin, or the half of it with x >= 0.
    pub(crate) fn ball(half: bool) -> Surface {
        let low = if half {
            Vec3::new(0.0, -1.3, -1.3)
        } else {
            Vec3::new(1.7, -1.3, -1.3)
        };
        let center = if half { Vec3::ZERO } else { Vec3::X * 3.0 };
        let high = center + 1.3;
        polygonise(&Grid::uniform(low, high, 0.1), &|p| {
            (p - center).length() - 1.0
        })
    }

    #[test]
    fn a_ball_is_closed_round_and_faces_outwards() {
        let ball = ball(false);
        let edges = edge_uses(&ball);
        assert!(edges.values().all(|n| *n == 2));
        // Euler: V - E + F = 2 for a sphere.
        assert_eq!(ball.positions.len() + ball.triangles.len(), edges.len() + 2);
        for p in &ball.positions {
            // Steps are at most 2 mm; the means of the cells lie within 4 mm of the ball.
            assert!(((*p - Vec3::X * 3.0).length() - 1.0).abs() < 2e-3, "{p}");
        }
        for t in &ball.triangles {
            let [a, b, c] = t.map(|v| ball.positions[v as usize] - Vec3::X * 3.0);
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
        }
    }

    #[test]
    fn half_a_ball_opens_only_in_the_mirror_plane() {
        let half = ball(true);
        for ((a, b), uses) in edge_uses(&half) {
            let in_plane = [a, b].iter().all(|v| half.positions[*v as usize].x == 0.0);
            assert_eq!(uses, if in_plane { 1 } else { 2 });
        }
        assert!(half.positions.iter().all(|p| p.x >= 0.0));
    }
}
