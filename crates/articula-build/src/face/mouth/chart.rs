//! A chart of the lower face: the angle around the mouth and the distance from the line between the lips.
//!
//! The warp of a head to the template carries the feature points of the one to those of the other. There the face is
//! unrolled about an upright axis, and the line between the lips is the segment between the foci of elliptic coordinates:
//! the angle runs along the upper lip and back along the lower one, the level grows outwards.

use super::super::points::{FacePoints, FaceSurface, template_place, to_template};
use super::super::table::{Mirror, SurfaceGraph, sheet, smooth};
use super::depths::Depths;
use super::laid_on::laid_on;
use articula_core::Libm;
use articula_core::feature_points::PointId;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Columns of the chart around the mouth, from the left corner over the upper lip.
pub(super) const COLUMNS: usize = 32;
/// Rows of the chart, outwards, and the level between two.
pub(super) const ROWS: usize = 16;
pub(super) const STEP: f32 = 0.15;
/// Level over which motions fade at the border of the chart.
const FADE: f32 = 0.3;

/// Depth of the upright axis on the template, metres: that of the hinge of the jaw.
const AXIS: f32 = 0.0125;
/// Depths on the template behind which the head rests, metres.
const BACK: [f32; 2] = [-0.02, 0.01];
/// Depths behind the foremost skin, by height of the face, from which skin is inside of the mouth, and from which
/// it does not follow the lips.
const INSIDE: [f32; 2] = [0.11, 0.26];
/// Level up to which hidden skin is inside of the mouth.
const AROUND: [f32; 2] = [0.7, 1.0];
/// Depth behind the foremost skin up to which a vertex is seen from the front, by height of the face.
const SEEN: f32 = 0.03;

/// How far below the chin of the unrolled face, by half the width of the mouth, skin may end that goes with the chin, as
/// the neck is a part of its own; and how far beside the middle that is seen.
const UNDER: f32 = 1.5;
const BESIDE: f32 = 1.0;
/// How far on the other side of the line between the lips a vertex may be that stands for a point of a lip.
const ASTRAY: f32 = 0.05;

/// Points of the upper and of the lower lip.
const LIPS: [[PointId; 6]; 2] = [
    [(2, 2), (2, 6), (2, 7), (8, 1), (8, 5), (8, 6)],
    [(2, 3), (2, 8), (2, 9), (8, 2), (8, 7), (8, 8)],
];

/// Where a vertex is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) vertex: u32,
    /// Place in the unrolled face, by half the width of the mouth: to the left of its middle, and above the line
    /// between the lips.
    pub(super) flat: Vec2,
    /// 0 on the upper sheet, 1 on the lower one.
    pub(super) lower: f32,
    /// How much it follows the motions of the chart.
    pub(super) share: f32,
    /// 0 on the face, 1 deep inside of the mouth.
    pub(super) inside: f32,
    /// Whether it is on the outer side of the face.
    pub(super) is_seen: bool,
}

/// The vertices of the skin of a head, by where they are around the mouth.
#[derive(Debug, Clone, PartialEq)]
pub struct MouthChart {
    pub(super) places: Vec<Place>,
    /// Vertices of parts that lie on the skin.
    pub(super) others: Vec<Place>,
    /// Height of the face, metres.
    pub(super) height: f32,
    /// Number of vertices of the surface.
    pub(super) count: usize,
}

/// Column and row of a place in the unrolled face, on the upper (0) or the lower (1) sheet; a place beyond the line
/// between the lips is on it.
pub(super) fn cell(flat: Vec2, sheet: usize) -> [f32; 2] {
    let y = if sheet == 0 { flat.y } else { -flat.y }.max(0.0);
    // x = cosh(level) cos(angle), y = sinh(level) sin(angle).
    let [before, behind] = [flat.x - 1.0, flat.x + 1.0].map(|x| (x * x + y * y).sqrt());
    let (cosh, cos) = (0.5 * (before + behind), 0.5 * (behind - before));
    let cosh = cosh.max(1.0);
    let level = (cosh + (cosh * cosh - 1.0).sqrt()).libm_ln();
    let angle = (1.0 - cos * cos).max(0.0).sqrt().libm_atan2(cos);
    let column = angle / PI * (COLUMNS / 2) as f32;
    let column = if sheet == 0 {
        column
    } else {
        COLUMNS as f32 - column
    };
    [column, level / STEP]
}

