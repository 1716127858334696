//! Level table of a character's meshes: size and error of each mesh level, by which levels are
//! chosen.
//!
//! Source: `docs/methods/clustered-mesh.md` part 7. All objects of a character have the same list
//! of levels.

use crate::Mismatch;
use crate::mesh_level::MeshErrors;

/// Statistics of the distance between two surfaces over many points, in metres. All infinite for a
/// level without triangles, or whose error is unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SurfaceError {
    /// Maximum.
    pub max_metres: f32,
    /// 99th percentile.
    pub p99_metres: f32,
    /// 95th percentile.
    pub p95_metres: f32,
    /// Mean.
    pub mean_metres: f32,
}

/// Size and error of one level over all meshes of a character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelRow {
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices that they use.
    pub vertices: u64,
    /// Distance from the original surface at rest.
    pub rest: SurfaceError,
    /// Distance from the original surface over poses of the character's motions.
    pub motion: SurfaceError,
}

/// Size and error of all mesh levels of a character.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelTable {
    /// Levels from the original to the coarsest.
    pub levels: Vec<LevelRow>,
    /// Names of the regions that may be at different levels; empty if there is only one.
    pub regions: Vec<String>,
    /// Coarsest level of the range, from the original on, within which regions may be at different
    /// levels.
    pub mixable_to: usize,
}

impl LevelTable {
    /// Returns the errors in motion, by which a level is chosen.
    ///
    /// # Errors
    /// A [`Mismatch`] if there is no level, or the error of the first one is not 0.
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
