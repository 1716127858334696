//! Distance of levels from the original, at rest and in poses not used for simplification.

use super::characters::Subject;
use super::contestants::{Contestant, Made, Posed, levels};
use anyhow::Result;
use articula_build::LevelTriangles;
use articula_build::{DistanceOptions, surface_distances};
use articula_core::SurfaceError;
use rayon::prelude::*;

/// Height of the figure in the picture, in lines.
pub(super) const LINES_PX: f32 = 1080.0;

/// One level of one simplifier.
pub(super) struct Row {
    pub(super) who: Contestant,
    /// Index of the level, coarsest first.
    pub(super) level: usize,
    pub(super) triangles: usize,
    pub(super) vertices: usize,
    /// Whether seams had to be crossed to reach the number of triangles.
    pub(super) crossed_seams: bool,
    pub(super) rest: Millimetres,
    pub(super) motion: Millimetres,
}

/// Distances, scaled to the nominal height of the figure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Millimetres {
    pub(super) max: f32,
    pub(super) p99: f32,
    pub(super) mean: f32,
}

impl Millimetres {
    fn new(of: SurfaceError, scale: f32) -> Self {
        Self {
            max: 1e3 * scale * of.max_metres,
            p99: 1e3 * scale * of.p99_metres,
            mean: 1e3 * scale * of.mean_metres,
        }
    }
}

/// Measures all simplifiers at every level but the original.
pub(super) fn rows(
    subject: &Subject,
    posed: &Posed,
    ours: &[LevelTriangles],
    contestants: &[Contestant],
) -> Result<Vec<Row>> {
    let scale = subject.told_height_metres / subject.height_metres(posed.rest());
    let found: Result<Vec<Vec<Row>>> = contestants
        .par_iter()
        .map(|who| {
            let levels = levels(*who, subject, posed, ours)?;
            rows_of(&levels, posed, scale)
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}

fn rows_of(made: &Made, posed: &Posed, scale: f32) -> Result<Vec<Row>> {
    let Some((original, coarser)) = made.levels.split_last() else {
        return Ok(Vec::new());
    };
    let triangles: Vec<&[[u32; 3]]> = coarser.iter().map(|l| l.triangles.as_slice()).collect();
    let opts = DistanceOptions {
        two_sided: true,
        ..DistanceOptions::default()
    };
    let distances = surface_distances(
        &original.triangles,
        &triangles,
        posed.rest(),
        &posed.measuring,
        &opts,
    )?;
    Ok(distances
        .iter()
        .zip(coarser)
        .enumerate()
        .map(|(level, (found, of))| Row {
            who: made.who,
            level,
            triangles: of.triangles.len(),
            vertices: used(&of.triangles),
            crossed_seams: made.crossed_seams[level],
            rest: Millimetres::new(found.rest, scale),
            motion: Millimetres::new(found.motion, scale),
        })
        .collect())
}

/// Number of vertices used by triangles.
fn used(triangles: &[[u32; 3]]) -> usize {
    let mut all: Vec<u32> = triangles.iter().flatten().copied().collect();
    all.sort_unstable();
    all.dedup();
    all.len()
}
