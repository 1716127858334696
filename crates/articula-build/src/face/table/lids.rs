//! Lids that close: the rims of an eye meet along their whole length, and stay in front of the eyeball.
//!
//! A few handles move the skin of a lid. Between them its rim would come close to the other one, but a
//! thin line of the eye would stay open. Here every place of a rim goes its own share of the way to the
//! other rim, on a circle about the middle of the eye.

use super::super::points::{FacePoints, FaceSurface};
use super::eye_shape::EyeShape;
use super::graph::{SurfaceGraph, smooth};
use super::handles::Handle;
use super::mirror::Mirror;
use articula_core::feature_points::PointId;
use articula_core::{Libm, LibmQuat};
use glam::{Quat, Vec3};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Distance from a rim, along the skin, over which its correction fades, by height of the face.
const REACH: f32 = 0.06;
/// How far closed rims overlap, by height of the face: 0.2 mm on an average one.
const OVERLAP: f32 = 1.5e-3;
/// Share of the way to the other rim from which the overlap grows.
const NEARLY: f32 = 0.9;
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
/// Most by which the opening may differ from 1024 units, by its height.
const MOST_ADAPTED: f32 = 0.5;

/// Middles of the upper and of the lower lid, and the corners, of the left and the right eye.
const EYES: [([PointId; 2], [PointId; 2]); 2] = [
    ([(3, 1), (3, 3)], [(3, 7), (3, 11)]),
    ([(3, 2), (3, 4)], [(3, 8), (3, 12)]),
];

/// An eye with its lids.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EyeLids {
    pub(super) shape: EyeShape,
    /// Upper and lower rim.
    rims: [Rim; 2],
    /// Height of the opening at rest at the middles of the upper and the lower lid, metres.
    gaps: [f32; 2],
    /// Length of 1024 units of the parameters of lids, metres: these close the eye.
    closed: f32,
    near: Vec<NearRim>,
    /// Vertices of other parts that a rim carries, such as lashes.
    carried: Vec<Carried>,
    /// Vertices of other parts between the lids, and how far each is from the upper to the lower rim.
    between: Vec<(u32, f32)>,
    /// Vertices of the skin, and of what follows it, that must stay outside of the eyeball, and their
    /// distance from it at rest, but not more than they must keep.
    outside: Vec<(u32, f32)>,
    /// Distance from the eyeball that they keep, and motion by which it is reached, metres.
    clear: [f32; 2],
    overlap: f32,
}

/// The rim of a lid, from the one corner to the other.
#[derive(Debug, Clone, PartialEq)]
struct Rim {
    /// Places at rest, by ascending x, each with the row of its vertex.
    places: Vec<(Vec3, usize)>,
}

/// A vertex that follows a rim.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NearRim {
    row: usize,
    /// 0 for the upper rim, 1 for the lower one.
    side: usize,
    x: f32,
    share: f32,
}

/// A vertex that turns about the middle of the eye as the rim does.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Carried {
    vertex: u32,
    side: usize,
    /// The vertex of the skin that carries it.
    by: u32,
    share: f32,
}

/// What lids are found by.
pub(super) struct LidInput<'a> {
    pub(super) surface: &'a FaceSurface,
    pub(super) points: &'a FacePoints,
    pub(super) handles: &'a [Handle],
    pub(super) graph: &'a SurfaceGraph,
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

impl Rim {
    /// The places before and after a place along the rim, and how far it is between them.
    fn between(&self, x: f32) -> (usize, usize, f32) {
        let after = self.places.partition_point(|(p, _)| p.x < x);
        let (a, b) = (after.saturating_sub(1), after.min(self.places.len() - 1));
        let width = self.places[b].0.x - self.places[a].0.x;
        let along = if width > 0.0 {
            ((x - self.places[a].0.x) / width).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a, b, along)
    }

    fn height(&self, x: f32) -> f32 {
        let (a, b, along) = self.between(x);
        self.places[a].0.y + along * (self.places[b].0.y - self.places[a].0.y)
    }
}

impl EyeLids {
    /// The lids of both eyes; `None` for one whose rims are not found.
    pub(super) fn of(input: &LidInput<'_>) -> [Option<Self>; 2] {
        let edges = Edges::around(input);
        [0, 1].map(|eye| Self::of_eye(input, &edges, eye))
    }

