//! Merging: regions of triangles with similar colours, each painted as one shape.
//!
//! Source: `docs/methods/vector.md` 6. Regions grow across common edges, the most similar colours
//! first. A region is painted at one position of the order, so a triangle may join only if that
//! moves it past nothing that it ever overlaps. Only triangles that are drawn in the same frames
//! join, so the points of an outline never change.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::error::PlanarError;
use super::neighbours::{Neighbours, faces_viewer};
use super::order::{Layer, Overlaps};
use super::shading::{drawn_frames, flat_color};
use super::underlap::{OutlineEdge, Sealer, UnderlapOptions};
use glam::Vec2;
use std::collections::BTreeMap;
use std::ops::Range;

/// Triangles that are painted as one shape.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Region {
    /// The triangles, ascending.
    pub triangles: Vec<u32>,
    /// Colour: the mean of the triangles' colours, weighted by area.
    pub color: [u8; 3],
    /// Spans of frames in which the region is drawn, ascending and disjoint.
    pub frames: Vec<Range<usize>>,
    /// Closed outlines, each a list of edges; nonzero fill rule.
    pub outlines: Vec<Vec<OutlineEdge>>,
}

impl Region {
    /// The points of all outlines in a frame, one outline after the other, without underlap.
    pub(crate) fn points(&self, clip: &PlanarClip, frame: usize) -> Vec<Vec2> {
        let xy = &clip.frames[frame].xy;
        let start = |(t, e): &(u32, u8)| clip.triangles[*t as usize][usize::from(*e)];
        let edges = self.outlines.iter().flatten();
        edges.map(|edge| xy[start(edge) as usize]).collect()
    }

    /// Index of the first point of each outline after the first.
    pub(crate) fn further_outlines(&self) -> Vec<u32> {
        let ends = self.outlines.iter().scan(0, |end, outline| {
            *end += outline.len() as u32;
            Some(*end)
        });
        ends.take(self.outlines.len().saturating_sub(1)).collect()
    }
}

/// Merges layers into regions, back to front. Colours of a region differ by at most
/// `merge_tol_levels` in any channel.
///
/// O(edges x overlaps) per round; few rounds.
///
/// # Errors
/// Errors of the clip, or [`PlanarError::Mismatch`] if the arguments belong to different clips.
pub(super) fn merge(
    clip: &PlanarClip,
    drawn: &Drawn,
    layers: &[Layer],
    merge_tol_levels: f32,
) -> Result<Vec<Region>, PlanarError> {
    let overlaps = Overlaps::of(clip, drawn)?;
    let beyond = |l: &Layer| {
        let last = l.frames.last().map_or(0, |span| span.end);
        l.triangle as usize >= clip.triangles.len() || last > clip.frames.len()
    };
    if layers.iter().any(beyond) {
        let (at, what) = (
            "layers",
            "a triangle or frame is outside the clip".to_owned(),
        );
        return Err(PlanarError::Mismatch { at, what });
    }
    let neighbours = Neighbours::new(clip);
    let mut growing = Growing::new(clip, drawn, layers, &overlaps);
    let candidates = candidates(clip, layers, &neighbours, &growing);
    // A join may make another one possible.
    while candidates
        .iter()
        .map(|(a, b)| growing.join(*a, *b, merge_tol_levels))
        .fold(false, |any, joined| any | joined)
    {}
    Ok(growing.finish(clip, layers, &neighbours))
}

