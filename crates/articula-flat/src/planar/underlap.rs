//! Sealed edges: triangles reach a little under those neighbours that are painted later, so that no
//! background shows through anti-aliased edges.
//!
//! Source: `docs/methods/vector.md` 5. Silhouettes stay where they are, and no bytes are added.
//! Corners move steadily between frames, since every jump would cost a key frame:
//! - an edge moves outward no further than its neighbour reaches, so it comes to rest on the
//!   silhouette while the neighbour turns away;
//! - a corner stays within the triangles around it that are painted later or have about the same
//!   colour: what sticks out beside them, at a silhouette or over another colour, shows as a thorn,
//!   the gap that is left beside it as a hairline at most;
//! - a neighbour counts while it faces the viewer, even when something else hides it;
//! - corners are a damped least-squares solution of the moved edge lines; their intersection would
//!   run away and turn over where lines are nearly parallel.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::fan::{Fan, Wall};
use super::neighbours::{Neighbour, Neighbours, faces_viewer, outward};
use super::order::Painting;
use glam::Vec2;

/// A triangle, and the corner at which its edge begins.
pub(crate) type OutlineEdge = (u32, u8);

/// Maximum displacement of a corner, in underlap distances.
const FURTHEST: f32 = 5.0;
/// Maximum underlap distance, pixels.
const MAX_DISTANCE: f32 = 64.0;
/// Weight that keeps a corner at its position, relative to the two edge lines.
const DAMPING: f32 = 0.02;
/// Stiffness of an edge line that stays, relative to one that moves by the whole distance. It never
/// moves outward; inward it opens a gap.
const STIFFNESS: f32 = 50.0;
/// Difference of colours, levels, up to half of which a triangle may be painted over one beside its
/// neighbour; from one and a half of it on it may not.
const ALIKE: f32 = 32.0;
/// Maximum number of walls of a corner.
const MAX_WALLS: usize = 2 * (1 + Fan::MAX_WALLS);
/// Distance beyond a wall that does not show, pixels.
const SLACK_PX: f32 = 0.02;

/// Options of sealing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UnderlapOptions {
    /// Distance by which an edge reaches under its neighbour, pixels; 0 moves nothing.
    pub distance_px: f32,
}

impl Default for UnderlapOptions {
    fn default() -> Self {
        Self { distance_px: 0.8 }
    }
}

/// Sealed corners of triangles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sealed {
    /// The three corners of every triangle in every frame, pixels. Where a triangle is not drawn
    /// they are those of the clip.
    pub corners: Vec<Vec<[Vec2; 3]>>,
}

/// Seals the triangles of a whole clip.
///
/// O(frames x triangles).
pub(crate) fn seal(
    clip: &PlanarClip,
    drawn: &Drawn,
    painting: &Painting,
    options: UnderlapOptions,
) -> Sealed {
    let sealer = Sealer::new(clip, options);
    let mut corners: Vec<Vec<[Vec2; 3]>> = Vec::with_capacity(clip.frames.len());
    for epoch in &painting.epochs {
        let rank = ranks(clip, &epoch.order);
        for f in epoch.frames.clone().take(clip.frames.len() - corners.len()) {
            let is_drawn = |t| f < drawn.frames() && drawn.get(f, t);
            corners.push(sealer.frame(f, is_drawn, |t| rank[t as usize]));
        }
    }
    Sealed { corners }
}

/// Position of each triangle in an order; triangles that the clip does not have are ignored.
pub(crate) fn ranks(clip: &PlanarClip, order: &[u32]) -> Vec<Option<u32>> {
    let mut rank = vec![None; clip.triangles.len()];
    for (r, t) in (0..).zip(order) {
        if let Some(of) = rank.get_mut(*t as usize) {
            *of = Some(r);
        }
    }
    rank
}

/// Moves the edges of drawn triangles under neighbours that are painted later.
#[derive(Debug, Clone)]
pub(crate) struct Sealer<'a> {
    clip: &'a PlanarClip,
    neighbours: Neighbours,
    distance: f32,
}

impl<'a> Sealer<'a> {
    /// Finds the neighbours of all triangles.
    pub(crate) fn new(clip: &'a PlanarClip, options: UnderlapOptions) -> Self {
        Self {
            clip,
            neighbours: Neighbours::new(clip),
            // NaN becomes 0.
            distance: f32::max(options.distance_px, 0.0).min(MAX_DISTANCE),
        }
    }

