//! Lids that close: the rims of an eye meet along their whole length, and stay in front of the eyeball.
//!
//! Seen from the front, an opening has a height at each place from corner to corner. What is above it goes its
//! share of this height, on a circle about the middle of the eye, all the more the nearer to the rim it is.

use super::super::points::{FacePoints, FaceSurface};
use super::eye_shape::EyeShape;
use super::graph::{SurfaceGraph, smooth};
use super::lid_view::{EyeView, NoLids, Opening};
use super::mirror::Mirror;
use articula_core::feature_points::PointId;
use articula_core::{Libm, LibmQuat};
use glam::{Quat, Vec3};

/// Distances from a rim, along the skin, up to which skin goes with it, and from which it rests, by height of
/// the face; and the same by the height of the opening, where that is more.
const WITH_RIM: [f32; 2] = [0.02, 0.085];
const WITH_OPENING: [f32; 2] = [0.15, 0.8];
/// What is nearer to the inside of a socket, seen at rest, than to the rim by this factor, rests.
const INSIDE: f32 = 1.5;
/// Widths over which the heights of an opening are smoothed, at the rims and away from them, by height of the face, and
/// the distance from a rim of the latter.
const SMOOTHED: [f32; 2] = [6e-3, 0.045];
const AWAY: f32 = 0.035;
/// Most by which the way of a lid falls off along it beyond the corners, at the rim and away from it: an opening that ends
/// steeply, as before the inner corner, is no step in the lid.
const STEEP: [f32; 2] = [2.5, 0.6];
/// Difference of the distances from both rims, by height of the face, from which skin goes on beyond the corners: between
/// them it goes with neither.
const APART: f32 = 0.03;
/// Skin that rests up to this distance beyond what goes with a lid, by height of the face, may be smoothed with it.
const AROUND_LID: f32 = 0.02;
/// Distance of lids from the eyeball, by height of the face: 0.27 mm on an average one.
const CLEAR: f32 = 2e-3;
/// Skin up to this distance from the centre of an eye, by its radius, stays outside of it.
const AROUND: f32 = 1.6;
/// Depth below the surface of an eye, by its radius, up to which skin at rest counts as outside of it: rims
/// lie on the eye.
const TOUCHING: f32 = 0.03;
/// Motion by which the distance from the eyeball is reached, by height of the face.
const CLEARED: f32 = 0.01;
/// Distances from the centre of an eye, by its radius, at which other parts lie between the lids.
const BETWEEN: std::ops::Range<f32> = 0.9..1.1;
/// Distance from the skin up to which other parts do not, but are of a lid, by height of the face.
const OF_LID: f32 = 2e-3;
/// Closing, by what 1024 units of a parameter say, from which the upper lid moves more or less than its
/// parameter says, and at which its rim, so, is where both lids meet.
const ADAPTED: [f32; 2] = [0.2, 0.9];
/// Least way of a point of a lid, by the height of the opening; one that goes less is not of the lid.
const LEAST_OWN: f32 = 0.25;
/// Share of the opening from which what closes lids wholly is added at the latest.
const MOST_CORRECTED: f32 = 0.5;
/// Most by which the opening may differ from 1024 units, by its height.
const MOST_ADAPTED: f32 = 0.5;
/// Depth of the middle of an eye without eyeball behind its rims, by height of the face, and by the width of
/// the opening.
const BEHIND: [f32; 2] = [0.09, 0.55];

/// Middles of the upper and of the lower lid, and the corners, of the left and the right eye.
const EYES: [([PointId; 2], [PointId; 2]); 2] = [
    ([(3, 1), (3, 3)], [(3, 7), (3, 11)]),
    ([(3, 2), (3, 4)], [(3, 8), (3, 12)]),
];

