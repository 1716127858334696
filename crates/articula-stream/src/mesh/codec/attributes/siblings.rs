//! Wedges of the same point, and values that they share.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (e). A seam of one kind of value is rarely one
//! of another; the best evidence is the wedges at the other end of the edges between two
//! siblings.

use super::super::mixing::{Weights, decide};
use super::ring::Ring;
use crate::range_coder::{Bit, Coder};

/// Maximum number of siblings tried.
const MOST: usize = 8;

/// The wedges of each point.
#[derive(Debug)]
pub(super) struct Siblings<'a> {
    wedge_points: &'a [u32],
    starts: Vec<u32>,
    wedges: Vec<u32>,
}

impl<'a> Siblings<'a> {
    pub(super) fn new(points: usize, wedge_points: &'a [u32]) -> Self {
        let mut starts = vec![0u32; points + 1];
        for &p in wedge_points {
            starts[p as usize + 1] += 1;
        }
        for p in 0..points {
            starts[p + 1] += starts[p];
        }
        let mut next = starts.clone();
        let mut wedges = vec![0; wedge_points.len()];
        for (w, &p) in wedge_points.iter().enumerate() {
            wedges[next[p as usize] as usize] = w as u32;
            next[p as usize] += 1;
        }
        Self {
            wedge_points,
            starts,
            wedges,
        }
    }

    /// Point of a wedge.
    pub(super) fn point(&self, w: u32) -> u32 {
        self.wedge_points[w as usize]
    }

    /// All wedges of a wedge's point.
    pub(super) fn all(&self, w: u32) -> &[u32] {
        let p = self.wedge_points[w as usize] as usize;
        &self.wedges[self.starts[p] as usize..self.starts[p + 1] as usize]
    }

    /// The wedges of a point with ids below `end`.
    pub(super) fn at(&self, p: u32, end: u32) -> impl Iterator<Item = u32> + '_ {
        let p = p as usize;
        let all = &self.wedges[self.starts[p] as usize..self.starts[p + 1] as usize];
        all.iter().copied().take(MOST).take_while(move |w| *w < end)
    }

    /// The siblings with lower ids, latest first.
    pub(super) fn known(&self, w: u32) -> impl Iterator<Item = u32> + '_ {
        let all = self.all(w);
        let count = all.partition_point(|s| *s < w);
        all[..count].iter().rev().take(MOST).copied()
    }
}

/// Model of equality with a sibling, for one kind of value.
#[derive(Debug, Default)]
pub(super) struct SameValue {
    by_ends: [[Bit; 4]; 16],
    by_rank: [[Bit; 4]; 16],
    weights: Weights<2>,
}