/// Points of each region in each frame, `[region][frame][point]`, with edges sealed under regions
/// that are painted later. Where a region is not drawn they are those of the clip.
pub(super) fn seal_regions(
    clip: &PlanarClip,
    regions: &[Region],
    options: UnderlapOptions,
) -> Vec<Vec<Vec<Vec2>>> {
    let sealer = Sealer::new(clip, options);
    let mut sealed = vec![Vec::with_capacity(clip.frames.len()); regions.len()];
    let mut rank = vec![None; clip.triangles.len()];
    for f in 0..clip.frames.len() {
        rank.fill(None);
        for (r, region) in (0..).zip(regions) {
            if region.frames.iter().any(|span| span.contains(&f)) {
                for t in &region.triangles {
                    rank[*t as usize] = Some(r);
                }
            }
        }
        for (region, points) in regions.iter().zip(&mut sealed) {
            let is_shown = region.frames.iter().any(|span| span.contains(&f));
            let outlines = region.outlines.iter();
            points.push(if is_shown {
                let of = |edges: &Vec<_>| sealer.outline(f, edges, |t| rank[t as usize]);
                outlines.flat_map(of).collect()
            } else {
                region.points(clip, f)
            });
        }
    }
    sealed
}

/// A region during growth.
#[derive(Debug, Clone)]
struct Grown {
    /// Its layers; empty once it has joined another region.
    members: Vec<u32>,
    /// Its position in the painting order: the layer at which all of it is painted.
    slot: u32,
    low: [u8; 3],
    high: [u8; 3],
    /// Layers that some member overlaps.
    touched: Vec<u32>,
}

struct Growing {
    /// Regions, indexed by their first layer.
    regions: Vec<Grown>,
    /// Region of each layer.
    region_of: Vec<u32>,
    colors: Vec<[u8; 3]>,
}

impl Growing {
    fn new(clip: &PlanarClip, drawn: &Drawn, layers: &[Layer], overlaps: &Overlaps) -> Self {
        let mut copies: Vec<Vec<u32>> = vec![Vec::new(); clip.triangles.len()];
        for (l, layer) in (0..).zip(layers) {
            copies[layer.triangle as usize].push(l);
        }
        let mut touching: Vec<Vec<u32>> = vec![Vec::new(); clip.triangles.len()];
        for set in 0..overlaps.sets() {
            let members = overlaps.members(set);
            for a in members {
                touching[*a as usize].extend(members.iter().filter(|b| *b != a));
            }
        }
        for list in &mut touching {
            list.sort_unstable();
            list.dedup();
        }
        let color = |l: &Layer| {
            let t = l.triangle as usize;
            flat_color(clip, t, drawn_frames(drawn, t))
        };
        let colors: Vec<[u8; 3]> = layers.iter().map(color).collect();
        let region = |l: usize| Grown {
            members: vec![l as u32],
            slot: l as u32,
            low: colors[l],
            high: colors[l],
            touched: touching[layers[l].triangle as usize]
                .iter()
                .flat_map(|t| copies[*t as usize].iter().copied())
                .collect(),
        };
        Self {
            regions: (0..layers.len()).map(region).collect(),
            region_of: (0..layers.len() as u32).collect(),
            colors,
        }
    }

    /// Joins the regions of two layers if colours and order allow it; returns whether it did.
    fn join(&mut self, a: u32, b: u32, tol: f32) -> bool {
        let (x, y) = (self.region_of[a as usize], self.region_of[b as usize]);
        if x == y {
            return false;
        }
        let (p, q) = (&self.regions[x as usize], &self.regions[y as usize]);
        let low: [u8; 3] = std::array::from_fn(|k| p.low[k].min(q.low[k]));
        let high: [u8; 3] = std::array::from_fn(|k| p.high[k].max(q.high[k]));
        if (0..3).any(|k| f32::from(high[k] - low[k]) > tol) {
            return false;
        }
        let slot = if self.may_move(x, y) {
            q.slot
        } else if self.may_move(y, x) {
            p.slot
        } else {
            return false;
        };
        let (into, from) = if p.members.len() >= q.members.len() {
            (x, y)
        } else {
            (y, x)
        };
        let taken = &mut self.regions[from as usize];
        let members = std::mem::take(&mut taken.members);
        let touched = std::mem::take(&mut taken.touched);
        for l in &members {
            self.region_of[*l as usize] = into;
        }
        let region = &mut self.regions[into as usize];
        region.members.extend(members);
        region.touched.extend(touched);
        (region.slot, region.low, region.high) = (slot, low, high);
        true
    }

