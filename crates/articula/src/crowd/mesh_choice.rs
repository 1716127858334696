//! Which mesh levels a crowd has, and the levels of its character with them.

use super::mesh_lods::{LevelledMeshes, MeshLevelTriangles, MeshLods, mesh_level_triangles};
use super::options::{CrowdOptions, JointLodMethod};
use crate::error::Result;
use crate::figure::Figure;
use crate::mesh_levels::{MAX_MESH_LEVELS, MeshLevelOptions};
use crate::prepared::stored::Stored;
use articula_build::{Asset, JointLodOptions, MergedLevels};

/// Returns the triangles of the mesh levels, if there are to be several. Where the options name no number,
/// they are those of the file, else those for crowds, which are measured in pairs with merged joints. What
/// was prepared without has none: it is to be opened at once.
pub(super) fn mesh_levels(
    figure: Option<&Figure>,
    asset: &Asset,
    options: &CrowdOptions,
    is_prepared: bool,
    warnings: &mut Vec<String>,
) -> Result<Option<MeshLevelTriangles>> {
    let stored = figure.map_or(0, Figure::stored_mesh_level_count);
    let (wanted, of) = match options.mesh_levels {
        Some(wanted) => (wanted, MeshLevelOptions::levels(wanted)),
        None if options.joints != JointLodMethod::Merged => return Ok(None),
        None if is_prepared && stored <= 1 => return Ok(None),
        None => {
            let of = MeshLevelOptions::for_crowds(asset.mesh.triangles.len());
            let has_own = (2..=MAX_MESH_LEVELS).contains(&stored);
            (if has_own { stored } else { of.targets.len() }, of)
        }
    };
    if wanted <= 1 {
        return Ok(None);
    }
    let triangles = mesh_level_triangles(figure, asset, wanted, &of)?;
    let found = triangles.levels.len();
    if found < wanted && options.mesh_levels.is_some() {
        warnings.push(format!(
            "{found} mesh levels are used instead of {wanted}: coarser ones are not stored, or they are empty, equal to finer ones or too far from the original"
        ));
    }
    Ok(Some(triangles))
}

/// The levels of a character with their meshes: pairs of joint and mesh levels, if there are several of these.
pub(super) fn levelled(
    asset: &Asset,
    levels: MergedLevels,
    triangles: Option<MeshLevelTriangles>,
    opts: &JointLodOptions,
    stored: Option<&Stored<'_>>,
) -> Result<LevelledMeshes> {
    if let Some(triangles) = triangles.filter(|t| t.levels.len() > 1) {
        let count = triangles.levels.len();
        let stored = stored.filter(|s| triangles.are_stored && s.mesh_levels() == count);
        return MeshLods::paired(asset, &levels, triangles.levels, opts, stored);
    }
    let all = 0..levels.joint_lods.levels();
    let meshes = all.map(|l| levels.skins.mesh(l, &asset.mesh)).collect();
    Ok(LevelledMeshes {
        mesh_lods: None,
        is_stored: stored.is_some(),
        levels,
        meshes,
    })
}