impl SameValue {
    /// Codes whether a wedge has the value of a sibling, and which; each distinct value is tried
    /// once. `before` returns in which earlier kinds two wedges agree.
    pub(super) fn code<V: PartialEq + Copy>(
        &mut self,
        coder: &mut impl Coder,
        (ring, siblings): (&Ring, &Siblings<'_>),
        (values, w): (&[V], u32),
        before: impl Fn(u32, u32) -> usize,
    ) -> Option<V> {
        let mut asked: Vec<V> = Vec::with_capacity(MOST);
        let mut near = Vec::new();
        let mut beside = Vec::new();
        for sibling in siblings.known(w) {
            let value = values[sibling as usize];
            if asked.contains(&value) {
                continue;
            }
            if asked.is_empty() {
                ring.known(w, &mut near);
            }
            ring.known_below(sibling, w, &mut beside);
            let mut ends = 0;
            for &u in &near {
                let at = siblings.point(u);
                for &other in beside.iter().filter(|o| siblings.point(**o) == at) {
                    let is_same = values[u as usize] == values[other as usize];
                    // One wedge at the other end is weaker evidence than two that agree or differ.
                    let found = match (u == other, is_same) {
                        (true, _) => 1,
                        (_, true) => 2,
                        _ => 3,
                    };
                    ends = ends.max(found);
                }
            }
            let before = before(w, sibling);
            let rank = asked.len().min(3);
            let models = [
                &mut self.by_ends[before][ends],
                &mut self.by_rank[before][rank],
            ];
            let is_same = value == values[w as usize];
            if decide(coder, models, &mut self.weights, is_same) {
                return Some(value);
            }
            asked.push(value);
        }
        None
    }
}

/// Maximum number of surrounding values tried: of neighbours, and of other wedges of their points.
const MAX_AROUND: usize = 2;
/// Maximum number of wedges examined at neighbouring points.
const MAX_NEARBY: usize = 48;

/// Model of equality with a surrounding value, as on flat faces.
#[derive(Debug)]
pub(super) struct SameAround {
    by_votes: [[[Bit; 4]; 4]; 2 * MAX_AROUND],
    by_history: Vec<[Bit; 2]>,
    weights: Weights<2>,
    history: usize,
}

impl Default for SameAround {
    fn default() -> Self {
        Self {
            by_votes: Default::default(),
            by_history: vec![[Bit::default(); 2]; 16 * 16],
            weights: Weights::default(),
            history: 0,
        }
    }
}

impl SameAround {
    /// Codes whether a wedge without an equal sibling has the value of a neighbour (most frequent
    /// first) or of another wedge at a neighbour's point (smallest `far` first), and which.
    pub(super) fn code<V: PartialEq + Copy>(
        &mut self,
        coder: &mut impl Coder,
        (wedges, points, siblings): (&Ring, &Ring, &Siblings<'_>),
        (values, w): (&[V], u32),
        far: impl Fn(u32) -> u64,
    ) -> Option<V> {
        let mut near = Vec::new();
        wedges.known(w, &mut near);
        let is_asked = |v: &V| siblings.known(w).any(|s| values[s as usize] == *v);
        let mut votes: Vec<(V, usize)> = Vec::with_capacity(near.len());
        for u in &near {
            let value = values[*u as usize];
            match votes.iter_mut().find(|v| v.0 == value) {
                Some(found) => found.1 += 1,
                None if !is_asked(&value) => votes.push((value, 1)),
                None => (),
            }
        }
        votes.sort_by_key(|v| std::cmp::Reverse(v.1));
        let faces = wedges.edges(w).take(4).count() - 1;
        for (rank, (value, count)) in votes.iter().take(MAX_AROUND).enumerate() {
            let is_all = usize::from(*count == near.len());
            let given = *value == values[w as usize];
            if self.ask(coder, (rank, faces, (*count).min(3), is_all), given) {
                return Some(*value);
            }
        }
        votes.truncate(MAX_AROUND);
        let around = points.edges(siblings.point(w)).flatten();
        let all = around.flat_map(|p| siblings.at(p, w)).take(MAX_NEARBY);
        let mut nearby: Vec<(u64, u32)> = all.map(|u| (far(u), u)).collect();
        nearby.sort_unstable();
        let mut rank = MAX_AROUND;
        for (_, u) in nearby {
            let value = values[u as usize];
            if rank == 2 * MAX_AROUND {
                break;
            }
            if is_asked(&value) || votes.iter().any(|v| v.0 == value) {
                continue;
            }
            let given = value == values[w as usize];
            if self.ask(coder, (rank, faces, votes.len(), 0), given) {
                return Some(value);
            }
            votes.push((value, 0));
            rank += 1;
        }
        None
    }

    fn ask(
        &mut self,
        coder: &mut impl Coder,
        (rank, faces, count, is_all): (usize, usize, usize, usize),
        given: bool,
    ) -> bool {
        let models = [
            &mut self.by_votes[rank][count.min(3)][faces],
            &mut self.by_history[(self.history & 15) | (rank << 6) | (faces << 4)][is_all],
        ];
        let is_same = decide(coder, models, &mut self.weights, given);
        self.history = (self.history << 1) | usize::from(is_same);
        is_same
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::Encoder;

    #[test]
    fn siblings_are_the_wedges_of_a_point() {
        let points = [0, 1, 0, 2, 1, 0];
        let siblings = Siblings::new(3, &points);
        assert_eq!(siblings.all(2), [0, 2, 5]);
        assert_eq!(siblings.all(1), [1, 4]);
        assert_eq!(siblings.all(3), [3]);
        assert_eq!(siblings.known(5).collect::<Vec<_>>(), [2, 0]);
        assert_eq!(siblings.known(0).count(), 0);
        assert_eq!(siblings.at(0, 5).collect::<Vec<_>>(), [0, 2]);
        assert_eq!(siblings.at(1, 9).collect::<Vec<_>>(), [1, 4]);
    }

    #[test]
    fn the_latest_eight_siblings_are_tried() {
        let siblings = Siblings::new(1, &[0; 10]);
        let known: Vec<u32> = siblings.known(9).collect();
        assert_eq!(known, [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(siblings.at(0, 10).count(), 8);
    }

    /// Index of the evidence in which the equality of wedge `w` with its only sibling is coded.
    fn evidence(points: &[u32], faces: &[[u32; 3]], values: &[i32], w: u32) -> Vec<usize> {
        let ring = Ring::new(points.len(), faces.to_vec());
        let siblings = Siblings::new(points.len(), points);
        let mut same = SameValue::default();
        let place = (&ring, &siblings);
        same.code(&mut Encoder::new(), place, (values, w), |_, _| 0);
        let unused = Bit::default().seen();
        (0..4)
            .filter(|e| same.by_ends[0][*e].seen() != unused)
            .collect()
    }

    #[test]
    fn evidence_is_what_the_other_end_shows() {
        // Two faces over the edge from point 0 to point 2; a seam splits point 0, then both ends.
        let one_end = ([0, 1, 2, 0, 3], [[0, 1, 2], [3, 2, 4]]);
        assert_eq!(evidence(&one_end.0, &one_end.1, &[7; 5], 3), [1]);
        let both_ends = ([0, 1, 2, 2, 0, 3], [[0, 1, 2], [4, 3, 5]]);
        assert_eq!(evidence(&both_ends.0, &both_ends.1, &[7; 6], 4), [2]);
        let differ = [7, 7, 7, 8, 7, 7];
        assert_eq!(evidence(&both_ends.0, &both_ends.1, &differ, 4), [3]);
        let apart = ([0, 1, 2, 0, 3, 4], [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(evidence(&apart.0, &apart.1, &[7; 6], 3), [0]);
    }
}