/// The place in the unrolled face of a column and a row.
pub(super) fn node(column: usize, row: usize) -> Vec2 {
    let (sin, cos) = (2.0 * PI * column as f32 / COLUMNS as f32).libm_sin_cos();
    let up = (row as f32 * STEP).libm_exp();
    0.5 * Vec2::new((up + 1.0 / up) * cos, (up - 1.0 / up) * sin)
}

impl MouthChart {
    /// The chart of a head. `None` if its feature points lie in a plane, or the tip of the nose (9.3) is not among them.
    pub fn new(surface: &FaceSurface, points: &FacePoints) -> Option<Self> {
        let warp = to_template(points)?;
        let unrolled = Unrolled::of_template();
        let parts = &points.parts;
        let height = points.height();
        let at = |v: u32| surface.positions[v as usize];
        let mirror = Mirror::of(
            &surface.positions,
            &parts.joined,
            points.get((9, 3))?.place.x,
        );
        let graph = SurfaceGraph::of(&surface.positions, &parts.joined, &parts.skin, &mirror);
        let flat = |place: Vec3| unrolled.flat(warp.apply(place));
        let lips = lips(points, |v| flat(at(v)).y);
        let to_lips = lips.each_ref().map(|lip| graph.distances(lip));
        let ends = border(&parts.joined, &parts.skin).into_iter();
        let chin = unrolled.bottom(ends.map(|v| flat(at(v))));
        let depths = Depths::of(surface, &parts.skin, height / 150.0);
        let place = |vertex: u32, lower: f32| {
            let on_template = warp.apply(at(vertex));
            let flat = unrolled.flat(on_template);
            let flat = Vec2::new(flat.x, flat.y.max(chin));
            let behind = depths.behind(at(vertex)) / height;
            let rim = smooth(((ROWS - 1) as f32 * STEP - level(flat)) / FADE);
            Place {
                vertex,
                flat,
                lower,
                share: rim * between(BACK, on_template.z),
                inside: between(INSIDE, behind) * (1.0 - between(AROUND, level(flat))),
                is_seen: behind < SEEN,
            }
        };
        let of_skin = |v: &u32| {
            let to_lips = to_lips.each_ref().map(|away| away[*v as usize]);
            place(*v, lower(to_lips, height, flat(at(*v))))
        };
        let around = |place: Vec3| Some(flat(place)).filter(|flat| level(*flat) < AROUND[1]);
        let others = laid_on(surface, points, (&mirror, &lips), around);
        let others = others.into_iter().map(|(vertex, lower)| Place {
            inside: 0.0,
            ..place(vertex, lower)
        });
        Some(Self {
            places: parts
                .skin_vertices
                .iter()
                .map(of_skin)
                .filter(|p| p.share > 0.0)
                .collect(),
            others: others.collect(),
            height,
            count: surface.positions.len(),
        })
    }
}

/// The vertices of the upper and of the lower lip that stand for its points. On a coarse mesh one vertex may stand for
/// points of both; it is of the lip on whose side of the line between them it is. None where a face has no lips, so that
/// all are on one side. `height` is that above the line.
fn lips(points: &FacePoints, height: impl Fn(u32) -> f32) -> [Vec<u32>; 2] {
    let lips = [(0, 1.0), (1, -1.0)].map(|(lip, up): (usize, f32)| {
        let vertex = |point: &PointId| points.get(*point)?.vertex;
        let all = LIPS[lip].iter().filter_map(vertex);
        all.filter(|v| up * height(*v) > -ASTRAY)
            .collect::<Vec<u32>>()
    });
    match lips.iter().any(Vec::is_empty) {
        true => [Vec::new(), Vec::new()],
        false => lips,
    }
}

/// Vertices at edges of one triangle.
fn border(joined: &[u32], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| joined[v as usize]);
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    edges.sort_unstable();
    let alone = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
    alone.flat_map(|same| same[0]).collect()
}

