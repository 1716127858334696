//! Mesh levels as ranges of one triangle list, so that a level is selected by copying ranges.
//!
//! Every triangle is shown during an interval of levels. Triangles with the same interval (and
//! region of the body) are stored together as one [`Cluster`], so that a level is a short list of
//! ranges of one index list, and its vertices are a prefix of one vertex list. A finer level only
//! adds to the data of a coarser one; a coarser one needs no further data.
//!
//! Source: thesis 3.1.2, `docs/methods/clustered-mesh.md` parts 3 and 4. The clusters may be in any
//! order; the order decides how many ranges a level has, and that of `articula_build::cluster`
//! gives at most one for each level from the coarsest up to it. Level 0 is the finest; the thesis
//! counts from the coarsest.

use crate::Mismatch;
use std::ops::Range;

/// A range of triangles that are shown at the same consecutive levels.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Cluster {
    /// Finest level that shows the triangles, the lowest number.
    pub finest_level: u16,
    /// Coarsest level that shows the triangles.
    pub coarsest_level: u16,
    /// Region whose level decides, less than [`Clusters::regions`].
    pub region: u16,
    /// Range of the index list, in triangles.
    pub triangles: Range<u32>,
}

impl Cluster {
    fn is_shown_at(&self, level: usize) -> bool {
        usize::from(self.finest_level) <= level && level <= usize::from(self.coarsest_level)
    }
}

/// The levels of one object: the number of vertices and the triangle ranges of each level.
///
/// ```
/// use articula_core::{Cluster, Clusters};
///
/// // A square of four triangles around its centre; level 1 shows two without it.
/// let cluster = |level, triangles| Cluster {
///     finest_level: level,
///     coarsest_level: level,
///     region: 0,
///     triangles,
/// };
/// let square = Clusters::new(vec![5, 4], vec![cluster(1, 0..2), cluster(0, 2..6)])?;
/// assert_eq!(square.ranges(0).collect::<Vec<_>>(), [2..6]);
/// assert_eq!(square.ranges(1).collect::<Vec<_>>(), [0..2]);
/// assert_eq!(square.vertices(1), 4);
/// # Ok::<(), articula_core::Mismatch>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Clusters {
    vertices: Vec<u32>,
    clusters: Vec<Cluster>,
    regions: usize,
}

impl Clusters {
    /// Creates the levels from the vertex count of each level, finest first, and the clusters in
    /// the order of the index list.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no level or more than 65536, vertex counts rise, the levels of a
    /// cluster are reversed or out of range, or the clusters are not contiguous from triangle 0.
    pub fn new(vertices: Vec<u32>, clusters: Vec<Cluster>) -> Result<Self, Mismatch> {
        if vertices.is_empty() || vertices.len() > usize::from(u16::MAX) + 1 {
            let what = format!("{} levels, expected 1 to 65536", vertices.len());
            return Err(Mismatch::new("vertices", what));
        }
        if let Some(i) = vertices.windows(2).position(|w| w[1] > w[0]) {
            let what = format!(
                "{} after {}; a coarser level must not have more vertices",
                vertices[i + 1],
                vertices[i]
            );
            return Err(Mismatch::new(format!("vertices[{}]", i + 1), what));
        }
        let mut end = 0;
        for (c, cluster) in clusters.iter().enumerate() {
            let (finest, coarsest) = (cluster.finest_level, cluster.coarsest_level);
            if finest > coarsest || usize::from(coarsest) >= vertices.len() {
                let what = format!(
                    "levels {finest} to {coarsest} are not a range of the {} levels",
                    vertices.len()
                );
                return Err(Mismatch::new(format!("clusters[{c}]"), what));
            }
            let Range { start, end: after } = cluster.triangles;
            if start != end || after < start {
                let what = format!("{start}..{after}, expected a range that begins at {end}");
                return Err(Mismatch::new(format!("clusters[{c}].triangles"), what));
            }
            end = after;
        }
        let regions = clusters.iter().map(|c| usize::from(c.region) + 1).max();
        Ok(Self {
            vertices,
            clusters,
            regions: regions.unwrap_or(1),
        })
    }