    /// Whether a region may be painted at the position of another one: it overlaps nothing that is
    /// painted between.
    fn may_move(&self, region: u32, to: u32) -> bool {
        let (moving, goal) = (
            &self.regions[region as usize],
            self.regions[to as usize].slot,
        );
        let between = moving.slot.min(goal)..moving.slot.max(goal);
        moving.touched.iter().all(|l| {
            let other = self.region_of[*l as usize];
            let slot = self.regions[other as usize].slot;
            other == region || other == to || !between.contains(&slot)
        })
    }

    fn finish(self, clip: &PlanarClip, layers: &[Layer], neighbours: &Neighbours) -> Vec<Region> {
        let mut grown: Vec<&Grown> = self
            .regions
            .iter()
            .filter(|r| !r.members.is_empty())
            .collect();
        grown.sort_by_key(|r| r.slot);
        let region = |grown: &Grown| {
            let of = |l: &u32| layers[*l as usize].triangle;
            let mut triangles: Vec<u32> = grown.members.iter().map(of).collect();
            triangles.sort_unstable();
            triangles.dedup();
            Region {
                color: self.mean_color(clip, layers, grown),
                frames: layers[grown.members[0] as usize].frames.clone(),
                outlines: outlines(clip, neighbours, &triangles),
                triangles,
            }
        };
        grown.into_iter().map(region).collect()
    }

    fn mean_color(&self, clip: &PlanarClip, layers: &[Layer], grown: &Grown) -> [u8; 3] {
        let (mut sum, mut weights) = ([0.0f64; 3], 0.0);
        for l in &grown.members {
            let layer = &layers[*l as usize];
            let area = |f: usize| {
                let [a, b, c] = clip.places(f, layer.triangle as usize);
                f64::from((b - a).perp_dot(c - a).abs())
            };
            let weight = layer
                .frames
                .iter()
                .cloned()
                .flatten()
                .map(area)
                .sum::<f64>()
                + 1e-3;
            for (total, level) in sum.iter_mut().zip(self.colors[*l as usize]) {
                *total += weight * f64::from(level);
            }
            weights += weight;
        }
        sum.map(|total| (total / weights).round() as u8)
    }
}

