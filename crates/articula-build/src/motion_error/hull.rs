//! Outline of the skin that a joint moves, seen from a half-sphere of cameras: a reference for levers.
//!
//! Source: thesis 7.2.3, which proposes convex hulls with and without the update of a joint,
//! projected from a discretised half-sphere; `docs/methods/motion-lod.md` 4.1 states what it leaves
//! open.

use articula_core::Libm;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Number of directions of view on the half-sphere. Opposite directions see mirrored outlines.
const VIEWS: usize = 64;

/// Number of directions in which the hull is searched for extreme points.
const SEARCHED: usize = 256;

/// Number of directions in the picture in which outlines are compared.
const OUTLINE: usize = 32;

/// Convex hull of the skin that one joint moves, as its extreme points in the joint's own frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointHull {
    points: Vec<Vec3>,
}

impl JointHull {
    /// Extreme points of the joint itself, at the origin, and of `points`: all that are farthest in
    /// one of [`SEARCHED`] directions.
    pub(crate) fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let mut all = vec![Vec3::ZERO];
        all.extend(points);
        let mut extreme: Vec<usize> = sphere(SEARCHED)
            .map(|direction| farthest(&all, direction).0)
            .collect();
        extreme.sort_unstable();
        extreme.dedup();
        Self {
            points: extreme.into_iter().map(|i| all[i]).collect(),
        }
    }

    /// Greatest distance in metres between the outlines of the hull with rotation `shown` and with
    /// rotation `wanted`, seen along the unit direction `view` in the frame of the joint as wanted.
    ///
    /// For convex outlines it is the greatest difference of their extents over the directions of the
    /// picture.
    pub(crate) fn outline_error(&self, shown: Quat, wanted: Quat, view: Vec3) -> f32 {
        if shown == wanted {
            return 0.0;
        }
        let to_shown = shown.conjugate() * wanted;
        let (right, up) = view.any_orthonormal_pair();
        let extent = |direction: Vec3| farthest(&self.points, direction).1;
        let apart = (0..OUTLINE).map(|i| {
            let (sin, cos) = (TAU * i as f32 / OUTLINE as f32).libm_sin_cos();
            let direction = cos * right + sin * up;
            (extent(direction) - extent(to_shown * direction)).abs()
        });
        apart.fold(0.0, f32::max)
    }
}

/// The direction of the half-sphere nearest to a unit direction or to its opposite.
pub(crate) fn nearest_view(direction: Vec3) -> Vec3 {
    // Both halves of an even number of directions; only one of each opposite pair is compared.
    let half = sphere(2 * VIEWS).take(VIEWS);
    let nearest = half.max_by(|a, b| {
        let (a, b) = (a.dot(direction).abs(), b.dot(direction).abs());
        a.total_cmp(&b)
    });
    nearest.unwrap_or(direction)
}

/// Directions spread evenly over the sphere from +Y to -Y, on a spiral by the golden angle.
fn sphere(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = TAU * (1.0 - 2.0 / (1.0 + 5.0f32.sqrt()));
    (0..count).map(move |i| {
        let height = 1.0 - (2 * i + 1) as f32 / count as f32;
        let radius = (1.0 - height * height).sqrt();
        let (sin, cos) = (golden * i as f32).libm_sin_cos();
        Vec3::new(radius * cos, height, radius * sin)
    })
}

/// Index of the point farthest in a direction, and how far it is.
fn farthest(points: &[Vec3], direction: Vec3) -> (usize, f32) {
    let mut best = (0, f32::NEG_INFINITY);
    for (i, point) in points.iter().enumerate() {
        let far = point.dot(direction);
        if far > best.1 {
            best = (i, far);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    #[test]
    fn a_cube_has_its_corners_and_no_point_inside() {
        let corner = |i: usize| {
            let side = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
            vec3(side(1), side(2), side(4))
        };
        let corners: Vec<Vec3> = (0..8).map(corner).collect();
        let inside = (0..8).map(|i| 0.5 * corner(i)).chain([vec3(0.9, 0.0, 0.0)]);
        let hull = JointHull::of(inside.chain(corners.iter().copied()));
        assert_eq!(hull.points.len(), 8);
        assert!(corners.iter().all(|c| hull.points.contains(c)));
    }

    #[test]
    fn a_stick_that_turns_by_a_right_angle_is_seen_by_its_length() {
        // Wanted is an end at (0.5, 0, 0), shown one at (0, 0.5, 0). Seen along Z both have an extent
        // of 0.5 m where the other has none; seen along Y the shown one is a point.
        let hull = JointHull::of([vec3(0.5, 0.0, 0.0)]);
        let turned = Quat::from_rotation_z(0.25 * TAU);
        let seen = |view: Vec3| hull.outline_error(turned, Quat::IDENTITY, view.normalize());
        assert!((seen(Vec3::Z) - 0.5).abs() < 0.02, "{}", seen(Vec3::Z));
        assert!((seen(Vec3::Y) - 0.5).abs() < 0.02, "{}", seen(Vec3::Y));
        // Along (1, 1, 0) the stick points from +0.35 m to -0.35 m of the picture.
        let between = seen(vec3(1.0, 1.0, 0.0));
        let half = 0.5 * std::f32::consts::FRAC_1_SQRT_2;
        assert!((between - half).abs() < 0.02, "{between}");
    }

    #[test]
    fn a_turn_about_the_line_of_sight_of_a_round_thing_is_not_seen() {
        let ring = (0..64).map(|i| Quat::from_rotation_y(TAU * i as f32 / 64.0) * Vec3::X);
        let hull = JointHull::of(ring);
        let turned = Quat::from_rotation_y(0.3);
        let error = hull.outline_error(turned, Quat::IDENTITY, Vec3::Y);
        assert!(error < 0.01, "{error}");
        let tipped = hull.outline_error(Quat::from_rotation_x(0.3), Quat::IDENTITY, Vec3::X);
        assert!(tipped > 0.2, "{tipped}");
    }

    #[test]
    fn the_half_sphere_has_a_view_near_every_direction() {
        for direction in sphere(500) {
            let angle = nearest_view(direction).dot(direction).abs().acos();
            assert!(angle.to_degrees() < 16.0, "{direction}: {angle}");
        }
    }
}
