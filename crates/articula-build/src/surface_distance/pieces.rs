//! Levels as unions of pieces: sets of triangles that several levels have in common.
//!
//! A level with one region finer than the others shares most of its triangles with other such levels,
//! and what is known about a piece serves all levels that have it.

use foldhash::{HashMap, HashMapExt};
use std::collections::BTreeMap;

/// Levels of a surface, divided into pieces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pieces {
    /// Triangles of each piece. One of several levels may be in a piece of each of them.
    pub(super) triangles: Vec<Vec<[u32; 3]>>,
    /// The pieces of each level, which together have all its triangles and no others.
    pub(super) of_level: Vec<Vec<usize>>,
}

impl Pieces {
    pub(super) fn of(levels: &[&[[u32; 3]]]) -> Self {
        let mut triangles: Vec<Vec<[u32; 3]>> = Vec::new();
        let mut levels_of: Vec<Vec<u32>> = Vec::new();
        // Triangles of few levels first: those of more are then added to the pieces of these.
        for ((_, mut left), own) in by_levels(levels) {
            for (piece, has) in triangles.iter_mut().zip(&levels_of) {
                if has.iter().all(|l| left.binary_search(l).is_ok()) {
                    piece.extend(&own);
                    left.retain(|l| has.binary_search(l).is_err());
                }
            }
            if !left.is_empty() {
                triangles.push(own);
                levels_of.push(left);
            }
        }
        let pieces_of = |level: usize| {
            let pieces = levels_of.iter().enumerate();
            let has = |levels: &[u32]| levels.binary_search(&(level as u32)).is_ok();
            pieces.filter(|(_, l)| has(l)).map(|(p, _)| p).collect()
        };
        Self {
            of_level: (0..levels.len()).map(pieces_of).collect(),
            triangles,
        }
    }
}

/// Different triangles by the levels that have them, with the number of these in front.
fn by_levels(levels: &[&[[u32; 3]]]) -> BTreeMap<(usize, Vec<u32>), Vec<[u32; 3]>> {
    let mut places: HashMap<[u32; 3], usize> = HashMap::new();
    let mut found: Vec<([u32; 3], Vec<u32>)> = Vec::new();
    for (l, level) in levels.iter().enumerate() {
        for triangle in *level {
            let place = *places.entry(*triangle).or_insert(found.len());
            if place == found.len() {
                found.push((*triangle, Vec::new()));
            }
            let of_triangle = &mut found[place].1;
            if of_triangle.last() != Some(&(l as u32)) {
                of_triangle.push(l as u32);
            }
        }
    }
    let mut sorted: BTreeMap<(usize, Vec<u32>), Vec<[u32; 3]>> = BTreeMap::new();
    for (triangle, levels) in found {
        sorted
            .entry((levels.len(), levels))
            .or_default()
            .push(triangle);
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn regions_at_two_levels_are_four_pieces() {
        let of = |firsts: [u32; 2]| firsts.map(|v| [v, v + 1, v + 2]);
        let (fine, coarse) = ([of([0, 1]), of([10, 11])], [of([20, 21]), of([30, 31])]);
        let levels = [
            [fine[0], fine[1]].concat(),
            [coarse[0], fine[1]].concat(),
            [fine[0], coarse[1]].concat(),
            [coarse[0], coarse[1]].concat(),
        ];
        let levels: Vec<&[[u32; 3]]> = levels.iter().map(Vec::as_slice).collect();
        let found = Pieces::of(&levels);
        assert_eq!(found.triangles.len(), 4);
        assert!(found.triangles.iter().all(|piece| piece.len() == 2));
        assert!(found.of_level.iter().all(|pieces| pieces.len() == 2));
    }

    #[test]
    fn few_triangles_of_two_levels_are_no_piece_of_their_own() {
        let levels: [&[[u32; 3]]; 2] = [&[[0, 1, 2], [3, 4, 5]], &[[3, 4, 5], [6, 7, 8]]];
        let found = Pieces::of(&levels);
        assert_eq!(found.of_level, [[0], [1]]);
        assert_eq!(found.triangles, [levels[0], &[[6, 7, 8], [3, 4, 5]]]);
        assert_eq!(Pieces::of(&[&[], &[]]).of_level, vec![vec![0; 0]; 2]);
    }

    proptest! {
        #[test]
        fn the_pieces_of_a_level_are_its_triangles(
            levels in prop::collection::vec(
                prop::collection::vec(prop::array::uniform3(0u32..3), 0..12), 0..6),
        ) {
            let levels: Vec<&[[u32; 3]]> = levels.iter().map(Vec::as_slice).collect();
            let found = Pieces::of(&levels);
            for (level, pieces) in levels.iter().zip(&found.of_level) {
                let all = pieces.iter().flat_map(|p| &found.triangles[*p]);
                let all: Vec<&[u32; 3]> = all.collect();
                let different: BTreeSet<&[u32; 3]> = level.iter().collect();
                prop_assert_eq!(all.len(), different.len(), "once each");
                prop_assert_eq!(all.into_iter().collect::<BTreeSet<_>>(), different);
            }
        }
    }
}
