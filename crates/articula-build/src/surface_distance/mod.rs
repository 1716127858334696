//! Distance of the surface of a mesh level from the original surface, at rest and in motion.
//!
//! Source: the one-sided distance of Metro (Cignoni, Rocchini and Scopigno, Metro: measuring error
//! on simplified surfaces, 1998), from points of the original to the closest point of the level.
//! Unlike there, both surfaces are in the same pose, pose after pose, and the points are the
//! original's vertices and face centres. Definition and example: `docs/metrics.md`.
//!
//! Near triangles stay near each other in a pose, so a bounding box tree is built over triangles at
//! rest and refitted for each pose, and the search for each point starts at the triangle that was
//! closest in the pose before. Triangles that several levels have in common are searched once for all
//! of these.

mod attach;
mod borders;
mod bounds;
mod four_triangles;
mod greatest;
mod pieces;
mod points;
mod search;
mod skin_point;
#[cfg(test)]
mod slow;
mod tree;

pub use attach::attach;
pub use borders::Borders;
pub(crate) use greatest::{TwoSurfaces, greatest_distances};
pub(crate) use skin_point::corners;
pub use skin_point::{SkinPoint, compact};

use articula_core::percentile;
use articula_core::{Mismatch, SurfaceError};
use glam::Vec3;
use pieces::Pieces;
use points::Points;
use search::Search;

/// Options of [`surface_distances`]: the points at which distances are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DistanceOptions {
    /// Maximum number of vertices of the original; if it has more, a seeded sample is taken.
    pub vertices: usize,
    /// Maximum number of face centres of the original; if it has more, a seeded sample is taken.
    pub face_centres: usize,
    /// Whether the reverse distance is measured too, from face centres and edge midpoints of the
    /// level to the original surface; each value is then the larger of both. It detects a level
    /// that spans a gap, such as a web between fingers.
    pub two_sided: bool,
    /// Of each so many poses the first is measured in full; of the others only the maximum, which takes a
    /// fraction of the time.
    pub full_every: usize,
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for DistanceOptions {
    /// Up to 100,000 vertices and 10,000 face centres, one-sided, all poses in full.
    fn default() -> Self {
        Self {
            vertices: 100_000,
            face_centres: 10_000,
            two_sided: false,
            full_every: 1,
            seed: 1,
        }
    }
}

/// Distances of one level from the original.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelDistances {
    /// Distances at rest.
    pub rest: SurfaceError,
    /// Distances in motion: the maximum over all poses, percentiles over the points of all poses that are
    /// measured in full together, the mean of their means. Those at rest if there is no pose.
    pub motion: SurfaceError,
    /// Distances in each pose that is measured in full.
    pub poses: Vec<SurfaceError>,
}

/// Returns the distance from the original surface to each level, at rest and in poses. Triangles of
/// all levels index the same vertices; a pose is the positions of all vertices.
///
/// Points that are not finite in a pose and triangles with such corners are ignored there. A
/// degenerate triangle counts as the segment or point it covers. Points are the vertices in use,
/// not samples by area: dense regions weigh more. O(points · log(triangles)) for each pose.
///
/// # Errors
/// A [`Mismatch`] if a pose has a different number of vertices than the rest pose, or a triangle
/// indexes a vertex that does not exist.
pub fn surface_distances(
    original: &[[u32; 3]],
    levels: &[&[[u32; 3]]],
    rest: &[Vec3],
    motion: &[Vec<Vec3>],
    opts: &DistanceOptions,
) -> Result<Vec<LevelDistances>, Mismatch> {
    check("original", original, rest.len())?;
    for (l, level) in levels.iter().enumerate() {
        check(&format!("levels[{l}]"), level, rest.len())?;
    }
    if let Some(p) = motion.iter().position(|p| p.len() != rest.len()) {
        let what = format!(
            "{} vertices, the rest pose has {}",
            motion[p].len(),
            rest.len()
        );
        return Err(Mismatch::new(format!("motion[{p}]"), what));
    }
    let points = Points::of(original, rest.len(), opts);
    let mut found = measured(levels, points, rest, motion, opts);
    if opts.two_sided {
        for (level, distances) in levels.iter().zip(&mut found) {
            let mut points = Points::default();
            points.add_triangles(level);
            for back in measured(&[original], points, rest, motion, opts) {
                distances.raise(&back);
            }
        }
    }
    Ok(found)
}

