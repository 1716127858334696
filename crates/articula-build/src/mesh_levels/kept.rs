//! Which levels of a simplified mesh are made.
//!
//! Source: `docs/methods/clustered-mesh.md` part 6.

use super::{MeshLevelOptions, between, mix};
use crate::character::Asset;
use crate::poses::{Poses, positions};
use crate::simplify::{LevelTriangles, Simplified, extent};
use crate::surface_distance::LevelDistances;
use articula_core::Mismatch;

/// A level that was wanted and is not made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOutLevel {
    /// Its fraction of the triangles, as wanted.
    pub target: f64,
    /// Its number of triangles.
    pub triangles: usize,
    /// Why it is not made.
    pub reason: LeftOutReason,
    /// Number of triangles of the level that is made instead, between it and the next finer one.
    pub instead: Option<usize>,
}

/// Why a level is not made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeftOutReason {
    /// It has no triangles.
    Empty,
    /// It has the triangles of the next finer level.
    Equal,
    /// Its error in motion, or that of a finer level, is above the limit. Holds the error relative
    /// to the longest side of the bounding box at rest.
    TooCoarse(f32),
}

/// The levels that are made.
pub(super) struct Kept {
    pub(super) levels: Vec<LevelTriangles>,
    /// Distances of each level; empty if not measured.
    pub(super) distances: Vec<LevelDistances>,
    pub(super) left_out: Vec<LeftOutLevel>,
    /// Longest side of the bounding box at rest.
    pub(super) size_metres: f32,
}

/// Selects the levels to be made, and measures them if `is_measured`. The limit of errors needs a
/// measurement.
pub(super) fn kept(
    asset: &Asset,
    simplified: Simplified,
    poses: &Poses,
    opts: &MeshLevelOptions,
    is_measured: bool,
) -> Result<Kept, Mismatch> {
    let mut levels: Vec<LevelTriangles> = Vec::new();
    let mut targets = Vec::new();
    let mut left_out = Vec::new();
    for (level, target) in simplified.levels.into_iter().zip(&opts.simplify.targets) {
        let triangles = level.triangles.len();
        // A level consists of changed triangles of the next finer one, and each change removes some.
        let reason = match levels.last() {
            Some(_) if triangles == 0 => Some(LeftOutReason::Empty),
            Some(finer) if finer.triangles.len() == triangles => Some(LeftOutReason::Equal),
            _ => None,
        };
        match reason {
            Some(reason) => left_out.push(LeftOutLevel {
                target: *target,
                triangles,
                reason,
                instead: None,
            }),
            None => {
                levels.push(level);
                targets.push(*target);
            }
        }
    }
    let mut distances = Vec::new();
    if is_measured {
        let lists: Vec<&[[u32; 3]]> = levels.iter().map(|l| &l.triangles[..]).collect();
        distances = mix::measured(asset, &lists, poses, &opts.distance)?;
    }
    let size_metres = extent(&positions(asset, &poses.shaping[..1])[0]);
    if let Some(limit) = opts.max_error {
        let share =
            |d: &LevelDistances| error_share(d.rest.max_metres, d.motion.max_metres, size_metres);
        let fine = distances.iter().position(|d| share(d) > limit);
        let fine = fine.unwrap_or(levels.len()).max(1);
        let coarse: Vec<_> = levels.drain(fine..).zip(distances.drain(fine..)).collect();
        let mut instead = None;
        if let (Some(finer), Some((refused, _))) = (levels.last(), coarse.first()) {
            let counts = (finer.triangles.len(), refused.triangles.len());
            let original = &levels[0].triangles;
            let found = between::coarsest(simplified.between, counts, limit, |level| {
                let lists = [&original[..], &level.triangles[..]];
                let mut found = mix::measured(asset, &lists, poses, &opts.distance)?;
                let found = found.pop().unwrap_or_default();
                let share = share(&found);
                Ok((found, share))
            })?;
            if let Some((level, found)) = found {
                instead = Some(level.triangles.len());
                levels.push(level);
                distances.push(found);
            }
        }
        let coarse = coarse.iter().zip(&targets[fine..]);
        left_out.extend(coarse.map(|((level, distances), target)| LeftOutLevel {
            target: *target,
            triangles: level.triangles.len(),
            reason: LeftOutReason::TooCoarse(share(distances)),
            instead: instead.take(),
        }));
        left_out.sort_by(|a, b| b.target.total_cmp(&a.target));
    }
    Ok(Kept {
        levels,
        distances,
        left_out,
        size_metres,
    })
}

/// The larger of the errors at rest and in motion, relative to the size of the figure.
pub(super) fn error_share(rest_metres: f32, motion_metres: f32, size_metres: f32) -> f32 {
    motion_metres.max(rest_metres) / size_metres
}