/// An eye with its lids.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EyeLids {
    pub(super) shape: EyeShape,
    pub(super) heights: Heights,
    /// How far the points of the upper and the lower lid go as their lid closes the opening, metres.
    gaps: [f32; 2],
    /// Length of 1024 units of the parameters of lids, metres: these close the eye.
    closed: f32,
    /// Share of the opening up to which lids go as their parameters say, without what closes them wholly.
    corrected: f32,
    /// Vertices of lids, ascending.
    pub(super) vertices: Vec<LidVertex>,
    /// Vertices of other parts that a lid carries, such as lashes.
    carried: Vec<Carried>,
    /// Vertices of other parts between the lids, and how far each is from the upper to the lower rim.
    between: Vec<(u32, f32)>,
    /// Vertices of the skin, and of what follows it, that must stay outside of the eyeball, and their
    /// distance from it at rest, but not more than they must keep.
    outside: Vec<(u32, f32)>,
    /// Distance from the eyeball that they keep, and motion by which it is reached, metres.
    clear: [f32; 2],
}

/// The opening of an eye from corner to corner, in even steps of x.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Heights {
    /// Place of the first step, and the step, metres.
    pub(super) low: f32,
    pub(super) step: f32,
    /// Heights of the upper and the lower rim.
    rims: Vec<[f32; 2]>,
    /// How far a lid goes to the other one, at its rim and away from it.
    ways: [Vec<f32>; 2],
    /// What is added to these where both lids are apart, so that they end in no step.
    beyond: [Vec<f32>; 2],
    /// What the upper and the lower lid go in addition when the eye is closed.
    pub(super) more: [Vec<f32>; 2],
}

/// A vertex that goes with a lid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LidVertex {
    pub(super) vertex: u32,
    /// Row of the skin; `None` for lids that are parts of their own.
    row: Option<usize>,
    going: Going,
    /// Whether it is of the rim itself.
    pub(super) is_rim: bool,
    /// What is added to its motion when the eye is closed, metres.
    pub(super) more: Vec3,
}

/// How a place goes with a lid.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Going {
    /// 0 for the upper lid, 1 for the lower one.
    side: usize,
    /// How much it goes with the rim.
    share: f32,
    /// 0 at the rim, 1 away from it.
    away: f32,
    /// 0 as near to the one rim as to the other, 1 at one of them.
    apart: f32,
}

/// A vertex that turns about the middle of the eye as the lid does.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Carried {
    vertex: u32,
    /// Index among the vertices of the lids of the one that carries it.
    by: usize,
}

/// What lids are found by.
pub(super) struct LidInput<'a> {
    pub(super) surface: &'a FaceSurface,
    pub(super) points: &'a FacePoints,
    pub(super) mirror: &'a Mirror,
    /// Vertices of the skin, ascending.
    pub(super) vertices: &'a [u32],
    /// Vertices of other parts, and the row of the skin that they follow.
    pub(super) followers: &'a [(u32, usize)],
    pub(super) height: f32,
    /// The eyes, without surface where no eyeball is known.
    pub(super) eyes: [EyeShape; 2],
    /// Length of 1024 units of the parameters of lids, metres.
    pub(super) closed: f32,
}

impl Going {
    fn of_rim(side: usize) -> Self {
        Self {
            side,
            share: 1.0,
            away: 0.0,
            apart: 1.0,
        }
    }
}

impl LidVertex {
    /// 0 for the upper lid, 1 for the lower one.
    pub(super) fn side(&self) -> usize {
        self.going.side
    }
}

