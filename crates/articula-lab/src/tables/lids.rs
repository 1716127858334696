//! Whether the lids of a face close, seen from the front.

use articula_build::face::{EyeShape, FaceSurface, FaceTable, FapInterval, FapValues};
use glam::{Vec2, Vec3};

/// Cells across an eyeball.
const CELLS: usize = 240;
/// Parameters of the upper and the lower lids.
const LID_FAPS: [usize; 4] = [19, 20, 21, 22];
/// Distance from an eyeball, by its radius, up to which triangles belong to it.
const OF_BALL: f32 = 0.06;
/// Depth below the surface of an eye, by its radius, from which a vertex is inside: 12 micrometres.
const INSIDE: f32 = 1e-3;
/// States of the upper and the lower lids, in units, in which an eye is closed: the columns of `eyeBlink`,
/// the upper lid alone, and farther than the lids can go. They stop where they meet.
const CLOSED: [[f32; 2]; 5] = [
    [950.0, 74.0],
    [1024.0, 0.0],
    [1600.0, 0.0],
    [800.0, 800.0],
    [1080.0, 150.0],
];
/// Those that the table as morph targets shows too: it adds up what each parameter does alone.
const AS_MORPHS: usize = 2;
/// States on the way.
const HALF: [[f32; 2]; 4] = [[270.0, 0.0], [540.0, 0.0], [810.0, 100.0], [220.0, 400.0]];

/// What was measured of the lids of a face.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lids {
    /// Greatest height that stays open while the lids are closed, percent of that at rest.
    pub(super) open_percent: f32,
    /// The same of the table as morph targets.
    pub(super) open_as_morphs_percent: f32,
    /// Number of vertices of the head that go from outside of an eyeball to its inside.
    pub(super) inside: usize,
    /// The same of the table as morph targets, whose straight lines cut corners.
    pub(super) inside_as_morphs: usize,
}

impl Lids {
    /// Closes the eyes of a face by its table.
    pub(super) fn of(surface: &FaceSurface, table: &FaceTable) -> Self {
        let mut found = Self::default();
        let intervals = LID_FAPS.map(|fap| table.intervals(fap));
        for eye in table.eyes().into_iter().flatten() {
            let rest = opening(surface, &surface.positions, eye);
            let shown = |moved: Vec<Vec3>, open: Option<&mut f32>, inside: &mut usize| {
                let places = surface.positions.iter().zip(&moved).map(|(a, b)| *a + *b);
                let places: Vec<Vec3> = places.collect();
                if let Some(open) = open {
                    *open = open.max(100.0 * opening(surface, &places, eye) / rest);
                }
                *inside = (*inside).max(entered(&surface.positions, &places, eye));
            };
            for state in CLOSED {
                shown(
                    table.displacements(&values(state)),
                    Some(&mut found.open_percent),
                    &mut found.inside,
                );
            }
            for state in HALF {
                shown(table.displacements(&values(state)), None, &mut found.inside);
            }
            for (index, state) in CLOSED[..AS_MORPHS].iter().chain(&HALF).enumerate() {
                let open = &mut found.open_as_morphs_percent;
                let moved = as_morphs(table, &intervals, &values(*state));
                shown(
                    moved,
                    (index < AS_MORPHS).then_some(open),
                    &mut found.inside_as_morphs,
                );
            }
        }
        found
    }
}

/// The lids of both eyes: the upper and the lower ones.
fn values([upper, lower]: [f32; 2]) -> FapValues {
    let mut values = FapValues::default();
    for (fap, value) in LID_FAPS.into_iter().zip([upper, upper, lower, lower]) {
        values.set(fap, value);
    }
    values
}

/// Displacements by the table as morph targets, of lids in their intervals.
fn as_morphs(
    table: &FaceTable,
    intervals: &[Vec<FapInterval>; 4],
    values: &FapValues,
) -> Vec<Vec3> {
    let at = |fap: usize, value: i32| table.displacements(&FapValues::alone(fap, value as f32));
    let mut sum: Vec<Vec3> = at(19, 0);
    let moved = LID_FAPS.into_iter().zip(intervals);
    for (fap, intervals) in moved.filter(|(fap, _)| values.get(*fap) != 0.0) {
        for interval in intervals {
            let weight = interval.weight(values.get(fap), intervals);
            let ends = [interval.from, interval.to].map(|value| at(fap, value));
            for ((sum, from), to) in sum.iter_mut().zip(&ends[0]).zip(&ends[1]) {
                *sum += weight * (*to - *from);
            }
        }
    }
    sum
}

/// Number of vertices that go from outside of an eye to its inside.
fn entered(from: &[Vec3], to: &[Vec3], eye: &EyeShape) -> usize {
    let depth = |p: Vec3| 1.0 - p.distance(eye.centre) / eye.radius(p - eye.centre).max(1e-6);
    let pairs = from.iter().zip(to);
    pairs
        .filter(|(from, to)| from != to && depth(**from) < 0.0 && depth(**to) > INSIDE)
        .count()
}

/// Greatest height over the columns of what is seen of an eye between the skin in front of it, in cells.
fn opening(surface: &FaceSurface, places: &[Vec3], eye: &EyeShape) -> f32 {
    let (centre, radius) = (eye.centre, eye.radius(Vec3::Z));
    let step = 2.0 * radius / CELLS as f32;
    let mut covered = vec![false; CELLS * CELLS];
    let is_of_ball = |v: &u32| {
        let from = surface.positions[*v as usize] - centre;
        from.length() < (1.0 + OF_BALL) * eye.radius(from)
    };
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
                let depth = front(eye, Vec2::new(dx, dy) * step) / step;
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

/// Depth of the surface of an eye beside its middle; 0 beside the eye.
fn front(eye: &EyeShape, aside: Vec2) -> f32 {
    let mut z = eye.radius(Vec3::Z);
    // The direction of the place says how far the surface is, and this where the place is.
    for _ in 0..4 {
        let radius = eye.radius(aside.extend(z));
        z = (radius * radius - aside.length_squared()).max(0.0).sqrt();
    }
    z
}