    /// Returns the number of levels, at least 1. Level 0 is the original mesh, `levels() - 1` the
    /// coarsest level.
    pub fn levels(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the number of regions with independent levels, at least 1.
    pub fn regions(&self) -> usize {
        self.regions
    }

    /// Returns the clusters in the order of the index list.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Returns the number of triangles in the index list, over all levels.
    fn stored_triangles(&self) -> u32 {
        self.clusters.last().map_or(0, |c| c.triangles.end)
    }

    /// Returns the number of vertices of a level; all its indices are less than that. Here and in
    /// the methods below a level beyond the coarsest counts as the coarsest.
    pub fn vertices(&self, level: usize) -> u32 {
        self.vertices[level.min(self.levels() - 1)]
    }

    /// Returns the vertex counts of all levels, finest first.
    pub fn vertex_counts(&self) -> &[u32] {
        &self.vertices
    }

    /// Returns the number of triangles shown at a level.
    pub fn triangles(&self, level: usize) -> u32 {
        self.ranges(level).map(|r| r.end - r.start).sum()
    }

    /// Returns the triangles of a level as ranges of the index list: ascending, disjoint, adjacent
    /// ones merged, none empty. Does not allocate.
    pub fn ranges(&self, level: usize) -> impl Iterator<Item = Range<u32>> + '_ {
        let level = level.min(self.levels() - 1);
        merged(self.clusters.iter().filter(move |c| c.is_shown_at(level)))
    }

    /// Returns the triangle ranges for a separate level of each region. Does not allocate.
    ///
    /// Whether two levels can be mixed without gaps where regions touch is known to the builder of
    /// the levels (`articula_build::cluster`) and stated by the table of levels
    /// ([`LevelTable::check_mix`](crate::LevelTable::check_mix)).
    ///
    /// # Errors
    /// A [`Mismatch`] unless there is one level for each region.
    pub fn ranges_of<'a>(
        &'a self,
        levels: &'a [u16],
    ) -> Result<impl Iterator<Item = Range<u32>> + 'a, Mismatch> {
        if levels.len() != self.regions {
            let what = format!("{} levels for {} regions", levels.len(), self.regions);
            return Err(Mismatch::new("levels", what));
        }
        let coarsest = self.levels() - 1;
        let shown = move |c: &&Cluster| {
            c.is_shown_at(usize::from(levels[usize::from(c.region)]).min(coarsest))
        };
        Ok(merged(self.clusters.iter().filter(shown)))
    }

    /// Returns the number of vertices for a separate level of each region: that of the finest of
    /// these levels.
    pub fn vertices_of(&self, levels: &[u16]) -> u32 {
        let coarsest = self.levels() - 1;
        let finest = levels.iter().min();
        self.vertices(finest.map_or(coarsest, |l| usize::from(*l)))
    }
}

/// The triangles of all levels of one object, over vertices in the order in which levels add them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClusteredTriangles {
    /// The triangle ranges of each level.
    pub clusters: Clusters,
    /// The triangles of all levels, in the order of the clusters.
    pub triangles: Vec<[u32; 3]>,
}

