//! Mesh levels stored in a file: sizes, errors and index ranges.

use articula_core::source;
use articula_core::{ClusteredTriangles, LevelTable};
use serde::Serialize;

/// A coarser level of one mesh.
#[derive(Debug, Serialize)]
pub struct CoarserMesh {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Minimum screen coverage for which it is intended, as stored in the file.
    pub screen_coverage: Option<f32>,
    /// Half-open ranges of triangles in the index list of each part; empty if the level has its own
    /// vertices.
    pub ranges: Vec<Vec<[u32; 2]>>,
}

/// Levels of all meshes together.
#[derive(Debug, Serialize)]
pub struct MeshLevelsInspection {
    /// The levels, finest first.
    pub levels: Vec<MeshLevelInspection>,
    /// Names of zones that may be shown at independent levels.
    pub regions: Vec<String>,
    /// Coarsest level up to which zones may differ.
    pub mixable_to: usize,
}

/// One level of all meshes. Errors are null if the file does not state them.
#[derive(Debug, Serialize)]
pub struct MeshLevelInspection {
    /// Number of the level; 0 is the finest.
    pub level: usize,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
    /// Maximum distance of the original surface from the level at rest, in metres.
    pub error_rest_m: Option<f32>,
    /// Maximum distance in motion, in metres.
    pub error_motion_m: Option<f32>,
    /// Number of index ranges over all parts.
    pub ranges: usize,
}

/// The coarser levels of a mesh, finest first.
pub(super) fn of_mesh(mesh: &source::RawMesh) -> Vec<CoarserMesh> {
    let vertices = |parts: &[source::Primitive]| parts.iter().map(|p| p.positions.len()).sum();
    let triangles = |parts: &[source::Primitive]| parts.iter().map(|p| p.triangles.len()).sum();
    let nodes: Vec<CoarserMesh> = mesh
        .levels
        .iter()
        .map(|level| CoarserMesh {
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
        .map(|level| CoarserMesh {
            screen_coverage: nodes.get(level - 1).and_then(|n| n.screen_coverage),
            ..clustered(&mesh.clustered, level)
        })
        .collect()
}

fn clustered(parts: &[ClusteredTriangles], level: usize) -> CoarserMesh {
    let all = || parts.iter().map(|p| &p.clusters);
    let ranges = |c: &articula_core::Clusters| c.ranges(level).map(|r| [r.start, r.end]).collect();
    CoarserMesh {
        triangles: all().map(|c| c.triangles(level) as usize).sum(),
        vertices: all().map(|c| c.vertices(level) as usize).sum(),
        screen_coverage: None,
        ranges: all().map(ranges).collect(),
    }
}

/// Levels of all meshes, from the file's table of errors.
pub(super) fn of(table: &LevelTable, meshes: &[source::RawMesh]) -> MeshLevelsInspection {
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let parts = || meshes.iter().flat_map(|m| &m.clustered);
    let rows = table.levels.iter().enumerate();
    let level = |(l, row): (usize, &articula_core::LevelRow)| MeshLevelInspection {
        level: l,
        triangles: row.triangles,
        vertices: row.vertices,
        error_rest_m: finite(row.rest.max_metres),
        error_motion_m: finite(row.motion.max_metres),
        ranges: parts().map(|p| p.clusters.ranges(l).count()).sum(),
    };
    MeshLevelsInspection {
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
