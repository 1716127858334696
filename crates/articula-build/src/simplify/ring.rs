//! The neighbourhood of a position class: its neighbours, borders and fans.

use super::classes::Classes;
use super::topology::Surface;

/// The one-ring of a class. Reused for different classes.
#[derive(Debug, Default)]
pub(super) struct Ring {
    /// Faces around the class, as (face, corner of the class, next class, previous class).
    pub(super) faces: Vec<(usize, usize, u32, u32)>,
    /// Neighbours, in the order of first use.
    pub(super) neighbours: Vec<u32>,
    /// Number of different classes opposite to the edge towards each neighbour: 2 inside a surface,
    /// 1 on a border. Faces that lie back to back count once, so both sides of a sheet are one.
    pub(super) degrees: Vec<u32>,
    edges: Vec<(u32, u32)>,
    seen: Vec<bool>,
}

impl Ring {
    /// Fills the ring with the neighbourhood of a class.
    pub(super) fn look(&mut self, surface: &Surface, class: u32) {
        self.faces.clear();
        self.neighbours.clear();
        self.edges.clear();
        for (face, at) in surface.around(class) {
            let corners = surface.faces[face];
            let (a, b) = (corners[(at + 1) % 3], corners[(at + 2) % 3]);
            self.faces.push((face, at, a, b));
            let (i, j) = (self.place(a), self.place(b));
            self.edges.push((i.min(j), i.max(j)));
        }
        self.edges.sort_unstable();
        self.edges.dedup();
        self.degrees.clear();
        self.degrees.resize(self.neighbours.len(), 0);
        for (i, j) in &self.edges {
            self.degrees[*i as usize] += 1;
            self.degrees[*j as usize] += 1;
        }
    }

    /// Index of a neighbour, which is added if it is new.
    fn place(&mut self, class: u32) -> u32 {
        let at = self.neighbours.iter().position(|n| *n == class);
        at.unwrap_or_else(|| {
            self.neighbours.push(class);
            self.neighbours.len() - 1
        }) as u32
    }

    /// Whether texture coordinates, colours or parts differ across the edge to a neighbour.
    pub(super) fn is_seam(&self, surface: &Surface, classes: &Classes, place: usize) -> bool {
        let other = self.neighbours[place];
        let mut ends = self.faces.iter().filter_map(|(face, at, a, b)| {
            let there = match other {
                other if other == *a => (at + 1) % 3,
                other if other == *b => (at + 2) % 3,
                _ => return None,
            };
            let wedges = surface.wedges[*face];
            Some([wedges[*at], wedges[there]].map(|w| classes.chart[w as usize]))
        });
        let first = ends.next();
        ends.any(|e| Some(e) != first)
    }

    /// Whether borders allow the class to move to the neighbour at `place`: from inside a surface
    /// along any edge, from a border only along the border, otherwise never.
    pub(super) fn keeps_border(&self, place: usize) -> bool {
        let mut ends = 0;
        let mut degree = 2;
        for d in self.degrees.iter().filter(|d| **d != 2) {
            ends += 1;
            if ends > 1 && *d != degree {
                return false;
            }
            degree = *d;
        }
        match ends {
            0 => true,
            2 => self.degrees[place] == degree,
            _ => false,
        }
    }

    /// Whether all faces are connected by edges.
    pub(super) fn is_one_fan(&mut self) -> bool {
        self.seen.clear();
        self.seen.resize(self.neighbours.len(), false);
        if let Some(first) = self.seen.first_mut() {
            *first = true;
        }
        // Each pass reaches at least one more neighbour, and around most classes all of them.
        loop {
            let mut reached = false;
            for (i, j) in &self.edges {
                let (i, j) = (*i as usize, *j as usize);
                if self.seen[i] != self.seen[j] {
                    (self.seen[i], self.seen[j], reached) = (true, true, true);
                }
            }
            if !reached {
                return self.seen.iter().all(|s| *s);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surface::tangle;
    use super::*;
    use proptest::prelude::*;
    use std::collections::{BTreeMap, BTreeSet};

    /// Classes opposite to the edge towards each neighbour.
    fn opposite(triangles: &[[u32; 3]], class: u32) -> BTreeMap<u32, BTreeSet<u32>> {
        let mut found = BTreeMap::<u32, BTreeSet<u32>>::new();
        for t in triangles.iter().filter(|t| t.contains(&class)) {
            let others: Vec<u32> = t.iter().copied().filter(|c| *c != class).collect();
            found.entry(others[0]).or_default().insert(others[1]);
            found.entry(others[1]).or_default().insert(others[0]);
        }
        found
    }

    proptest! {
        #[test]
        fn neighbours_and_their_opposites_are_those_of_all_triangles((classes, triangles) in tangle()) {
            let surface = Surface::new(&triangles, &classes);
            let mut ring = Ring::default();
            for class in 0..9 {
                ring.look(&surface, class);
                let expected = opposite(&triangles, class);
                let found = ring.neighbours.iter().copied().zip(ring.degrees.iter().copied());
                let counts = expected.iter().map(|(n, o)| (*n, o.len() as u32));
                prop_assert_eq!(found.collect::<BTreeMap<_, _>>(), counts.collect());
                prop_assert_eq!(ring.neighbours.len(), expected.len());
                for (face, at, a, b) in &ring.faces {
                    let [x, y, z] = triangles[*face];
                    let turned = [[x, y, z], [y, z, x], [z, x, y]][*at];
                    prop_assert_eq!(turned, [class, *a, *b]);
                }
                // One fan: all neighbours are reached from any of them.
                let mut reached: BTreeSet<u32> = expected.keys().take(1).copied().collect();
                for _ in 0..9 {
                    let more: Vec<u32> = reached.iter().flat_map(|n| &expected[n]).copied().collect();
                    reached.extend(more);
                }
                prop_assert_eq!(ring.is_one_fan(), reached.len() == expected.len());
                // Along a border of two ends with as many opposites, or inside.
                let ends: Vec<usize> = expected.values().map(BTreeSet::len).filter(|n| *n != 2).collect();
                for (place, n) in ring.neighbours.iter().enumerate() {
                    let along = expected[n].len();
                    let keeps = match ends[..] {
                        [] => true,
                        [one, other] => one == other && along == one,
                        _ => false,
                    };
                    prop_assert_eq!(ring.keeps_border(place), keeps);
                }
            }
        }
    }
}
