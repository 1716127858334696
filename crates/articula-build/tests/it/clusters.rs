//! Properties of clustered levels (`docs/methods/clustered-mesh.md` 10, checks 1, 2, 3 and 5), on
//! random levels.

use articula_build::{ClusterOrder, Clustered, cluster};
use proptest::prelude::*;
use std::collections::HashMap;

type Level = Vec<[u32; 3]>;

/// A sheet of `side * side` squares, two triangles each.
fn sheet(side: u32) -> Level {
    let corner = |x, y| y * (side + 1) + x;
    let squares = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    squares
        .flat_map(|(x, y)| {
            let [a, b] = [corner(x, y), corner(x + 1, y)];
            let [c, d] = [corner(x, y + 1), corner(x + 1, y + 1)];
            [[a, b, c], [b, d, c]]
        })
        .collect()
}

/// Moves some vertices onto others that share an edge with them.
fn collapsed(level: &Level, picks: &[(usize, usize)]) -> Level {
    let mut level = level.clone();
    for &(triangle, corner) in picks {
        if level.is_empty() {
            break;
        }
        let t = level[triangle % level.len()];
        let (from, to) = (t[corner % 3], t[(corner + 1) % 3]);
        for v in level.as_flattened_mut() {
            if *v == from {
                *v = to;
            }
        }
        level.retain(|[a, b, c]| a != b && b != c && c != a);
    }
    level
}

fn picks() -> impl Strategy<Value = Vec<Vec<(usize, usize)>>> {
    let of_one = prop::collection::vec((0_usize..1000, 0_usize..3), 0..12);
    prop::collection::vec(of_one, 0..7)
}

/// Levels, finest first, each made from the next finer one, or each from the finest.
fn levels(side: u32, picks: &[Vec<(usize, usize)>], chained: bool) -> Vec<Level> {
    let mut levels = vec![sheet(side)];
    for picks in picks {
        let from = if chained {
            levels.last().unwrap()
        } else {
            &levels[0]
        };
        levels.push(collapsed(from, picks));
    }
    levels
}

/// Number of occurrences of each triangle, regardless of which corner is first.
fn counted(triangles: impl Iterator<Item = [u32; 3]>) -> HashMap<[u32; 3], u32> {
    let mut counts = HashMap::new();
    for [a, b, c] in triangles {
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        *counts.entry(*turned.iter().min().unwrap()).or_default() += 1;
    }
    counts
}

fn shown(c: &Clustered, ranges: impl Iterator<Item = std::ops::Range<u32>>) -> Level {
    ranges
        .flat_map(|r| c.triangles[r.start as usize..r.end as usize].to_vec())
        .collect()
}

fn check(levels: &[Level], c: &Clustered, order: ClusterOrder) {
    assert_eq!(c.clusters.levels(), levels.len());
    let mut seen = vec![false; c.triangles.len()];
    for (l, level) in levels.iter().enumerate() {
        let ranges: Vec<_> = c.clusters.ranges(l).collect();
        for range in &ranges {
            seen[range.start as usize..range.end as usize].fill(true);
        }
        let apart = ranges.windows(2).all(|w| w[0].end < w[1].start);
        assert!(
            apart && ranges.iter().all(|r| r.start < r.end),
            "{ranges:?}"
        );
        // With the range of vertices that is i + 2 at most, and never above 3 i + 1, as the thesis
        // counts levels: from the coarsest.
        let i = levels.len() - 1 - l;
        let most = match order {
            ClusterOrder::Chunks => i + 1,
            ClusterOrder::Store if l == 0 => 1,
            ClusterOrder::Store => 1 + i.div_ceil(2),
        };
        assert!(ranges.len() <= most, "{} ranges at level {l}", ranges.len());
        let shown = shown(c, ranges.into_iter());
        let below = c.clusters.vertices(l);
        assert!(shown.as_flattened().iter().all(|v| *v < below));
        let original = shown.iter().map(|t| t.map(|v| c.vertices[v as usize]));
        assert_eq!(
            counted(original),
            counted(level.iter().copied()),
            "level {l}"
        );
    }
    assert!(seen.iter().all(|s| *s), "a triangle that no level shows");
    let mut vertices = c.vertices.clone();
    vertices.sort_unstable();
    vertices.dedup();
    assert_eq!(vertices.len(), c.vertices.len(), "a vertex is stored twice");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn every_level_shows_its_triangles(
        side in 1_u32..9,
        picks in picks(),
        chained: bool,
        regions in prop::collection::vec(0_u16..3, 0..2),
    ) {
        let levels = levels(side, &picks, chained);
        let vertices = ((side + 1) * (side + 1)) as usize;
        // No region, or as many as stripes of the sheet.
        let stripes: Vec<u16> = match regions.first() {
            None => vec![],
            Some(n) => (0..vertices).map(|v| (v % (usize::from(*n) + 1)) as u16).collect(),
        };
        for order in [ClusterOrder::Chunks, ClusterOrder::Store] {
            let c = cluster(&levels, vertices, &stripes, order).unwrap();
            check(&levels, &c, order);
            if chained {
                prop_assert_eq!(c.copies, 0);
            }
            let uniform = vec![(levels.len() / 2) as u16; c.clusters.regions()];
            let same: Vec<_> = c.clusters.ranges(levels.len() / 2).collect();
            prop_assert_eq!(c.clusters.ranges_of(&uniform).unwrap().collect::<Vec<_>>(), same);
            prop_assert_eq!(&c, &cluster(&levels, vertices, &stripes, order).unwrap());
        }
    }

    /// Left and right half simplified separately, the triangles between them untouched: any mix of
    /// levels is the left half of one and the right half of another.
    #[test]
    fn regions_are_chosen_apart(side in 2_u32..9, picks in picks(), mix: (u16, u16)) {
        let finest = sheet(side);
        let row = side + 1;
        let half = |v: u32| u16::from(v % row > side / 2);
        let of = |t: &[u32; 3]| t.map(half);
        let part = |r: u16| finest.iter().copied().filter(move |t| of(t) == [r; 3]).collect::<Level>();
        let seam = finest.iter().copied().filter(|t| of(t)[0] != of(t)[1] || of(t)[1] != of(t)[2]);
        let seam: Level = seam.collect();
        let parts = [0, 1].map(|r| levels_of(part(r), &picks));
        let levels: Vec<Level> = (0..=picks.len())
            .map(|i| [parts[0][i].clone(), parts[1][i].clone(), seam.clone()].concat())
            .collect();
        let regions: Vec<u16> = (0..row * row).map(half).collect();
        let c = cluster(&levels, regions.len(), &regions, ClusterOrder::Store).unwrap();
        prop_assert_eq!(c.mixable_to, levels.len() - 1);
        prop_assume!(c.clusters.regions() == 2);
        let mix = [mix.0, mix.1].map(|l| l % levels.len() as u16);
        let shown = shown(&c, c.clusters.ranges_of(&mix).unwrap());
        let below = c.clusters.vertices_of(&mix);
        prop_assert!(shown.as_flattened().iter().all(|v| *v < below));
        let original = shown.iter().map(|t| t.map(|v| c.vertices[v as usize]));
        let expected = [&parts[0][usize::from(mix[0])], &parts[1][usize::from(mix[1])], &seam];
        prop_assert_eq!(counted(original), counted(expected.into_iter().flatten().copied()));
    }
}

fn levels_of(finest: Level, picks: &[Vec<(usize, usize)>]) -> Vec<Level> {
    let mut levels = vec![finest];
    for picks in picks {
        levels.push(collapsed(levels.last().unwrap(), picks));
    }
    levels
}
