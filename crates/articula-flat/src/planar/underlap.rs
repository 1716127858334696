//! Sealed edges: triangles reach a little under those neighbours that are painted later, so that no
//! background shows through anti-aliased edges.
//!
//! Source: `docs/methods/vector.md` 5. Silhouettes stay where they are, and no bytes are added.
//! Corners move steadily between frames, since every jump would cost a key frame:
//! - an edge moves outward no further than its neighbour reaches, so it comes to rest on the
//!   silhouette while the neighbour turns away; an end that would stick out beside the neighbour is
//!   a compromise between both;
//! - a neighbour counts while it faces the viewer, even when something else hides it;
//! - corners are a damped least-squares solution of the moved edge lines; their intersection would
//!   run away and turn over where lines are nearly parallel.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::order::Painting;
use glam::Vec2;

/// A triangle, and the corner at which its edge begins.
pub(crate) type OutlineEdge = (u32, u8);

/// Maximum displacement of a corner, in underlap distances.
const FURTHEST: f32 = 2.5;
/// Maximum underlap distance, pixels.
const MAX_DISTANCE: f32 = 64.0;
/// Weight that keeps a corner at its position, relative to the two edge lines.
const DAMPING: f32 = 0.02;
/// Stiffness of an edge line that stays, relative to one that moves by the whole distance.
const STIFFNESS: f32 = 50.0;
/// Stiffness of the silhouette beside the end of an edge: sticking out shows as a dot, falling
/// short opens a gap.
const WALL: f32 = 0.5;
/// Edges with more triangles than this on the other side are not sealed.
const MAX_NEIGHBOURS: usize = 8;

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
    pub(crate) neighbours: Neighbours,
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
        let mut best = Side::default();
        for n in self.neighbours.across(triangle, edge) {
            let reach = self.height(frame, (triangle, edge), *n);
            if reach <= best.reach || !is_later(n.triangle) {
                continue;
            }
            // The neighbour has the opposite direction: its edge to the apex begins at this edge's
            // start.
            let (other, apex) = (n.triangle as usize, n.apex as usize);
            let places = self.clip.places(frame, other);
            let walls = [(apex + 2) % 3, apex].map(|e| {
                let beyond = self.neighbours.across(other, e).iter();
                Wall {
                    normal: outward(&places, e),
                    reach: beyond
                        .filter(|n| rank(n.triangle).is_some())
                        .map(|n| self.height(frame, (other, e), *n))
                        .fold(0.0, f32::max),
                }
            });
            // Across a sliver, the reach behind it is added.
            let more = walls[0].reach.min(walls[1].reach);
            let reach = if reach < self.distance {
                reach + more
            } else {
                reach
            };
            best = Side { reach, walls };
        }
        best
    }

    /// How far a neighbour reaches beyond an edge, pixels; 0 if it does not face the viewer.
    fn height(&self, frame: usize, (triangle, edge): (usize, usize), across: Neighbour) -> f32 {
        let places = self.clip.places(frame, across.triangle as usize);
        if !faces_viewer(&places) {
            return 0.0;
        }
        let corners = self.clip.places(frame, triangle);
        let apex = places[across.apex as usize];
        outward(&corners, edge).dot(apex - corners[edge]).max(0.0)
    }
}

/// How far a triangle may reach across one of its edges.
#[derive(Debug, Clone, Copy, Default)]
struct Side {
    /// Distance to the far side of the later triangle, or of what lies behind a sliver; pixels.
    reach: f32,
    /// The neighbour's edges that begin at the start and the end of this one.
    walls: [Wall; 2],
}

/// A line that a corner may cross by `reach`: 0 at a silhouette.
#[derive(Debug, Clone, Copy, Default)]
struct Wall {
    normal: Vec2,
    reach: f32,
}

/// A triangle across an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Neighbour {
    /// The triangle.
    pub(crate) triangle: u32,
    /// Index of the corner that is not on the edge.
    pub(crate) apex: u32,
}