impl Heights {
    fn of(opening: &Opening, height: f32) -> Self {
        let step = opening.grid.step;
        let count = opening.rims.len();
        let known = |i: usize| opening.rims[i][0] - opening.rims[i][1];
        let tallest = (0..count).map(known).fold(0.0, f32::max);
        // Beyond the corners nothing is open, but lids go on there.
        let beside = (tallest / STEEP[0].min(STEEP[1]) + SMOOTHED[1] * height) / step;
        let beside = beside.ceil() as usize;
        let all = count + 2 * beside;
        let mut open = vec![0.0; beside];
        open.extend((0..count).map(known));
        open.resize(all, 0.0);
        let mut ways = SMOOTHED.map(|over| smoothed(&open, over * height / step));
        let at_least = |way: &mut Vec<f32>| {
            let pairs = way.iter_mut().zip(&open);
            pairs.for_each(|(way, open)| *way = way.max(*open));
        };
        at_least(&mut ways[0]);
        let mut beyond = [0, 1].map(|away: usize| {
            let sloped = sloped(&open, STEEP[away] * step);
            smoothed(&sloped, SMOOTHED[away] * height / step)
        });
        at_least(&mut beyond[0]);
        for (beyond, ways) in beyond.iter_mut().zip(&ways) {
            let pairs = beyond.iter_mut().zip(ways);
            pairs.for_each(|(beyond, way)| *beyond -= way);
        }
        let rims = (0..all).map(|i| opening.rims[i.saturating_sub(beside).min(count - 1)]);
        Self {
            low: opening.grid.low.x + (opening.first as f32 - beside as f32) * step,
            step,
            rims: rims.collect(),
            ways,
            beyond,
            more: [vec![0.0; all], vec![0.0; all]],
        }
    }

    /// The steps before and after a place, and how far it is between them.
    fn between(&self, x: f32) -> Option<(usize, usize, f32)> {
        let at = (x - self.low) / self.step;
        let last = self.rims.len() as f32 - 1.0;
        (0.0..last).contains(&at).then(|| {
            let index = at as usize;
            (index, index + 1, at - index as f32)
        })
    }

    /// Way at a place of what goes with a lid.
    fn way(&self, x: f32, going: Going) -> f32 {
        let Some((a, b, t)) = self.between(x) else {
            return 0.0;
        };
        let at = |values: &[Vec<f32>; 2]| {
            let [near, far] = values.each_ref().map(|w| w[a] + t * (w[b] - w[a]));
            near + going.away * (far - near)
        };
        at(&self.ways) + going.apart * at(&self.beyond)
    }

    fn more(&self, side: usize, x: f32) -> f32 {
        let more = &self.more[side];
        self.between(x)
            .map_or(0.0, |(a, b, t)| more[a] + t * (more[b] - more[a]))
    }

    /// Heights of the upper and the lower rim; `None` beyond the corners.
    fn rims(&self, x: f32) -> Option<[f32; 2]> {
        let (a, b, t) = self.between(x)?;
        let [top, bottom] = [0, 1]
            .map(|side: usize| self.rims[a][side] + t * (self.rims[b][side] - self.rims[a][side]));
        (self.ways[0][a] > 0.0).then_some([top, bottom])
    }

    /// The tallest place.
    pub(super) fn most(&self) -> f32 {
        self.ways[0].iter().copied().fold(0.0, f32::max)
    }
}

impl EyeLids {
    /// The lids of both eyes, and why there are none.
    pub(super) fn of(input: &LidInput<'_>) -> [Result<Self, NoLids>; 2] {
        [0, 1].map(|eye| {
            let (view, mut lids) = Self::of_eye(input, eye)?;
            let (positions, joined) = (&input.surface.positions, &input.points.parts.joined);
            lids.close_fully(&view, positions, joined)?;
            Ok(lids)
        })
    }

