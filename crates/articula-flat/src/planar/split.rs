//! Cuts intersecting triangles, so that a correct painting order exists.
//!
//! Source: `docs/methods/vector.md` 4, `--quality split`. If two triangles cover each other in both
//! directions in one frame, no order is correct. One of them is cut where both are equally near, in
//! the frame in which most samples are affected. Its neighbours are cut at the same points, so no
//! crack opens.
//!
//! Position, nearness and light of a new vertex are interpolated linearly along its edge in every
//! frame, so no pixel of the reference changes.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::error::PlanarError;
use super::order::{OrderOptions, Overlaps, Painted, Painting};
use articula_core::Progress;
use glam::Vec2;
use std::collections::BTreeMap;

/// Options of cutting intersecting triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplitOptions {
    /// Fraction of the character's pixels that may be wrong; cutting ends there.
    pub wrong_share: f64,
    /// Minimum cost of a pair that is cut, as a fraction of the character's pixels over the whole
    /// clip.
    pub pair_share: f64,
    /// Maximum number of rounds of cutting, each followed by a new order.
    pub max_rounds: usize,
    /// Options of the painting order of the pieces.
    pub order: OrderOptions,
}

impl Default for SplitOptions {
    fn default() -> Self {
        Self {
            wrong_share: 0.0045,
            pair_share: 1e-5,
            max_rounds: 6,
            order: OrderOptions::default(),
        }
    }
}

/// A clip with cut triangles, its visibility and painting order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Split {
    /// The clip; triangles that were not cut keep their relative order.
    pub clip: PlanarClip,
    /// Visibility of its triangles.
    pub drawn: Drawn,
    /// Painting order.
    pub painting: Painting,
    /// Fraction of the character's samples that are wrong, over the whole clip.
    pub wrong_share: f64,
    /// Number of triangles that were cut because they intersect another one.
    pub cuts: usize,
}

/// Cuts the pairs with the highest cost until few enough pixels are wrong; returns the clip
/// unchanged where cutting does not help. Each round is one step of the progress.
///
/// # Errors
/// Errors of the clip, as in [`Drawn::of`] and [`Overlaps::of`]; [`PlanarError::Cancelled`].
pub(crate) fn split(
    clip: &PlanarClip,
    options: &SplitOptions,
    progress: &mut Progress<'_>,
) -> Result<Split, PlanarError> {
    let (mut best, mut overlaps) = painted(clip.clone(), 0, options)?;
    for round in 0..options.max_rounds {
        progress.step((round + 1) as f32 / (options.max_rounds + 1) as f32)?;
        if best.wrong_share <= options.wrong_share {
            break;
        }
        let marks = marks(&best, &overlaps, options);
        if marks.cuts == 0 {
            break;
        }
        let next = marks.apply(&best.clip);
        if next.check().is_err() {
            break;
        }
        let (next, found) = painted(next, best.cuts + marks.cuts, options)?;
        if next.wrong_share >= best.wrong_share {
            break;
        }
        (best, overlaps) = (next, found);
    }
    Ok(best)
}

fn painted(
    clip: PlanarClip,
    cuts: usize,
    options: &SplitOptions,
) -> Result<(Split, Overlaps), PlanarError> {
    let painted = Painted::of(&clip, &options.order)?;
    let wrong_share = painted.wrong().share();
    let Painted {
        drawn,
        painting,
        overlaps,
    } = painted;
    let split = Split {
        clip,
        drawn,
        painting,
        wrong_share,
        cuts,
    };
    Ok((split, overlaps))
}

/// Two triangles that cover each other in both directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Pair {
    triangles: [u32; 2],
    /// Minimum number of wrong samples, over all frames.
    samples: u64,
    /// Frame with the greatest number of wrong samples, and that number.
    peak: (usize, u64),
}

