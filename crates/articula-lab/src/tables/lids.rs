//! Whether the lids of a face close, seen from the front.

use articula_build::face::{FaceSurface, FaceTable, FapValues};
use articula_core::fap_table::LOW_FAPS;
use glam::Vec3;

/// Cells across an eyeball.
const CELLS: usize = 240;
/// Distance from an eyeball, by its radius, up to which triangles belong to it.
const OF_BALL: f32 = 0.06;
/// States of the upper and the lower lids, in units: the upper ones alone, and both. They stop where
/// they meet.
const CLOSED: [[f32; 2]; 3] = [[1600.0, 0.0], [800.0, 800.0], [1080.0, 150.0]];
/// States on the way.
const HALF: [[f32; 2]; 3] = [[270.0, 0.0], [540.0, 0.0], [810.0, 100.0]];

/// What was measured of the lids of a face.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lids {
    /// Greatest height that stays open while the lids are closed, percent of that at rest.
    pub(super) open_percent: f32,
    /// Number of vertices of the skin that go from outside of an eyeball to its inside.
    pub(super) inside: usize,
}

impl Lids {
    /// Closes the eyes of a face by its table.
    pub(super) fn of(surface: &FaceSurface, table: &FaceTable) -> Self {
        let mut found = Self::default();
        for (centre, radius) in table.eyes().into_iter().flatten() {
            let rest = opening(surface, &surface.positions, centre, radius);
            for state in CLOSED.into_iter().chain(HALF) {
                let mut values = FapValues::default();
                for (fap, value) in (19..=22).zip([state[0], state[0], state[1], state[1]]) {
                    values.0[fap - LOW_FAPS.start()] = value;
                }
                let moved = table.displacements(&values);
                let places: Vec<Vec3> = surface
                    .positions
                    .iter()
                    .zip(&moved)
                    .map(|(a, b)| *a + *b)
                    .collect();
                if CLOSED.contains(&state) {
                    let open = opening(surface, &places, centre, radius);
                    found.open_percent = found.open_percent.max(100.0 * open / rest);
                }
                let inside = surface.positions.iter().zip(&places).filter(|(from, to)| {
                    from.distance(centre) > radius && to.distance(centre) < radius * (1.0 - 1e-5)
                });
                found.inside = found.inside.max(inside.count());
            }
        }
        found
    }
}

/// Greatest height over the columns of what is seen of a ball between the skin in front of it, in cells.
fn opening(surface: &FaceSurface, places: &[Vec3], centre: Vec3, radius: f32) -> f32 {
    let step = 2.0 * radius / CELLS as f32;
    let mut covered = vec![false; CELLS * CELLS];
    let is_of_ball =
        |v: &u32| surface.positions[*v as usize].distance(centre) < (1.0 + OF_BALL) * radius;
    for triangle in &surface.triangles {
        // At rest, lids are no layer of the ball: some corner is farther away.
        if triangle.iter().all(is_of_ball) {
            continue;
        }
        let [a, b, c] = triangle.map(|v| (places[v as usize] - centre) / step + 0.5 * CELLS as f32);
        let low = a.min(b).min(c).max(Vec3::ZERO);
        let high = a.max(b).max(c).min(Vec3::splat(CELLS as f32 - 1.0));
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if area.abs() < 1e-9 || high.x < 0.0 || high.y < 0.0 {
            continue;
        }
        for y in low.y.ceil() as usize..=high.y as usize {
            for x in low.x.ceil() as usize..=high.x as usize {
                let p = Vec3::new(x as f32, y as f32, 0.0) - a;
                let wb = p.truncate().perp_dot((c - a).truncate()) / area;
                let wc = (b - a).truncate().perp_dot(p.truncate()) / area;
                if wb < 0.0 || wc < 0.0 || wb + wc > 1.0 {
                    continue;
                }
                let half = 0.5 * CELLS as f32;
                let (dx, dy) = (x as f32 - half, y as f32 - half);
                let depth = (half * half - dx * dx - dy * dy).max(0.0).sqrt();
                let z = a.z + wb * (b.z - a.z) + wc * (c.z - a.z) - half;
                covered[y * CELLS + x] |= z > depth;
            }
        }
    }
    let half = 0.5 * CELLS as f32;
    let is_ball = |x: usize, y: usize| {
        let (dx, dy) = (x as f32 - half, y as f32 - half);
        dx * dx + dy * dy < 0.9 * half * half
    };
    let open = |x: usize| {
        let cells = (0..CELLS).filter(|y| is_ball(x, *y) && !covered[y * CELLS + x]);
        cells.count()
    };
    (0..CELLS).map(open).max().unwrap_or(0) as f32
}
