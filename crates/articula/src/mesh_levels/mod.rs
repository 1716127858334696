//! Mesh levels of an asset, and those that a file shows.
//!
//! - `options`: how levels are made; `build_options`: the same for the builder
//! - `face`: what levels keep of a face
//! - `made`: their triangles; `coded` measures, codes and stores them
//! - `show`: the levels that a file shows

#[cfg(feature = "prepare")]
mod build_options;
#[cfg(feature = "prepare")]
pub(crate) mod coded;
#[cfg(feature = "prepare")]
mod face;
#[cfg(feature = "prepare")]
mod made;
mod options;
mod show;

#[cfg(feature = "prepare")]
pub use coded::{CodedMeshLevels, MeshLevelStream};
#[cfg(feature = "prepare")]
pub(crate) use coded::{add, source_orders};
#[cfg(feature = "prepare")]
pub use face::KeptFace;
#[cfg(feature = "prepare")]
pub(crate) use made::{triangles, triangles_of};
pub use options::{MAX_MESH_LEVELS, MeshLevelOptions};
pub(crate) use show::show;
pub use show::{
    LevelChoice, MeshView, ShownInView, ShownLevelOptions, ShownLevels, ShownLevelsReport,
    ShownRegion,
};

use articula_core::source::RawMesh;

/// Number of coarser levels that a mesh has.
pub(crate) fn coarser_levels(mesh: &RawMesh) -> usize {
    let of_primitive = mesh.clustered.iter().map(|c| c.clusters.levels() - 1);
    mesh.levels.len().max(of_primitive.max().unwrap_or(0))
}

/// Range of primitives, counted over all meshes, for each mesh.
fn parts_of_meshes_of(meshes: &[RawMesh]) -> Vec<std::ops::Range<usize>> {
    let mut first = 0;
    let range = |mesh: &RawMesh| {
        let range = first..first + mesh.primitives.len();
        first = range.end;
        range
    };
    meshes.iter().map(range).collect()
}
