//! What each level of a character's meshes costs and loses: the numbers that selection works with.
//!
//! Source: `docs/methods/clustered-mesh.md` 7. All objects of a character have the same list of levels.

use crate::Mismatch;
use crate::mesh_level::MeshErrors;

/// How far one surface lies from another over many points, metres. All infinite for a level that
/// has nothing left to show, or whose error is not known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SurfaceError {
    /// The greatest.
    pub max_metres: f32,
    /// 99th percentile.
    pub p99_metres: f32,
    /// 95th percentile.
    pub p95_metres: f32,
    /// Mean.
    pub mean_metres: f32,
}

/// One level over all meshes of a character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelRow {
    /// Triangles that it shows.
    pub triangles: u64,
    /// Vertices that they need.
    pub vertices: u64,
    /// Distance from the original surface at rest.
    pub rest: SurfaceError,
    /// The same over poses of the character's motions.
    pub motion: SurfaceError,
}

/// The levels of all meshes of a character.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelTable {
    /// The original first, then coarser and coarser ones.
    pub levels: Vec<LevelRow>,
    /// Names of the regions that may have levels of their own; none if there is but one.
    pub regions: Vec<String>,
    /// Coarsest level up to which regions may be at different levels, beginning with the original.
    pub mixable_to: usize,
}

impl LevelTable {
    /// The errors in motion that a level is chosen by.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no level, or the first one is not free of error.
    pub fn errors(&self) -> Result<MeshErrors, Mismatch> {
        let list = |number: fn(&SurfaceError) -> f32| -> Vec<f32> {
            self.levels.iter().map(|l| number(&l.motion)).collect()
        };
        MeshErrors::of_statistics(&list(|e| e.p95_metres), &list(|e| e.max_metres))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_chosen_by_motion() {
        let error = |p95_metres, max_metres| SurfaceError {
            max_metres,
            p99_metres: max_metres,
            p95_metres,
            mean_metres: 0.0,
        };
        let row = |motion| LevelRow {
            triangles: 1,
            vertices: 3,
            rest: error(0.0, 0.0),
            motion,
        };
        let mut table = LevelTable {
            levels: vec![
                row(error(0.0, 0.0)),
                row(error(0.01, 0.011)),
                row(error(0.01, 0.05)),
            ],
            ..LevelTable::default()
        };
        let errors = table.errors().unwrap();
        assert_eq!(errors.levels_metres(), [0.0, 0.01, 0.025]);
        table.levels.remove(0);
        assert!(table.errors().is_err());
    }
}
