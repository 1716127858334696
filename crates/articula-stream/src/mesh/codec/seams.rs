//! Seams: edges at which adjacent faces have different wedges, and the wedges of all corners.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (a). Corners that no seam separates form a
//! sector; a sector has a known wedge of its point, the wedge of another sector, or a new one.

use super::connectivity::Fault;
use super::half_edges::{self, NONE};
use super::matching::Coarse;
use super::mesh::QuantisedMesh;
use super::mixing::{Weights, decide};
use crate::range_coder::{Bit, Coder};

/// Wedges of a level by corner.
#[derive(Debug, Default)]
pub(super) struct Wedges {
    pub(super) faces: Vec<[u32; 3]>,
    /// Point of each new wedge; new wedges have the ids after the known ones.
    pub(super) new_points: Vec<u32>,
}

/// Models of seams and sectors.
struct Models {
    is_seam: [Vec<Bit>; 3],
    is_seam_weights: [Weights<3>; 9],
    parts_end: Vec<Bit>,
    is_known: Vec<Bit>,
    is_this: Vec<Bit>,
    is_used: Vec<Bit>,
}

impl Models {
    fn new() -> Self {
        let bits = |count| vec![Bit::default(); count];
        Self {
            is_seam: [bits(16 * 9), bits(256 * 9), bits(4096)],
            is_seam_weights: Default::default(),
            parts_end: bits(512 * 9),
            is_known: bits(64),
            is_this: bits(256),
            is_used: bits(64),
        }
    }
}

/// Seams and sectors of one level.
struct Seams<'a> {
    faces: &'a [[u32; 3]],
    twins: Vec<u32>,
    /// The known wedges of each known point.
    known: &'a Known,
    /// Known wedge of each corner as predicted from the coarser level's edges, or [`NONE`].
    expected: Vec<u32>,
    /// Number of seams coded so far at each point.
    seen: Vec<u8>,
    sectors: Sectors,
}

/// The wedges of each point of the coarser level, in canonical order.
#[derive(Debug)]
pub(super) struct Known {
    first: Vec<u32>,
    total: usize,
}

impl Known {
    /// Indexes a mesh in canonical order, whose wedges are sorted by point.
    pub(super) fn new(mesh: &QuantisedMesh) -> Self {
        let mut first = vec![0; mesh.points() + 1];
        for &point in &mesh.wedge_points {
            first[point as usize + 1] += 1;
        }
        for i in 0..mesh.points() {
            first[i + 1] += first[i];
        }
        Self {
            first,
            total: mesh.wedges(),
        }
    }

    /// The known wedges of a point.
    fn of(&self, point: u32) -> std::ops::Range<u32> {
        match self.first.get(point as usize + 1) {
            Some(&end) => self.first[point as usize]..end,
            None => 0..0,
        }
    }

    /// Number of known wedges of a point, up to 3; 0 for a new point.
    fn class(&self, point: u32) -> usize {
        self.of(point).len().min(3)
    }
}

/// Disjoint sets of corners with the same wedge.
#[derive(Debug)]
struct Sectors {
    parents: Vec<u32>,
}

impl Sectors {
    fn root(&mut self, corner: u32) -> u32 {
        let mut at = corner as usize;
        while self.parents[at] as usize != at {
            self.parents[at] = self.parents[self.parents[at] as usize];
            at = self.parents[at] as usize;
        }
        at as u32
    }

    /// Joins two sets; the lower corner stays the root.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

/// Maximum number of wedges of a point that are distinguished by one decision each.
const FEW: usize = 16;

/// The new wedges of each point.
struct New {
    points: Vec<u32>,
    /// For each new wedge the previous one at the same point, [`NONE`] for the first.
    older: Vec<u32>,
    latest: Vec<u32>,
}

impl New {
    fn at(points: usize) -> Self {
        Self {
            points: Vec::new(),
            older: Vec::new(),
            latest: vec![NONE; points],
        }
    }

    fn add(&mut self, point: u32) -> u32 {
        let id = self.points.len() as u32;
        self.points.push(point);
        self.older.push(self.latest[point as usize]);
        self.latest[point as usize] = id;
        id
    }