    fn of_eye(input: &LidInput<'_>, eye: usize) -> Result<(EyeView, Self), NoLids> {
        let (middles, corners) = EYES[eye];
        let (surface, points, height) = (input.surface, input.points, input.height);
        let place = |point: PointId| points.get(point).map_or(Vec3::ZERO, |p| p.place);
        let corners = corners.map(place);
        let mut shape = input.eyes[eye].clone();
        let (view, opening) = EyeView::of(surface, points, eye, &shape, corners)?;
        let heights = Heights::of(&opening, height);
        let rims = || opening.hits.iter().flatten().map(|(_, place)| *place);
        if points.eyeballs().is_none() {
            let middle = rims().sum::<Vec3>() / rims().count().max(1) as f32;
            let width = opening.rims.len() as f32 * opening.grid.step;
            let [of_face, of_width] = BEHIND;
            let behind = (of_face * height).max(of_width * width);
            shape.centre = middle - behind * Vec3::Z;
        }
        let shape = shape.or_behind(rims(), CLEAR * height);
        let vertices = lid_vertices(input, &view, &opening, heights.most());
        if (0..2).any(|side| !vertices.iter().any(|v| v.going.side == side)) {
            return Err(NoLids::NoRim);
        }
        let most = heights.most();
        let own = |side: usize| {
            let vertex = points.get(middles[side])?.vertex?;
            let index = vertices.binary_search_by_key(&vertex, |v| v.vertex).ok()?;
            let going = vertices[index].going;
            let x = surface.positions[vertex as usize].x;
            let way = going.share * heights.way(x, going);
            (going.side == side && way > LEAST_OWN * most).then_some(way)
        };
        let gaps = [0, 1].map(|side| own(side).unwrap_or(most));
        let least = gaps[0].min(gaps[1]);
        let mut lids = Self {
            gaps,
            closed: input.closed,
            corrected: (ADAPTED[0] * input.closed / least).min(MOST_CORRECTED),
            carried: Vec::new(),
            between: Vec::new(),
            outside: Vec::new(),
            clear: [CLEAR, CLEARED].map(|d| d * height),
            shape,
            heights,
            vertices,
        };
        lids.find_others(input);
        Ok((view, lids))
    }

    /// Finds what goes with the lids, lies between them, and stays outside of the eyeball.
    fn find_others(&mut self, input: &LidInput<'_>) {
        let at = |v: u32| input.surface.positions[v as usize];
        let index = |vertex: u32| {
            self.vertices
                .binary_search_by_key(&vertex, |v| v.vertex)
                .ok()
        };
        let is_own = |vertex: u32| index(vertex).is_some();
        let followers = || input.followers.iter().filter(|(v, _)| !is_own(*v));
        let carried = followers().filter_map(|(vertex, row)| {
            let by = index(input.vertices[*row])?;
            Some(Carried {
                vertex: *vertex,
                by,
            })
        });
        let carried = carried.collect();
        let distance = |v: u32| {
            let from = at(v) - self.shape.centre;
            from.length() / self.shape.radius(from)
        };
        let part = |(v, row): (u32, usize)| {
            let of_lid = at(v).distance(at(input.vertices[row])) < OF_LID * input.height;
            let [top, bottom] = self.heights.rims(at(v).x)?;
            let part = (top - at(v).y) / (top - bottom);
            let is_near = at(v).z > self.shape.centre.z && BETWEEN.contains(&distance(v));
            let is_between = is_near && !of_lid && top > bottom && (0.0..1.0).contains(&part);
            is_between.then_some((v, part))
        };
        let between = followers().filter_map(|f| part(*f)).collect();
        let others = followers().map(|(v, _)| *v);
        let own = self.vertices.iter().filter(|v| v.row.is_none());
        let skin = input.vertices.iter().copied().chain(others);
        let skin = skin.chain(own.map(|v| v.vertex));
        let stays = |v: u32| {
            let radius = self.shape.radius(at(v) - self.shape.centre);
            let is_near = (1.0 - TOUCHING..AROUND).contains(&distance(v));
            let away = (distance(v) - 1.0) * radius;
            is_near.then_some((v, away.min(CLEAR * input.height)))
        };
        let outside = skin.filter_map(stays).collect();
        (self.carried, self.between, self.outside) = (carried, between, outside);
    }

    /// Shares of the opening by which the upper and the lower lid close it, together 1 at most, for how
    /// far the middle of the one goes down and of the other up, metres.
    pub(super) fn closing(&self, down: f32, up: f32) -> [f32; 2] {
        let mut shares = [down / self.gaps[0], up / self.gaps[1]];
        // What 1024 units say is the distance of two points of the lids; it may not be that of the rims.
        let lacks = 1.0 - self.closed / self.gaps[0];
        let [first, last] = ADAPTED;
        let nearly = (down / self.closed - first) / (last - first);
        shares[0] += smooth(nearly) * lacks.clamp(-MOST_ADAPTED, MOST_ADAPTED);
        let beyond = shares[0] + shares[1] - 1.0;
        let positive = shares[0].max(0.0) + shares[1].max(0.0);
        if beyond <= 0.0 || positive <= 0.0 {
            return shares;
        }
        shares.map(|share| share - beyond * share.max(0.0) / positive)
    }