/// Pairs of a clip, highest cost first.
fn pairs(overlaps: &Overlaps) -> Vec<Pair> {
    let mut known: BTreeMap<[u32; 2], Pair> = BTreeMap::new();
    for f in 0..overlaps.frames() {
        // Each pair with its samples in both directions.
        let mut over = Vec::new();
        for (set, n) in overlaps.counts(f) {
            let members = overlaps.members(*set as usize);
            let owner = members[0];
            for t in &members[1..] {
                let ways = if owner < *t { (*n, 0) } else { (0, *n) };
                over.push(([owner.min(*t), owner.max(*t)], ways));
            }
        }
        over.sort_unstable();
        for same in over.chunk_by(|p, q| p.0 == q.0) {
            let one_way: u64 = same.iter().map(|p| u64::from(p.1.0)).sum();
            let other_way: u64 = same.iter().map(|p| u64::from(p.1.1)).sum();
            let samples = one_way.min(other_way);
            if samples == 0 {
                continue;
            }
            let triangles = same[0].0;
            let pair = known.entry(triangles).or_insert(Pair {
                triangles,
                samples: 0,
                peak: (f, 0),
            });
            pair.samples += samples;
            if samples > pair.peak.1 {
                pair.peak = (f, samples);
            }
        }
    }
    let mut pairs: Vec<Pair> = known.into_values().collect();
    pairs.sort_by_key(|p| (std::cmp::Reverse(p.samples), p.triangles));
    pairs
}

/// Points on edges at which triangles are cut.
struct Marks {
    /// Position classes: vertices that coincide in every frame.
    classes: Vec<u32>,
    /// Cut edges by the classes of their ends, ascending, with the fraction from the first to the
    /// second.
    edges: BTreeMap<[u32; 2], f64>,
    cuts: usize,
}

/// Cuts closer to a corner than this fraction of an edge go through the corner.
const CORNER: f64 = 0.01;
/// Two cuts of an edge within this fraction of it share a point.
const SAME: f64 = 0.02;

/// Chooses the cuts of one round.
fn marks(split: &Split, overlaps: &Overlaps, options: &SplitOptions) -> Marks {
    let clip = &split.clip;
    let pairs = pairs(overlaps);
    let object = overlaps.object(&(0..overlaps.frames())) as f64;
    let mut at_stake = vec![0; clip.triangles.len()];
    for pair in &pairs {
        for t in pair.triangles {
            at_stake[t as usize] += pair.samples;
        }
    }
    let mut marks = Marks {
        classes: clip.position_classes(),
        edges: BTreeMap::new(),
        cuts: 0,
    };
    let mut left = split.wrong_share * object;
    for pair in pairs {
        let is_light = (pair.samples as f64) < options.pair_share * object;
        if is_light || left <= options.wrong_share * object {
            break;
        }
        // The triangle with the lower total cost is cut, exactly at the plane of the other one,
        // which often cuts its neighbours too; the other one if that is not possible.
        let [a, b] = pair.triangles;
        let is_first = at_stake[a as usize] < at_stake[b as usize];
        let (first, second) = if is_first { (a, b) } else { (b, a) };
        let frame = pair.peak.0;
        if marks.cut(clip, frame, first, second) || marks.cut(clip, frame, second, first) {
            left -= pair.samples as f64;
        }
    }
    marks
}

