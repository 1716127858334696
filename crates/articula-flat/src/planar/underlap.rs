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
//! - where a corner cannot move, since it is almost a point or between edges that stay, the neighbour
//!   that is painted later reaches over the edge instead;
//! - a neighbour counts while it faces the viewer, even when something else hides it;
//! - corners are a damped least-squares solution of the moved edge lines; their intersection would
//!   run away and turn over where lines are nearly parallel.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::fan::{Fan, Wall};
use super::neighbours::{Neighbour, Neighbours, faces_viewer, outward};
use super::order::Painting;
use super::pull::Pull;
use glam::Vec2;

/// A triangle, and the corner at which its edge begins.
pub(crate) type OutlineEdge = (u32, u8);

/// Maximum displacement of a corner, in underlap distances.
const FURTHEST: f32 = 5.0;
/// Maximum underlap distance, pixels.
const MAX_DISTANCE: f32 = 64.0;
/// Stiffness of an edge line that stays, relative to one that moves by the whole distance. It never
/// moves outward; inward it opens a gap.
const STIFFNESS: f32 = 50.0;
/// Difference of colours, levels, up to half of which a triangle may be painted over one beside its
/// neighbour; from one and a half of it on it may not.
const ALIKE: f32 = 32.0;
/// Share of the distance up to which an edge covers a neighbour that is painted earlier and falls short.
const OVER: f32 = 0.75;

/// Options of sealing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UnderlapOptions {
    /// Distance by which an edge reaches under its neighbour, pixels; 0 moves nothing.
    pub distance_px: f32,
    /// Number of vertices before triangles were cut where others pass through them; those beyond are on cuts.
    pub uncut: u32,
}

