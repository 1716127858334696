//! Meshes thinned out without regard to quality: levels for tests of how levels are stored.
#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test file uses a part of it, and a test may panic"
)]

use articula_build::{ClusterOrder, Clustered, cluster};
use articula_core::source::{Primitive, RawMesh};
use articula_core::{LevelRow, LevelTable, SurfaceError};
use articula_formats::WriteError;
use articula_formats::gltf::GltfFile;
use articula_formats::gltf::{MeshParts, PartLevels};

/// Returns levels of a primitive, finest first: each step moves vertices onto neighbours that stay.
pub(crate) fn levels(primitive: &Primitive, count: usize) -> Vec<Vec<[u32; 3]>> {
    let mut levels = vec![primitive.triangles.clone()];
    for step in 1..count {
        let mut moved: Vec<u32> = (0..primitive.positions.len() as u32).collect();
        let mut stays = vec![false; moved.len()];
        for t in levels[step - 1].iter().step_by(2 + step % 3) {
            let [from, to] = [t[0] as usize, t[1] as usize];
            if moved[from] as usize == from && moved[to] as usize == to && !stays[from] {
                moved[from] = to as u32;
                stays[to] = true;
            }
        }
        let coarser = levels[step - 1]
            .iter()
            .map(|t| t.map(|v| moved[v as usize]));
        let whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        levels.push(coarser.filter(whole).collect());
    }
    levels
}

/// Returns every part of a mesh with its levels.
pub(crate) fn clustered(mesh: &RawMesh, count: usize) -> Vec<Clustered> {
    let of = |p: &Primitive| {
        cluster(
            &levels(p, count),
            p.positions.len(),
            &[],
            ClusterOrder::Store,
        )
        .unwrap()
    };
    mesh.primitives.iter().map(of).collect()
}

/// Returns a table of errors that increase with coarser levels.
pub(crate) fn table(count: usize) -> LevelTable {
    let row = |level: usize| {
        let metres = 0.002 * level as f32;
        let error = SurfaceError {
            max_metres: 2.0 * metres,
            p99_metres: 1.5 * metres,
            p95_metres: metres,
            mean_metres: 0.25 * metres,
        };
        LevelRow {
            triangles: 10 * (count - 1 - level) as u64,
            vertices: 5 * (count - 1 - level) as u64,
            rest: error,
            motion: error,
        }
    };
    LevelTable {
        levels: (0..count).map(row).collect(),
        regions: vec![],
        mixable_to: count - 1,
    }
}

/// Stores levels of all meshes in a file's document.
pub(crate) fn store(file: &mut GltfFile, of: &[Vec<Clustered>]) -> Result<(), WriteError> {
    let nodes = file.node_of_mesh.iter();
    let meshes: Vec<_> = nodes
        .zip(of)
        .map(|(node, of)| MeshParts {
            node: *node,
            parts: of.iter().map(part).collect(),
        })
        .collect();
    let levels = of[0][0].clusters.levels();
    file.document.set_mesh_levels(&table(levels), &meshes)
}

pub(crate) fn part(of: &Clustered) -> PartLevels<'_> {
    PartLevels {
        vertices: &of.vertices,
        triangles: &of.triangles,
        clusters: &of.clusters,
    }
}