impl Marks {
    /// Marks where a triangle is as near as the plane of another one in a frame; returns whether
    /// that is compatible with the cuts so far.
    fn cut(&mut self, clip: &PlanarClip, frame: usize, triangle: u32, other: u32) -> bool {
        let corners = clip.triangles[triangle as usize];
        let Some(plane) = Plane::of(clip, frame, other) else {
            return false;
        };
        let frame = &clip.frames[frame];
        let ahead = corners.map(|v| {
            let v = v as usize;
            f64::from(frame.nearness[v]) - plane.at(frame.xy[v])
        });
        let mut points = Vec::new();
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (from, to) = (ahead[i], ahead[j]);
            if (from < 0.0) == (to < 0.0) {
                continue;
            }
            let way = from / (from - to);
            if !(CORNER..=1.0 - CORNER).contains(&way) {
                continue;
            }
            let Some((edge, way)) = self.edge(corners[i], corners[j], way) else {
                return false;
            };
            let held = self.edges.get(&edge);
            if held.is_some_and(|held| (held - way).abs() > SAME) {
                return false;
            }
            points.push((edge, way));
        }
        if points.is_empty() {
            return false;
        }
        let is_new = points
            .iter()
            .any(|(edge, _)| !self.edges.contains_key(edge));
        for (edge, way) in points {
            self.edges.entry(edge).or_insert(way);
        }
        self.cuts += usize::from(is_new);
        true
    }

    /// An edge by its classes, and a fraction along it in their direction; `None` without length.
    fn edge(&self, from: u32, to: u32, way: f64) -> Option<([u32; 2], f64)> {
        let (a, b) = (self.classes[from as usize], self.classes[to as usize]);
        match a.cmp(&b) {
            std::cmp::Ordering::Less => Some(([a, b], way)),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(([b, a], 1.0 - way)),
        }
    }

    /// Returns the clip with all marked edges cut.
    fn apply(&self, clip: &PlanarClip) -> PlanarClip {
        let mut out = PlanarClip {
            triangles: Vec::new(),
            surface: Vec::new(),
            part: Vec::new(),
            ..clip.clone()
        };
        if let Some(texture) = &mut out.texture {
            texture.shows.clear();
        }
        let mut made = BTreeMap::new();
        for (t, corners) in clip.triangles.iter().enumerate() {
            let mut point = |i: usize| {
                let (u, v) = (corners[i], corners[(i + 1) % 3]);
                let (edge, _) = self.edge(u, v, 0.0)?;
                let way = *self.edges.get(&edge)?;
                let is_along = self.classes[u as usize] == edge[0];
                let (from, to) = if is_along { (u, v) } else { (v, u) };
                let vertex = made.entry((from, to));
                Some(*vertex.or_insert_with(|| add_vertex(&mut out, from, to, way as f32)))
            };
            let points = [point(0), point(1), point(2)];
            for piece in pieces(*corners, points, &|u, v| length(&out, u, v)) {
                out.triangles.push(piece);
                out.surface.push(clip.surface[t]);
                out.part.push(clip.part[t]);
                if let (Some(to), Some(from)) = (&mut out.texture, &clip.texture) {
                    to.shows.push(from.shows[t]);
                }
            }
        }
        out
    }
}

/// Adds a vertex between two others.
fn add_vertex(clip: &mut PlanarClip, from: u32, to: u32, way: f32) -> u32 {
    let (u, v) = (from as usize, to as usize);
    let mix = |a: f32, b: f32| a + (b - a) * way;
    let (a, b) = (clip.albedo[u], clip.albedo[v]);
    clip.albedo.push([0, 1, 2].map(|k| mix(a[k], b[k])));
    if let Some(texture) = &mut clip.texture {
        texture.add_between(u, v, way);
    }
    for frame in &mut clip.frames {
        frame.xy.push(frame.xy[u].lerp(frame.xy[v], way));
        frame
            .nearness
            .push(mix(frame.nearness[u], frame.nearness[v]));
        frame.light.push(mix(frame.light[u], frame.light[v]));
    }
    clip.albedo.len() as u32 - 1
}

/// Sum of the squared distances of two vertices over all frames.
fn length(clip: &PlanarClip, u: u32, v: u32) -> f32 {
    let apart = |f: &super::clip::PlanarFrame| f.xy[u as usize].distance_squared(f.xy[v as usize]);
    clip.frames.iter().map(apart).sum()
}

/// Pieces of a triangle whose edges (from each corner to the next) carry these points.
fn pieces(
    [a, b, c]: [u32; 3],
    points: [Option<u32>; 3],
    length: &dyn Fn(u32, u32) -> f32,
) -> Vec<[u32; 3]> {
    match points {
        [None, None, None] => vec![[a, b, c]],
        [Some(p), None, None] => vec![[a, p, c], [p, b, c]],
        [Some(p), Some(q), None] => {
            let mut pieces = vec![[p, b, q]];
            // The rest is a quadrilateral, cut along its shorter diagonal.
            if length(a, q) <= length(p, c) {
                pieces.extend([[a, p, q], [a, q, c]]);
            } else {
                pieces.extend([[a, p, c], [p, q, c]]);
            }
            pieces
        }
        [Some(p), Some(q), Some(r)] => vec![[a, p, r], [p, b, q], [q, c, r], [p, q, r]],
        // One of the cases above, with the corners rotated.
        [p, q, r] => pieces([b, c, a], [q, r, p], length),
    }
}

/// Plane of a triangle's nearness over the picture.
struct Plane {
    origin: Vec2,
    nearness: f64,
    slope: [f64; 2],
}

