//! How much each vertex of the skin follows each handle.
//!
//! Source: a spline with the kernel -|r| through the handles gives weights that are 1 at their own handle
//! and 0 at all others. Lips and lids are sheets that lie on each other but move apart: their vertices
//! are weighted by splines without the handles of the other sheet (`docs/methods/faces.md`).

use super::super::dense;
use super::graph::{SurfaceGraph, smooth};
use super::handles::{Handle, HandleKind};
use articula_core::feature_points::PointId;
use glam::Vec3;

/// Added to the diagonal of the spline.
const SMOOTHING: f64 = 1e-4;
/// Radius of the rounding of the kernel, by height of the face.
const ROUND: f64 = 0.05;
/// Reach of the sheets of an eye around its centre, and over which they fade, by height of the face.
const EYE_REACH: f32 = 0.22;
const EYE_FADE: f32 = 0.08;
/// Distance from the nearest moving handle from which skin rests, and the width of the fade before it,
/// by height of the face.
const REST: f32 = 0.55;
const REST_FADE: f32 = 0.25;

/// Handles of the upper and of the lower lip.
const UPPER_LIP: [PointId; 6] = [(2, 2), (2, 6), (2, 7), (8, 1), (8, 5), (8, 6)];
const LOWER_LIP: [PointId; 10] = [
    (2, 3),
    (2, 8),
    (2, 9),
    (8, 2),
    (8, 7),
    (8, 8),
    (2, 1),
    (2, 10),
    (2, 11),
    (2, 12),
];

/// A spline of some of the handles.
struct Spline {
    /// Handles by index; further centres are pins, which have no weight.
    handles: Vec<usize>,
    centres: Vec<Vec3>,
    /// Row by centre and one for the constant: coefficients of each handle's weight.
    coefficients: Vec<f64>,
    unit: f32,
}

impl Spline {
    fn of(
        handles: &[Handle],
        pins: &[Vec3],
        unit: f32,
        left_out: impl Fn(&Handle) -> bool,
    ) -> Option<Self> {
        let kept: Vec<usize> = (0..handles.len())
            .filter(|h| !left_out(&handles[*h]))
            .collect();
        let centres: Vec<Vec3> = kept
            .iter()
            .map(|h| handles[*h].place)
            .chain(pins.iter().copied())
            .collect();
        let (n, sides) = (centres.len() + 1, kept.len());
        let mut matrix = vec![0.0; n * n];
        for (i, a) in centres.iter().enumerate() {
            for (j, b) in centres.iter().enumerate() {
                matrix[i * n + j] = kernel(*a, *b, unit);
            }
            matrix[i * n + i] += SMOOTHING;
            matrix[i * n + n - 1] = 1.0;
            matrix[(n - 1) * n + i] = 1.0;
        }
        let mut right = vec![0.0; n * sides];
        for side in 0..sides {
            right[side * sides + side] = 1.0;
        }
        dense::solve(&mut matrix, &mut right, sides)?;
        Some(Self {
            handles: kept,
            centres,
            coefficients: right,
            unit,
        })
    }

    /// Adds `share` times the weights at a place.
    fn add(&self, place: Vec3, share: f32, into: &mut [f32]) {
        if share == 0.0 {
            return;
        }
        let sides = self.handles.len();
        let mut sums = vec![0.0_f64; sides];
        let basis = self.centres.iter().map(|c| kernel(*c, place, self.unit));
        for (row, basis) in self
            .coefficients
            .chunks_exact(sides)
            .zip(basis.chain([1.0]))
        {
            for (sum, c) in sums.iter_mut().zip(row) {
                *sum += basis * c;
            }
        }
        for (handle, sum) in self.handles.iter().zip(sums) {
            into[*handle] += share * sum as f32;
        }
    }
}

/// The kernel of the spline: the distance by the height of the face, rounded near 0, so that no handle
/// draws the skin to a tip.
fn kernel(a: Vec3, b: Vec3, unit: f32) -> f64 {
    let distance = f64::from(a.distance(b) / unit);
    -(distance * distance + ROUND * ROUND).sqrt()
}

