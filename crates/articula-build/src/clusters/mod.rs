//! Clustering of the levels of one object: stores triangles that several levels share once, in an
//! order in which a level is a few ranges.
//!
//! The *life* of a triangle is the interval of levels that show it. Triangles with the same life
//! and region form a [`Cluster`]; a vertex belongs to the coarsest level that uses it. Both follow
//! from the triangle lists of any simplifier that keeps original vertices; no log of collapses is
//! needed.
//!
//! Source: thesis 3.1.2, `docs/methods/clustered-mesh.md` parts 3 to 5. In place of the sets of the
//! thesis there are lives (its `C(k,j)` live from `k` to `j - 1`), so levels need not be chained,
//! and the stored lists are in a serpentine order that halves the number of ranges
//! ([`ClusterOrder::Store`]). In the interface level 0 is the finest; internally a *step* counts
//! levels from the coarsest, as the thesis and the stored order do.

mod order;
mod vertex_cache;

pub use order::ClusterOrder;

use articula_core::{Cluster, Clusters, Mismatch};
use foldhash::{HashMap, HashMapExt};
use std::cmp::Reverse;

/// All levels of an object as one vertex list and one triangle list that the levels share.
#[derive(Debug, Clone, PartialEq)]
pub struct Clustered {
    /// Clusters, and the vertex count of each level.
    pub clusters: Clusters,
    /// Triangles of all levels in the order of `clusters`; they index `vertices`.
    pub triangles: Vec<[u32; 3]>,
    /// Original index of each stored vertex: those of the coarsest level first, then those that
    /// each finer level adds. Vertices that no level uses are left out.
    pub vertices: Vec<u32>,
    /// Number of triangles stored again because they vanish and return; 0 if each level is made
    /// from the next finer one.
    pub copies: usize,
    /// Coarsest level up to which regions may be at different levels. From it to the finest no step
    /// changes a triangle with corners in two regions, so the seam between them stays the same.
    pub mixable_to: usize,
}

/// Clusters the levels of one object, finest first, whose triangles index original vertices.
///
/// `regions` is the region of each original vertex, or empty for one region; a triangle belongs to
/// the lowest region of its corners. Triangles that differ by rotation only are the same; one that
/// a level contains twice is stored twice.
///
/// # Errors
/// A [`Mismatch`] if there is no level, a vertex is not below `vertex_count`, or `regions` is
/// neither empty nor one per vertex; also above 65535 levels or `u32::MAX / 3` triangles in all.
pub fn cluster<L: AsRef<[[u32; 3]]>>(
    levels: &[L],
    vertex_count: usize,
    regions: &[u16],
    order: ClusterOrder,
) -> Result<Clustered, Mismatch> {
    check(levels, vertex_count, regions)?;
    let (lives, copies) = lives(levels);
    let finest = (levels.len() - 1) as u16;
    let region = |triangle: [u32; 3]| {
        let of = |v: u32| regions.get(v as usize).copied().unwrap_or(0);
        of(triangle[0]).min(of(triangle[1])).min(of(triangle[2]))
    };
    let mut sorted: Vec<(order::Place, &Life)> = lives
        .iter()
        .map(|life| {
            let region = region(life.triangle);
            (order.place(life.first, life.last, region, finest), life)
        })
        .collect();
    sorted.sort_by_key(|(place, _)| *place);
    let mut clusters = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(sorted.len());
    for group in sorted.chunk_by(|a, b| a.0 == b.0) {
        let start = triangles.len() as u32;
        let together: Vec<_> = group.iter().map(|(_, life)| life.triangle).collect();
        triangles.extend(vertex_cache::order(&together));
        clusters.push(Cluster {
            finest_level: finest - group[0].1.last,
            coarsest_level: finest - group[0].1.first,
            region: region(group[0].1.triangle),
            triangles: start..triangles.len() as u32,
        });
    }
    let (vertices, counts) = vertex_order(&clusters, &triangles, vertex_count, levels.len());
    renumber(&mut triangles, &vertices, vertex_count);
    Ok(Clustered {
        clusters: Clusters::new(counts, clusters)?,
        triangles,
        vertices,
        copies,
        mixable_to: levels.len() - 1 - mixable_from(&lives, regions, levels.len()),
    })
}

fn check<L: AsRef<[[u32; 3]]>>(
    levels: &[L],
    vertex_count: usize,
    regions: &[u16],
) -> Result<(), Mismatch> {
    if levels.is_empty() || levels.len() > usize::from(u16::MAX) {
        let what = format!("{} levels, expected 1 to 65535", levels.len());
        return Err(Mismatch::new("levels", what));
    }
    let total: usize = levels.iter().map(|l| l.as_ref().len()).sum();
    if total > (u32::MAX / 3) as usize {
        let what =
            format!("{total} triangles in all levels exceed what 32-bit indices can address");
        return Err(Mismatch::new("levels", what));
    }
    for (l, level) in levels.iter().enumerate() {
        let outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= vertex_count);
        if let Some(t) = level.as_ref().iter().position(outside) {
            let what = format!(
                "{:?} names a vertex out of range: the mesh has {vertex_count} vertices",
                level.as_ref()[t]
            );
            return Err(Mismatch::new(format!("levels[{l}][{t}]"), what));
        }
    }
    if !regions.is_empty() && regions.len() != vertex_count {
        let what = format!("{} entries for {vertex_count} vertices", regions.len());
        return Err(Mismatch::new("regions", what));
    }
    Ok(())
}

