//! Distance of the surface of a mesh level from the original surface, at rest and in motion.
//!
//! Source: the one-sided distance of Metro (Cignoni, Rocchini and Scopigno, Metro: measuring error
//! on simplified surfaces, 1998), from points of the original to the closest point of the level.
//! Unlike there, both surfaces are in the same pose, pose after pose, and the points are the
//! original's vertices and face centres. Definition and example: `docs/metrics.md`.
//!
//! Near triangles stay near each other in a pose, so one bounding box tree is built over the
//! triangles of a level at rest and refitted for each pose, and the search for each point starts at
//! the triangle that was closest in the pose before.

mod attach;
mod skin_point;
#[cfg(test)]
mod slow;
mod tree;

pub use attach::attach;
pub(crate) use skin_point::corners;
pub use skin_point::{SkinPoint, compact};

use crate::points::draw_vertices;
use articula_core::percentile;
use articula_core::{Mismatch, SurfaceError};
use glam::Vec3;
use tree::{NO_TRIANGLE, SurfaceTree};

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
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for DistanceOptions {
    /// Up to 100,000 vertices and 10,000 face centres, one-sided.
    fn default() -> Self {
        Self {
            vertices: 100_000,
            face_centres: 10_000,
            two_sided: false,
            seed: 1,
        }
    }
}

/// Distances of one level from the original.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelDistances {
    /// Distances at rest.
    pub rest: SurfaceError,
    /// Distances in motion: the maximum over all poses, percentiles over the points of all poses
    /// together, the mean of the means. Those at rest if there is no pose.
    pub motion: SurfaceError,
    /// Distances in each pose.
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
    let mut there: Vec<Search> = levels
        .iter()
        .map(|l| Search::new(SurfaceTree::new(l, rest), l, points.clone(), rest.len()))
        .collect();
    let mut tallies: Vec<Tally> = levels.iter().map(|_| Tally::default()).collect();
    for pose in std::iter::once(rest).chain(motion.iter().map(Vec::as_slice)) {
        for (search, tally) in there.iter_mut().zip(&mut tallies) {
            search.tree.refit(pose);
            tally.add(search.distances(pose));
        }
    }
    let mut found: Vec<LevelDistances> = tallies.into_iter().map(Tally::level).collect();
    if opts.two_sided {
        let back = way_back(original, levels, rest, motion);
        for (level, back) in found.iter_mut().zip(&back) {
            level.raise(back);
        }
    }
    Ok(found)
}

/// Distances from points of each level to the original.
fn way_back(
    original: &[[u32; 3]],
    levels: &[&[[u32; 3]]],
    rest: &[Vec3],
    motion: &[Vec<Vec3>],
) -> Vec<LevelDistances> {
    let mut tree = SurfaceTree::new(original, rest);
    let all = |level: &&[[u32; 3]]| {
        let mut points = Points::default();
        points.add_triangles(level);
        let hints = vec![NO_TRIANGLE; points.len()];
        (points, hints, Tally::default())
    };
    let mut back: Vec<(Points, Vec<u32>, Tally)> = levels.iter().map(all).collect();
    for pose in std::iter::once(rest).chain(motion.iter().map(Vec::as_slice)) {
        tree.refit(pose);
        for (points, hints, tally) in &mut back {
            tally.add(distances(&tree, points, hints, pose));
        }
    }
    back.into_iter()
        .map(|(_, _, tally)| tally.level())
        .collect()
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

/// Points on a surface: vertices, and means of two or three of them.
#[derive(Debug, Clone, Default)]
struct Points {
    vertices: Vec<u32>,
    edges: Vec<[u32; 2]>,
    centres: Vec<[u32; 3]>,
}

impl Points {
    /// Vertices that triangles use, and face centres.
    fn of(triangles: &[[u32; 3]], vertices: usize, opts: &DistanceOptions) -> Self {
        let mut is_used = vec![false; vertices];
        for v in triangles.iter().flatten() {
            is_used[*v as usize] = true;
        }
        let used: Vec<u32> = (0..vertices as u32)
            .filter(|v| is_used[*v as usize])
            .collect();
        let some = |total, count| draw_vertices(total, count, opts.seed);
        let vertices = some(used.len(), opts.vertices);
        let centres = some(triangles.len(), opts.face_centres);
        Self {
            vertices: vertices.iter().map(|i| used[*i as usize]).collect(),
            edges: Vec::new(),
            centres: centres.iter().map(|t| triangles[*t as usize]).collect(),
        }
    }

    /// Adds face centres and edge midpoints.
    fn add_triangles(&mut self, triangles: &[[u32; 3]]) {
        self.centres.extend(triangles);
        for [a, b, c] in triangles {
            self.edges.extend([[*a, *b], [*b, *c], [*c, *a]]);
        }
    }

    fn len(&self) -> usize {
        self.vertices.len() + self.edges.len() + self.centres.len()
    }

    /// Positions of the points in a pose.
    fn posed<'a>(&'a self, pose: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
        let at = |v: &u32| pose[*v as usize];
        let vertices = self.vertices.iter().map(at);
        let edges = self.edges.iter().map(move |[a, b]| 0.5 * (at(a) + at(b)));
        let third = 1.0 / 3.0;
        let centres = self.centres.iter();
        let centres = centres.map(move |[a, b, c]| third * (at(a) + at(b) + at(c)));
        vertices.chain(edges).chain(centres)
    }
}

