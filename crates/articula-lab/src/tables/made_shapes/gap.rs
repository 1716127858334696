//! How far lids are open, seen from the front.

use articula_build::face::{FacePoints, FaceSurface};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

/// Width of the cells, metres.
const CELL: f32 = 1e-4;
/// Half the width of the window around an eye, by the distance of its corners.
const WINDOW: f32 = 0.75;
/// Depth behind the skin on all sides from which a place is inside of a socket, by the height of the face; and that of
/// one that was not seen there at rest.
const DEEP: f32 = 0.04;
const INSIDE: f32 = 0.06;
/// Distances of a lid that is a part of its own from the middle of the eyeball, by its radius, the least of its outer side,
/// its least height, and the most of the opening that it covers.
const ON_BALL: std::ops::Range<f32> = 0.95..1.4;
const THICK: f32 = 1.07;
const TALL: f32 = 0.5;
const COVERS: f32 = 0.9;
/// Outer and inner corner of each eye.
const CORNERS: [[(u8, u8); 2]; 2] = [[(3, 7), (3, 11)], [(3, 8), (3, 12)]];

/// Depths of cells of a square grid, and the triangle that is seen in each.
struct Grid {
    low: Vec2,
    count: usize,
    depths: Vec<f32>,
    seen: Vec<usize>,
}

/// An eye, and the triangles that are drawn.
struct Eye<'a> {
    surface: &'a FaceSurface,
    low: Vec2,
    count: usize,
    /// Height of the face.
    height: f32,
    lids: Vec<[u32; 3]>,
    ball: Vec<[u32; 3]>,
}

/// Height of the tallest place of the left (0) or the right eye at which an eyeball is in front of the lids or, without
/// eyeballs, what is seen inside of a socket at rest is seen still, metres; with the vertices displaced. `None` if nothing
/// of the kind is seen at rest.
pub(super) fn gap(
    (surface, points): (&FaceSurface, &FacePoints),
    moved: &[Vec3],
    eye: usize,
) -> Option<f32> {
    let eye = Eye::of(surface, points, eye);
    let still = vec![Vec3::ZERO; moved.len()];
    let (at_rest, seen) = eye.open(&still, None);
    let rest = tallest(&at_rest, eye.count);
    let (now, _) = eye.open(moved, Some(&seen));
    (rest > 5.0 * CELL).then(|| tallest(&now, eye.count))
}

/// The tallest column of open cells, metres.
fn tallest(is_open: &[bool], count: usize) -> f32 {
    let run = |column: usize| {
        let (mut most, mut now) = (0_u32, 0_u32);
        for row in 0..count {
            now = if is_open[row * count + column] {
                now + 1
            } else {
                0
            };
            most = most.max(now);
        }
        most
    };
    (0..count).map(run).max().unwrap_or(0) as f32 * CELL
}

impl<'a> Eye<'a> {
    fn of(surface: &'a FaceSurface, points: &FacePoints, eye: usize) -> Self {
        let [outer, inner] = CORNERS[eye].map(|p| points.get(p).map_or(Vec3::ZERO, |p| p.place));
        let half = (WINDOW * outer.distance(inner) / CELL).ceil();
        let ball = points.eyeballs().map_or(Vec::new(), |balls| {
            let is_ball = |t: &&[u32; 3]| t.iter().all(|v| balls[eye].binary_search(v).is_ok());
            surface.triangles.iter().filter(is_ball).copied().collect()
        });
        let mut found = Self {
            surface,
            low: outer.midpoint(inner).truncate() - half * CELL,
            count: 2 * half as usize + 1,
            height: points.height(),
            lids: points.skin().to_vec(),
            ball,
        };
        let parts = found.lid_parts(points);
        found.lids.extend(parts);
        found
    }

    fn drawn(&self, triangles: &[[u32; 3]], moved: &[Vec3]) -> Grid {
        let grid = Grid {
            low: self.low,
            count: self.count,
            depths: Vec::new(),
            seen: Vec::new(),
        };
        let at = |v: u32| self.surface.positions[v as usize] + moved[v as usize];
        grid.drawn(triangles.iter().map(|t| t.map(at)))
    }

    /// The open cells, and the triangles that are seen in them; `at_rest` are those that are seen at rest.
    fn open(
        &self,
        moved: &[Vec3],
        at_rest: Option<&BTreeSet<usize>>,
    ) -> (Vec<bool>, BTreeSet<usize>) {
        let lids = self.drawn(&self.lids, moved);
        let is_open: Vec<bool> = if self.ball.is_empty() {
            let around = lids.around();
            let cells = lids.depths.iter().zip(&around).zip(&lids.seen);
            let is_open = |((at, around), seen): ((&f32, &f32), &usize)| {
                let behind = around - at;
                let was_seen = at_rest.is_none_or(|rest| rest.contains(seen));
                at.is_finite()
                    && (behind > INSIDE * self.height || behind > DEEP * self.height && was_seen)
            };
            cells.map(is_open).collect()
        } else {
            let ball = self.drawn(&self.ball, moved);
            let pairs = ball.depths.iter().zip(&lids.depths);
            pairs.map(|(ball, skin)| ball > skin).collect()
        };
        let open = lids.seen.iter().zip(&is_open).filter(|(_, open)| **open);
        let seen = open.map(|(seen, _)| *seen).collect();
        (is_open, seen)
    }