    /// Moves the skin, by row.
    pub(super) fn close(&self, shares: [f32; 2], positions: &[Vec3], rows: &mut [Vec3]) {
        for lid in &self.vertices {
            if let Some(row) = lid.row {
                rows[row] += self.motion(lid, positions, shares);
            }
        }
    }

    /// Moves other parts at the lids: lids that are parts of their own, lashes, which turn with them, and what lies
    /// between them, which goes as far as it is from one rim to the other; `moved` has a displacement for each
    /// vertex of the surface.
    pub(super) fn move_others(&self, shares: [f32; 2], positions: &[Vec3], moved: &mut [Vec3]) {
        for lid in self.vertices.iter().filter(|v| v.row.is_none()) {
            moved[lid.vertex as usize] = self.motion(lid, positions, shares);
        }
        let angle = |from: Vec3| from.y.libm_atan2(from.z);
        for carried in &self.carried {
            let lid = &self.vertices[carried.by];
            let root = positions[lid.vertex as usize];
            let from = root - self.shape.centre;
            let up = angle(from + self.motion(lid, positions, shares)) - angle(from);
            let tip = positions[carried.vertex as usize] - root;
            let turned = Quat::libm_rotation_x(-up) * tip;
            moved[carried.vertex as usize] += turned - tip;
        }
        for (vertex, part) in &self.between {
            let v = *vertex as usize;
            let [upper, lower] =
                [0, 1].map(|side| self.way(Going::of_rim(side), positions[v], shares));
            moved[v] = upper.lerp(lower, *part);
        }
    }

    /// Moves the lids alone; `moved` has a displacement for each vertex of the surface.
    pub(super) fn move_lids(&self, shares: [f32; 2], positions: &[Vec3], moved: &mut [Vec3]) {
        for lid in &self.vertices {
            moved[lid.vertex as usize] = self.motion(lid, positions, shares);
        }
    }

    /// Pushes what is displaced into the eyeball out of it, to the front; `moved` has a displacement for
    /// each vertex of the surface.
    pub(super) fn push_out(&self, positions: &[Vec3], moved: &mut [Vec3]) {
        let [clear, cleared] = self.clear;
        for (vertex, at_rest) in &self.outside {
            let v = *vertex as usize;
            let least = at_rest + (clear - at_rest) * smooth(moved[v].length() / cleared);
            if moved[v] != Vec3::ZERO {
                moved[v] += self.shape.out_of(positions[v] + moved[v], least);
            }
        }
    }

    /// How much of what is added to close the eye wholly is added: none while lids go as their parameters say.
    fn whole(&self, shares: [f32; 2]) -> f32 {
        let closed = (shares[0] + shares[1] - self.corrected) / (1.0 - self.corrected);
        let closed = closed.clamp(0.0, 1.0);
        closed * closed
    }

    /// How a vertex of a lid moves.
    fn motion(&self, lid: &LidVertex, positions: &[Vec3], shares: [f32; 2]) -> Vec3 {
        let place = positions[lid.vertex as usize];
        let way = self.way(lid.going, place, shares);
        way + self.whole(shares) * lid.more
    }

    /// The way of a place that goes with a lid, on a circle about the middle of the eye.
    fn way(&self, going: Going, place: Vec3, shares: [f32; 2]) -> Vec3 {
        let Going { side, share, .. } = going;
        let down = [1.0, -1.0][side];
        let way = shares[side] * self.heights.way(place.x, going);
        let more = self.whole(shares) * self.heights.more(side, place.x);
        let y = -down * share * (way + more);
        let from = place - self.shape.centre;
        let circle = (from.y * from.y + from.z * from.z).sqrt();
        let to = (from.y + y).clamp(-0.95 * circle, 0.95 * circle);
        let z = (circle * circle - to * to).sqrt() - from.z;
        // Beside the eye and above it the circle is steep; what is there slides.
        let z = if from.z > 0.0 {
            z.clamp(-y.abs(), y.abs())
        } else {
            0.0
        };
        Vec3::new(0.0, y, z)
    }
}

