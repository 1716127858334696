//! Correspondence between the vertices of the original and points of a coarser surface.
//!
//! The closest point at rest may lie on another part of the body: on the other lip, or on the arm
//! beside the hip. Therefore only the same part of the mesh is searched, the closest points in
//! several poses are tried, and the one with the smallest maximum distance over these poses is
//! taken.

use super::skin_point::SkinPoint;
use super::tree::SurfaceTree;
use articula_core::Part;
use glam::Vec3;

/// Returns, for each of the given vertices of the original, the corresponding point of a level's
/// surface, on the same part of the mesh if the level has triangles of it. A vertex without a
/// finite distance to the level corresponds to itself. `poses` are positions of all vertices;
/// without any, all vertices correspond to themselves. O(poses² · vertices + poses · vertices ·
/// log(triangles)).
///
/// # Panics
/// If a vertex or a triangle is out of range of the poses.
pub fn attach(
    triangles: &[[u32; 3]],
    vertices: &[u32],
    poses: &[Vec<Vec3>],
    parts: &[Part],
) -> Vec<SkinPoint> {
    let mut found: Vec<SkinPoint> = vertices.iter().map(|v| SkinPoint::at(*v)).collect();
    let Some(rest) = poses.first() else {
        return found;
    };
    let part_of = |v: u32| {
        let is_in = |p: &Part| p.vertices.contains(&(v as usize));
        parts.iter().position(is_in).unwrap_or(parts.len())
    };
    let mut of_part = vec![Vec::new(); parts.len() + 1];
    for triangle in triangles {
        of_part[part_of(triangle[0])].push(*triangle);
    }
    let mut places = vec![Vec::new(); parts.len() + 1];
    for (place, v) in vertices.iter().enumerate() {
        places[part_of(*v)].push(place);
    }
    for (own, places) in of_part.iter().zip(&places).filter(|(_, p)| !p.is_empty()) {
        let surface = if own.is_empty() { triangles } else { own };
        let mut tree = SurfaceTree::new(surface, rest);
        let mut least = vec![f32::INFINITY; places.len()];
        for pose in poses {
            tree.refit(pose);
            for (place, least) in places.iter().zip(&mut least) {
                nearer(
                    &tree,
                    vertices[*place],
                    (pose, poses),
                    (least, &mut found[*place]),
                );
            }
        }
    }
    found
}

/// Takes the closest point in one pose if its maximum distance over all poses is smaller than that
/// of the point so far.
fn nearer(
    tree: &SurfaceTree,
    vertex: u32,
    (pose, poses): (&[Vec3], &[Vec<Vec3>]),
    (least, point): (&mut f32, &mut SkinPoint),
) {
    let v = vertex as usize;
    if *least == 0.0 || !pose[v].is_finite() {
        return;
    }
    let Some(found) = tree.closest_point(pose[v], pose) else {
        return;
    };
    let apart = |p: &Vec<Vec3>| {
        let distance = found.posed(p).distance(p[v]);
        if distance.is_finite() { distance } else { 0.0 }
    };
    let worst = poses.iter().map(apart).fold(0.0, f32::max);
    if worst < *least {
        (*least, *point) = (worst, found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_distance::corners;

    #[test]
    fn the_other_lip_is_closer_at_rest_but_not_for_long() {
        // Two sheets a millimetre apart; the level lacks the middle vertex 3 of the upper one.
        let mut rest: Vec<Vec3> = [[0, 0], [2, 0], [0, 2]]
            .iter()
            .map(|[x, z]| Vec3::new(*x as f32, 0.010, *z as f32))
            .collect();
        rest.push(Vec3::new(0.5, 0.002, 0.5));
        rest.extend([[0, 0], [2, 0], [0, 2]].map(|[x, z]| Vec3::new(x as f32, 0.0, z as f32)));
        let level = [[0, 1, 2], [4, 5, 6]];
        let mut open = rest.clone();
        for upper in &mut open[..4] {
            upper.y += 0.1;
        }
        let alone = attach(&level, &[3, 0], std::slice::from_ref(&rest), &[]);
        assert_eq!(
            alone[0].corners,
            [4, 5, 6],
            "2 mm to the lower sheet, 8 mm to its own"
        );
        assert_eq!(
            alone[1].posed(&rest),
            rest[0],
            "a corner of the level is itself"
        );
        let both = attach(&level, &[3], &[rest.clone(), open.clone()], &[]);
        assert_eq!(both[0].corners, [0, 1, 2]);
        // The lower sheet as another part is ignored, except for a part without triangles.
        let part = |vertices| Part {
            name: String::new(),
            mesh: 0,
            material: None,
            vertices,
            triangles: 0..0,
        };
        let sheets = [part(0..4), part(4..7)];
        let apart = attach(&level, &[3], std::slice::from_ref(&rest), &sheets);
        assert_eq!(apart[0].corners, [0, 1, 2]);
        let gone = attach(&level[1..], &[3], std::slice::from_ref(&rest), &sheets);
        assert_eq!(gone[0].corners, [4, 5, 6]);
        let few = corners(&alone);
        assert_eq!(few, [0, 1, 2, 4, 5, 6]);
        assert_eq!(alone[0].among(&few).corners, [3, 4, 5]);
        let sum: f32 = both[0].weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-6);
        assert!((both[0].posed(&open) - Vec3::new(0.5, 0.11, 0.5)).length() < 1e-6);
    }

    #[test]
    fn nothing_to_stand_on() {
        let points = vec![Vec3::ZERO, Vec3::NAN];
        assert_eq!(
            attach(&[], &[0], std::slice::from_ref(&points), &[]),
            [SkinPoint::at(0)]
        );
        assert_eq!(
            attach(&[[0, 0, 0]], &[1], &[points], &[]),
            [SkinPoint::at(1)]
        );
        assert_eq!(attach(&[], &[7], &[], &[]), [SkinPoint::at(7)]);
    }
}
