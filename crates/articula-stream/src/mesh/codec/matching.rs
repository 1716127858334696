//! Matching of the points of a level with those of the coarser level.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (c). A point is matched when it is discovered,
//! by the faces of the coarser level first and by distance second. Half-edge collapse keeps each
//! edge whose ends both survive, so the known neighbours of a point in the finer level are
//! neighbours in the coarser one too, in the same rotational order.

use super::half_edges::{self, NONE, Rings};
use super::mesh::QuantisedMesh;
use super::mixing::{MixedNatural, Weights, decide};
use super::number::Natural;
use crate::range_coder::{Bit, Coder};

/// The coarser level with adjacency, as needed to traverse the finer one.
#[derive(Debug)]
pub(super) struct Coarse<'a> {
    positions: &'a [[i32; 3]],
    faces: Vec<[u32; 3]>,
    wedge_faces: &'a [[u32; 3]],
    rings: Rings,
}

impl<'a> Coarse<'a> {
    /// Indexes a mesh in canonical order.
    pub(super) fn new(mesh: &'a QuantisedMesh) -> Self {
        let faces: Vec<[u32; 3]> = mesh.point_faces().collect();
        let rings = Rings::new(&faces, mesh.points());
        Self {
            positions: &mesh.positions,
            faces,
            wedge_faces: &mesh.faces,
            rings,
        }
    }

    /// Number of known points.
    pub(super) fn points(&self) -> usize {
        self.positions.len()
    }

    /// Wedges at both ends of an edge, in the face on its left.
    pub(super) fn wedges(&self, from: u32, to: u32) -> Option<[u32; 2]> {
        if from as usize >= self.points() || to as usize >= self.points() {
            return None;
        }
        let half_edge = self.rings.find(&self.faces, from, to)?;
        let start = half_edges::start(self.wedge_faces, half_edge);
        Some([start, half_edges::end(self.wedge_faces, half_edge)])
    }

    /// The point that follows `neighbour` counter-clockwise around `about`.
    fn after(&self, about: u32, neighbour: u32) -> Option<u32> {
        let half_edge = self.rings.find(&self.faces, about, neighbour)?;
        Some(half_edges::apex(&self.faces, half_edge))
    }

    /// The point that precedes `neighbour` counter-clockwise around `about`.
    fn before(&self, about: u32, neighbour: u32) -> Option<u32> {
        let half_edge = self.rings.find(&self.faces, neighbour, about)?;
        Some(half_edges::apex(&self.faces, half_edge))
    }
}

/// Maximum number of known points collected near a gate.
pub(super) const SEEDS: usize = 6;

/// Surroundings of a gate: the edge a-b of a visited face; the face to be coded lies beyond it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gate {
    pub(super) a: u32,
    pub(super) b: u32,
    /// Third corner of the visited face, or [`NONE`].
    pub(super) o: u32,
    /// Known points nearby, used if neither end is known.
    pub(super) seeds: [u32; SEEDS],
    /// The last known neighbour of `b` before the gate, with the number of steps to it; likewise
    /// the first known neighbour of `a` after the gate.
    pub(super) about_b: Option<(u32, u8)>,
    pub(super) about_a: Option<(u32, u8)>,
}

/// Prediction for the face beyond a gate from the coarser level; contexts below [`Hint::COUNT`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Hint {
    /// 0 to 3: which of b (2) and a (1) are known.
    pub(super) known: usize,
    /// 0: no candidate, 1: a free one, 2: the next corner of the loop, 3: the previous one, 4:
    /// another visited one.
    pub(super) candidate: usize,
}

impl Hint {
    pub(super) const COUNT: usize = 20;

    pub(super) fn context(self) -> usize {
        self.known * 5 + self.candidate
    }
}

/// Matches found so far, and models.
#[derive(Debug)]
pub(super) struct Matching<'a> {
    pub(super) coarse: &'a Coarse<'a>,
    taken: Vec<bool>,
    left: usize,
    lowest: u32,
    /// Predicted positions of new points, used until they are coded.
    guesses: Vec<[i32; 3]>,
    marks: Vec<u32>,
    mark: u32,
    models: Models,
}

