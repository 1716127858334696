//! The mesh levels that a file brings: how many triangles, how far off, which ranges.

use articula_core::source;
use articula_core::{ClusteredTriangles, LevelTable};
use serde::Serialize;

/// A coarser form of one mesh.
#[derive(Debug, Serialize)]
pub struct MeshLevel {
    /// Triangles.
    pub triangles: usize,
    /// Vertices.
    pub vertices: usize,
    /// Least share of the screen that it is made for, as the file says.
    pub screen_coverage: Option<f32>,
    /// For each part the triangles of its index list that show it, from and up to; empty if the
    /// level has vertices of its own.
    pub ranges: Vec<Vec<[u32; 2]>>,
}

/// The levels of all meshes together.
#[derive(Debug, Serialize)]
pub struct Levels {
    /// The finest first.
    pub levels: Vec<Level>,
    /// Zones that may be shown at a level of their own.
    pub regions: Vec<String>,
    /// Coarsest level up to which they may differ.
    pub mixable_to: usize,
}

/// One level of all meshes. An error is null if the file does not say it.
#[derive(Debug, Serialize)]
pub struct Level {
    /// Its number: 0 is the finest.
    pub level: usize,
    /// Triangles.
    pub triangles: u64,
    /// Vertices.
    pub vertices: u64,
    /// Greatest distance of the original from it at rest, metres.
    pub error_rest_m: Option<f32>,
    /// The same in motion, metres.
    pub error_motion_m: Option<f32>,
    /// Index ranges that show it, over all parts.
    pub ranges: usize,
}

/// The coarser forms of a mesh, the finest first.
pub(super) fn of_mesh(mesh: &source::RawMesh) -> Vec<MeshLevel> {
    let vertices = |parts: &[source::Primitive]| parts.iter().map(|p| p.positions.len()).sum();
    let triangles = |parts: &[source::Primitive]| parts.iter().map(|p| p.triangles.len()).sum();
    let nodes: Vec<MeshLevel> = mesh
        .levels
        .iter()
        .map(|level| MeshLevel {
            triangles: triangles(&level.primitives),
            vertices: vertices(&level.primitives),
            screen_coverage: level.screen_coverage,
            ranges: Vec::new(),
        })
        .collect();
    let Some(count) = mesh.clustered.first().map(|c| c.clusters.levels()) else {
        return nodes;
    };
    (1..count)
        .map(|level| MeshLevel {
            screen_coverage: nodes.get(level - 1).and_then(|n| n.screen_coverage),
            ..clustered(&mesh.clustered, level)
        })
        .collect()
}

fn clustered(parts: &[ClusteredTriangles], level: usize) -> MeshLevel {
    let all = || parts.iter().map(|p| &p.clusters);
    let ranges = |c: &articula_core::Clusters| c.ranges(level).map(|r| [r.start, r.end]).collect();
    MeshLevel {
        triangles: all().map(|c| c.triangles(level) as usize).sum(),
        vertices: all().map(|c| c.vertices(level) as usize).sum(),
        screen_coverage: None,
        ranges: all().map(ranges).collect(),
    }
}

/// The levels of all meshes, if the file says what they lose.
pub(super) fn of(table: &LevelTable, meshes: &[source::RawMesh]) -> Levels {
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let parts = || meshes.iter().flat_map(|m| &m.clustered);
    let rows = table.levels.iter().enumerate();
    let level = |(l, row): (usize, &articula_core::LevelRow)| Level {
        level: l,
        triangles: row.triangles,
        vertices: row.vertices,
        error_rest_m: finite(row.rest.max_metres),
        error_motion_m: finite(row.motion.max_metres),
        ranges: parts().map(|p| p.clusters.ranges(l).count()).sum(),
    };
    Levels {
        levels: rows.map(level).collect(),
        regions: table.regions.clone(),
        mixable_to: table.mixable_to,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::{Cluster, Clusters};

    #[test]
    fn ranges_are_those_of_each_part() {
        let cluster = |finest_level, coarsest_level, triangles| Cluster {
            finest_level,
            coarsest_level,
            region: 0,
            triangles,
        };
        let part = ClusteredTriangles {
            clusters: Clusters::new(
                vec![5, 3],
                vec![
                    cluster(0, 0, 0..4),
                    cluster(0, 1, 4..5),
                    cluster(1, 1, 5..6),
                ],
            )
            .unwrap(),
            triangles: vec![[0, 1, 2]; 6],
        };
        let mesh = source::RawMesh {
            clustered: vec![part.clone(), part],
            ..source::RawMesh::default()
        };
        let levels = of_mesh(&mesh);
        assert_eq!(levels.len(), 1);
        assert_eq!((levels[0].triangles, levels[0].vertices), (4, 6));
        assert_eq!(levels[0].ranges, [[[4, 6]], [[4, 6]]]);
    }
}