/// Triangles across each edge of a triangle; edge `e` runs from corner `e` to the next. Vertices
/// are joined by position class, and the two triangles must have the same winding.
#[derive(Debug, Clone)]
pub(crate) struct Neighbours {
    /// Position class of each vertex.
    pub(crate) class: Vec<u32>,
    /// Index of the first entry of each edge `3 t + e`, and the end.
    first: Vec<u32>,
    entries: Vec<Neighbour>,
}

impl Neighbours {
    pub(crate) fn new(clip: &PlanarClip) -> Self {
        let class = clip.position_classes();
        let ends = |t: usize, e: usize| {
            let corners = clip.triangles[t];
            (
                class[corners[e] as usize],
                class[corners[(e + 1) % 3] as usize],
            )
        };
        let all = || (0..clip.triangles.len()).flat_map(|t| (0..3).map(move |e| (t, e)));
        let mut edges: Vec<((u32, u32), Neighbour)> = all()
            .map(|(t, e)| {
                let triangle = t as u32;
                let apex = (e as u32 + 2) % 3;
                (ends(t, e), Neighbour { triangle, apex })
            })
            .collect();
        edges.sort_by_key(|(ends, n)| (*ends, n.triangle));
        let (mut first, mut entries) = (vec![0], Vec::new());
        for (t, e) in all() {
            let (a, b) = ends(t, e);
            let from = edges.partition_point(|(ends, _)| *ends < (b, a));
            let to = edges.partition_point(|(ends, _)| *ends <= (b, a));
            if a != b && to - from <= MAX_NEIGHBOURS {
                entries.extend(edges[from..to].iter().map(|(_, n)| *n));
            }
            first.push(entries.len() as u32);
        }
        Self {
            class,
            first,
            entries,
        }
    }

    pub(crate) fn across(&self, triangle: usize, edge: usize) -> &[Neighbour] {
        let i = 3 * triangle + edge;
        &self.entries[self.first[i] as usize..self.first[i + 1] as usize]
    }
}

/// Whether corners run counter-clockwise to the viewer (y points down).
pub(crate) fn faces_viewer([a, b, c]: &[Vec2; 3]) -> bool {
    (*b - *a).perp_dot(*c - *a) < 0.0
}

/// Outward unit normal of an edge; zero if the edge has no length.
fn outward(corners: &[Vec2; 3], edge: usize) -> Vec2 {
    let along = corners[(edge + 1) % 3] - corners[edge];
    Vec2::new(-along.y, along.x).normalize_or_zero()
}

/// Moves each edge outward by its reach, at most by the distance.
fn moved(corners: &[Vec2; 3], sides: &[Side; 3], distance: f32) -> [Vec2; 3] {
    if sides.iter().all(|side| side.reach <= 0.0) {
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
    let mut pull = Pull::default();
    for (normal, side) in [before, after] {
        let wanted = side.reach.min(distance);
        pull.towards(*normal, wanted, 1.0 / (wanted / distance + 1.0 / STIFFNESS));
    }
    for wall in [before.1.walls[1], after.1.walls[0]] {
        if wall.normal.dot(pull.solved()) > wall.reach {
            pull.towards(wall.normal, wall.reach, WALL);
        }
    }
    pull.solved().clamp_length_max(FURTHEST * distance)
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
        // Beside the other triangle's silhouettes it falls short, along its own it does not move.
        for (end, off) in [(sw, sw.x - 10.0), (ne, ne.y - 10.0)] {
            assert!(
                (0.3..0.8).contains(&across(end)) && off.abs() < 0.03,
                "{end}"
            );
        }
        // With the opposite order the other triangle moves.
        let corners = sealed(&clip, &[1, 0], 0.8);
        assert_eq!(corners[0], clip.places(0, 0));
        assert!(across(corners[1][0]) < -0.3 && across(corners[1][1]) < -0.3);
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
                    prop_assert!(to.distance(from) <= 2.5 * distance + 1e-3);
                }
            }
        }
    }
}