/// A triangle and the levels that show it, as steps from the coarsest level, 0.
struct Life {
    triangle: [u32; 3],
    first: u16,
    last: u16,
}

/// Lives of all triangles, in order of appearance from the coarsest level, and the number of those
/// that repeat a triangle.
fn lives<L: AsRef<[[u32; 3]]>>(levels: &[L]) -> (Vec<Life>, usize) {
    let mut lives: Vec<Life> = Vec::new();
    let mut copies = 0;
    // Index of the last life of the n-th triangle with these corners. Used for look-up only; its
    // order has no effect.
    let mut latest = HashMap::<([u32; 3], u32), usize>::new();
    for (l, level) in levels.iter().rev().enumerate() {
        let l = l as u16;
        let mut times = HashMap::<[u32; 3], u32>::new();
        for &triangle in level.as_ref() {
            let corners = rotated(triangle);
            let time = times.entry(corners).or_default();
            let at = latest.entry((corners, *time)).or_insert(usize::MAX);
            *time += 1;
            match lives.get_mut(*at) {
                Some(life) if life.last + 1 == l => {
                    // The finest level that shows a triangle determines its first corner.
                    (life.last, life.triangle) = (l, triangle);
                    continue;
                }
                Some(_) => copies += 1,
                None => {}
            }
            *at = lives.len();
            lives.push(Life {
                triangle,
                first: l,
                last: l,
            });
        }
    }
    (lives, copies)
}

/// Rotates a triangle so that its lowest corner comes first; triangles that differ by rotation only
/// become equal.
pub(crate) fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Original vertices in stored order, and the number of vertices of each level, finest first.
/// Inside a level vertices are in order of first use.
fn vertex_order(
    clusters: &[Cluster],
    triangles: &[[u32; 3]],
    vertex_count: usize,
    levels: usize,
) -> (Vec<u32>, Vec<u32>) {
    let mut by_level: Vec<&Cluster> = clusters.iter().collect();
    by_level.sort_by_key(|c| Reverse(c.coarsest_level));
    let mut is_stored = vec![false; vertex_count];
    let mut vertices = Vec::new();
    // From the coarsest: a level has the vertices of all coarser ones and those it adds.
    let mut counts = Vec::with_capacity(levels);
    for group in by_level.chunk_by(|a, b| a.coarsest_level == b.coarsest_level) {
        let coarser = levels - 1 - usize::from(group[0].coarsest_level);
        counts.resize(coarser, vertices.len() as u32);
        for cluster in group {
            let range = cluster.triangles.start as usize..cluster.triangles.end as usize;
            for &v in triangles[range].as_flattened() {
                if !std::mem::replace(&mut is_stored[v as usize], true) {
                    vertices.push(v);
                }
            }
        }
    }
    counts.resize(levels, vertices.len() as u32);
    counts.reverse();
    (vertices, counts)
}

fn renumber(triangles: &mut [[u32; 3]], vertices: &[u32], vertex_count: usize) {
    let mut stored = vec![0; vertex_count];
    for (i, &v) in vertices.iter().enumerate() {
        stored[v as usize] = i as u32;
    }
    for v in triangles.as_flattened_mut() {
        *v = stored[*v as usize];
    }
}