/// What the weights are computed from.
pub(super) struct WeightInput<'a> {
    pub(super) handles: &'a [Handle],
    /// Places that rest.
    pub(super) pins: &'a [Vec3],
    pub(super) positions: &'a [Vec3],
    pub(super) graph: &'a SurfaceGraph,
    /// Height of the face.
    pub(super) height: f32,
    /// Centres of the eyes: left and right.
    pub(super) eyes: [Vec3; 2],
}

/// Weights of each vertex, one for each handle, row by row. `None` if the handles make no spline.
pub(super) fn weights(input: &WeightInput<'_>, vertices: &[u32]) -> Option<Vec<f32>> {
    let unit = input.height;
    let moving = |points: &[PointId]| {
        let of = |h: &&Handle| matches!(h.what, HandleKind::Moving(p) if points.contains(&p));
        input
            .handles
            .iter()
            .filter(of)
            .map(|h| h.vertex)
            .collect::<Vec<u32>>()
    };
    let is_lip = |h: &Handle, points: &[PointId]| matches!(h.what, HandleKind::Moving(p) if points.contains(&p));
    let is_lid = |h: &Handle, lid: PointId| h.what.lid() == Some(lid);
    let lid_vertices = |lid: PointId| {
        let of = input.handles.iter().filter(|h| is_lid(h, lid));
        of.map(|h| h.vertex).collect::<Vec<u32>>()
    };
    let lips =
        [moving(&UPPER_LIP), moving(&LOWER_LIP[..6])].map(|from| input.graph.distances(&from));
    let lids = [[(3, 1), (3, 3)], [(3, 2), (3, 4)]];
    let lid_distances = lids.map(|lids| lids.map(|lid| input.graph.distances(&lid_vertices(lid))));
    let movers: Vec<u32> = input
        .handles
        .iter()
        .filter(|h| h.what != HandleKind::Resting)
        .map(|h| h.vertex)
        .collect();
    let near = input.graph.distances(&movers);

    // Without one lip each; of either, with all lids and without one of each eye.
    let mut splines: Vec<[Spline; 5]> = Vec::new();
    for other in [&LOWER_LIP[..], &UPPER_LIP[..]] {
        let without = |lid: Option<PointId>| {
            Spline::of(input.handles, input.pins, unit, |h| {
                is_lip(h, other) || lid.is_some_and(|lid| is_lid(h, lid))
            })
        };
        splines.push([
            without(None)?,
            without(Some(lids[0][1]))?,
            without(Some(lids[0][0]))?,
            without(Some(lids[1][1]))?,
            without(Some(lids[1][0]))?,
        ]);
    }
    let count = input.handles.len();
    let mut all = vec![0.0; vertices.len() * count];
    for (vertex, row) in vertices.iter().zip(all.chunks_exact_mut(count)) {
        let v = *vertex as usize;
        let fade = smooth((REST - near[v] / unit) / REST_FADE);
        if fade == 0.0 {
            continue;
        }
        let place = input.positions[v];
        let lower_lip = sheet(lips[0][v], lips[1][v], 0.01 * unit);
        for (lip, share) in [(0, 1.0 - lower_lip), (1, lower_lip)] {
            let share = share * fade;
            let [full, lids @ ..] = &splines[lip];
            let eye = usize::from(place.distance(input.eyes[1]) < place.distance(input.eyes[0]));
            let away = place.distance(input.eyes[eye]) / unit;
            let of_eye = smooth((EYE_REACH + EYE_FADE - away) / EYE_FADE);
            full.add(place, share * (1.0 - of_eye), row);
            let [upper, lower] = &lid_distances[eye];
            let lower_lid = sheet(upper[v], lower[v], 0.006 * unit);
            lids[2 * eye].add(place, share * of_eye * (1.0 - lower_lid), row);
            lids[2 * eye + 1].add(place, share * of_eye * lower_lid, row);
        }
    }
    Some(all)
}

/// 0 on the upper sheet, 1 on the lower one, by the distances along the surface to each.
pub(in crate::face) fn sheet(upper: f32, lower: f32, band: f32) -> f32 {
    if !upper.is_finite() || !lower.is_finite() {
        return if upper <= lower { 0.0 } else { 1.0 };
    }
    smooth(0.5 + 0.5 * (upper - lower) / (band + 0.25 * upper.min(lower)))
}