    /// Codes whether a sector has the wedge of another sector at its point, and which; `wanted` is
    /// that wedge, [`NONE`] for a new one.
    fn code_again(
        &self,
        coder: &mut impl Coder,
        model: &mut Bit,
        point: u32,
        wanted: u32,
    ) -> Result<Option<u32>, Fault> {
        let mut at = self.latest[point as usize];
        for _ in 0..FEW {
            if at == NONE {
                return Ok(None);
            }
            if coder.bit(model, at == wanted) {
                return Ok(Some(at));
            }
            at = self.older[at as usize];
        }
        // Too many for one decision each: coded by number; the next number is a new wedge.
        let count = self.points.len() as u32;
        let id = coder.raw(32 - count.leading_zeros(), wanted.min(count));
        if id == count {
            return Ok(None);
        }
        let is_of_point = self.points.get(id as usize) == Some(&point);
        let found = is_of_point.then_some(Some(id));
        found.ok_or("a corner names a wedge of another point")
    }
}

/// Codes the wedges of a level whose faces of points are known. `truth` has the wedge of each
/// corner, under any numbering, and for each of these wedges the known wedge or [`NONE`].
pub(super) fn code_wedges(
    coder: &mut impl Coder,
    faces: &[[u32; 3]],
    points: usize,
    (coarse, known): (&Coarse<'_>, &Known),
    truth: Option<(&[[u32; 3]], &[u32])>,
) -> Result<Wedges, Fault> {
    let corners = faces.len() as u32 * 3;
    let mut seams = Seams {
        faces,
        twins: half_edges::twins(faces),
        known,
        expected: expected(faces, coarse),
        seen: vec![0; points],
        sectors: Sectors {
            parents: (0..corners).collect(),
        },
    };
    let mut models = Models::new();
    for half_edge in 0..corners {
        let twin = seams.twins[half_edge as usize];
        if twin != NONE && twin > half_edge {
            seams.code_edge(coder, &mut models, half_edge, truth.map(|t| t.0));
        }
        if coder.is_exhausted() {
            return Err("unexpected end of the bytes within the seams");
        }
    }
    seams.code_sectors(coder, &mut models, points, truth)
}

/// Predicts the wedges of corners: faces to the left of an edge of known points in both levels have
/// the same wedges at its ends, since collapses move the third corner only.
fn expected(faces: &[[u32; 3]], coarse: &Coarse<'_>) -> Vec<u32> {
    let mut expected = vec![NONE; faces.len() * 3];
    for half_edge in 0..expected.len() as u32 {
        let (from, to) = (
            half_edges::start(faces, half_edge),
            half_edges::end(faces, half_edge),
        );
        if let Some([start, end]) = coarse.wedges(from, to) {
            expected[half_edge as usize] = start;
            let next = &mut expected[half_edges::next(half_edge) as usize];
            if *next == NONE {
                *next = end;
            }
        }
    }
    expected
}

impl Seams<'_> {
    /// Prediction for two corners at a point: 0 none, 1 the same wedge, 2 different wedges.
    fn expectation(&self, corner: u32, other: u32) -> usize {
        match [corner, other].map(|c| self.expected[c as usize]) {
            [NONE, _] | [_, NONE] => 0,
            [a, b] => 1 + usize::from(a != b),
        }
    }

    fn code_edge(
        &mut self,
        coder: &mut impl Coder,
        models: &mut Models,
        half_edge: u32,
        truth: Option<&[[u32; 3]]>,
    ) {
        let twin = self.twins[half_edge as usize];
        let ends = [half_edge, half_edges::next(half_edge)];
        let beyond = [half_edges::next(twin), twin];
        let parts = [0, 1].map(|k| {
            truth.is_some_and(|wedges| {
                half_edges::start(wedges, ends[k]) != half_edges::start(wedges, beyond[k])
            })
        });
        let points = ends.map(|h| half_edges::start(self.faces, h));
        let classes = points.map(|p| self.known.class(p));
        let seen = points.map(|p| usize::from(self.seen[p as usize].min(3)));
        let (low, high) = (seen[0].min(seen[1]), seen[0].max(seen[1]));
        let (least, most) = (classes[0].min(classes[1]), classes[0].max(classes[1]));
        let i = (low * 4 + high) * 16 + least * 4 + most;
        let apexes = [half_edge, twin].map(|h| half_edges::apex(self.faces, h));
        let beside = apexes.map(|p| usize::from(self.seen[p as usize].min(3)));
        let sides = beside[0].min(beside[1]) * 4 + beside[0].max(beside[1]);
        let expected = [0, 1].map(|k| self.expectation(ends[k], beyond[k]));
        let hope = expected[0].min(expected[1]) * 3 + expected[0].max(expected[1]);
        let [x, y, z] = &mut models.is_seam;
        let bits = [
            &mut x[(low * 4 + high) * 9 + hope],
            &mut y[i * 9 + hope],
            &mut z[i * 16 + sides],
        ];
        let weights = &mut models.is_seam_weights[hope];
        if decide(coder, bits, weights, parts[0] || parts[1]) {
            let at = |k: usize| {
                let of = |k: usize| classes[k] * 4 + seen[k];
                (of(k) * 16 + of(1 - k)) * 9 + expected[k] * 3 + expected[1 - k]
            };
            let first = coder.bit(&mut models.parts_end[at(0)], parts[0]);
            let second = !first || coder.bit(&mut models.parts_end[256 * 9 + at(1)], parts[1]);
            for (k, is_parted) in [first, second].into_iter().enumerate() {
                if is_parted {
                    let seen = &mut self.seen[points[k] as usize];
                    *seen = seen.saturating_add(1);
                } else {
                    self.sectors.join(ends[k], beyond[k]);
                }
            }
        } else {
            self.sectors.join(ends[0], beyond[0]);
            self.sectors.join(ends[1], beyond[1]);
        }
    }

    fn code_sectors(
        &mut self,
        coder: &mut impl Coder,
        models: &mut Models,
        points: usize,
        truth: Option<(&[[u32; 3]], &[u32])>,
    ) -> Result<Wedges, Fault> {
        let mut found = Wedges::default();
        let mut wedges = vec![NONE; self.faces.len() * 3];
        // New wedge assigned to each wedge of the truth.
        let mut given = vec![NONE; truth.map_or(0, |t| t.1.len())];
        let mut new = New::at(points);
        let mut is_used = vec![false; self.known.total];
        let sector_expected = self.sector_expected();
        for corner in 0..wedges.len() as u32 {
            let root = self.sectors.root(corner);
            if root != corner {
                wedges[corner as usize] = wedges[root as usize];
                continue;
            }
            let point = half_edges::start(self.faces, corner);
            let true_wedge = truth.map(|t| half_edges::start(t.0, corner));
            let wanted = true_wedge.zip(truth).map_or(NONE, |(w, t)| t.1[w as usize]);
            let asked = (point, sector_expected[corner as usize], wanted);
            let mut wedge = self.code_known(coder, models, asked, &mut is_used);
            if wedge == NONE {
                let wanted = true_wedge.map_or(NONE, |w| given[w as usize]);
                let model = &mut models.is_used[self.known.class(point)];
                let id = new.code_again(coder, model, point, wanted)?;
                let id = id.unwrap_or_else(|| new.add(point));
                if let Some(true_wedge) = true_wedge {
                    given[true_wedge as usize] = id;
                }
                wedge = self.known.total as u32 + id;
            }
            wedges[corner as usize] = wedge;
            if coder.is_exhausted() {
                return Err("unexpected end of the bytes within the wedges");
            }
        }
        found.new_points = new.points;
        found.faces = wedges.chunks_exact(3).map(|w| [w[0], w[1], w[2]]).collect();
        Ok(found)
    }

    /// For the root corner of each sector, the prediction of its first corner that has one.
    fn sector_expected(&mut self) -> Vec<u32> {
        let mut found = vec![NONE; self.expected.len()];
        for corner in 0..found.len() {
            let root = self.sectors.root(corner as u32) as usize;
            if found[root] == NONE {
                found[root] = self.expected[corner];
            }
        }
        found
    }

    /// Codes whether a sector has a known wedge of its point, and which; [`NONE`] if not.
    fn code_known(
        &self,
        coder: &mut impl Coder,
        models: &mut Models,
        (point, expected, wanted): (u32, u32, u32),
        is_used: &mut [bool],
    ) -> u32 {
        let known = self.known.of(point);
        let class = self.known.class(point);
        if known.is_empty() {
            return NONE;
        }
        let few = known.clone().take(FEW);
        let unused = few.filter(|&w| !is_used[w as usize]).count();
        let state = match expected {
            _ if !known.contains(&expected) => 0,
            wedge => 1 + usize::from(is_used[wedge as usize]),
        };
        let context = (class * 4 + unused.min(3)) * 3 + state;
        if !coder.bit(&mut models.is_known[context], wanted != NONE) {
            return NONE;
        }
        if known.len() > FEW {
            let bits = 32 - (known.len() as u32).leading_zeros();
            let place = coder.raw(bits, wanted.wrapping_sub(known.start));
            let found = known.start + place.min(known.len() as u32 - 1);
            is_used[found as usize] = true;
            return found;
        }
        // The predicted wedge first, then wedges without a sector; the last one needs no decision.
        let rest = || known.clone().filter(|&w| w != expected);
        let used = rest().filter(|&w| is_used[w as usize]);
        let free = rest().filter(|&w| !is_used[w as usize]);
        let first = (state > 0).then_some(expected);
        let order: Vec<u32> = first.into_iter().chain(free).chain(used).collect();
        let mut found = order[order.len() - 1];
        for (i, &wedge) in order[..order.len() - 1].iter().enumerate() {
            let model = &mut models.is_this[context * 4 + i.min(3)];
            if coder.bit(model, wedge == wanted) {
                found = wedge;
                break;
            }
        }
        is_used[found as usize] = true;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range_coder::{Decoder, Encoder};

    /// A point with seventeen known wedges, too many for one decision each.
    fn many() -> Known {
        Known {
            first: vec![0, 2, 19],
            total: 19,
        }
    }

    fn seams(known: &Known) -> Seams<'_> {
        Seams {
            faces: &[],
            twins: Vec::new(),
            known,
            expected: Vec::new(),
            seen: Vec::new(),
            sectors: Sectors {
                parents: Vec::new(),
            },
        }
    }

    #[test]
    fn known_wedges_are_those_of_the_point() {
        let known = many();
        assert_eq!([0, 1, 2].map(|p| known.of(p)), [0..2, 2..19, 0..0]);
        assert_eq!([0, 1, 2].map(|p| known.class(p)), [2, 3, 0]);
    }

    /// Seventeen wedges are named by five bits, which can exceed them in a broken stream.
    #[test]
    fn a_number_beyond_the_wedges_of_a_point_is_the_last() {
        let known = many();
        let seams = seams(&known);
        for (wanted, expected) in [(2, 2), (9, 9), (18, 18), (19, 18), (33, 18)] {
            let mut used = vec![false; known.total];
            let mut encoder = Encoder::new();
            let asked = (1, NONE, wanted);
            let found = seams.code_known(&mut encoder, &mut Models::new(), asked, &mut used);
            assert_eq!(found, expected);
            let bytes = encoder.finish();
            let mut used = vec![false; known.total];
            let asked = (1, NONE, NONE);
            let models = &mut Models::new();
            let found = seams.code_known(&mut Decoder::new(&bytes), models, asked, &mut used);
            assert_eq!(found, expected);
            let first = used.iter().position(|is_used| *is_used);
            assert_eq!(first, Some(expected as usize));
        }
    }

    /// Beyond sixteen wedges of a point, a new one is named by its number among all new ones.
    #[test]
    fn a_wedge_of_another_point_is_refused() {
        let mut new = New::at(2);
        for _ in 0..=FEW {
            new.add(1);
        }
        let other = new.add(0);
        let oldest = 0;
        for (wanted, expected) in [
            (oldest, Ok(Some(oldest))),
            (NONE, Ok(None)),
            (other, Err("a corner names a wedge of another point")),
        ] {
            let mut encoder = Encoder::new();
            let mut model = Bit::default();
            let found = new.code_again(&mut encoder, &mut model, 1, wanted);
            assert_eq!(found, expected);
            let bytes = encoder.finish();
            let mut model = Bit::default();
            let decoder = &mut Decoder::new(&bytes);
            assert_eq!(new.code_again(decoder, &mut model, 1, NONE), expected);
        }
    }
}