/// The least values above some that nowhere fall by more than `most` from one to the next.
fn sloped(values: &[f32], most: f32) -> Vec<f32> {
    let mut sloped = values.to_vec();
    for i in 1..sloped.len() {
        sloped[i] = sloped[i].max(sloped[i - 1] - most);
    }
    for i in (1..sloped.len()).rev() {
        sloped[i - 1] = sloped[i - 1].max(sloped[i] - most);
    }
    sloped
}

/// Means over some steps on both sides, by smooth steps; beyond the ends is nothing.
fn smoothed(values: &[f32], width: f32) -> Vec<f32> {
    let width = width.max(2.0);
    let reach = width.ceil() as isize;
    let weights = (-reach..=reach).map(|j| smooth(1.0 - (j as f32 / width).abs()));
    let weights: Vec<f32> = weights.collect();
    let sum: f32 = weights.iter().sum();
    let value = |i: isize| usize::try_from(i).ok().and_then(|i| values.get(i));
    let at = |i: isize| {
        let near = (-reach..=reach).map(|j| value(i + j).copied().unwrap_or(0.0));
        near.zip(&weights).map(|(v, w)| v * w).sum::<f32>() / sum
    };
    (0..values.len() as isize).map(at).collect()
}

/// Distance from a rim, by height of the face, up to which a vertex is of it.
const OF_RIM: f32 = 7.5e-3;