    /// Triangles of lids that are parts of their own: sheets on the eyeball that leave some of it open.
    fn lid_parts(&self, points: &FacePoints) -> Vec<[u32; 3]> {
        let at = |v: &u32| self.surface.positions[*v as usize];
        let extent = |triangles: &[[u32; 3]]| {
            let places = || triangles.iter().flatten().map(at);
            let low = places().fold(Vec3::INFINITY, Vec3::min);
            (low, places().fold(Vec3::NEG_INFINITY, Vec3::max))
        };
        if self.ball.is_empty() {
            return Vec::new();
        }
        let (low, high) = extent(&self.ball);
        let radius = 0.5 * (high.y - low.y);
        let middle = low.midpoint(high).truncate().extend(high.z - radius);
        let skin: BTreeSet<u32> = points.skin().iter().flatten().copied().collect();
        let eyes: BTreeSet<u32> = points
            .eyeballs()
            .into_iter()
            .flatten()
            .flatten()
            .copied()
            .collect();
        let is_near = |t: &&[u32; 3]| {
            let near = |v: &u32| ON_BALL.contains(&(at(v).distance(middle) / radius));
            t.iter()
                .all(|v| near(v) && !skin.contains(v) && !eyes.contains(v))
        };
        let near = self.surface.triangles.iter().filter(is_near).copied();
        let still = vec![Vec3::ZERO; self.surface.positions.len()];
        let (open, _) = self.open(&still, None);
        let ball = self.drawn(&self.ball, &still);
        let is_lid = |part: &Vec<[u32; 3]>| {
            let (low, high) = extent(part);
            let view = self.drawn(part, &still);
            let covered = |cell: &usize| open[*cell] && view.depths[*cell] > ball.depths[*cell];
            let covered = (0..open.len()).filter(covered).count() as f32;
            let all = open.iter().filter(|open| **open).count() as f32;
            let mut vertices = part.iter().flatten();
            let is_thick = vertices.any(|v| at(v).distance(middle) > THICK * radius);
            is_thick && high.y - low.y > TALL * radius && covered < COVERS * all
        };
        let parts = pieces(&near.collect::<Vec<_>>()).into_iter();
        parts.filter(is_lid).flatten().collect()
    }
}

/// Triangles that are connected by shared vertices.
fn pieces(triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    let mut pieces: Vec<(BTreeSet<u32>, Vec<[u32; 3]>)> = Vec::new();
    for triangle in triangles {
        let touches =
            |piece: &(BTreeSet<u32>, Vec<[u32; 3]>)| triangle.iter().any(|v| piece.0.contains(v));
        let (touched, mut others): (Vec<_>, Vec<_>) = pieces.into_iter().partition(touches);
        let mut one = (BTreeSet::from(*triangle), vec![*triangle]);
        for (vertices, triangles) in touched {
            one.0.extend(vertices);
            one.1.extend(triangles);
        }
        others.push(one);
        pieces = others;
    }
    pieces.into_iter().map(|(_, triangles)| triangles).collect()
}

impl Grid {
    fn drawn(mut self, triangles: impl Iterator<Item = [Vec3; 3]>) -> Self {
        self.depths = vec![f32::NEG_INFINITY; self.count * self.count];
        self.seen = vec![usize::MAX; self.depths.len()];
        for (index, corners) in triangles.enumerate() {
            self.draw(index, corners);
        }
        self
    }

    fn draw(&mut self, index: usize, [a, b, c]: [Vec3; 3]) {
        let [fa, fb, fc] = [a, b, c].map(|p| (p.truncate() - self.low) / CELL);
        let area = (fb - fa).perp_dot(fc - fa);
        let least = fa.min(fb).min(fc).ceil().max(Vec2::ZERO);
        let most = fa
            .max(fb)
            .max(fc)
            .floor()
            .min(Vec2::splat(self.count as f32 - 1.0));
        if area.abs() < 1e-9 || most.x < least.x || most.y < least.y {
            return;
        }
        for y in least.y as usize..=most.y as usize {
            for x in least.x as usize..=most.x as usize {
                let p = Vec2::new(x as f32, y as f32) - fa;
                let (wb, wc) = (p.perp_dot(fc - fa) / area, (fb - fa).perp_dot(p) / area);
                // A hair wider, so that no seam stays between two triangles.
                if wb >= -1e-3 && wc >= -1e-3 && wb + wc <= 1.001 {
                    let cell = y * self.count + x;
                    let depth = a.z + wb * (b.z - a.z) + wc * (c.z - a.z);
                    if depth > self.depths[cell] {
                        (self.depths[cell], self.seen[cell]) = (depth, index);
                    }
                }
            }
        }
    }

    /// For each cell the least of the foremost depths above it, below it, to its left and to its right.
    fn around(&self) -> Vec<f32> {
        let mut least = vec![f32::INFINITY; self.depths.len()];
        for line in 0..self.count {
            let row: Vec<usize> = (0..self.count).map(|i| line * self.count + i).collect();
            let column: Vec<usize> = (0..self.count).map(|i| i * self.count + line).collect();
            for cells in [row, column] {
                self.foremost_before(cells.iter(), &mut least);
                self.foremost_before(cells.iter().rev(), &mut least);
            }
        }
        least
    }

    fn foremost_before<'a>(&self, cells: impl Iterator<Item = &'a usize>, least: &mut [f32]) {
        let mut foremost = f32::NEG_INFINITY;
        for cell in cells {
            least[*cell] = least[*cell].min(foremost);
            foremost = foremost.max(self.depths[*cell]);
        }
    }
}
