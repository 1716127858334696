//! Whether a head has something in its mouth.

use articula_build::face::{FacePoints, FaceSurface};
use glam::Vec3;
use std::ops::Range;

/// Vertices of pieces beside the skin behind the lips from which the head has teeth or a tongue of its own.
const FEW: usize = 12;
/// Where they lie, by the height of the face: above and below the line between the lips, and behind the lips, of which
/// pieces of their own are not as deep. By half the width of the mouth aside.
const HIGH: f32 = 0.25;
const DEEP: Range<f32> = 0.07..0.5;
const WIDE: f32 = 1.2;
/// Depth behind the lips up to which a surface is a tooth, a tongue, or a wall that hides them, and up to which it is the
/// wall of a bag; beyond is the back of the head. By the height of the face.
const NEAR: f32 = 0.13;
const BAG: f32 = 0.9;
/// Height of such a bag above and below the line between the lips, and the depth behind it from which it is no lip.
const BAG_HIGH: f32 = 0.3;
const BAG_FROM: f32 = 0.02;
/// Lines of sight through the open mouth: places between the lips and beside the middle by half the width.
const DOWN: [f32; 3] = [0.3, 0.5, 0.7];
const ASIDE: [f32; 3] = [-0.25, 0.0, 0.25];

/// What is seen through an open mouth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Inside {
    /// Teeth or a tongue: pieces that are no skin.
    Own,
    /// A wall close behind the lips, which would hide them; or teeth that are one with the skin.
    Wall,
    /// The skin goes on as a bag.
    Bag,
    /// Nothing.
    Hole,
}

/// What is inside of the mouth of a head. `opened` are the places of its vertices while the mouth is open, `lips` the
/// vertices of the upper and of the lower lip in the middle.
pub(super) fn inside(
    surface: &FaceSurface,
    points: &FacePoints,
    opened: &[Vec3],
    lips: [u32; 2],
) -> Option<Inside> {
    let place = |point| points.get(point).map(|p| p.place);
    let height = points.height();
    let (left, right) = (place((2, 4))?, place((2, 5))?);
    let half_width = 0.5 * (left.x - right.x);
    let seam = place((2, 2))?.midpoint(place((2, 3))?);
    let corners_behind = seam.z - 0.5 * (left.z + right.z);
    let mut is_skin = vec![false; surface.positions.len()];
    points
        .skin()
        .as_flattened()
        .iter()
        .for_each(|v| is_skin[*v as usize] = true);
    let is_piece = |(p, is_skin): &(&Vec3, &bool)| {
        let from = **p - seam;
        let lips = corners_behind * (from.x / half_width).powi(2);
        !**is_skin
            && from.x.abs() < WIDE * half_width
            && from.y.abs() < HIGH * height
            && DEEP.contains(&((-from.z - lips) / height))
    };
    let pieces = surface.positions.iter().zip(&is_skin).filter(is_piece);
    if pieces.count() >= FEW {
        return Some(Inside::Own);
    }
    let [upper, lower] = lips.map(|v| opened[v as usize]);
    let from_z = upper.z.min(lower.z) - 0.02 * height;
    let depths = DOWN.iter().flat_map(|down| {
        let middle = upper.lerp(lower, *down);
        let eye = move |aside: &f32| Vec3::new(middle.x + aside * half_width, middle.y, from_z);
        ASIDE.iter().map(eye)
    });
    let depths: Vec<f32> = depths
        .map(|eye| depth_behind(&surface.triangles, opened, eye) / height)
        .collect();
    let within = |limit: f32| depths.iter().filter(|d| **d < limit).count();
    Some(if 3 * within(NEAR) > depths.len() {
        Inside::Wall
    } else if 2 * within(BAG) > depths.len() {
        Inside::Bag
    } else {
        Inside::Hole
    })
}

/// Vertices of the skin inside of a closed mouth, and how deep they lie behind the lips by the height of the face: those
/// near the line between the lips with other skin in front of them.
pub(super) fn bag(surface: &FaceSurface, points: &FacePoints) -> Option<Vec<(u32, f32)>> {
    let place = |point| points.get(point).map(|p| p.place);
    let height = points.height();
    let half_width = 0.5 * (place((2, 4))?.x - place((2, 5))?.x);
    let seam = place((2, 2))?.midpoint(place((2, 3))?);
    let is_near = |p: Vec3| {
        let from = p - seam;
        from.x.abs() < WIDE * half_width && from.y.abs() < BAG_HIGH * height
    };
    let at = |v: u32| surface.positions[v as usize];
    let skin: Vec<[u32; 3]> = points
        .skin()
        .iter()
        .filter(|t| t.iter().any(|v| is_near(at(*v))))
        .copied()
        .collect();
    let mut inner: Vec<u32> = skin.as_flattened().to_vec();
    inner.sort_unstable();
    inner.dedup();
    let depth = |v: u32| (seam.z - at(v).z) / height;
    inner.retain(|v| is_near(at(*v)) && (BAG_FROM..BAG).contains(&depth(*v)));
    // Turned about, so that what is in front of a vertex is behind it.
    let turned: Vec<Vec3> = surface
        .positions
        .iter()
        .map(|p| Vec3::new(-p.x, p.y, -p.z))
        .collect();
    let is_covered = |v: &u32| {
        let p = turned[*v as usize];
        first_behind(&skin, &turned, p - 0.01 * height * Vec3::Z).0 < f32::INFINITY
    };
    inner.retain(is_covered);
    Some(inner.into_iter().map(|v| (v, depth(v))).collect())
}

/// Distance from a place straight back to the first surface that faces it; infinite if there is none, or what is first is
/// seen from behind.
fn depth_behind(triangles: &[[u32; 3]], places: &[Vec3], eye: Vec3) -> f32 {
    let (depth, is_front) = first_behind(triangles, places, eye);
    if is_front { depth } else { f32::INFINITY }
}

/// Distance from a place straight back to the first surface, and whether that faces it.
fn first_behind(triangles: &[[u32; 3]], places: &[Vec3], eye: Vec3) -> (f32, bool) {
    let mut first = (f32::INFINITY, false);
    for t in triangles {
        let [a, b, c] = t.map(|v| places[v as usize] - eye);
        let cross = |p: Vec3, q: Vec3| p.x * q.y - p.y * q.x;
        let shares = [cross(b, c), cross(c, a), cross(a, b)];
        let area: f32 = shares.iter().sum();
        let is_hit = shares.iter().all(|s| *s >= 0.0) || shares.iter().all(|s| *s <= 0.0);
        if !is_hit || area == 0.0 {
            continue;
        }
        let z = (shares[0] * a.z + shares[1] * b.z + shares[2] * c.z) / area;
        if z < 0.0 && -z < first.0 {
            first = (-z, area > 0.0);
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_surface_counts_if_it_faces_the_eye() {
        let at = |z: f32| [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, z));
        let places: Vec<Vec3> = [at(-3.0), at(-2.0), at(1.0)].concat();
        let depth = |triangles: &[[u32; 3]]| depth_behind(triangles, &places, Vec3::ZERO);
        assert!((depth(&[[0, 1, 2], [6, 7, 8]]) - 3.0).abs() < 1e-6);
        assert!((depth(&[[0, 1, 2], [3, 4, 5]]) - 2.0).abs() < 1e-6);
        // The back of a head, seen from within.
        assert_eq!(depth(&[[0, 1, 2], [3, 5, 4]]), f32::INFINITY);
        assert_eq!(depth(&[]), f32::INFINITY);
    }
}