impl Default for UnderlapOptions {
    fn default() -> Self {
        Self {
            distance_px: 0.8,
            uncut: u32::MAX,
        }
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
    uncut: u32,
}

impl<'a> Sealer<'a> {
    /// Finds the neighbours of all triangles.
    pub(crate) fn new(clip: &'a PlanarClip, options: UnderlapOptions) -> Self {
        Self {
            clip,
            neighbours: Neighbours::new(clip),
            // NaN becomes 0.
            distance: f32::max(options.distance_px, 0.0).min(MAX_DISTANCE),
            uncut: options.uncut,
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
        let all = 0..self.clip.triangles.len();
        let sides = |t: usize| {
            let own = is_drawn(t).then(|| rank(t as u32)).flatten()?;
            let is_later = |n: u32| rank(n).is_some_and(|r| r > own);
            let side = |e| self.side(frame, (t, e), &rank, &is_later);
            faces_viewer(&self.clip.places(frame, t)).then(|| [0, 1, 2].map(side))
        };
        let sides: Vec<Option<[Side; 3]>> = all.clone().map(sides).collect();
        let corners = |t: usize, sides: &Option<[Side; 3]>| {
            let places = self.clip.places(frame, t);
            let moved = |sides| moved(&places, sides, self.distance);
            sides.as_ref().map_or(places, moved)
        };
        let under: Vec<[Vec2; 3]> = all.clone().map(|t| corners(t, &sides[t])).collect();
        let covered = |t: usize| {
            let mut sides = sides[t]?;
            let own = rank(t as u32)?;
            let open: [bool; 3] = [0, 1, 2].map(|e| {
                let side = &mut sides[e];
                let over = (side.reach == [0.0; 2])
                    .then(|| self.over(frame, (t, e), own, &rank, &under))
                    .flatten();
                *side = over.unwrap_or(*side);
                over.is_some()
            });
            open.contains(&true).then_some(Some(sides))
        };
        all.map(|t| covered(t).map_or(under[t], |sides| corners(t, &sides)))
            .collect()
    }

    /// What an edge may cover: a neighbour that is painted earlier, as far as its own edge falls short
    /// of the distance; a corner between two edges that stay, or almost a point, cannot move.
    fn over(
        &self,
        frame: usize,
        (triangle, edge): (usize, usize),
        own: u32,
        rank: &impl Fn(u32) -> Option<u32>,
        under: &[[Vec2; 3]],
    ) -> Option<Side> {
        let ends = [edge, (edge + 1) % 3].map(|i| self.clip.triangles[triangle][i]);
        if ends.iter().all(|v| *v >= self.uncut) {
            // What passes between the two pieces would be covered.
            return None;
        }
        let earlier = |n: &&Neighbour| rank(n.triangle).is_some_and(|r| r < own);
        let height = |n: &Neighbour| n.height(self.clip, frame, (triangle, edge));
        let all = self.neighbours.across(triangle, edge).iter();
        let first = all
            .filter(earlier)
            .filter(|n| height(n) > 0.0)
            .max_by(|a, b| height(a).total_cmp(&height(b)))?;
        let (n, apex) = (first.triangle as usize, first.apex as usize);
        let places = self.clip.places(frame, n);
        let normal = outward(&places, (apex + 1) % 3);
        // The neighbour has the opposite direction: its edge ends where this one starts.
        let short = [(apex + 2) % 3, (apex + 1) % 3].map(|at| {
            let moved = normal.dot(under[n][at] - places[at]);
            (OVER * self.distance - moved).max(0.0)
        });
        if short == [0.0; 2] {
            return None;
        }
        let is_later = |n: u32| rank(n).is_some_and(|r| r > own);
        let fans = self.fans(frame, (triangle, edge), *first, rank, &is_later);
        let reach = self.reach(height(first), &fans);
        let own = self.clip.places(frame, triangle);
        let own_height = outward(&own, edge).dot(own[edge] - own[(edge + 2) % 3]);
        let corners = self.clip.triangles[triangle];
        // A sliver of another colour would become a line.
        let most = [0, 1].map(|end: usize| {
            let at = (apex + 2 - end) % 3;
            let beside = self.clip.triangles[n][at];
            let alike = self.alike(frame, corners[(edge + end) % 3], beside);
            own_height.max(alike * self.distance)
        });
        let reach = [0, 1].map(|end| reach[end].min(short[end]).min(most[end]));
        Some(Side { reach, fans })
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
        let fans = self.fans(frame, (triangle, edge), first, rank, is_later);
        let reach = self.reach(reach, &fans);
        Side { reach, fans }
    }

    /// How far an edge may move at its ends, given how far its neighbour reaches. Across a sliver, the
    /// reach behind it is added.
    fn reach(&self, height: f32, fans: &[Fan; 2]) -> [f32; 2] {
        fans.map(|fan| {
            if height < self.distance {
                height + fan.beyond_first()
            } else {
                height
            }
        })
    }

    /// Triangles beyond an edge, around its start and its end.
    fn fans(
        &self,
        frame: usize,
        (triangle, edge): (usize, usize),
        first: Neighbour,
        rank: &impl Fn(u32) -> Option<u32>,
        is_later: &impl Fn(u32) -> bool,
    ) -> [Fan; 2] {
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
        [fan(edge, true), fan((edge + 1) % 3, false)]
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
    let along = [
        Vec2::new(-before.0.y, before.0.x),
        Vec2::new(after.0.y, -after.0.x),
    ];
    let tip = Fan::tip([&before.1.fans[1], &after.1.fans[0]], along);
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
            let tip = tip.map_or(0.0, |tip| tip.excess(way));
            sides.into_iter().map(excess).fold(tip, f32::max)
        },
        sides
            .into_iter()
            .flat_map(|((normal, side), end)| {
                let edge = Wall {
                    normal: *normal,
                    reach: side.reach[end].min(distance),
                };
                std::iter::once(edge).chain(side.fans[end].walls())
            })
            .chain(tip),
    )
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
        let options = UnderlapOptions {
            distance_px,
            ..UnderlapOptions::default()
        };
        seal(clip, &drawn, &Painting { epochs }, options)
            .corners
            .remove(0)
    }

