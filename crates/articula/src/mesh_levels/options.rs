//! Options of mesh levels.

use articula_build::ErrorWeighting;
use articula_core::{Libm, Zone};
use std::collections::BTreeMap;

/// Triangle fractions of five levels; other numbers of levels are interpolated.
const FIVE_LEVELS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.015];

/// Maximum error in motion of a level, relative to the longest side of the bounding box at rest,
/// unless the fractions of the triangles are given one by one. Above it figures of several parts
/// come apart at neck and shins and lose hands and feet.
pub(crate) const MAX_ERROR: f32 = 0.05;

/// Maximum number of mesh levels that crowds are shown with, the original included.
pub const MAX_MESH_LEVELS: usize = 12;

/// Triangles of the coarsest of them, as far as simplification gets: enough for a figure 10 pixels high.
const CROWD_LEAST: f64 = 40.0;

/// Greatest share of the triangles of the next finer one.
const CROWD_SHARE: f64 = 0.6;

/// Options for making the mesh levels of a character.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshLevelOptions {
    /// Fraction of the triangles at each level, 0 to 1, decreasing from 1.
    pub targets: Vec<f64>,
    /// Maximum error in motion of a level, relative to the longest side of the bounding box at
    /// rest; a level above it and all coarser ones are not made. `None` makes them all.
    pub max_error: Option<f32>,
    /// Where a level is left out for its error, how often the range of triangles between it and the next
    /// finer one is halved to find one within [`Self::max_error`], which is made instead.
    pub halvings: u32,
    /// Factors on errors by body region name; 1 for regions without an entry.
    pub region_weights: Vec<(String, f32)>,
    /// Named zones that may be shown at independent levels; the remaining vertices form one more.
    pub split: Vec<(String, Zone)>,
    /// Poses and weights of the error that the simplifier minimises.
    pub weighting: ErrorWeighting,
    /// Vertices that no level removes, by mesh name; indices within the mesh.
    pub locked: BTreeMap<String, Vec<u32>>,
    /// Whether no level removes a feature point of the face, and errors count more where the face
    /// moves. Has no effect on a figure whose face is not found or doubtful.
    pub keep_face: bool,
    /// Whether the coarser levels are also written as `MSFT_lod` nodes.
    pub msft_lod: bool,
    /// Of each so many poses the first is measured in full: means and percentiles of errors in motion are
    /// those of these poses, maxima of all.
    pub full_every: usize,
    /// Whether each level is also coded alone, to compare sizes: as much work again as the stream.
    pub sizes_alone: bool,
}

impl MeshLevelOptions {
    /// Options for at most `count` levels, from all triangles down to 1.5 % of them, with errors of
    /// at most 5 % of the longest side of the bounding box.
    pub fn levels(count: usize) -> Self {
        Self {
            targets: default_targets(count),
            max_error: Some(MAX_ERROR),
            halvings: 0,
            region_weights: Vec::new(),
            split: Vec::new(),
            weighting: ErrorWeighting::PoseSummed,
            locked: BTreeMap::new(),
            keep_face: true,
            msft_lod: false,
            full_every: 1,
            sizes_alone: true,
        }
    }

    /// Options for the levels that crowds are shown with: at most [`MAX_MESH_LEVELS`], with equal ratios from all of so
    /// many triangles down to about 40, none of which is left out for its error and none of which keeps a feature
    /// point of the face that the error does not need. For those who choose levels by their errors, as
    /// [crowds](crate::crowd) do.
    pub fn for_crowds(triangles: usize) -> Self {
        let least = CROWD_LEAST / triangles.max(1) as f64;
        let mut levels = MAX_MESH_LEVELS;
        let share = |levels: usize| least.libm_powf(1.0 / (levels - 1) as f64);
        while levels > 1 && share(levels) > CROWD_SHARE {
            levels -= 1;
        }
        let target = |i: usize| share(levels).libm_powf(i as f64);
        let targets = match levels {
            1 => vec![1.0],
            _ => (0..levels).map(target).collect(),
        };
        Self {
            targets,
            max_error: None,
            keep_face: false,
            ..Self::levels(1)
        }
    }
}

/// Triangle fractions of `levels` levels, interpolated from those of five.
fn default_targets(levels: usize) -> Vec<f64> {
    let last = FIVE_LEVELS.len() - 1;
    let at = |i: usize| {
        let x = (i * last) as f64 / (levels.max(2) - 1) as f64;
        let below = (x as usize).min(last - 1);
        let (a, b) = (100.0 * FIVE_LEVELS[below], 100.0 * FIVE_LEVELS[below + 1]);
        let between = a * (b / a).libm_powf(x - below as f64);
        (between * 100.0).round() / 100.0 / 100.0
    };
    (0..levels).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_crowds_have_equal_ratios() {
        let of = |triangles| MeshLevelOptions::for_crowds(triangles).targets;
        for triangles in [67, 240, 600, 12_000, 50_000_000] {
            let targets = of(triangles);
            let steps = (targets.len() - 1) as f64;
            let share = (40.0 / triangles as f64).powf(1.0 / steps);
            for (i, target) in targets.iter().enumerate() {
                assert!(
                    (target / share.powi(i as i32) - 1.0).abs() < 1e-9,
                    "{targets:?}"
                );
            }
            assert!(share <= 0.6, "worth a level: {targets:?}");
            // With one more level they would be too many or too close.
            let closer = share.powf(steps / (steps + 1.0));
            assert!(
                targets.len() == MAX_MESH_LEVELS || closer > 0.6,
                "{targets:?}"
            );
        }
        for few in [0, 1, 40, 66] {
            assert_eq!(of(few), [1.0], "{few}");
        }
    }

    #[test]
    fn other_numbers_of_levels_run_along_the_five() {
        assert_eq!(default_targets(5), FIVE_LEVELS);
        assert_eq!(default_targets(1), [1.0]);
        assert_eq!(default_targets(2), [1.0, 0.015]);
        // Half-way: index 1 of 2 at three levels is index 2 of 4 at five.
        assert_eq!(default_targets(3), [1.0, 0.25, 0.015]);
        let nine = default_targets(9);
        // Between 100 and 50 percent: their geometric mean, to a hundredth of a percent.
        assert_eq!(nine[1], 7071.0 / 1e4);
        assert!(nine.windows(2).all(|w| w[0] > w[1]));
    }
}