/// The last step at which a triangle between regions appears or after which one disappears.
fn mixable_from(lives: &[Life], regions: &[u16], levels: usize) -> usize {
    if regions.is_empty() {
        return 0;
    }
    let crosses = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| regions[v as usize]);
        a != b || b != c
    };
    let steps = lives
        .iter()
        .filter(|life| crosses(life.triangle))
        .map(|life| {
            let end = usize::from(life.last) + 1;
            if end < levels {
                end
            } else {
                usize::from(life.first)
            }
        });
    steps.max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    #![expect(
        clippy::single_range_in_vec_init,
        reason = "lists of ranges, some of one"
    )]
    use super::*;

    /// The worked example of `docs/methods/clustered-mesh.md` part 4.
    fn example() -> [Vec<[u32; 3]>; 3] {
        [
            vec![
                [0, 1, 4],
                [3, 0, 4],
                [1, 5, 4],
                [5, 3, 4],
                [1, 2, 5],
                [2, 3, 5],
            ],
            vec![[0, 1, 4], [3, 0, 4], [1, 2, 4], [2, 3, 4]],
            vec![[1, 2, 0], [2, 3, 0]],
        ]
    }

    /// Original corners of a range of stored triangles, as a sorted set.
    fn named(c: &Clustered, range: std::ops::Range<usize>) -> Vec<[u32; 3]> {
        let name = |t: &[u32; 3]| rotated(t.map(|v| c.vertices[v as usize]));
        let mut set: Vec<_> = c.triangles[range].iter().map(name).collect();
        set.sort_unstable();
        set
    }

    fn set(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut set: Vec<_> = triangles.iter().map(|t| rotated(*t)).collect();
        set.sort_unstable();
        set
    }

    #[test]
    fn worked_example_in_chunks() {
        let c = cluster(&example(), 6, &[], ClusterOrder::Chunks).unwrap();
        assert_eq!(c.triangles.len(), 10);
        assert_eq!(named(&c, 0..2), set(&[[1, 2, 0], [2, 3, 0]]), "C(0,1)");
        assert_eq!(named(&c, 2..4), set(&[[1, 2, 4], [2, 3, 4]]), "C(1,2)");
        assert_eq!(named(&c, 4..6), set(&[[0, 1, 4], [3, 0, 4]]), "C(1,1)");
        let finest = [[1, 5, 4], [5, 3, 4], [1, 2, 5], [2, 3, 5]];
        assert_eq!(named(&c, 6..10), set(&finest), "C(2,2)");
        let ranges = |level| c.clusters.ranges(level).collect::<Vec<_>>();
        assert_eq!(
            (ranges(2), ranges(1), ranges(0)),
            (Vec::from([0..2]), Vec::from([2..6]), Vec::from([4..10]),)
        );
        assert_eq!(c.clusters.vertex_counts(), [6, 5, 4]);
        assert_eq!(c.vertices[4..], [4, 5]);
        assert_eq!(c.copies, 0);
    }

    #[test]
    fn worked_example_as_stored() {
        let c = cluster(&example(), 6, &[], ClusterOrder::Store).unwrap();
        assert_eq!(
            named(&c, 0..6),
            set(&example()[0]),
            "survivors are the finest level"
        );
        // C(2,2) C(1,1) | C(0,1) | C(1,2)
        let ranges = |level| c.clusters.ranges(level).collect::<Vec<_>>();
        assert_eq!(
            (ranges(2), ranges(1), ranges(0)),
            (
                Vec::from([6..8]),
                Vec::from([4..6, 8..10]),
                Vec::from([0..6]),
            )
        );
    }

    #[test]
    fn a_triangle_that_comes_back_is_a_copy_and_one_named_twice_is_two() {
        let levels = [
            vec![[2, 0, 1], [0, 1, 3], [3, 3, 3]],
            vec![[0, 1, 3], [0, 1, 3]],
            vec![[0, 1, 2]],
        ];
        let c = cluster(&levels, 9, &[], ClusterOrder::Chunks).unwrap();
        assert_eq!(c.copies, 1);
        assert_eq!(c.triangles.len(), 5);
        for (level, triangles) in levels.iter().enumerate() {
            let shown: Vec<_> = c
                .clusters
                .ranges(level)
                .flat_map(|r| named(&c, r.start as usize..r.end as usize))
                .collect();
            assert_eq!(set(&shown), set(triangles));
        }
        assert_eq!(
            c.vertices.len(),
            4,
            "vertices that nothing uses are left out"
        );
    }

    #[test]
    fn levels_without_triangles() {
        let levels: [Vec<[u32; 3]>; 3] = [vec![], vec![[0, 1, 2]], vec![]];
        let c = cluster(&levels, 3, &[], ClusterOrder::Store).unwrap();
        assert_eq!(c.clusters.vertex_counts(), [3, 3, 0]);
        assert_eq!([0, 1, 2].map(|i| c.clusters.triangles(i)), [0, 1, 0]);
        assert_eq!(
            cluster::<Vec<_>>(&[], 0, &[], ClusterOrder::Store)
                .unwrap_err()
                .at,
            "levels"
        );
        assert_eq!(
            cluster(&levels, 2, &[], ClusterOrder::Store)
                .unwrap_err()
                .at,
            "levels[1][0]"
        );
        assert_eq!(
            cluster(&levels, 3, &[0], ClusterOrder::Store)
                .unwrap_err()
                .at,
            "regions"
        );
    }

    /// Two regions that touch in one triangle: level 1 simplifies region 0 only, level 2 also
    /// changes the seam.
    #[test]
    fn regions_mix_while_their_seam_is_whole() {
        let levels = [
            vec![[0, 1, 6], [1, 2, 6], [2, 0, 6], [1, 3, 2], [3, 4, 5]],
            vec![[0, 1, 2], [1, 3, 2], [3, 4, 5]],
            vec![[0, 1, 4]],
        ];
        let regions = [0, 0, 0, 1, 1, 1, 0];
        let c = cluster(&levels, 7, &regions, ClusterOrder::Store).unwrap();
        assert_eq!(c.mixable_to, 1);
        assert_eq!(c.clusters.regions(), 2);
        let count = |levels: &[u16]| {
            let ranges = c.clusters.ranges_of(levels).unwrap();
            ranges.map(|r| r.end - r.start).sum::<u32>()
        };
        assert_eq!([count(&[1, 0]), count(&[0, 1])], [3, 5]);
    }
}