    /// Returns the corners of every triangle in one frame.
    ///
    /// `rank` returns the position of a triangle in the painting order, greater is later; `None` if
    /// it is not painted around this frame.
    pub(crate) fn frame(
        &self,
        frame: usize,
        is_drawn: impl Fn(usize) -> bool,
        rank: impl Fn(u32) -> Option<u32>,
    ) -> Vec<[Vec2; 3]> {
        let of = |t: usize| {
            let places = self.clip.places(frame, t);
            let own = is_drawn(t).then(|| rank(t as u32)).flatten();
            let Some(own) = own.filter(|_| faces_viewer(&places)) else {
                return places;
            };
            let is_later = |n: u32| rank(n).is_some_and(|r| r > own);
            let sides = [0, 1, 2].map(|e| self.side(frame, (t, e), &rank, &is_later));
            moved(&places, &sides, self.distance)
        };
        (0..self.clip.triangles.len()).map(of).collect()
    }

    /// Returns the points of an outline in one frame, each where one of its edges begins; an edge
    /// is a triangle and the corner at which it starts. `rank` as for [`Self::frame`], with the
    /// same value for all triangles within the outline.
    pub(crate) fn outline(
        &self,
        frame: usize,
        edges: &[OutlineEdge],
        rank: impl Fn(u32) -> Option<u32>,
    ) -> Vec<Vec2> {
        let line = |(t, e): &(u32, u8)| {
            let (triangle, edge) = (*t as usize, usize::from(*e));
            let places = self.clip.places(frame, triangle);
            let own = rank(*t).filter(|_| faces_viewer(&places));
            let is_later = |n: u32| own.is_some_and(|own| rank(n).is_some_and(|r| r > own));
            let side = self.side(frame, (triangle, edge), &rank, &is_later);
            (places[edge], (outward(&places, edge), side))
        };
        let lines: Vec<(Vec2, (Vec2, Side))> = edges.iter().map(line).collect();
        let before = lines.iter().cycle().skip(lines.len().saturating_sub(1));
        let corner = |((_, before), (place, after)): (&(Vec2, (Vec2, Side)), &(Vec2, _))| {
            *place + way(before, after, self.distance)
        };
        before.zip(&lines).map(corner).collect()
    }

    /// What an edge may reach under: its neighbours that are painted later.
    fn side(
        &self,
        frame: usize,
        (triangle, edge): (usize, usize),
        rank: &impl Fn(u32) -> Option<u32>,
        is_later: &impl Fn(u32) -> bool,
    ) -> Side {
        let mut best: Option<(f32, Neighbour)> = None;
        for n in self.neighbours.across(triangle, edge) {
            let reach = n.height(self.clip, frame, (triangle, edge));
            if reach > best.map_or(0.0, |(reach, _)| reach) && is_later(n.triangle) {
                best = Some((reach, *n));
            }
        }
        let Some((reach, first)) = best else {
            return Side::default();
        };
        let own = self.clip.triangles[triangle];
        let fan = |corner: usize, at_start: bool| {
            // How much of a triangle may be painted over: all of a later one, which hides it
            // again, and of an earlier one as far as the colours are alike.
            let share = |n: Neighbour, vertex: u32| {
                if is_later(n.triangle) {
                    return Some(1.0);
                }
                rank(n.triangle).map(|_| self.alike(frame, own[corner], vertex))
            };
            Fan::new((self.clip, &self.neighbours), frame, first, at_start, share)
        };
        let fans = [fan(edge, true), fan((edge + 1) % 3, false)];
        // Across a sliver, the reach behind it is added.
        let reach = fans.map(|fan| {
            if reach < self.distance {
                reach + fan.beyond_first()
            } else {
                reach
            }
        });
        Side { reach, fans }
    }

    /// How alike the colours of two vertices are in a frame: 1 if no edge shows between them, 0 if
    /// it shows clearly.
    fn alike(&self, frame: usize, a: u32, b: u32) -> f32 {
        let (p, q) = (self.clip.color(frame, a), self.clip.color(frame, b));
        let off = (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f32::max);
        (1.5 - off / ALIKE).clamp(0.0, 1.0)
    }
}

