//! The mesh levels that a file brings: how many triangles, how far off, which ranges.

use crate::table::Table;
use articula_core::source;
use articula_core::{ClusteredTriangles, LevelTable};
use serde::Serialize;

/// A coarser form of one mesh.
#[derive(Debug, Serialize)]
pub(super) struct MeshLevel {
    pub(super) triangles: usize,
    pub(super) vertices: usize,
    pub(super) screen_coverage: Option<f32>,
    /// For each part the triangles of its index list that show it, from and up to; empty if the
    /// level has vertices of its own.
    pub(super) ranges: Vec<Vec<[u32; 2]>>,
}

/// The levels of all meshes together.
#[derive(Debug, Serialize)]
pub(super) struct Levels {
    /// The finest first.
    pub(super) levels: Vec<Level>,
    /// Zones that may be shown at a level of their own.
    pub(super) regions: Vec<String>,
    /// Coarsest level from which on they may differ.
    pub(super) mixable_from: usize,
}

/// One level of all meshes. An error is null if the file does not say it.
#[derive(Debug, Serialize)]
pub(super) struct Level {
    /// Its number: 0 is the coarsest.
    pub(super) level: usize,
    pub(super) triangles: u64,
    pub(super) vertices: u64,
    pub(super) error_rest_m: Option<f32>,
    pub(super) error_motion_m: Option<f32>,
    /// Index ranges that show it, over all parts.
    pub(super) ranges: usize,
}

/// The coarser forms of a mesh, the finest first.
pub(super) fn of_mesh(mesh: &source::Mesh) -> Vec<MeshLevel> {
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
    let coarser = (0..count - 1).rev().enumerate();
    coarser
        .map(|(i, level)| MeshLevel {
            screen_coverage: nodes.get(i).and_then(|n| n.screen_coverage),
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
pub(super) fn of(table: &LevelTable, meshes: &[source::Mesh]) -> Levels {
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let parts = || meshes.iter().flat_map(|m| &m.clustered);
    let rows = table.levels.iter().enumerate().rev();
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
        mixable_from: table.mixable_from,
    }
}

/// The same for people.
pub(super) fn table(found: &Levels) -> Table {
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "off at rest",
        "in motion",
        "ranges",
    ]);
    for level in &found.levels {
        let [rest, motion] = [level.error_rest_m, level.error_motion_m].map(millimetres);
        table.row([
            level.level.to_string(),
            level.triangles.to_string(),
            level.vertices.to_string(),
            rest,
            motion,
            level.ranges.to_string(),
        ]);
    }
    table
}

/// An error as people read it.
pub(super) fn millimetres(metres: Option<f32>) -> String {
    metres.map_or("-".to_owned(), |m| format!("{:.2} mm", 1e3 * m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::{Cluster, Clusters};

    #[test]
    fn ranges_are_those_of_each_part() {
        let cluster = |first_level, last_level, triangles| Cluster {
            first_level,
            last_level,
            region: 0,
            triangles,
        };
        let part = ClusteredTriangles {
            clusters: Clusters::new(
                vec![3, 5],
                vec![
                    cluster(1, 1, 0..4),
                    cluster(0, 1, 4..5),
                    cluster(0, 0, 5..6),
                ],
            )
            .unwrap(),
            triangles: vec![[0, 1, 2]; 6],
        };
        let mesh = source::Mesh {
            clustered: vec![part.clone(), part],
            ..source::Mesh::default()
        };
        let levels = of_mesh(&mesh);
        assert_eq!(levels.len(), 1);
        assert_eq!((levels[0].triangles, levels[0].vertices), (4, 6));
        assert_eq!(levels[0].ranges, [[[4, 6]], [[4, 6]]]);
    }
}