/// The vertices that go with the lids of an eye, ascending.
fn lid_vertices(
    input: &LidInput<'_>,
    view: &EyeView,
    opening: &Opening,
    tallest: f32,
) -> Vec<LidVertex> {
    let positions = &input.surface.positions;
    let joined = &input.points.parts.joined;
    let graph = SurfaceGraph::of(positions, joined, &view.lids, input.mirror);
    let [upper, lower] = opening.hits.each_ref().map(|hits| {
        let seeds = hits.iter().flat_map(|(triangle, place)| {
            let corners = view.lids[*triangle].into_iter();
            corners.map(|v| (v, positions[v as usize].distance(*place)))
        });
        graph.distances_beyond(seeds)
    });
    let inside = graph.distances(&opening.inside);
    let reach = |i: usize| (WITH_RIM[i] * input.height).max(WITH_OPENING[i] * tallest);
    let (near, far) = (reach(0), reach(1));
    let mut all: Vec<u32> = view.lids.iter().flatten().copied().collect();
    all.sort_unstable();
    all.dedup();
    let lid = |vertex: u32| {
        let v = vertex as usize;
        let away = upper[v].min(lower[v]);
        let mut share = smooth((far - away) / (far - near));
        if inside[v].is_finite() && away > 0.0 {
            share *= smooth(INSIDE * inside[v] / (inside[v] + away));
        }
        let row = input.vertices.binary_search(&vertex).ok();
        let is_near = row.is_some() && away < far + AROUND_LID * input.height;
        (share > 0.0 || is_near).then_some(LidVertex {
            vertex,
            row,
            going: Going {
                side: usize::from(lower[v] < upper[v]),
                share,
                away: smooth(away / (AWAY * input.height)),
                apart: smooth((upper[v] - lower[v]).abs() / (APART * input.height)),
            },
            is_rim: away < OF_RIM * input.height,
            more: Vec3::ZERO,
        })
    };
    all.into_iter().filter_map(lid).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3Swizzles;

    /// Places of the rims of an eye of 1 m at the origin: along x, 0.5 m apart in the middle.
    fn rims() -> Vec<Vec3> {
        let place = |sign: f32, i: usize| {
            let x = -0.8 + 0.2 * i as f32;
            let y = sign * 0.25 * (1.0 - (x / 0.8).powi(2));
            Vec3::new(x, y, (1.1 - x * x - y * y).sqrt())
        };
        let rim = |sign: f32| (0..9).map(move |i| place(sign, i));
        rim(1.0).chain(rim(-1.0)).collect()
    }

    /// Its lids, whose vertices are those of the rims.
    fn eye() -> EyeLids {
        let all = rims();
        let heights: Vec<[f32; 2]> = (0..9).map(|i| [all[i].y, all[9 + i].y]).collect();
        let ways: Vec<f32> = heights.iter().map(|[top, bottom]| top - bottom).collect();
        let vertex = |v: usize| LidVertex {
            vertex: v as u32,
            row: Some(v),
            going: Going::of_rim(v / 9),
            is_rim: true,
            more: Vec3::ZERO,
        };
        EyeLids {
            shape: EyeShape::new(Vec3::ZERO, std::iter::once(Vec3::Z)),
            heights: Heights {
                low: -0.8,
                step: 0.2,
                ways: [ways.clone(), ways],
                beyond: [vec![0.0; 9], vec![0.0; 9]],
                more: [vec![0.0; 9], vec![0.0; 9]],
                rims: heights,
            },
            gaps: [0.5; 2],
            closed: 0.5,
            corrected: 0.2,
            carried: Vec::new(),
            between: Vec::new(),
            clear: [0.05, 0.1],
            vertices: (0..18).map(vertex).collect(),
            outside: Vec::new(),
        }
    }

    /// Places of the rims after closing.
    fn closed(eye: &EyeLids, shares: [f32; 2]) -> Vec<Vec3> {
        let rest = rims();
        let mut moved = vec![Vec3::ZERO; rest.len()];
        eye.close(shares, &rest, &mut moved);
        rest.iter().zip(&moved).map(|(a, b)| *a + *b).collect()
    }

    #[test]
    fn rims_meet_along_their_whole_length() {
        let eye = eye();
        for shares in [[1.0, 0.0], [0.7, 0.3], [0.0, 1.0]] {
            let at = closed(&eye, shares);
            for i in 0..9 {
                assert!((at[i].y - at[9 + i].y).abs() < 1e-6, "{shares:?}, {i}");
            }
        }
        // Half closed, each place has gone half of its own way, on its circle.
        let at = closed(&eye, [0.5, 0.0]);
        let rest = rims()[4];
        assert!((at[4].y - 0.0).abs() < 1e-6);
        assert!((at[4].yz().length() - rest.yz().length()).abs() < 1e-6);
    }

    #[test]
    fn lids_stay_on_a_circle_about_the_eye() {
        let eye = eye();
        let place = rims()[4];
        // 0.4 m down: from 0.25 m above the middle to 0.15 m below.
        let shut = eye.way(Going::of_rim(0), place, [0.8, 0.0]);
        assert!((shut.y + 0.4).abs() < 1e-6);
        assert!(((place + shut).yz().length() - place.yz().length()).abs() < 1e-6);
        // Half as near to the rim, it goes half of it; the other lid rests.
        let half = Going {
            share: 0.5,
            ..Going::of_rim(0)
        };
        assert!((eye.way(half, place, [0.8, 0.0]).y + 0.2).abs() < 1e-6);
        assert_eq!(
            eye.way(Going::of_rim(1), rims()[13], [0.8, 0.0]),
            Vec3::ZERO
        );
        // Beyond the corners nothing is open.
        let beyond = Vec3::new(0.9, 0.1, 0.5);
        assert_eq!(eye.way(Going::of_rim(0), beyond, [1.0, 0.0]).y, 0.0);
    }

    #[test]
    fn the_way_of_a_lid_has_no_steps() {
        // An opening that ends in steps of 3 and 2: they fall off by 1 at most, and nothing is less than it was.
        let open = [0.0, 0.0, 3.0, 3.5, 2.0, 0.0, 0.0];
        assert_eq!(sloped(&open, 1.0), [1.0, 2.0, 3.0, 3.5, 2.5, 1.5, 0.5]);
        // A single step of height 4 over two steps on each side: smooth steps of 0, 1/2 and 1.
        let spread = smoothed(&[0.0, 0.0, 4.0, 0.0, 0.0], 2.0);
        assert_eq!(spread, [0.0, 1.0, 2.0, 1.0, 0.0]);
    }

    #[test]
    fn lids_stop_where_they_meet() {
        let eye = eye();
        assert_eq!(eye.closing(0.25, 0.125), [0.5, 0.25]);
        let [upper, lower] = eye.closing(0.75, 0.25);
        assert!((upper - 0.75).abs() < 1e-6 && (lower - 0.25).abs() < 1e-6);
        assert_eq!(eye.closing(1.0, 0.0), [1.0, 0.0]);
        // A lid that opens leaves more way to the other one.
        assert_eq!(eye.closing(0.75, -0.25), [1.5, -0.5]);
        // Wide open eyes are no matter of this.
        assert_eq!(eye.closing(-0.5, -0.5), [-1.0, -1.0]);
    }

    #[test]
    fn skin_stays_outside_of_the_eyeball() {
        let mut eye = eye();
        eye.outside = vec![(4, 0.05)];
        // What moves the lid into the ball is pushed out to the front.
        let rest = rims()[..9].to_vec();
        let mut moved = vec![Vec3::ZERO; 9];
        moved[4] = -0.6 * Vec3::Z;
        moved[3] = -0.6 * Vec3::Z;
        eye.push_out(&rest, &mut moved);
        assert_eq!(moved[3], -0.6 * Vec3::Z);
        assert!(((rest[4] + moved[4]).length() - 1.05).abs() < 1e-5);
        assert_eq!(moved[4].truncate(), glam::Vec2::ZERO);
    }

    #[test]
    fn what_is_between_the_lids_goes_along() {
        let mut eye = eye();
        // Half way between the rims, and a quarter of the way.
        let at = |y: f32| Vec3::new(0.0, y, (1.0 - y * y).sqrt());
        eye.between = vec![(0, 0.5), (1, 0.25)];
        let rest = [at(0.0), at(0.125)];
        let mut moved = [Vec3::ONE; 2];
        eye.move_others([1.0, 0.0], &rest, &mut moved);
        assert!((moved[0].y + 0.25).abs() < 1e-6 && (moved[1].y + 0.375).abs() < 1e-6);
    }

    #[test]
    fn lashes_turn_with_the_lid() {
        let mut eye = eye();
        // A lash in front of the middle of the upper rim, which goes half a metre down on its circle.
        let root = rims()[4];
        let rest = [root, root + 0.3 * root.normalize()];
        eye.vertices.truncate(1);
        eye.carried = vec![Carried { vertex: 1, by: 0 }];
        let way = eye.way(Going::of_rim(0), root, [1.0, 0.0]);
        let mut moved = [way; 2];
        eye.move_others([1.0, 0.0], &rest, &mut moved);
        let tip = rest[1] + moved[1];
        // It still points away from the middle of the eye.
        let expected = (root + way).normalize() * rest[1].length();
        assert!((tip - expected).length() < 1e-6, "{tip}, not {expected}");
    }

    #[test]
    fn eyes_are_closed_at_1024_units() {
        let mut eye = eye();
        // The points of the lids are 0.4 m apart, the rims 0.5 m.
        eye.closed = 0.4;
        let unit = 0.4 / 1024.0;
        for [upper, lower] in [[1024.0, 0.0], [950.0, 74.0]] {
            let [a, b] = eye.closing(upper * unit, lower * unit);
            assert!(
                (a + b - 1.0).abs() < 1e-5,
                "{upper} and {lower}: {a} and {b}"
            );
        }
        // Up to 200 units a lid moves as its parameter says, and so does the lower one.
        assert_eq!(eye.closing(200.0 * unit, 0.0)[0], 200.0 * unit / 0.5);
        assert_eq!(eye.closing(0.0, 400.0 * unit)[1], 400.0 * unit / 0.5);
        assert_eq!(eye.closing(-300.0 * unit, 0.0)[0], -300.0 * unit / 0.5);
    }
}
