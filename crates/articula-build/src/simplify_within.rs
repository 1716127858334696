//! Fewer triangles, whose surface stays within a distance of the original in all poses.
//!
//! The simplifier bounds the distance of removed vertices in a few poses. The surface is then measured in
//! all of them, in both directions; poses in which it is too far are given to the simplifier too, and the
//! limit is scaled by what was measured.

use crate::simplify::{LevelTriangles, SimplifyLimit, SimplifyOptions, simplify};
use crate::surface_distance::greatest_distances;
use articula_core::{Mesh, Mismatch};
use glam::Vec3;

/// Greatest costs that are tried, of which one or the other leaves fewer triangles.
const COSTS: [f64; 2] = [1.0, 4.0];
/// Number of attempts with each, and the share of the bound that is near enough.
const TRIES: usize = 5;
const NEAR: f32 = 0.85;
/// The share of the bound that each aims at, and the factors by which a limit may change.
const AIM: f32 = 0.95;
const LOWER: (f32, f32) = (0.5, 0.95);
const HIGHER: (f32, f32) = (1.05, 1.6);
/// Poses that the simplifier begins with, besides the first, and those that an attempt may add.
const FIRST: usize = 7;
const MORE: usize = 3;
/// Vertices above which there are fewer attempts, with one cost.
const LARGE: usize = 200_000;
const TRIES_OF_LARGE: usize = 2;
/// Greatest number of points that the simplifier holds in all poses together.
const POINTS: usize = 4_000_000;

/// A mesh with fewer triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SimplifiedWithin {
    /// The triangles that remain, over the vertices of the original.
    pub level: LevelTriangles,
    /// Greatest distance between the surfaces in any pose, in both directions, in metres.
    pub metres: f32,
}

/// Removes triangles of a mesh as long as its surface stays within a bound in metres in all poses, of which
/// the first is at rest. No component vanishes. Of `options`, the targets and the limit are ignored.
///
/// Distances are measured at vertices, middles of edges and centres of triangles. `None` if no triangle
/// can be removed. Deterministic.
///
/// # Errors
/// As [`simplify`].
pub fn simplify_within(
    mesh: &Mesh,
    poses: &[Vec<Vec3>],
    bound: f32,
    options: &SimplifyOptions,
) -> Result<Option<SimplifiedWithin>, Mismatch> {
    let mut best: Option<SimplifiedWithin> = None;
    let costs = match mesh.len() {
        0..=LARGE => &COSTS[..],
        _ => &COSTS[..1],
    };
    for &cost in costs {
        let found = within_at_cost(mesh, poses, (bound, cost), options)?;
        let left = |found: &SimplifiedWithin| found.level.triangles.len();
        let is_fewer =
            |best: &SimplifiedWithin| found.as_ref().is_some_and(|f| left(f) < left(best));
        if best.as_ref().is_none_or(is_fewer) {
            best = found;
        }
    }
    Ok(best)
}

/// The same with one greatest cost of a collapse.
fn within_at_cost(
    mesh: &Mesh,
    poses: &[Vec<Vec3>],
    (bound, cost): (f32, f64),
    options: &SimplifyOptions,
) -> Result<Option<SimplifiedWithin>, Mismatch> {
    let most = (POINTS / mesh.len().max(1)).clamp(2, poses.len().max(2));
    let mut shaping = spread(poses.len(), FIRST.min(most - 1));
    let mut limit = bound;
    let mut best: Option<SimplifiedWithin> = None;
    let tries = match mesh.len() {
        0..=LARGE => TRIES,
        _ => TRIES_OF_LARGE,
    };
    for _ in 0..tries {
        let options = SimplifyOptions {
            targets: vec![1.0, 0.0],
            between: 0,
            measured: true,
            limit: Some(SimplifyLimit {
                metres: limit,
                cost,
            }),
            ..options.clone()
        };
        let shapes = shaping.iter().filter_map(|p| poses.get(*p).cloned());
        let shapes: Vec<Vec<Vec3>> = shapes.collect();
        let mut levels = simplify(mesh, &shapes, &options)?.levels.into_iter();
        let (Some(original), Some(level)) = (levels.next(), levels.next()) else {
            break;
        };
        let triangles = [original.triangles.as_slice(), &level.triangles];
        let errors = greatest_distances(triangles, poses)?;
        let metres = errors.iter().copied().fold(0.0, f32::max);
        let is_fewer = |count: usize| level.triangles.len() < count;
        if metres <= bound {
            let fewest = best
                .as_ref()
                .map_or(original.triangles.len(), |best| best.level.triangles.len());
            let is_near =
                metres >= NEAR * bound || level.triangles.len() == original.triangles.len();
            if is_fewer(fewest) {
                best = Some(SimplifiedWithin { level, metres });
            }
            if is_near {
                break;
            }
            limit *= (AIM * bound / metres.max(1e-9)).clamp(HIGHER.0, HIGHER.1);
        } else {
            let mut worst: Vec<usize> = (0..poses.len()).filter(|p| errors[*p] > bound).collect();
            worst.sort_by(|a, b| errors[*b].total_cmp(&errors[*a]));
            worst.retain(|p| !shaping.contains(p));
            worst.truncate(MORE.min(most.saturating_sub(shaping.len())));
            shaping.extend(worst);
            limit *= (AIM * bound / metres).clamp(LOWER.0, LOWER.1);
        }
    }
    Ok(best)
}