    #[test]
    fn the_diagonal_moves_under_the_later_triangle_and_the_outline_stays() {
        let clip = square(true);
        let corners = sealed(&clip, &[0, 1], 0.8);
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
        // The later one covers what is short of that, and no more.
        let over = moved_across(&clip, &corners, 1, 0);
        assert!(over.iter().all(|o| (0.1..0.4).contains(o)), "{over:?}");
        assert_eq!(corners[1][2], clip.places(0, 1)[2]);
        // With the opposite order the other triangle moves.
        let corners = sealed(&clip, &[1, 0], 0.8);
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

    /// How far the start and the end of an edge have moved across it.
    fn moved_across(clip: &PlanarClip, to: &[[Vec2; 3]], t: usize, edge: usize) -> [f32; 2] {
        let from = clip.places(0, t);
        let normal = outward(&from, edge);
        [edge, (edge + 1) % 3].map(|i| normal.dot(to[t][i] - from[i]))
    }

    #[test]
    fn a_later_triangle_covers_the_edge_of_one_whose_corners_are_too_sharp_to_move() {
        let place = |x: f32, y: f32| [x, y, 0.5];
        // A strip on an outline, less than a pixel wide, and what is above it.
        let strip = [place(14.0, 20.0), place(0.0, 21.0), place(78.0, 21.0)];
        let above = [place(46.0, -60.0), place(14.0, 20.0), place(78.0, 21.0)];
        let clip = fixture::loose(&[(strip, [100; 3]), (above, [110; 3])], 1);
        let corners = sealed(&clip, &[0, 1], 0.8);
        let [end, start] = moved_across(&clip, &corners, 0, 2);
        assert!(end < 0.1 && start < 0.4, "{end} {start}");
        let over = moved_across(&clip, &corners, 1, 1);
        assert!(start + over[0] > 0.5 && over[0] <= 0.8, "{over:?}");
        // One that has moved by itself is left alone.
        let wide = [place(14.0, 20.0), place(46.0, 60.0), place(78.0, 21.0)];
        let clip = fixture::loose(&[(wide, [100; 3]), (above, [110; 3])], 1);
        let [end, start] = moved_across(&clip, &sealed(&clip, &[0, 1], 0.8), 1, 1);
        assert!(end < 0.4 && start < 0.4, "{end} {start}");
    }

    #[test]
    fn an_edge_reaches_through_a_sliver_that_is_painted_before() {
        let place = |x: f32, y: f32| [x, y, 0.5];
        let (left, right) = (place(10.0, 30.0), place(60.0, 30.0));
        let (middle, up, low) = (place(30.0, 30.05), place(30.0, 5.0), place(30.0, 55.0));
        let all = [
            [left, right, up],
            [left, middle, right],
            [left, low, middle],
        ];
        let clip = fixture::loose(&all.map(|places| (places, [100; 3])), 1);
        let corners = sealed(&clip, &[1, 0, 2], 0.8);
        let out = moved_across(&clip, &corners, 0, 0);
        assert!(out[0] > 0.2, "{out:?}");
    }

    #[test]
    fn no_piece_of_a_cut_triangle_covers_another_one() {
        let place = |x: f32, y: f32| [x, y, 0.5];
        let strip = [place(14.0, 20.0), place(0.0, 21.0), place(78.0, 21.0)];
        let above = [place(46.0, -60.0), place(14.0, 20.0), place(78.0, 21.0)];
        let clip = fixture::loose(&[(strip, [100; 3]), (above, [110; 3])], 1);
        let covered = |uncut: u32| {
            let options = UnderlapOptions {
                uncut,
                ..UnderlapOptions::default()
            };
            let corners = Sealer::new(&clip, options).frame(0, |_| true, Some);
            moved_across(&clip, &corners, 1, 1)
        };
        assert!(covered(6).iter().all(|out| *out > 0.0));
        // All corners of the second are on cuts.
        assert_eq!(covered(3), [0.0, 0.0]);
    }

    #[test]
    fn a_tip_does_not_grow() {
        let place = |x: f32, y: f32| [x, y, 0.5];
        let (tip, a, b) = (place(60.0, 30.0), place(10.0, 28.0), place(10.0, 32.0));
        let (above, below) = (place(10.0, 24.0), place(10.0, 36.0));
        let all = [[tip, a, b], [tip, above, a], [tip, b, below]];
        let clip = fixture::loose(&all.map(|places| (places, [100; 3])), 1);
        let grown = sealed(&clip, &[0, 1, 2], 0.8)[0][0].x - 60.0;
        assert!((0.0..0.45).contains(&grown), "{grown}");
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
            let options = UnderlapOptions {
                distance_px: distance,
                ..UnderlapOptions::default()
            };
            let sealed = Sealer::new(&cube, options).frame(0, |_| true, |t| Some((t + turn) % 12));
            for (t, corners) in sealed.iter().enumerate() {
                for (to, from) in corners.iter().zip(cube.places(0, t)) {
                    prop_assert!(to.distance(from) <= FURTHEST * distance + 1e-3);
                }
            }
        }
    }
}
