//! The greatest distance of two surfaces in some poses.

use super::check;
use super::pieces::Pieces;
use super::points::Points;
use super::search::Search;
use crate::clusters::rotated;
use articula_core::Mismatch;
use foldhash::HashSet;
use glam::Vec3;

/// Two surfaces over one array of vertices, of which only some triangles differ.
pub(crate) struct TwoSurfaces {
    searches: Vec<Search>,
}

impl TwoSurfaces {
    /// Prepares two surfaces, each with those of its triangles that the other has not. Distances are from
    /// vertices, middles of edges and centres of these to the other surface.
    pub(crate) fn new(
        [first, second]: [&[[u32; 3]]; 2],
        [of_first, of_second]: [&[[u32; 3]]; 2],
        rest: &[Vec3],
    ) -> Result<Self, Mismatch> {
        let pairs = [(of_first, second), (of_second, first)];
        for (changed, to) in pairs {
            check("changed", changed, rest.len())?;
            check("surface", to, rest.len())?;
        }
        let search = |(changed, to): (&[[u32; 3]], &[[u32; 3]])| {
            let mut points = Points::default();
            points.add_corners(changed);
            points.add_triangles(changed);
            (!changed.is_empty()).then(|| Search::new(Pieces::of(&[to]), rest, points))
        };
        Ok(Self {
            searches: pairs.into_iter().filter_map(search).collect(),
        })
    }

    /// Raises a distance to the greatest in a pose. Points that are not finite and triangles with such
    /// corners are ignored.
    ///
    /// # Panics
    /// If the pose has fewer vertices than the surfaces.
    pub(crate) fn raise(&mut self, pose: &[Vec3], greatest: &mut f32) {
        for search in &mut self.searches {
            search.raise(pose, std::slice::from_mut(greatest));
        }
    }
}

/// Returns the greatest distance between two surfaces over the same vertices in each pose, in both
/// directions.
///
/// # Errors
/// A [`Mismatch`] if a triangle indexes a vertex that a pose has not.
pub(crate) fn greatest_distances(
    [original, level]: [&[[u32; 3]]; 2],
    poses: &[Vec<Vec3>],
) -> Result<Vec<f32>, Mismatch> {
    let Some(rest) = poses.iter().min_by_key(|pose| pose.len()) else {
        return Ok(Vec::new());
    };
    let known =
        |of: &[[u32; 3]]| -> HashSet<[u32; 3]> { of.iter().copied().map(rotated).collect() };
    let changed = |of: &[[u32; 3]], known: HashSet<[u32; 3]>| -> Vec<[u32; 3]> {
        let changed = of.iter().filter(|t| !known.contains(&rotated(**t)));
        changed.copied().collect()
    };
    let (first, second) = (
        changed(original, known(level)),
        changed(level, known(original)),
    );
    let mut surfaces = TwoSurfaces::new([original, level], [&first, &second], rest)?;
    let mut of_pose = |pose: &Vec<Vec3>| {
        let mut greatest = 0.0;
        surfaces.raise(pose, &mut greatest);
        greatest
    };
    Ok(poses.iter().map(&mut of_pose).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flattened_ridge_is_as_far_as_it_was_high() {
        // Four slopes over a square, and the square without its tip.
        let ridge = |height: f32| {
            [
                [0.0, 0.0, 0.0],
                [2.0, 0.0, 0.0],
                [2.0, 0.0, 2.0],
                [0.0, 0.0, 2.0],
                [1.0, height, 1.0],
            ]
            .map(Vec3::from_array)
            .to_vec()
        };
        let sides = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let flat = [[0, 1, 2], [0, 2, 3]];
        let poses = [ridge(0.25), ridge(0.5), ridge(0.0)];
        // The tip; the middle of the square is as far from a slope, times a cosine.
        let expected = [0.25, 0.5, 0.0];
        assert_eq!(
            greatest_distances([&sides, &flat], &poses),
            Ok(expected.to_vec())
        );
        assert_eq!(
            greatest_distances([&flat, &sides], &poses),
            Ok(expected.to_vec())
        );
        assert_eq!(greatest_distances([&flat, &flat], &poses), Ok(vec![0.0; 3]));
        assert!(greatest_distances([&[[0, 1, 9]], &flat], &poses).is_err());
        assert_eq!(greatest_distances([&flat, &flat], &[]), Ok(Vec::new()));
    }
}