/// The first of some poses, and others evenly spread.
fn spread(poses: usize, others: usize) -> Vec<usize> {
    let others = others.min(poses.saturating_sub(1));
    let at = |i: usize| 1 + (2 * i + 1) * (poses - 1) / (2 * others);
    std::iter::once(0).chain((0..others).map(at)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Part;
    use glam::{Vec2, Vec4};

    const SIDE: usize = 8;

    /// A flat square of 64 squares.
    fn sheet() -> Mesh {
        let places = (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| (x, z)));
        let positions: Vec<Vec3> = places
            .map(|(x, z)| Vec3::new(x as f32, 0.0, z as f32))
            .collect();
        let at = |x: usize, z: usize| (x + (SIDE + 1) * z) as u32;
        let squares = (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| (x, z)));
        let triangles: Vec<[u32; 3]> = squares
            .flat_map(|(x, z)| {
                let [a, b, c, d] = [at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)];
                [[a, c, b], [a, d, c]]
            })
            .collect();
        let count = positions.len();
        Mesh {
            normals: vec![Vec3::Y; count],
            texcoords: vec![Vec2::ZERO; count],
            colors: vec![Vec4::ONE; count],
            parts: vec![Part {
                name: "sheet".into(),
                mesh: 0,
                material: None,
                draw_material: None,
                vertices: 0..count,
                triangles: 0..triangles.len(),
            }],
            triangles,
            positions,
            ..Mesh::default()
        }
    }

    #[test]
    fn what_rises_in_a_pose_that_the_simplifier_does_not_begin_with_is_kept() {
        let mesh = sheet();
        let flat = vec![mesh.positions.clone(); 20];
        let options = SimplifyOptions::default();
        let found = simplify_within(&mesh, &flat, 0.1, &options)
            .unwrap()
            .unwrap();
        assert_eq!((found.level.triangles.len(), found.metres), (2, 0.0));
        let pose = (0..20).find(|p| !spread(20, FIRST).contains(p)).unwrap();
        let middle = mesh.len() / 2;
        let mut risen = flat.clone();
        risen[pose][middle].y = 1.0;
        let found = simplify_within(&mesh, &risen, 0.1, &options)
            .unwrap()
            .unwrap();
        assert!(found.metres <= 0.1, "{}", found.metres);
        let corners = found.level.triangles.as_flattened();
        assert!(corners.contains(&(middle as u32)));
        assert!(found.level.triangles.len() < mesh.triangles.len());
    }

    #[test]
    fn a_mesh_without_triangles_or_poses_to_spare_is_none_or_refused() {
        let mesh = sheet();
        let options = SimplifyOptions::default();
        assert!(simplify_within(&mesh, &[], 1.0, &options).is_err());
        let all = SimplifyOptions {
            locked: (0..mesh.len() as u32).collect(),
            ..options
        };
        let poses = [mesh.positions.clone()];
        assert_eq!(simplify_within(&mesh, &poses, 1.0, &all), Ok(None));
        assert_eq!(spread(1, 7), [0]);
        assert_eq!(spread(3, 7), [0, 1, 2]);
    }
}