#[derive(Debug)]
struct Models {
    is_known: [Vec<Bit>; 3],
    is_known_weights: Vec<Weights<3>>,
    is_in_ring: Vec<Bit>,
    ring_rank: MixedNatural<2>,
    is_near: Bit,
    near_rank: Natural,
    last: usize,
}

/// Maximum number of steps around a point of the coarser level.
const RING_REACH: usize = 12;
/// Maximum number of neighbours examined per point.
const RING_SCAN: usize = 64;
/// Maximum number of points expanded in the search by distance.
const NEAR_REACH: usize = 64;

impl<'a> Matching<'a> {
    pub(super) fn new(coarse: &'a Coarse<'a>) -> Self {
        Self {
            coarse,
            taken: vec![false; coarse.points()],
            left: coarse.points(),
            lowest: 0,
            guesses: Vec::new(),
            marks: vec![0; coarse.points()],
            mark: 0,
            models: Models {
                is_known: [
                    vec![Bit::default(); Hint::COUNT * 16],
                    vec![Bit::default(); Hint::COUNT * 16],
                    vec![Bit::default(); Hint::COUNT * 27],
                ],
                is_known_weights: vec![Weights::default(); Hint::COUNT],
                is_in_ring: vec![Bit::default(); 4],
                ring_rank: MixedNatural::new([Hint::COUNT, 16 * 16]),
                is_near: Bit::default(),
                near_rank: Natural::default(),
                last: 0,
            },
        }
    }

    /// Returns whether an id belongs to the coarser level.
    pub(super) fn is_known(&self, point: u32) -> bool {
        (point as usize) < self.taken.len()
    }

    /// Returns whether a point has been visited; new points always have.
    pub(super) fn is_visited(&self, point: u32) -> bool {
        self.taken.get(point as usize).copied().unwrap_or(true)
    }

    /// The unvisited known point of the lowest id.
    pub(super) fn lowest(&mut self) -> Option<u32> {
        while self.taken.get(self.lowest as usize) == Some(&true) {
            self.lowest += 1;
        }
        ((self.lowest as usize) < self.taken.len()).then_some(self.lowest)
    }

    /// Number of known and new points so far.
    pub(super) fn points(&self) -> usize {
        self.taken.len() + self.guesses.len()
    }

    fn take(&mut self, point: u32) {
        self.taken[point as usize] = true;
        self.left -= 1;
    }

    fn place(&self, point: u32) -> [i32; 3] {
        let known = self.coarse.positions.get(point as usize);
        *known.unwrap_or_else(|| &self.guesses[point as usize - self.taken.len()])
    }

    /// Predicted position of the corner beyond a gate, by the parallelogram rule.
    fn guess(&self, gate: &Gate) -> [i32; 3] {
        let (a, b) = (self.place(gate.a), self.place(gate.b));
        if gate.o == NONE {
            return a;
        }
        let o = self.place(gate.o);
        std::array::from_fn(|i| a[i] + b[i] - o[i]).map(|x: i32| x.clamp(-(1 << 24), 1 << 24))
    }

    /// Predicts the face beyond a gate; `next` and `previous` are the adjacent corners of the loop.
    pub(super) fn hint(&self, gate: &Gate, next: u32, previous: u32) -> Hint {
        let (coarse, known) = (self.coarse, |p| self.is_known(p));
        let after = |about, (neighbour, _)| coarse.after(about, neighbour);
        let before = |about, (neighbour, _)| coarse.before(about, neighbour);
        let candidate = if known(gate.b) {
            gate.about_b.and_then(|n| after(gate.b, n))
        } else {
            gate.about_a.and_then(|n| before(gate.a, n))
        };
        let candidate = match candidate {
            None => 0,
            Some(c) if !self.taken[c as usize] => 1,
            Some(c) if c == next => 2,
            Some(c) if c == previous => 3,
            Some(_) => 4,
        };
        Hint {
            known: usize::from(known(gate.b)) * 2 + usize::from(known(gate.a)),
            candidate,
        }
    }

