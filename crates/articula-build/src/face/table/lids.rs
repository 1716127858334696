//! Lids that close: the rims of an eye meet along their whole length, and stay in front of the eyeball.
//!
//! A few handles move the skin of a lid. Between them its rim would come close to the other one, but a
//! thin line of the eye would stay open. Here every place of a rim goes its own share of the way to the
//! other rim, on a circle about the middle of the eye.

use super::super::points::{FacePoints, FaceSurface};
use super::graph::{SurfaceGraph, smooth};
use super::handles::{Handle, HandleKind};
use articula_core::feature_points::PointId;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Distance from a rim, along the skin, over which its correction fades, by height of the face.
const REACH: f32 = 0.06;
/// How far closed rims overlap, by height of the face: 0.2 mm on an average one.
const OVERLAP: f32 = 1.5e-3;
/// Share of the way to the other rim from which the overlap grows.
const NEARLY: f32 = 0.9;
/// Distance of lids from the eyeball, by height of the face: 0.2 mm on an average one.
const CLEAR: f32 = 1.5e-3;
/// Skin up to this distance from the centre of an eye, by its radius, stays outside of it.
const AROUND: f32 = 1.6;

/// Middles of the upper and of the lower lid, and the corners, of the left and the right eye.
const EYES: [([PointId; 2], [PointId; 2]); 2] = [
    ([(3, 1), (3, 3)], [(3, 7), (3, 11)]),
    ([(3, 2), (3, 4)], [(3, 8), (3, 12)]),
];

/// An eye with its lids.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EyeLids {
    pub(super) centre: Vec3,
    pub(super) radius: f32,
    /// Upper and lower rim.
    rims: [Rim; 2],
    /// Height of the opening at rest at the middles of the upper and the lower lid, metres.
    gaps: [f32; 2],
    near: Vec<NearRim>,
    /// Vertices of the skin, and of what follows it, that must stay outside of the eyeball, and how far
    /// from the centre.
    outside: Vec<(u32, f32)>,
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