/// The level of a place in the unrolled face.
fn level(flat: Vec2) -> f32 {
    cell(flat, usize::from(flat.y < 0.0))[1] * STEP
}

/// 0 on the upper sheet, 1 on the lower one, by the distances along the skin to each lip; for skin that is not connected
/// to them by the place.
fn lower([to_upper, to_lower]: [f32; 2], height: f32, flat: Vec2) -> f32 {
    if to_upper.is_finite() && to_lower.is_finite() {
        sheet(to_upper, to_lower, 0.01 * height)
    } else {
        smooth(0.5 - 0.5 * flat.y)
    }
}

/// Smooth step from 0 at the first limit to 1 at the second.
fn between([from, to]: [f32; 2], value: f32) -> f32 {
    smooth((value - from) / (to - from))
}

/// The face of the template, unrolled about an upright axis.
struct Unrolled {
    /// Distance of the corners of the lips from the axis, and of a corner from the middle, unrolled, metres.
    radius: f32,
    half: f32,
    /// Heights of the line between the lips at the middle and at the corners.
    line: [f32; 2],
    /// Height of the bottom of the chin, and its distance from the axis.
    chin: [f32; 2],
}

impl Unrolled {
    fn of_template() -> Self {
        let [corner, upper, low, chin] = [(2, 4), (2, 2), (2, 3), (2, 1)].map(template_place);
        let radius = Vec2::new(corner.x, corner.z - AXIS).length();
        Self {
            radius,
            half: radius * corner.x.libm_atan2(corner.z - AXIS),
            line: [0.5 * (upper.y + low.y), corner.y],
            chin: [chin.y, chin.z - AXIS],
        }
    }

    /// The height below which a face goes with its chin, by the places where its skin ends: that of the chin, if the skin
    /// ends below it.
    fn bottom(&self, mut ends: impl Iterator<Item = Vec2>) -> f32 {
        let [chin, _] = self.chin;
        let [middle, _] = self.line;
        let chin = (chin - middle) / self.half;
        let is_below = |end: Vec2| end.x.abs() < BESIDE && (chin - UNDER..chin).contains(&end.y);
        if ends.any(is_below) {
            chin
        } else {
            f32::NEG_INFINITY
        }
    }

    fn flat(&self, place: Vec3) -> Vec2 {
        let x = self.radius * place.x.libm_atan2(place.z - AXIS) / self.half;
        let [middle, corner] = self.line;
        let line = middle + (corner - middle) * (x * x).min(1.0);
        // What is under the chin goes on below it, back to the neck.
        let [low, front] = self.chin;
        let under = smooth((middle - place.y) / (middle - low));
        let back = (front - Vec2::new(place.x, place.z - AXIS).length()).max(0.0);
        Vec2::new(x, (place.y - line - under * back) / self.half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_at_their_cells() {
        for column in 0..COLUMNS {
            for row in 1..ROWS {
                let sheet = usize::from(column > COLUMNS / 2);
                let [c, r] = cell(node(column, row), sheet);
                assert!((c - column as f32).abs() < 2e-2, "{column} {row}: {c}");
                assert!((r - row as f32).abs() < 1e-2, "{column} {row}: {r}");
            }
        }
    }

    #[test]
    fn the_line_between_the_lips_is_of_both_sheets() {
        let middle = COLUMNS as f32 / 4.0;
        assert!((cell(Vec2::ZERO, 0)[0] - middle).abs() < 1e-3);
        assert!((cell(Vec2::ZERO, 1)[0] - 3.0 * middle).abs() < 1e-3);
        // Upper skin that reaches below the line is at its edge.
        assert_eq!(cell(Vec2::new(0.3, -0.2), 0), cell(Vec2::new(0.3, 0.0), 0));
        // Corners are the foci.
        assert!(cell(Vec2::X, 0)[1] < 1e-3 && cell(-Vec2::X, 1)[1] < 1e-3);
        assert!((cell(-Vec2::X, 0)[0] - 2.0 * middle).abs() < 1e-3);
    }
}