    /// Codes the id of a point discovered beyond a gate; `wanted` is a known id or [`NONE`].
    /// Returns `None` if the decoded id is not a free point.
    pub(super) fn code(
        &mut self,
        coder: &mut impl Coder,
        gate: &Gate,
        hint: Hint,
        valences: [u8; 2],
        wanted: u32,
    ) -> Option<u32> {
        let is_known = self.left > 0 && {
            let context = hint.context();
            let gap = |about: Option<(u32, u8)>| about.map_or(3, |n| usize::from(n.1).min(2));
            let gaps = gap(gate.about_a) * 4 + gap(gate.about_b);
            let valence = usize::from(valences[0].min(8)) * 3 + usize::from(valences[1].min(2));
            let models = &mut self.models;
            let [x, y, z] = &mut models.is_known;
            let bits = [
                &mut x[context * 16 + (models.last & 15)],
                &mut y[context * 16 + gaps],
                &mut z[context * 27 + valence],
            ];
            let weights = &mut models.is_known_weights[context];
            decide(coder, bits, weights, wanted != NONE)
        };
        self.models.last = self.models.last << 1 | usize::from(is_known);
        if !is_known {
            let id = self.points() as u32;
            self.guesses.push(self.guess(gate));
            return Some(id);
        }
        let found = self.code_known(coder, gate, hint, wanted)?;
        if self.taken[found as usize] {
            return None;
        }
        self.take(found);
        Some(found)
    }

    fn code_known(
        &mut self,
        coder: &mut impl Coder,
        gate: &Gate,
        hint: Hint,
        wanted: u32,
    ) -> Option<u32> {
        let ring = self.ring_candidates(gate);
        let rank = |list: &[u32]| list.iter().position(|&c| c == wanted);
        if !ring.is_empty() {
            let rank = rank(&ring);
            let models = &mut self.models;
            let is_in_ring = &mut models.is_in_ring[hint.known];
            if coder.bit(is_in_ring, rank.is_some()) {
                if ring.len() == 1 {
                    return Some(ring[0]);
                }
                let gap = |about: Option<(u32, u8)>| about.map_or(3, |n| usize::from(n.1).min(2));
                let gaps = gap(gate.about_a) * 4 + gap(gate.about_b);
                let contexts = [hint.context(), gaps * 16 + ring.len().min(15)];
                let rank = rank.unwrap_or(0) as u32;
                let rank = models.ring_rank.code(coder, contexts, rank);
                return ring.get(rank as usize).copied();
            }
        }
        let near = self.near_candidates(gate);
        let rank = rank(&near);
        if !near.is_empty() && coder.bit(&mut self.models.is_near, rank.is_some()) {
            let rank = rank.unwrap_or(0) as u32;
            let rank = self.models.near_rank.code(coder, rank);
            return near.get(rank as usize).copied();
        }
        self.code_raw(coder, wanted)
    }

    fn code_raw(&self, coder: &mut impl Coder, wanted: u32) -> Option<u32> {
        let count = self.taken.len() as u32;
        let id = coder.raw(32 - count.leading_zeros(), wanted);
        (id < count).then_some(id)
    }

    /// Codes the first point of a component.
    pub(super) fn code_first(
        &mut self,
        coder: &mut impl Coder,
        models: &mut [Bit; 2],
        wanted: u32,
    ) -> Option<u32> {
        if self.left == 0 || !coder.bit(&mut models[0], wanted != NONE) {
            let id = self.points() as u32;
            // No prediction is possible; any position will do.
            self.guesses.push([0; 3]);
            return Some(id);
        }
        let lowest = self.lowest()?;
        let found = if coder.bit(&mut models[1], wanted == lowest) {
            lowest
        } else {
            self.code_raw(coder, wanted)?
        };
        if self.taken[found as usize] {
            return None;
        }
        self.take(found);
        Some(found)
    }