    fn of_eye(input: &LidInput<'_>, edges: &Edges, eye: usize) -> Option<Self> {
        let ([upper, lower], corners) = EYES[eye];
        let rims = [
            edges.rim(input, upper, corners)?,
            edges.rim(input, lower, corners)?,
        ];
        let at = |v: u32| input.surface.positions[v as usize];
        let places = rims.iter().flat_map(|r| &r.places).map(|(p, _)| *p);
        let shape = input.eyes[eye].clone();
        let shape = shape.or_behind(places, CLEAR * input.height);
        let middle = |point: PointId| input.points.get(point)?.vertex.map(|v| at(v).x);
        let gap = |x: f32| rims[0].height(x) - rims[1].height(x);
        let gaps = [gap(middle(upper)?), gap(middle(lower)?)];
        if gaps.iter().any(|gap| *gap < 1e-3 * input.height) {
            return None;
        }
        let distances = rims.each_ref().map(|rim| {
            let vertices = rim.places.iter().map(|(_, row)| input.vertices[*row]);
            input.graph.distances(&vertices.collect::<Vec<_>>())
        });
        let reach = REACH * input.height;
        let mut near = Vec::new();
        for (row, vertex) in input.vertices.iter().enumerate() {
            let [up, down] = [0, 1].map(|side: usize| distances[side][*vertex as usize]);
            let side = usize::from(down < up);
            let place = at(*vertex);
            let share = smooth(1.0 - up.min(down) / reach);
            if share > 0.0 {
                near.push(NearRim {
                    row,
                    side,
                    x: place.x,
                    share,
                });
            }
        }
        let carried = input.followers.iter().filter_map(|(vertex, row)| {
            let near = near[near.binary_search_by_key(row, |n| n.row).ok()?];
            Some(Carried {
                vertex: *vertex,
                side: near.side,
                by: input.vertices[*row],
                share: near.share,
            })
        });
        let carried = carried.collect();
        let distance = |v: u32| {
            let from = at(v) - shape.centre;
            from.length() / shape.radius(from)
        };
        let part = |(v, row): (u32, usize)| {
            let of_lid = at(v).distance(at(input.vertices[row])) < OF_LID * input.height;
            let [top, bottom] = rims.each_ref().map(|rim| rim.height(at(v).x));
            let part = (top - at(v).y) / (top - bottom);
            let is_near = at(v).z > shape.centre.z && BETWEEN.contains(&distance(v));
            let is_between = is_near && !of_lid && top > bottom && (0.0..1.0).contains(&part);
            is_between.then_some((v, part))
        };
        let between = input.followers.iter().filter_map(|f| part(*f)).collect();
        let followers = input.followers.iter().map(|(v, _)| *v);
        let skin = input.vertices.iter().copied().chain(followers);
        let stays = |v: u32| {
            let radius = shape.radius(at(v) - shape.centre);
            let is_near = (1.0 - TOUCHING..AROUND).contains(&distance(v));
            let away = (distance(v) - 1.0) * radius;
            is_near.then_some((v, away.min(CLEAR * input.height)))
        };
        Some(Self {
            outside: skin.filter_map(stays).collect(),
            carried,
            between,
            shape,
            rims,
            gaps,
            closed: input.closed,
            near,
            clear: [CLEAR, CLEARED].map(|d| d * input.height),
            overlap: OVERLAP * input.height,
        })
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

    /// How far the middles of the lids then go, metres: the one down, the other up.
    pub(super) fn middles(&self, shares: [f32; 2]) -> [f32; 2] {
        [shares[0] * self.gaps[0], shares[1] * self.gaps[1]]
    }

    /// Corrects the displacements of the skin, by row. `lids` is what the handles of the lids alone do
    /// to a row.
    pub(super) fn close(&self, shares: [f32; 2], lids: impl Fn(usize) -> Vec3, moved: &mut [Vec3]) {
        if shares == [0.0; 2] {
            return;
        }
        let rims = [0, 1].map(|side| self.corrections(side, shares, &lids));
        for near in &self.near {
            let (a, b, along) = self.rims[near.side].between(near.x);
            let of_rim = &rims[near.side];
            moved[near.row] += near.share * of_rim[a].lerp(of_rim[b], along);
        }
    }

    /// Moves other parts at the lids: lashes turn with them, and what lies between them goes as far as it is
    /// from one rim to the other; `moved` has a displacement for each vertex of the surface.
    pub(super) fn move_others(&self, shares: [f32; 2], positions: &[Vec3], moved: &mut [Vec3]) {
        let angle = |from: Vec3| from.y.libm_atan2(from.z);
        for carried in &self.carried {
            let root = positions[carried.by as usize];
            let from = root - self.shape.centre;
            let up = angle(from + self.way(carried.side, root, shares)) - angle(from);
            let tip = positions[carried.vertex as usize] - root;
            let turned = Quat::libm_rotation_x(-carried.share * up) * tip;
            moved[carried.vertex as usize] += turned - tip;
        }
        for (vertex, part) in &self.between {
            let v = *vertex as usize;
            let [upper, lower] = [0, 1].map(|side| self.way(side, positions[v], shares));
            moved[v] = upper.lerp(lower, *part);
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

    /// What the places of a rim lack to go their share of the way to the other one.
    fn corrections(
        &self,
        side: usize,
        shares: [f32; 2],
        lids: &impl Fn(usize) -> Vec3,
    ) -> Vec<Vec3> {
        let of = self.rims[side].places.iter();
        of.map(|(place, row)| self.way(side, *place, shares) - lids(*row))
            .collect()
    }

    /// The way of a place that goes with a rim, on a circle about the middle of the eye.
    fn way(&self, side: usize, place: Vec3, shares: [f32; 2]) -> Vec3 {
        let down = [1.0, -1.0][side];
        let closed = shares[0] + shares[1];
        let overlap = match closed > NEARLY {
            true => self.overlap * smooth((closed - NEARLY) / (1.0 - NEARLY)),
            false => 0.0,
        };
        let overlap = overlap * shares[side].max(0.0);
        let gap = self.rims[0].height(place.x) - self.rims[1].height(place.x);
        // Towards the corners the rims touch already.
        let overlap = overlap * smooth(gap / (0.5 * self.gaps[side]));
        let y = -down * (shares[side] * gap.max(0.0) + overlap);
        let from = place - self.shape.centre;
        let circle = (from.y * from.y + from.z * from.z).sqrt();
        let to = (from.y + y).clamp(-0.95 * circle, 0.95 * circle);
        let z = (circle * circle - to * to).sqrt() - from.z;
        Vec3::new(0.0, y, z)
    }
}

/// The edges of the skin around both eyes, and their twins.
struct Edges {
    of: BTreeMap<u32, Vec<(u32, f32)>>,
}

impl Edges {
    fn around(input: &LidInput<'_>) -> Self {
        let at = |v: u32| input.surface.positions[v as usize];
        let joined = &input.points.parts.joined;
        let reach = 0.3 * input.height;
        let mut of: BTreeMap<u32, Vec<(u32, f32)>> = BTreeMap::new();
        for triangle in &input.points.parts.skin {
            let corners = triangle.map(|v| joined[v as usize]);
            // Of either eye: an edge of the one has its twin at the other.
            let is_far =
                |eye: &EyeShape| corners.iter().any(|v| at(*v).distance(eye.centre) > reach);
            if input.eyes.iter().all(is_far) {
                continue;
            }
            for i in 0..3 {
                let edge = (corners[i], corners[(i + 1) % 3]);
                for (a, b) in [Some(edge), input.mirror.edge(edge)].into_iter().flatten() {
                    let length = at(a).distance(at(b));
                    of.entry(a).or_default().push((b, length));
                    of.entry(b).or_default().push((a, length));
                }
            }
        }
        Self { of }
    }

    /// The rim through the handles of a lid, from corner to corner; `None` if they are not connected.
    fn rim(&self, input: &LidInput<'_>, middle: PointId, corners: [PointId; 2]) -> Option<Rim> {
        let at = |v: u32| input.surface.positions[v as usize];
        let handles = input.handles.iter();
        let of_lid = handles.filter(|h| h.what.lid() == Some(middle));
        let mut through: Vec<u32> = of_lid.map(|h| h.vertex).collect();
        for corner in corners {
            through.push(input.points.get(corner)?.vertex?);
        }
        through.sort_by(|a, b| at(*a).x.total_cmp(&at(*b).x));
        through.dedup();
        if through.len() < 3 {
            return None;
        }
        let joined = &input.points.parts.joined;
        let mut path: Vec<u32> = Vec::new();
        for pair in through.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|v| joined[v as usize]);
            path.extend(self.path(from, to)?);
        }
        path.sort_by(|a, b| at(*a).x.total_cmp(&at(*b).x));
        path.dedup();
        let mut places: Vec<(Vec3, usize)> = Vec::new();
        for vertex in path {
            let row = input.vertices.binary_search(&vertex).ok()?;
            let place = at(vertex);
            // The rim is a function of x; a step back would have no place in it.
            if places.last().is_none_or(|(last, _)| place.x > last.x) {
                places.push((place, row));
            }
        }
        (places.len() >= 3).then_some(Rim { places })
    }

    /// The shortest path between two vertices, both included.
    fn path(&self, from: u32, to: u32) -> Option<Vec<u32>> {
        let mut found: BTreeMap<u32, (f32, u32)> = BTreeMap::from([(from, (0.0, from))]);
        let mut open = BinaryHeap::from([Reverse((0_u32, from))]);
        while let Some(Reverse((bits, vertex))) = open.pop() {
            let here = f32::from_bits(bits);
            if vertex == to {
                let mut path = vec![to];
                let mut last = to;
                while last != from {
                    last = found[&last].1;
                    path.push(last);
                }
                return Some(path);
            }
            if here > found[&vertex].0 {
                continue;
            }
            for (next, length) in self.of.get(&vertex).into_iter().flatten() {
                let there = here + length;
                if found.get(next).is_none_or(|(known, _)| there < *known) {
                    found.insert(*next, (there, vertex));
                    open.push(Reverse((there.to_bits(), *next)));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3Swizzles;

    /// An eye of 1 m at the origin: rims along x, 0.5 m apart in the middle.
    fn eye() -> EyeLids {
        let rim = |sign: f32, first: usize| {
            let place = |i: usize| {
                let x = -0.8 + 0.2 * i as f32;
                let y = sign * 0.25 * (1.0 - (x / 0.8).powi(2));
                (Vec3::new(x, y, (1.1 - x * x - y * y).sqrt()), first + i)
            };
            Rim {
                places: (0..9).map(place).collect(),
            }
        };
        let rims = [rim(1.0, 0), rim(-1.0, 9)];
        let near = |side: usize| {
            let places = rims[side].places.iter();
            places.map(move |(p, row)| NearRim {
                row: *row,
                side,
                x: p.x,
                share: 1.0,
            })
        };
        EyeLids {
            shape: EyeShape::new(Vec3::ZERO, std::iter::once(Vec3::Z)),
            gaps: [0.5; 2],
            closed: 0.5,
            carried: Vec::new(),
            between: Vec::new(),
            clear: [0.05, 0.1],
            near: near(0).chain(near(1)).collect(),
            outside: Vec::new(),
            overlap: 0.0,
            rims: rims.clone(),
        }
    }

    /// Places of the rims after closing, where the handles do nothing by themselves.
    fn closed(eye: &EyeLids, shares: [f32; 2]) -> Vec<Vec3> {
        let rest: Vec<Vec3> = eye
            .rims
            .iter()
            .flat_map(|r| &r.places)
            .map(|p| p.0)
            .collect();
        let mut moved = vec![Vec3::ZERO; rest.len()];
        eye.close(shares, |_| Vec3::ZERO, &mut moved);
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
        let rest = eye.rims[0].places[4].0;
        assert!((at[4].y - 0.0).abs() < 1e-6);
        assert!((at[4].yz().length() - rest.yz().length()).abs() < 1e-6);
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
        assert_eq!(eye.middles([1.0, 0.0]), [0.5, 0.0]);
        // Wide open eyes are no matter of this.
        assert_eq!(eye.closing(-0.5, -0.5), [-1.0, -1.0]);
    }

    #[test]
    fn skin_stays_outside_of_the_eyeball() {
        let mut eye = eye();
        eye.outside = vec![(4, 0.05)];
        // What moves the lid into the ball is pushed out to the front.
        let rest: Vec<Vec3> = eye.rims[0].places.iter().map(|p| p.0).collect();
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
        let root = eye.rims[0].places[4].0;
        let rest = [root, root + 0.3 * root.normalize()];
        eye.carried = vec![Carried {
            vertex: 1,
            side: 0,
            by: 0,
            share: 1.0,
        }];
        let way = eye.way(0, root, [1.0, 0.0]);
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