/// Pairs of layers that may join: with a common edge, drawn in the same frames, never showing a
/// back face; the most similar colours first.
fn candidates(
    clip: &PlanarClip,
    layers: &[Layer],
    neighbours: &Neighbours,
    growing: &Growing,
) -> Vec<(u32, u32)> {
    let always_faces = |l: &Layer| {
        let mut frames = l.frames.iter().cloned().flatten();
        frames.all(|f| faces_viewer(&clip.places(f, l.triangle as usize)))
    };
    let mut by_triangle: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (l, layer) in (0..).zip(layers) {
        if always_faces(layer) {
            by_triangle.entry(layer.triangle).or_default().push(l);
        }
    }
    let copies = |t: u32| by_triangle.get(&t).map_or(&[][..], Vec::as_slice);
    let mut pairs = Vec::new();
    for a in by_triangle.values().flatten() {
        let layer = &layers[*a as usize];
        for e in 0..3 {
            for n in neighbours.across(layer.triangle as usize, e) {
                let same = |b: &&u32| *a < **b && layers[**b as usize].frames == layer.frames;
                let colors = |l: u32| growing.colors[l as usize];
                for b in copies(n.triangle).iter().filter(same) {
                    let (p, q) = (colors(*a), colors(*b));
                    let apart = (0..3).map(|k| p[k].abs_diff(q[k])).max();
                    pairs.push((apart, *a, *b));
                }
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs.into_iter().map(|(_, a, b)| (a, b)).collect()
}

/// Edges around a set of triangles, as closed outlines.
fn outlines(
    clip: &PlanarClip,
    neighbours: &Neighbours,
    triangles: &[u32],
) -> Vec<Vec<OutlineEdge>> {
    let ends = |t: u32, e: u8| {
        let corners = clip.triangles[t as usize];
        let class = |i: u8| neighbours.class[corners[usize::from(i % 3)] as usize];
        (class(e), class(e + 1))
    };
    // Edges that remain after every edge is cancelled against one in the opposite direction.
    let mut left: BTreeMap<(u32, u32), Vec<OutlineEdge>> = BTreeMap::new();
    for t in triangles {
        for e in 0..3 {
            let (from, to) = ends(*t, e);
            let against = left.get_mut(&(to, from)).and_then(Vec::pop);
            if from != to && against.is_none() {
                left.entry((from, to)).or_default().push((*t, e));
            }
        }
    }
    let mut outgoing: BTreeMap<u32, Vec<(u32, OutlineEdge)>> = BTreeMap::new();
    for ((from, to), edges) in left {
        for edge in edges {
            outgoing.entry(from).or_default().push((to, edge));
        }
    }
    let mut found = Vec::new();
    while let Some((first, _)) = outgoing.first_key_value() {
        let mut at = *first;
        let mut outline = Vec::new();
        // As many edges end at a vertex as begin there, so this returns to its start.
        while let Some(edges) = outgoing.get_mut(&at) {
            let Some((to, edge)) = edges.pop() else { break };
            if edges.is_empty() {
                outgoing.remove(&at);
            }
            outline.push(edge);
            at = to;
        }
        found.push(outline);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;
    use crate::planar::order::{OrderOptions, Painting};

    fn layers_of(clip: &PlanarClip, drawn: &Drawn) -> Vec<Layer> {
        let painting = Painting::constraints(clip, drawn, &OrderOptions::default()).unwrap();
        painting.layers(drawn)
    }

    /// A grid of 4 x 4 squares of two triangles each; colours by column.
    fn field(colors: [u8; 4]) -> PlanarClip {
        let mut all = Vec::new();
        for y in 0..4u8 {
            for x in 0..4u8 {
                let at = |dx: u8, dy: u8| {
                    [
                        f32::from(x + dx) * 8.0 + 2.0,
                        f32::from(y + dy) * 8.0 + 2.0,
                        0.5,
                    ]
                };
                let color = [colors[usize::from(x)]; 3];
                all.push(([at(0, 0), at(0, 1), at(1, 0)], color));
                all.push(([at(1, 0), at(0, 1), at(1, 1)], color));
            }
        }
        fixture::loose(&all, 2)
    }

    fn merged(clip: &PlanarClip, tol: f32) -> Vec<Region> {
        let drawn = Drawn::of(clip).unwrap();
        merge(clip, &drawn, &layers_of(clip, &drawn), tol).unwrap()
    }

    /// Twice the area within outlines, by the shoelace formula; negative if it faces the viewer.
    fn area(points: &[Vec2], further: &[u32]) -> f32 {
        let ends = further.iter().map(|e| *e as usize).chain([points.len()]);
        let (mut start, mut sum) = (0, 0.0);
        for end in ends {
            let outline = &points[start..end];
            for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
                sum += a.perp_dot(*b);
            }
            start = end;
        }
        sum
    }

    #[test]
    fn a_field_of_two_halves_becomes_two_outlines() {
        let clip = field([100, 110, 200, 190]);
        let regions = merged(&clip, 12.0);
        assert_eq!(regions.len(), 2);
        let mut colors: Vec<u8> = regions.iter().map(|r| r.color[0]).collect();
        colors.sort_unstable();
        assert_eq!(colors, [105, 195]);
        for region in &regions {
            assert_eq!((region.triangles.len(), region.outlines.len()), (16, 1));
            // Around 2 x 4 squares: twelve edges.
            let points = region.points(&clip, 1);
            assert_eq!(points.len(), 12);
            assert!((area(&points, &[]) + 2.0 * 16.0 * 32.0).abs() < 1e-2);
        }
        assert_eq!(merged(&clip, 255.0).len(), 1);
        assert_eq!(merged(&clip, 9.0).len(), 4);
    }

    #[test]
    fn a_hole_is_an_outline_of_its_own() {
        let mut clip = field([50; 4]);
        for t in [10, 11, 12, 13, 18, 19, 20, 21] {
            for v in clip.triangles[t] {
                clip.albedo[v as usize] = [250.0; 3];
            }
        }
        let mut regions = merged(&clip, 5.0);
        regions.sort_by_key(|r| r.color);
        assert_eq!(regions[0].outlines.len(), 2);
        assert_eq!(regions[0].further_outlines().len(), 1);
        let points = regions[0].points(&clip, 0);
        let around = area(&points, &regions[0].further_outlines());
        assert!((around + 2.0 * (1024.0 - 256.0)).abs() < 1e-2, "{around}");
        assert_eq!((points.len(), regions[1].outlines.len()), (24, 1));
    }

    #[test]
    fn a_triangle_between_two_alike_keeps_them_apart() {
        // Two halves of a square; a bar lies over one and under the other.
        let square = [
            (
                [[2.0, 2.0, 0.3], [2.0, 38.0, 0.5], [38.0, 2.0, 0.5]],
                [90; 3],
            ),
            (
                [[38.0, 2.0, 0.5], [2.0, 38.0, 0.5], [38.0, 38.0, 5.0]],
                [90; 3],
            ),
            (
                [[4.0, 4.0, 0.6], [14.0, 20.0, 0.6], [36.0, 34.0, 0.6]],
                [200; 3],
            ),
        ];
        let clip = fixture::loose(&square, 1);
        assert_eq!(merged(&clip, 10.0).len(), 3);
        let apart = fixture::loose(&square[..2], 1);
        assert_eq!(merged(&apart, 10.0).len(), 1);
    }

    #[test]
    fn merging_covers_what_the_triangles_cover() {
        let cube = fixture::turning_cube(12);
        let drawn = Drawn::of(&cube).unwrap();
        let layers = layers_of(&cube, &drawn);
        let regions = merge(&cube, &drawn, &layers, 60.0).unwrap();
        assert!(
            regions.len() < layers.len(),
            "{} of {}",
            regions.len(),
            layers.len()
        );
        let sealed = seal_regions(
            &cube,
            &regions,
            UnderlapOptions {
                distance_px: 0.0,
                ..UnderlapOptions::default()
            },
        );
        for f in 0..12 {
            let shown = |frames: &[Range<usize>]| frames.iter().any(|s| s.contains(&f));
            let of_layer = |l: &&Layer| shown(&l.frames);
            let triangles = layers.iter().filter(of_layer);
            let expected: f32 = triangles
                .map(|l| area(&cube.places(f, l.triangle as usize), &[]))
                .sum();
            let regions = regions
                .iter()
                .zip(&sealed)
                .filter(|(r, _)| shown(&r.frames));
            let found: f32 = regions
                .map(|(r, s)| area(&s[f], &r.further_outlines()))
                .sum();
            assert!(
                (found - expected).abs() < 0.5,
                "{found} {expected} in frame {f}"
            );
        }
    }

    #[test]
    fn sealed_regions_reach_under_later_ones_alone() {
        let clip = field([100, 100, 200, 200]);
        let regions = merged(&clip, 12.0);
        let sealed = seal_regions(&clip, &regions, UnderlapOptions::default());
        assert_eq!(sealed[1][0], regions[1].points(&clip, 0));
        let moved = sealed[0][0].iter().zip(regions[0].points(&clip, 0));
        let inner = moved.filter(|(a, b)| a.distance(*b) > 0.5).count();
        // The three points inside the common edge move by the whole distance.
        assert!((3..=5).contains(&inner), "{inner}");
    }
}