    /// Free points around the ends of a gate, the most likely first: those that follow the last
    /// known neighbour of `b`, and those that precede the first one of `a`.
    fn ring_candidates(&self, gate: &Gate) -> Vec<u32> {
        let walk = |about: u32, first: Option<(u32, u8)>, is_forward: bool| {
            let mut found = Vec::new();
            let mut at = first.map(|n| n.0);
            while let Some(neighbour) = at
                && found.len() < RING_REACH
            {
                at = if is_forward {
                    self.coarse.after(about, neighbour)
                } else {
                    self.coarse.before(about, neighbour)
                };
                at = at.filter(|&c| !self.taken[c as usize] && !found.contains(&c));
                found.extend(at);
            }
            found
        };
        let ring = |about: u32, walked: &[u32]| -> Vec<u32> {
            let half_edges = self.coarse.rings.leaving(about).iter().take(RING_SCAN);
            half_edges
                .map(|&h| half_edges::end(&self.coarse.faces, h))
                .filter(|&c| !self.taken[c as usize] && !walked.contains(&c))
                .take(RING_REACH)
                .collect()
        };
        let list = |point: u32, first, is_forward| {
            let mut found = Vec::new();
            if self.is_known(point) {
                found = walk(point, first, is_forward);
                let rest = ring(point, &found);
                found.extend(rest);
            }
            found
        };
        let b = list(gate.b, gate.about_b, true);
        let a = list(gate.a, gate.about_a, false);
        let place = |list: &[u32], c: u32| list.iter().position(|&x| x == c);
        let mut ranked: Vec<(usize, u32)> = Vec::with_capacity(a.len() + b.len());
        for (i, &c) in b.iter().enumerate() {
            ranked.push((i + place(&a, c).unwrap_or(RING_REACH * 3), c));
        }
        for (i, &c) in a.iter().enumerate() {
            if place(&b, c).is_none() {
                ranked.push((i + RING_REACH * 3, c));
            }
        }
        // The sort is stable: b before a.
        ranked.sort_by_key(|r| r.0);
        ranked.into_iter().map(|r| r.1).collect()
    }

    /// Free points nearby, sorted by distance from the parallelogram's prediction.
    fn near_candidates(&mut self, gate: &Gate) -> Vec<u32> {
        self.mark += 1;
        let mut seen: Vec<u32> = Vec::new();
        let anchors = [gate.about_b, gate.about_a].map(|n| n.map_or(NONE, |n| n.0));
        for point in anchors
            .into_iter()
            .chain([gate.a, gate.b, gate.o])
            .chain(gate.seeds)
        {
            if self.is_known(point) && self.marks[point as usize] != self.mark {
                self.marks[point as usize] = self.mark;
                seen.push(point);
            }
        }
        let guess = self.guess(gate);
        let mut free: Vec<(i64, u32)> = Vec::new();
        let mut at = 0;
        while at < seen.len() && at < NEAR_REACH {
            let leaving = self.coarse.rings.leaving(seen[at]);
            at += 1;
            for &h in leaving.iter().take(2 * RING_REACH) {
                let point = half_edges::end(&self.coarse.faces, h);
                if self.marks[point as usize] == self.mark {
                    continue;
                }
                self.marks[point as usize] = self.mark;
                seen.push(point);
                if !self.taken[point as usize] {
                    free.push((
                        distance2(self.coarse.positions[point as usize], guess),
                        point,
                    ));
                }
            }
        }
        free.sort_unstable();
        free.into_iter().map(|f| f.1).collect()
    }
}

fn distance2(p: [i32; 3], q: [i32; 3]) -> i64 {
    (0..3).map(|i| i64::from(p[i] - q[i]).pow(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::Encoder;

    #[test]
    fn nothing_is_asked_once_all_points_are_taken() {
        let mesh = QuantisedMesh {
            positions: vec![[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            ..QuantisedMesh::default()
        };
        let coarse = Coarse::new(&mesh);
        let mut matching = Matching::new(&coarse);
        for (taken, lowest) in [(0, Some(1)), (2, Some(1)), (1, None)] {
            assert!(!matching.is_visited(taken));
            matching.take(taken);
            assert!(matching.is_visited(taken));
            assert_eq!(matching.lowest(), lowest);
        }
        let mut models = [Bit::default(); 2];
        let found = matching.code_first(&mut Encoder::new(), &mut models, NONE);
        assert_eq!(found, Some(3), "a new point after the three known ones");
        assert_eq!(models[0].seen(), Bit::default().seen());
        assert_eq!(matching.points(), 4);
    }
}