/// One level, the points measured against it, and the closest triangle of each so far.
struct Search {
    tree: SurfaceTree,
    points: Points,
    hints: Vec<u32>,
}

impl Search {
    fn new(tree: SurfaceTree, level: &[[u32; 3]], points: Points, vertices: usize) -> Self {
        // A vertex that the level still has is found immediately.
        let mut of_vertex = vec![NO_TRIANGLE; vertices];
        for (t, triangle) in level.iter().enumerate() {
            for v in triangle {
                of_vertex[*v as usize] = tree.place(t);
            }
        }
        let mut hints: Vec<u32> = points
            .vertices
            .iter()
            .map(|v| of_vertex[*v as usize])
            .collect();
        hints.resize(points.len(), NO_TRIANGLE);
        Self {
            tree,
            points,
            hints,
        }
    }

    fn distances(&mut self, pose: &[Vec3]) -> Vec<f32> {
        distances(&self.tree, &self.points, &mut self.hints, pose)
    }
}

fn distances(tree: &SurfaceTree, points: &Points, hints: &mut [u32], pose: &[Vec3]) -> Vec<f32> {
    let mut out = Vec::with_capacity(hints.len());
    for (point, hint) in points.posed(pose).zip(hints) {
        if point.is_finite() {
            let (squared, place) = tree.closest(point, *hint);
            *hint = place;
            out.push(squared.sqrt());
        }
    }
    out
}

/// Distances of one level, pose by pose, the rest pose first.
#[derive(Debug, Default)]
struct Tally {
    poses: Vec<SurfaceError>,
    /// Distances in all poses but the first.
    all: Vec<f32>,
}

impl Tally {
    fn add(&mut self, mut distances: Vec<f32>) {
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

    #[test]
    fn points_are_the_vertices_in_use_and_the_centres() {
        let pose = [0.0, 1.0, 2.0, 100.0, 5.0].map(|x| Vec3::X * x);
        let triangles = [[0, 1, 4], [1, 2, 4]];
        let opts = DistanceOptions::default();
        let mut points = Points::of(&triangles, pose.len(), &opts);
        let at = |points: &Points| -> Vec<f32> { points.posed(&pose).map(|p| p.x).collect() };
        let near = |found: Vec<f32>, expected: &[f32]| {
            assert_eq!(found.len(), expected.len());
            let pairs = found.iter().zip(expected);
            assert!(
                pairs.clone().all(|(a, b)| (a - b).abs() < 1e-5),
                "{found:?}"
            );
        };
        assert_eq!(points.len(), 6);
        near(at(&points), &[0.0, 1.0, 2.0, 5.0, 2.0, 8.0 / 3.0]);
        points.add_triangles(&[[0, 2, 4]]);
        assert_eq!(points.len(), 10);
        let edges = [1.0, 3.5, 2.5];
        let centres = [2.0, 8.0 / 3.0, 7.0 / 3.0];
        near(
            at(&points),
            &[&[0.0, 1.0, 2.0, 5.0], &edges[..], &centres].concat(),
        );
        let few = DistanceOptions {
            vertices: 2,
            face_centres: 1,
            ..opts
        };
        assert_eq!(Points::of(&triangles, pose.len(), &few).len(), 3);
    }
}