/// How far a triangle may reach across one of its edges.
#[derive(Debug, Clone, Copy, Default)]
struct Side {
    /// Distance to the far side of the later triangle, or of what lies behind a sliver, at start and
    /// end; pixels.
    reach: [f32; 2],
    /// Triangles beyond the edge, around its start and its end.
    fans: [Fan; 2],
}

/// Moves each edge outward by its reach, at most by the distance.
fn moved(corners: &[Vec2; 3], sides: &[Side; 3], distance: f32) -> [Vec2; 3] {
    if sides.iter().all(|side| side.reach == [0.0; 2]) {
        return *corners;
    }
    let lines = [0, 1, 2].map(|e| (outward(corners, e), sides[e]));
    [0, 1, 2].map(|i| corners[i] + way(&lines[(i + 2) % 3], &lines[i], distance))
}

/// Displacement of a corner between the edge that ends there and the one that begins there, each
/// with its outward normal.
fn way(before: &(Vec2, Side), after: &(Vec2, Side), distance: f32) -> Vec2 {
    if distance <= 0.0 {
        return Vec2::ZERO;
    }
    let sides = [(before, 1), (after, 0)];
    let mut pull = Pull::default();
    for ((normal, side), end) in sides {
        let wanted = side.reach[end].min(distance);
        pull.towards(*normal, wanted, 1.0 / (wanted / distance + 1.0 / STIFFNESS));
    }
    pull.within(
        FURTHEST * distance,
        |way| {
            let excess = |((normal, side), end): (&(Vec2, Side), usize)| {
                let across = normal.dot(way);
                let beyond = if across > 0.0 {
                    side.fans[end].excess(way)
                } else {
                    0.0
                };
                beyond.max(across - side.reach[end].min(distance))
            };
            sides.into_iter().map(excess).fold(0.0, f32::max)
        },
        sides.into_iter().flat_map(|((normal, side), end)| {
            let edge = Wall {
                normal: *normal,
                reach: side.reach[end].min(distance),
            };
            std::iter::once(edge).chain(side.fans[end].walls())
        }),
    )
}

/// Damped least squares of a corner's displacement: weighted targets, each along a direction.
#[derive(Debug, Clone, Copy)]
struct Pull {
    sum: Vec2,
    /// The symmetric 2 x 2 matrix of the normal equations.
    xx: f32,
    xy: f32,
    yy: f32,
}

impl Default for Pull {
    fn default() -> Self {
        Self {
            sum: Vec2::ZERO,
            xx: DAMPING,
            xy: 0.0,
            yy: DAMPING,
        }
    }
}

impl Pull {
    fn towards(&mut self, normal: Vec2, wanted: f32, stiffness: f32) {
        self.sum += normal * (stiffness * wanted);
        self.xx += stiffness * normal.x * normal.x;
        self.xy += stiffness * normal.x * normal.y;
        self.yy += stiffness * normal.y * normal.y;
    }

    fn solved(&self) -> Vec2 {
        // Never 0: the diagonal is at least the damping.
        let determinant = self.xx * self.yy - self.xy * self.xy;
        let x = self.yy * self.sum.x - self.xy * self.sum.y;
        let y = self.xx * self.sum.y - self.xy * self.sum.x;
        Vec2::new(x, y) / determinant
    }

    /// The displacement of least error that lies beyond no wall, shortened to a length; `excess`
    /// is how far one lies beyond a wall.
    fn within(
        &self,
        furthest: f32,
        excess: impl Fn(Vec2) -> f32,
        walls: impl Iterator<Item = Wall>,
    ) -> Vec2 {
        let is_inside = |way: Vec2| excess(way) <= SLACK_PX;
        let free = self.solved().clamp_length_max(furthest);
        if is_inside(free) {
            return free;
        }
        let mut all = [Wall::default(); MAX_WALLS];
        let mut count = 0;
        for (slot, wall) in all.iter_mut().zip(walls) {
            *slot = wall;
            count += 1;
        }
        let mut best = (self.error(Vec2::ZERO), Vec2::ZERO);
        let mut offer = |way: Vec2| {
            let way = way.clamp_length_max(furthest);
            let error = self.error(way);
            if error < best.0 && way.is_finite() && is_inside(way) {
                best = (error, way);
            }
        };
        // The least error lies on a wall or where two meet.
        for (i, wall) in all[..count].iter().enumerate() {
            let (along, foot) = (wall.normal.perp(), wall.normal * wall.reach);
            let (slope, bend) = (self.slope(foot).dot(along), self.times(along).dot(along));
            offer(foot - along * (slope / bend));
            for other in &all[..i] {
                let across = wall.normal.perp_dot(other.normal);
                if across.abs() > 1e-3 {
                    let x = wall.reach * other.normal.y - other.reach * wall.normal.y;
                    let y = other.reach * wall.normal.x - wall.reach * other.normal.x;
                    offer(Vec2::new(x, y) / across);
                }
            }
        }
        best.1
    }

