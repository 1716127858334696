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

    /// Checks that regions can be shown at these levels without a gap between them: one level for
    /// each region, all equal or none coarser than [`LevelTable::mixable_to`].
    ///
    /// # Errors
    /// A [`Mismatch`] that names the region, and the levels that it may have.
    pub fn check_mix(&self, levels: &[u16]) -> Result<(), Mismatch> {
        let regions = self.regions.len().max(1);
        if levels.len() != regions {
            let what = format!("{} levels for {regions} regions", levels.len());
            return Err(Mismatch::new("levels", what));
        }
        let place = |region: usize| match self.regions.get(region) {
            Some(name) => format!("region \"{name}\""),
            None => "mesh".to_owned(),
        };
        let count = self.levels.len();
        if let Some(r) = levels.iter().position(|l| usize::from(*l) >= count) {
            let what = format!(
                "there is no level {}; the levels are 0 to {}",
                levels[r],
                count.saturating_sub(1)
            );
            return Err(Mismatch::new(place(r), what));
        }
        if levels.iter().all(|l| *l == levels[0]) {
            return Ok(());
        }
        match levels
            .iter()
            .position(|l| usize::from(*l) > self.mixable_to)
        {
            None => Ok(()),
            Some(r) => {
                let what = format!(
                    "level {} cannot stand beside another level without gaps; give regions levels \
                     of 0 to {}, or all regions the same level",
                    levels[r], self.mixable_to
                );
                Err(Mismatch::new(place(r), what))
            }
        }
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

    #[test]
    fn regions_differ_only_where_the_seam_is_the_same() {
        let row = LevelRow {
            triangles: 0,
            vertices: 0,
            rest: SurfaceError::default(),
            motion: SurfaceError::default(),
        };
        let table = LevelTable {
            levels: vec![row; 4],
            regions: vec!["face".into(), "rest".into()],
            mixable_to: 2,
        };
        for good in [[0, 0], [0, 2], [2, 1], [3, 3]] {
            assert_eq!(table.check_mix(&good), Ok(()), "{good:?}");
        }
        let refused = |levels: &[u16]| table.check_mix(levels).unwrap_err().to_string();
        assert!(refused(&[0, 3]).contains("region \"rest\""));
        assert!(refused(&[0, 3]).contains("0 to 2"));
        assert!(refused(&[4, 4]).contains("the levels are 0 to 3"));
        assert!(refused(&[1]).contains("1 levels for 2 regions"));
        let whole = LevelTable {
            regions: Vec::new(),
            ..table
        };
        assert_eq!(whole.check_mix(&[3]), Ok(()));
    }
}