impl Plane {
    /// `None` if the triangle is seen edge-on.
    fn of(clip: &PlanarClip, frame: usize, triangle: u32) -> Option<Self> {
        let corners = clip.triangles[triangle as usize];
        let frame = &clip.frames[frame];
        let [a, b, c] = corners.map(|v| frame.xy[v as usize]);
        let [na, nb, nc] = corners.map(|v| f64::from(frame.nearness[v as usize]));
        let (ab, ac) = ((b - a).as_dvec2(), (c - a).as_dvec2());
        let area = ab.perp_dot(ac);
        let slope = [
            ((nb - na) * ac.y - (nc - na) * ab.y) / area,
            ((nc - na) * ab.x - (nb - na) * ac.x) / area,
        ];
        slope.iter().all(|s| s.is_finite()).then_some(Self {
            origin: a,
            nearness: na,
            slope,
        })
    }

    fn at(&self, xy: Vec2) -> f64 {
        let from = (xy - self.origin).as_dvec2();
        self.nearness + self.slope[0] * from.x + self.slope[1] * from.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item_buffer::{ItemBuffer, Supersampling};
    use crate::planar::clip::fixture;
    use crate::planar::drawn::draw_frame;
    use crate::planar::reference::reference;
    use proptest::prelude::*;

    /// Covers all of a picture of 40 x 40 pixels, its nearness rising to the right.
    fn wall(nearness: f32, slope: f32, color: u8) -> ([[f32; 3]; 3], [u8; 3]) {
        let far = nearness + 80.0 * slope;
        let corners = [
            [0.0, 0.0, nearness],
            [0.0, 80.0, nearness],
            [80.0, 0.0, far],
        ];
        (corners, [color; 3])
    }

    #[test]
    fn two_that_cross_are_right_after_one_cut() {
        // Equal at x = 24: 40 % are wrong before.
        let clip = fixture::loose(&[wall(0.5, 0.0, 50), wall(0.2, 1.0 / 80.0, 250)], 3);
        let none = SplitOptions {
            wrong_share: 0.4,
            ..SplitOptions::default()
        };
        let before = split(&clip, &none, &mut Progress::none()).unwrap();
        assert_eq!((before.wrong_share, before.cuts), (0.4, 0));
        assert_eq!(before.clip, clip);
        let after = split(&clip, &SplitOptions::default(), &mut Progress::none()).unwrap();
        assert_eq!((after.wrong_share, after.cuts), (0.0, 1));
        assert_eq!(after.clip.triangles.len(), 4);
        assert!(
            after.clip.frames[2].xy[6..]
                .iter()
                .all(|p| (p.x - 24.0).abs() < 1e-4)
        );
        let picture = |clip| reference(clip, 1, Supersampling::Two, [0; 4]).unwrap();
        assert_eq!(picture(&after.clip), picture(&clip));
    }

    #[test]
    fn neighbours_are_cut_at_the_same_points() {
        // A square of two triangles that a wall intersects at x = 24; either the wall is cut there,
        // or the square is, with its common edge at a common point.
        let [a, b, c, d] = [
            [4.0, 4.0, 0.3],
            [4.0, 36.0, 0.3],
            [36.0, 36.0, 0.7],
            [36.0, 4.0, 0.7],
        ];
        let clip = fixture::loose(
            &[
                ([a, b, c], [9; 3]),
                ([a, c, d], [9; 3]),
                wall(0.55, 0.0, 200),
                wall(0.1, 0.0, 100),
            ],
            1,
        );
        let marks = {
            let mut marks = Marks {
                classes: clip.position_classes(),
                edges: BTreeMap::new(),
                cuts: 0,
            };
            assert!(marks.cut(&clip, 0, 0, 2));
            assert_eq!(marks.edges.len(), 2);
            assert!(marks.cut(&clip, 0, 1, 2));
            assert_eq!((marks.edges.len(), marks.cuts), (3, 2));
            // The square is not cut where its plane never has the same nearness.
            assert!(!marks.cut(&clip, 0, 0, 3));
            marks
        };
        let cut = marks.apply(&clip);
        cut.check().unwrap();
        assert_eq!(cut.triangles.len(), 3 + 3 + 2);
        let on_line = |v: &&u32| (cut.frames[0].xy[**v as usize].x - 24.0).abs() < 1e-3;
        // Each half has one piece with one corner and two pieces with two corners on the line, or
        // vice versa; every triangle lies on one side of it.
        for triangle in &cut.triangles[..6] {
            let xs = triangle.map(|v| cut.frames[0].xy[v as usize].x - 24.0);
            let (low, high) = (xs.iter().any(|x| *x < -1e-3), xs.iter().any(|x| *x > 1e-3));
            assert!(low != high, "{xs:?}");
            assert!(triangle.iter().filter(on_line).count() >= 1);
        }
        let drawn = Drawn::of(&cut).unwrap();
        let overlaps = Overlaps::of(&cut, &drawn).unwrap();
        let painting = Painting::single(&cut, &drawn).unwrap();
        assert_eq!(overlaps.wrong(&painting).percent_mean(), 0.0);
    }

    #[test]
    fn a_new_vertex_lies_between_by_hand() {
        let clip = fixture::turning_cube(3);
        let mut cut = clip.clone();
        cut.albedo[1] = [20.0, 0.0, 10.0];
        let v = add_vertex(&mut cut, 0, 1, 0.25) as usize;
        assert_eq!(v, 8);
        assert_eq!(cut.albedo[v], [95.0, 150.0, 70.0]);
        for (frame, was) in cut.frames.iter().zip(&clip.frames) {
            let expected = was.xy[0] * 0.75 + was.xy[1] * 0.25;
            assert!((frame.xy[v] - expected).length() < 1e-4);
            let light = was.light[0] * 0.75 + was.light[1] * 0.25;
            assert!((frame.light[v] - light).abs() < 1e-6);
        }
    }

    #[test]
    fn pieces_fill_the_triangle_and_keep_its_side() {
        // Corners 0, 1, 2 and the midpoints of the edges from each: 3, 4, 5.
        let place = [[0, 0], [0, 8], [8, 0], [0, 4], [4, 4], [4, 0]];
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| place[v as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        for bits in 0..8u32 {
            let points = [0, 1, 2].map(|i| (bits >> i & 1 == 1).then_some(3 + i));
            let pieces = pieces([0, 1, 2], points, &|u, v| (u + v) as f32);
            assert_eq!(pieces.len() as u32, 1 + bits.count_ones());
            assert!(pieces.iter().all(|t| area(t) < 0));
            assert_eq!(pieces.iter().map(area).sum::<i32>(), -64);
            let used = |v: &u32| pieces.iter().flatten().any(|u| u == v);
            assert!(points.iter().flatten().all(used));
        }
    }

    #[test]
    fn what_is_painted_right_is_left_alone() {
        let cube = fixture::turning_cube(12);
        let split = split(&cube, &SplitOptions::default(), &mut Progress::none()).unwrap();
        assert_eq!((split.clip, split.cuts), (cube, 0));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// The order does not get worse, and the visible nearness does not change.
        #[test]
        fn cutting_improves_and_changes_no_picture(
            corners in prop::collection::vec((0.0f32..40.0, 0.0f32..40.0, 0.1f32..0.9), 6..24),
        ) {
            let triangles: Vec<_> = corners
                .chunks_exact(3)
                .map(|c| ([0, 1, 2].map(|i| [c[i].0, c[i].1, c[i].2]), [9; 3]))
                .collect();
            let clip = fixture::loose(&triangles, 2);
            if Drawn::of(&clip).is_ok() {
                let options = SplitOptions { wrong_share: 0.0, ..SplitOptions::default() };
                let split = split(&clip, &options, &mut Progress::none()).unwrap();
                let before = Painted::of(&clip, &options.order).unwrap();
                prop_assert!(split.wrong_share <= before.wrong().share());
                let buffer = |clip: &PlanarClip| {
                    let mut buffer = ItemBuffer::new(40, 40, Supersampling::Two).unwrap();
                    draw_frame(clip, 1, &mut buffer);
                    buffer
                };
                let (was, is) = (buffer(&clip), buffer(&split.clip));
                let all = (0..80).flat_map(|y| (0..80).map(move |x| (x, y)));
                let differs = |at: &(u32, u32)| {
                    let (was, is) = (was.nearness(at.0, at.1), is.nearness(at.0, at.1));
                    // Steep slivers change a lot within one step of the snapping grid.
                    was != is && (was - is).abs() > 0.02
                };
                let count = all.filter(differs).count();
                prop_assert!(count <= 12, "{count} samples differ after {} cuts", split.cuts);
            }
        }
    }
}