    /// The matrix times a vector.
    fn times(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    /// Half of the gradient of the error.
    fn slope(&self, way: Vec2) -> Vec2 {
        self.times(way) - self.sum
    }

    /// The error of a displacement, up to a constant.
    fn error(&self, way: Vec2) -> f32 {
        (self.times(way) - 2.0 * self.sum).dot(way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;
    use crate::planar::order::Epoch;
    use proptest::prelude::*;

    /// A square of two triangles that share a diagonal, alone or surrounded by eight others.
    fn square(is_alone: bool) -> PlanarClip {
        let place = |x: f32, y: f32| [x, y, 0.5];
        let (nw, sw, ne, se) = (
            place(10.0, 10.0),
            place(10.0, 30.0),
            place(30.0, 10.0),
            place(30.0, 30.0),
        );
        let mut all = vec![([nw, sw, ne], [9; 3]), ([ne, sw, se], [200; 3])];
        if !is_alone {
            let (n, s) = (place(20.0, -60.0), place(20.0, 90.0));
            let (w, e) = (place(-60.0, 20.0), place(90.0, 20.0));
            let sides = [[nw, ne, n], [sw, nw, w], [se, sw, s], [ne, se, e]];
            let between = [[nw, n, w], [sw, w, s], [se, s, e], [ne, e, n]];
            all.extend(sides.into_iter().chain(between).map(|t| (t, [50; 3])));
        }
        fixture::loose(&all, 1)
    }

    fn sealed(clip: &PlanarClip, rank: &[u32], distance_px: f32) -> Vec<[Vec2; 3]> {
        let drawn = Drawn::of(clip).unwrap();
        let mut order: Vec<u32> = (0..rank.len() as u32).collect();
        order.sort_by_key(|t| rank[*t as usize]);
        let frames = 0..clip.frames.len();
        let epochs = vec![Epoch { frames, order }];
        let options = UnderlapOptions { distance_px };
        seal(clip, &drawn, &Painting { epochs }, options)
            .corners
            .remove(0)
    }

    #[test]
    fn the_diagonal_moves_under_the_later_triangle_and_the_outline_stays() {
        let clip = square(true);
        let corners = sealed(&clip, &[0, 1], 0.8);
        assert_eq!(corners[1], clip.places(0, 1));
        let [nw, sw, ne] = corners[0];
        assert_eq!(nw, Vec2::new(10.0, 10.0));
        let across = |p: Vec2| (p - Vec2::new(10.0, 30.0)).dot(Vec2::ONE.normalize());
        // Beside the other triangle's silhouettes it falls short, beyond them it hardly shows, and
        // along its own it does not move.
        for (end, off, out) in [
            (sw, sw.x - 10.0, sw.y - 30.0),
            (ne, ne.y - 10.0, ne.x - 30.0),
        ] {
            assert!(
                (0.25..0.8).contains(&across(end)) && off.abs() < 0.03 && out < 0.45,
                "{end}"
            );
        }
        // With the opposite order the other triangle moves.
        let corners = sealed(&clip, &[1, 0], 0.8);
        assert_eq!(corners[0], clip.places(0, 0));
        assert!(across(corners[1][0]) < -0.25 && across(corners[1][1]) < -0.25);
    }

    #[test]
    fn amid_others_the_diagonal_moves_by_the_whole_distance() {
        let corners = sealed(&square(false), &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], 0.8);
        let across = |p: Vec2| (p - Vec2::new(10.0, 30.0)).dot(Vec2::ONE.normalize());
        for end in [corners[0][1], corners[0][2]] {
            // A pointed corner falls a little short, where the intersection of the lines would run
            // away.
            assert!((0.7..0.81).contains(&across(end)), "{end}");
        }
        assert!(corners[0][0].distance(Vec2::splat(9.2)) < 0.06);
    }

    #[test]
    fn a_corner_covers_an_earlier_triangle_only_if_it_looks_the_same() {
        // Around the middle: the triangle that moves, a narrow one across its edge, and a third.
        let place = |x: f32, y: f32| [x, y, 0.5];
        let (middle, low, right) = (place(20.0, 20.0), place(20.0, 38.0), place(38.0, 30.0));
        let (up, top) = (place(38.0, 22.0), place(20.0, 2.0));
        let out = |color: [u8; 3]| {
            let clip = fixture::loose(
                &[
                    ([middle, up, top], color),
                    ([middle, low, right], [100; 3]),
                    ([middle, right, up], [100; 3]),
                ],
                1,
            );
            // The third is painted first, the narrow one last.
            let [corner, _, _] = sealed(&clip, &[0, 1, 2], 0.8)[1];
            let along = Vec2::new(18.0, 2.0).normalize();
            -Vec2::new(along.y, -along.x).dot(corner - Vec2::splat(20.0))
        };
        let (same, other) = (out([100; 3]), out([0; 3]));
        assert!(
            -same > 0.7 && -other < 0.65 && -other > 0.5,
            "{same} {other}"
        );
    }

    #[test]
    fn an_edge_comes_to_rest_on_the_silhouette_as_its_neighbour_turns_away() {
        let mut clip = square(true);
        let mut last = f32::MAX;
        for height in [6.0, 0.9, 0.6, 0.3, 0.1, 0.001, -1.0] {
            // The far corner of the later triangle comes towards the diagonal.
            clip.frames[0].xy[5] = Vec2::splat(20.0 + height / 2f32.sqrt());
            let sealer = Sealer::new(&clip, UnderlapOptions::default());
            let [_, sw, ne] = sealer.frame(0, |t| t == 0, Some)[0];
            let out = ((sw + ne) / 2.0 - Vec2::splat(20.0)).length();
            assert!(out <= f32::max(height, 0.0) + 1e-4, "{out} at {height}");
            last = out;
        }
        assert_eq!(last, 0.0);
    }

    #[test]
    fn nothing_moves_without_distance_or_neighbours_or_a_number() {
        let cube = fixture::turning_cube(3);
        let rank: Vec<u32> = (0..12).collect();
        for distance in [0.0, -1.0, f32::NAN] {
            let corners = sealed(&cube, &rank, distance);
            assert!((0..12).all(|t| corners[t] == cube.places(0, t)));
        }
        assert!(
            sealed(&cube, &rank, f32::INFINITY)
                .iter()
                .flatten()
                .all(|c| c.is_finite())
        );
        let loose = [[3.0, 3.0, 0.5], [3.0, 30.0, 0.5], [30.0, 3.0, 0.5]];
        let loose = fixture::loose(&[(loose, [9; 3])], 1);
        assert_eq!(sealed(&loose, &[0], 1.0)[0], loose.places(0, 0));
    }

    proptest! {
        #[test]
        fn corners_stay_near_and_finite_whatever_the_shape(
            places in prop::collection::vec((0i8..40, 0i8..40), 8),
            distance in 0.1f32..3.0,
            turn in 0u32..12,
        ) {
            // Integers, so that triangles without area and coincident corners occur.
            let mut cube = fixture::turning_cube(1);
            for (to, (x, y)) in cube.frames[0].xy.iter_mut().zip(places) {
                *to = Vec2::new(f32::from(x), f32::from(y));
            }
            let options = UnderlapOptions { distance_px: distance };
            let sealed = Sealer::new(&cube, options).frame(0, |_| true, |t| Some((t + turn) % 12));
            for (t, corners) in sealed.iter().enumerate() {
                for (to, from) in corners.iter().zip(cube.places(0, t)) {
                    prop_assert!(to.distance(from) <= FURTHEST * distance + 1e-3);
                }
            }
        }
    }
}