/// What lids are found by.
pub(super) struct LidInput<'a> {
    pub(super) surface: &'a FaceSurface,
    pub(super) points: &'a FacePoints,
    pub(super) handles: &'a [Handle],
    pub(super) graph: &'a SurfaceGraph,
    /// Vertices of the skin, ascending.
    pub(super) vertices: &'a [u32],
    /// Vertices of other parts that follow the skin.
    pub(super) followers: &'a [u32],
    pub(super) height: f32,
    /// Centres of the eyes.
    pub(super) eyes: [Vec3; 2],
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
        [0, 1].map(|eye| Self::of_eye(input, eye))
    }

    fn of_eye(input: &LidInput<'_>, eye: usize) -> Option<Self> {
        let ([upper, lower], corners) = EYES[eye];
        let edges = Edges::around(input, eye);
        let rims = [
            edges.rim(input, upper, corners)?,
            edges.rim(input, lower, corners)?,
        ];
        let at = |v: u32| input.surface.positions[v as usize];
        let centre = input.eyes[eye];
        let places = || rims.iter().flat_map(|r| &r.places).map(|(p, _)| *p);
        let nearest = places()
            .map(|p| p.distance(centre))
            .fold(f32::INFINITY, f32::min);
        let ball = input.points.parts.eyeballs.as_ref();
        let radius = ball.map_or(nearest - CLEAR * input.height, |balls| {
            let (vertices, _) = &balls[eye];
            let sum: f32 = vertices.iter().map(|v| at(*v).distance(centre)).sum();
            sum / vertices.len().max(1) as f32
        });
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
        let clear = radius + CLEAR * input.height;
        let stays = |place: Vec3| {
            let from = place.distance(centre);
            (from > radius && from < AROUND * radius).then_some(from.min(clear))
        };
        let skin = input.vertices.iter().chain(input.followers);
        let outside = skin.filter_map(|v| Some((*v, stays(at(*v))?)));
        Some(Self {
            centre,
            radius,
            rims,
            gaps,
            near,
            outside: outside.collect(),
            overlap: OVERLAP * input.height,
        })
    }

    /// Shares of the opening by which the upper and the lower lid close it, together 1 at most, for how
    /// far the middle of the one goes down and of the other up, metres.
    pub(super) fn closing(&self, down: f32, up: f32) -> [f32; 2] {
        let shares = [down / self.gaps[0], up / self.gaps[1]];
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

    /// Pushes what is displaced into the eyeball out of it, along its radius; `moved` has a
    /// displacement for each vertex of the surface.
    pub(super) fn push_out(&self, positions: &[Vec3], moved: &mut [Vec3]) {
        for (vertex, least) in &self.outside {
            let v = *vertex as usize;
            let from = positions[v] + moved[v] - self.centre;
            let distance = from.length();
            if moved[v] != Vec3::ZERO && distance < *least && distance > 0.0 {
                moved[v] += from * (least / distance - 1.0);
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
        let down = [1.0, -1.0][side];
        let closed = shares[0] + shares[1];
        let overlap = match closed > NEARLY {
            true => self.overlap * smooth((closed - NEARLY) / (1.0 - NEARLY)),
            false => 0.0,
        };
        let overlap = overlap * shares[side].max(0.0);
        let of = self.rims[side].places.iter();
        of.map(|(place, row)| {
            let gap = self.rims[0].height(place.x) - self.rims[1].height(place.x);
            // Towards the corners the rims touch already.
            let overlap = overlap * smooth(gap / (0.5 * self.gaps[side]));
            let y = -down * (shares[side] * gap.max(0.0) + overlap);
            let from = *place - self.centre;
            let circle = (from.y * from.y + from.z * from.z).sqrt();
            let to = (from.y + y).clamp(-0.95 * circle, 0.95 * circle);
            let z = (circle * circle - to * to).sqrt() - from.z;
            Vec3::new(0.0, y, z) - lids(*row)
        })
        .collect()
    }
}

/// The edges of the skin around an eye.
struct Edges {
    of: BTreeMap<u32, Vec<(u32, f32)>>,
}

impl Edges {
    fn around(input: &LidInput<'_>, eye: usize) -> Self {
        let at = |v: u32| input.surface.positions[v as usize];
        let joined = &input.points.parts.joined;
        let reach = 0.3 * input.height;
        let mut of: BTreeMap<u32, Vec<(u32, f32)>> = BTreeMap::new();
        for triangle in &input.points.parts.skin {
            let corners = triangle.map(|v| joined[v as usize]);
            if corners
                .iter()
                .any(|v| at(*v).distance(input.eyes[eye]) > reach)
            {
                continue;
            }
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                let length = at(a).distance(at(b));
                of.entry(a).or_default().push((b, length));
                of.entry(b).or_default().push((a, length));
            }
        }
        Self { of }
    }

    /// The rim through the handles of a lid, from corner to corner; `None` if they are not connected.
    fn rim(&self, input: &LidInput<'_>, middle: PointId, corners: [PointId; 2]) -> Option<Rim> {
        let at = |v: u32| input.surface.positions[v as usize];
        let of_lid = input.handles.iter().filter(|h| match h.what {
            HandleKind::Moving(p) | HandleKind::Rim(p, _) => p == middle,
            HandleKind::Resting => false,
        });
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
            centre: Vec3::ZERO,
            radius: 1.0,
            gaps: [0.5; 2],
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
        eye.outside = vec![(4, 1.05)];
        // What moves the lid into the ball is pushed out along the radius.
        let rest: Vec<Vec3> = eye.rims[0].places.iter().map(|p| p.0).collect();
        let mut moved = vec![Vec3::ZERO; 9];
        moved[4] = -0.6 * Vec3::Z;
        moved[3] = -0.6 * Vec3::Z;
        eye.push_out(&rest, &mut moved);
        assert_eq!(moved[3], -0.6 * Vec3::Z);
        assert!(((rest[4] + moved[4]).length() - 1.05).abs() < 1e-5);
    }
}