/// Distances of points to each level.
fn measured(
    levels: &[&[[u32; 3]]],
    points: Points,
    rest: &[Vec3],
    motion: &[Vec<Vec3>],
    opts: &DistanceOptions,
) -> Vec<LevelDistances> {
    let mut search = Search::new(Pieces::of(levels), rest, points);
    let mut tallies: Vec<Tally> = levels.iter().map(|_| Tally::default()).collect();
    let every = opts.full_every.max(1);
    let in_full = motion.iter().step_by(every).map(Vec::as_slice);
    for pose in std::iter::once(rest).chain(in_full) {
        for (tally, distances) in tallies.iter_mut().zip(search.distances(pose)) {
            tally.add(distances);
        }
    }
    let mut found: Vec<LevelDistances> = tallies.into_iter().map(Tally::level).collect();
    // The greatest so far rules out most points.
    let mut greatest: Vec<f32> = found.iter().map(|d| d.motion.max_metres).collect();
    let others = motion.iter().enumerate();
    for (_, pose) in others.filter(|(i, _)| !i.is_multiple_of(every)) {
        search.raise(pose, &mut greatest);
    }
    for (distances, greatest) in found.iter_mut().zip(greatest) {
        distances.motion.max_metres = greatest;
    }
    found
}

fn check(which: &str, triangles: &[[u32; 3]], vertices: usize) -> Result<(), Mismatch> {
    let outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= vertices);
    let Some(t) = triangles.iter().position(outside) else {
        return Ok(());
    };
    let what = format!(
        "{:?} names a vertex out of range: the mesh has {vertices} vertices",
        triangles[t]
    );
    Err(Mismatch::new(format!("{which}[{t}]"), what))
}

/// Distances of one level, pose by pose, the rest pose first.
#[derive(Debug, Default)]
struct Tally {
    poses: Vec<SurfaceError>,
    /// Distances in all poses but the first.
    all: Vec<f32>,
}

impl Tally {
    /// Adds a pose. Points without a distance, of NaN, do not count.
    fn add(&mut self, mut distances: Vec<f32>) {
        distances.retain(|distance| !distance.is_nan());
        if !self.poses.is_empty() {
            self.all.extend(&distances);
        }
        self.poses.push(summary(&mut distances));
    }

    fn level(mut self) -> LevelDistances {
        let rest = self.poses.first().copied().unwrap_or_default();
        let poses = self.poses.split_off(1);
        let motion = if poses.is_empty() {
            rest
        } else {
            let count = poses.len() as f32;
            SurfaceError {
                mean_metres: poses.iter().map(|p| p.mean_metres / count).sum(),
                ..summary(&mut self.all)
            }
        };
        LevelDistances {
            rest,
            motion,
            poses,
        }
    }
}

/// The larger of each pair of values.
fn greater(a: &SurfaceError, b: &SurfaceError) -> SurfaceError {
    SurfaceError {
        max_metres: a.max_metres.max(b.max_metres),
        p99_metres: a.p99_metres.max(b.p99_metres),
        p95_metres: a.p95_metres.max(b.p95_metres),
        mean_metres: a.mean_metres.max(b.mean_metres),
    }
}

impl LevelDistances {
    fn raise(&mut self, other: &Self) {
        self.rest = greater(&self.rest, &other.rest);
        self.motion = greater(&self.motion, &other.motion);
        for (pose, other) in self.poses.iter_mut().zip(&other.poses) {
            *pose = greater(pose, other);
        }
    }
}

fn summary(distances: &mut [f32]) -> SurfaceError {
    let count = distances.len().max(1) as f64;
    let sum: f64 = distances.iter().map(|d| f64::from(*d)).sum();
    let mut at = |fraction| {
        let value = percentile(distances, fraction);
        // The difference of two infinite values is NaN.
        if value.is_nan() { f32::INFINITY } else { value }
    };
    SurfaceError {
        max_metres: at(1.0),
        p99_metres: at(0.99),
        p95_metres: at(0.95),
        mean_metres: (sum / count) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_that_of_the_poses_and_percentiles_are_those_of_all_points() {
        let mut tally = Tally::default();
        // Points that are not finite in a pose are left out there.
        for distances in [vec![9.0, 9.0], vec![1.0, 2.0, 3.0], vec![6.0]] {
            tally.add(distances);
        }
        let found = tally.level();
        assert_eq!((found.rest.mean_metres, found.rest.max_metres), (9.0, 9.0));
        assert_eq!(
            (found.motion.mean_metres, found.motion.max_metres),
            (4.0, 6.0)
        );
        let means: Vec<f32> = found.poses.iter().map(|p| p.mean_metres).collect();
        assert_eq!(means, [2.0, 6.0]);
        let mut tally = Tally::default();
        tally.add(vec![1.0, 2.0]);
        let found = tally.level();
        assert_eq!(found.motion, found.rest, "without poses");
        assert_eq!(found.rest.mean_metres, 1.5);
    }
}