impl ClusteredTriangles {
    /// Returns the triangles of a level, in stored order.
    pub fn level(&self, level: usize) -> impl Iterator<Item = [u32; 3]> + '_ {
        let of = |r: Range<u32>| &self.triangles[r.start as usize..r.end as usize];
        self.clusters.ranges(level).flat_map(of).copied()
    }

    /// Returns the triangles for a separate level of each region, in stored order.
    ///
    /// # Errors
    /// As [`Clusters::ranges_of`].
    pub fn mix<'a>(
        &'a self,
        levels: &'a [u16],
    ) -> Result<impl Iterator<Item = [u32; 3]> + 'a, Mismatch> {
        let of = |r: Range<u32>| &self.triangles[r.start as usize..r.end as usize];
        Ok(self.clusters.ranges_of(levels)?.flat_map(of).copied())
    }

    /// Checks that the clusters cover all triangles, and that every level uses only its own
    /// vertices, of `vertex_count` in all.
    ///
    /// # Errors
    /// A [`Mismatch`] that gives the index of the first invalid triangle.
    pub fn check(&self, vertex_count: usize) -> Result<(), Mismatch> {
        let stored = self.clusters.stored_triangles() as usize;
        if stored != self.triangles.len() {
            let what = format!(
                "{} triangles, the clusters store {stored}",
                self.triangles.len()
            );
            return Err(Mismatch::new("triangles", what));
        }
        let finest = self.clusters.vertices(0);
        if finest as usize > vertex_count {
            let what =
                format!("{finest} vertices in the finest level, the mesh has {vertex_count}");
            return Err(Mismatch::new("clusters.vertices", what));
        }
        for cluster in self.clusters.clusters() {
            let below = self.clusters.vertices(usize::from(cluster.coarsest_level));
            let range = cluster.triangles.start as usize..cluster.triangles.end as usize;
            let mut corners = self.triangles[range.clone()].as_flattened().iter();
            if let Some(c) = corners.position(|v| *v >= below) {
                let at = format!("triangles[{}]", range.start + c / 3);
                let level = cluster.coarsest_level;
                let what = format!(
                    "names a vertex that level {level} with its {below} vertices does not have"
                );
                return Err(Mismatch::new(at, what));
            }
        }
        Ok(())
    }
}

/// Merges adjacent ranges. The clusters are ascending.
fn merged<'a>(
    clusters: impl Iterator<Item = &'a Cluster> + 'a,
) -> impl Iterator<Item = Range<u32>> + 'a {
    let mut ranges = clusters
        .map(|c| c.triangles.clone())
        .filter(|r| !r.is_empty())
        .peekable();
    std::iter::from_fn(move || {
        let mut range = ranges.next()?;
        while let Some(next) = ranges.next_if(|next| next.start == range.end) {
            range.end = next.end;
        }
        Some(range)
    })
}

