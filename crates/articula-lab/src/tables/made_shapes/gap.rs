//! How far lids are open, seen from the front.

use articula_build::face::{FacePoints, FaceSurface};
use glam::{Vec2, Vec3};

/// Width of the cells, metres.
const CELL: f32 = 1e-4;
/// Half the width of the window around an eye, by the distance of its corners.
const WINDOW: f32 = 0.75;
/// Depth behind the skin on all sides from which a place is inside of a socket, by the height of the face.
const DEEP: f32 = 0.02;
/// Outer and inner corner of each eye.
const CORNERS: [[(u8, u8); 2]; 2] = [[(3, 7), (3, 11)], [(3, 8), (3, 12)]];

/// Depths of cells of a square grid.
struct Grid {
    low: Vec2,
    count: usize,
    depths: Vec<f32>,
}

/// Height of the tallest place of the left (0) or the right eye at which an eyeball is in front of the skin or, without
/// eyeballs, the skin falls back into a socket, metres; with the vertices displaced. `None` if nothing of the kind is
/// seen at rest.
pub(super) fn gap(
    (surface, points): (&FaceSurface, &FacePoints),
    moved: &[Vec3],
    eye: usize,
) -> Option<f32> {
    let still = vec![Vec3::ZERO; moved.len()];
    let at_rest = tallest((surface, points), &still, eye);
    (at_rest > 5.0 * CELL).then(|| tallest((surface, points), moved, eye))
}

fn tallest((surface, points): (&FaceSurface, &FacePoints), moved: &[Vec3], eye: usize) -> f32 {
    let [outer, inner] = CORNERS[eye].map(|p| points.get(p).map_or(Vec3::ZERO, |p| p.place));
    let half = (WINDOW * outer.distance(inner) / CELL).ceil();
    let grid = || Grid {
        low: outer.midpoint(inner).truncate() - half * CELL,
        count: 2 * half as usize + 1,
        depths: Vec::new(),
    };
    let at = |v: u32| surface.positions[v as usize] + moved[v as usize];
    let skin = grid().drawn(points.skin().iter().map(|t| t.map(at)));
    let is_open: Vec<bool> = match points.eyeballs() {
        Some(balls) => {
            let is_ball = |t: &&[u32; 3]| t.iter().all(|v| balls[eye].binary_search(v).is_ok());
            let balls = surface.triangles.iter().filter(is_ball);
            let balls = grid().drawn(balls.map(|t| t.map(at)));
            let pairs = balls.depths.iter().zip(&skin.depths);
            pairs.map(|(ball, skin)| ball > skin).collect()
        }
        None => {
            let around = skin.around();
            let pairs = skin.depths.iter().zip(&around);
            let deep = DEEP * points.height();
            pairs
                .map(|(at, around)| at.is_finite() && around - at > deep)
                .collect()
        }
    };
    let run = |column: usize| {
        let (mut most, mut now) = (0_u32, 0_u32);
        for row in 0..skin.count {
            now = if is_open[row * skin.count + column] {
                now + 1
            } else {
                0
            };
            most = most.max(now);
        }
        most
    };
    (0..skin.count).map(run).max().unwrap_or(0) as f32 * CELL
}

impl Grid {
    fn drawn(mut self, triangles: impl Iterator<Item = [Vec3; 3]>) -> Self {
        self.depths = vec![f32::NEG_INFINITY; self.count * self.count];
        triangles.for_each(|t| self.draw(t));
        self
    }

    fn draw(&mut self, [a, b, c]: [Vec3; 3]) {
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
                    let depth = &mut self.depths[y * self.count + x];
                    *depth = depth.max(a.z + wb * (b.z - a.z) + wc * (c.z - a.z));
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
