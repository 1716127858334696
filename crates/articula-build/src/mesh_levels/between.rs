//! A level between two that are wanted, where the coarser one has too large an error.
//!
//! Source: `docs/methods/clustered-mesh.md` part 6.

use super::MeshLevelOptions;
use crate::simplify::LevelTriangles;
use crate::surface_distance::LevelDistances;
use articula_core::Mismatch;

/// Greatest number of triangles of such a level, relative to the next finer one: what it saves must be worth
/// a level.
const MOST: f64 = 0.75;

/// Most halvings; each doubles the number of levels that simplification notes.
const MOST_HALVINGS: u32 = 6;

/// Number of levels that simplification notes between two targets.
pub(super) fn count(opts: &MeshLevelOptions) -> usize {
    match opts.max_error {
        Some(_) => (1 << opts.halvings.min(MOST_HALVINGS)) - 1,
        None => 0,
    }
}

/// Returns the coarsest of some levels, finest first, whose error is within a limit, as far as halving finds
/// it: errors need not rise with every level. Only those with a number of triangles between two others'
/// count.
pub(super) fn coarsest(
    mut levels: Vec<LevelTriangles>,
    (finer, coarser): (usize, usize),
    limit: f32,
    mut measured: impl FnMut(&LevelTriangles) -> Result<(LevelDistances, f32), Mismatch>,
) -> Result<Option<(LevelTriangles, LevelDistances)>, Mismatch> {
    let most = (MOST * finer as f64) as usize;
    levels.retain(|level| (coarser + 1..=most).contains(&level.triangles.len()));
    let mut found = None;
    let (mut from, mut to) = (0, levels.len());
    while from < to {
        let middle = (from + to) / 2;
        let (distances, share) = measured(&levels[middle])?;
        if share <= limit {
            found = Some((middle, distances));
            from = middle + 1;
        } else {
            to = middle;
        }
    }
    Ok(found.map(|(level, distances)| (levels.swap_remove(level), distances)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_finds_the_coarsest_level_within_a_limit() {
        let of = |count| LevelTriangles {
            triangles: vec![[0, 1, 2]; count],
            parts: Vec::new(),
        };
        let counts = [90, 70, 60, 50, 40, 30, 20, 10];
        for limit in 0..=100 {
            let mut asked = 0;
            let levels = counts.map(of).to_vec();
            // The error rises as triangles get fewer.
            let found = coarsest(levels, (100, 15), limit as f32, |level| {
                asked += 1;
                Ok((
                    LevelDistances::default(),
                    100.0 - level.triangles.len() as f32,
                ))
            });
            let found = found.unwrap().map(|(level, _)| level.triangles.len());
            // Not 90, which saves too little, and not 10.
            let within = counts[1..7].iter().filter(|count| 100 - *count <= limit);
            assert_eq!(found, within.min().copied(), "{limit}");
            assert!(asked <= 3, "{asked}");
        }
    }
}