#[cfg(test)]
mod tests {
    #![expect(
        clippy::single_range_in_vec_init,
        reason = "lists of ranges, some of one"
    )]
    use super::*;

    fn cluster(
        finest_level: u16,
        coarsest_level: u16,
        region: u16,
        triangles: Range<u32>,
    ) -> Cluster {
        Cluster {
            finest_level,
            coarsest_level,
            region,
            triangles,
        }
    }

    /// The worked example of `docs/methods/clustered-mesh.md`, which counts steps from the
    /// coarsest: C(0,1) | C(1,2) C(1,1) | C(2,2).
    fn example() -> Clusters {
        let clusters = vec![
            cluster(2, 2, 0, 0..2),
            cluster(1, 1, 0, 2..4),
            cluster(0, 1, 0, 4..6),
            cluster(0, 0, 0, 6..10),
        ];
        Clusters::new(vec![6, 5, 4], clusters).unwrap()
    }

    #[test]
    fn levels_of_the_worked_example() {
        let mesh = example();
        let ranges = |level| mesh.ranges(level).collect::<Vec<_>>();
        assert_eq!(ranges(0), [4..10]);
        assert_eq!(ranges(1), [2..6]);
        assert_eq!(ranges(2), [0..2]);
        assert_eq!(ranges(7), [0..2], "beyond the coarsest is the coarsest");
        assert_eq!(mesh.vertex_counts(), [6, 5, 4]);
        assert_eq!([0, 1, 2].map(|i| mesh.triangles(i)), [6, 4, 2]);
        assert_eq!(mesh.stored_triangles(), 10);
    }

    #[test]
    fn empty_clusters_neither_show_nor_part_their_neighbours() {
        let clusters = vec![
            cluster(0, 1, 0, 0..3),
            cluster(1, 1, 0, 3..3),
            cluster(0, 0, 0, 3..4),
            cluster(1, 1, 0, 4..5),
            cluster(0, 1, 0, 5..6),
        ];
        let mesh = Clusters::new(vec![3, 3], clusters).unwrap();
        assert_eq!(mesh.ranges(0).collect::<Vec<_>>(), [0..4, 5..6]);
        assert_eq!(mesh.ranges(1).collect::<Vec<_>>(), [0..3, 4..6]);
        let nothing = Clusters::new(vec![0], vec![]).unwrap();
        assert_eq!(
            (nothing.stored_triangles(), nothing.ranges(0).count()),
            (0, 0)
        );
    }

    #[test]
    fn each_region_at_its_level() {
        let clusters = vec![
            cluster(1, 1, 0, 0..2),
            cluster(1, 1, 1, 2..4),
            cluster(0, 0, 0, 4..8),
            cluster(0, 0, 1, 8..12),
        ];
        let mesh = Clusters::new(vec![9, 4], clusters).unwrap();
        assert_eq!(mesh.regions(), 2);
        let of = |levels: &[u16]| mesh.ranges_of(levels).unwrap().collect::<Vec<_>>();
        assert_eq!(of(&[0, 1]), [2..8]);
        assert_eq!(of(&[1, 0]), [0..2, 8..12]);
        assert_eq!(of(&[0, 0]), mesh.ranges(0).collect::<Vec<_>>());
        assert_eq!(
            [mesh.vertices_of(&[1, 1]), mesh.vertices_of(&[1, 0])],
            [4, 9]
        );
        assert_eq!(mesh.ranges_of(&[0]).map(|_| ()).unwrap_err().at, "levels");
    }

    #[test]
    fn no_level_names_a_vertex_of_a_finer_one() {
        let clusters = vec![cluster(1, 1, 0, 0..1), cluster(0, 0, 0, 1..2)];
        let of = |triangles: &[[u32; 3]]| ClusteredTriangles {
            clusters: Clusters::new(vec![4, 3], clusters.clone()).unwrap(),
            triangles: triangles.to_vec(),
        };
        let good = of(&[[0, 1, 2], [0, 1, 3]]);
        assert_eq!(good.check(4), Ok(()));
        assert_eq!(good.level(0).collect::<Vec<_>>(), [[0, 1, 3]]);
        assert_eq!(good.mix(&[1]).unwrap().collect::<Vec<_>>(), [[0, 1, 2]]);
        assert!(good.mix(&[0, 0]).is_err(), "there is one region");
        let at = |of: ClusteredTriangles, count| of.check(count).unwrap_err().at;
        assert_eq!(
            good.check(5),
            Ok(()),
            "vertices that no level uses come last"
        );
        assert_eq!(at(good, 3), "clusters.vertices");
        assert_eq!(at(of(&[[0, 1, 3], [0, 1, 3]]), 4), "triangles[0]");
        assert_eq!(at(of(&[[0, 1, 2], [4, 1, 3]]), 4), "triangles[1]");
        assert_eq!(at(of(&[[0, 1, 2]]), 4), "triangles");
    }

    #[test]
    fn refuses_what_cannot_be_drawn() {
        let at = |vertices: &[u32], clusters: &[Cluster]| {
            Clusters::new(vertices.to_vec(), clusters.to_vec())
                .unwrap_err()
                .at
        };
        assert_eq!(at(&[], &[]), "vertices");
        assert_eq!(at(&[2, 3], &[]), "vertices[1]");
        assert_eq!(at(&[3], &[cluster(0, 1, 0, 0..1)]), "clusters[0]");
        assert_eq!(at(&[3, 3], &[cluster(1, 0, 0, 0..1)]), "clusters[0]");
        let gap = [cluster(0, 0, 0, 0..1), cluster(0, 0, 0, 2..3)];
        assert_eq!(at(&[3], &gap), "clusters[1].triangles");
        #[expect(clippy::reversed_empty_ranges, reason = "what a broken file may say")]
        let back = [cluster(0, 0, 0, 0..3), cluster(0, 0, 0, 3..1)];
        assert_eq!(at(&[3], &back), "clusters[1].triangles");
    }
}
