//! Sealed edges: corners move outward a little under neighbours that are painted later, so that no
//! background shows between anti-aliased triangles.
//!
//! Source: `docs/methods/vector.md` part 5 (underlap). Silhouette edges stay where they are. Edges
//! also move a little over earlier neighbours, since a canvas draws slivers thinner than a pixel
//! with holes.

use glam::Vec2;

/// Distance by which an edge moves under its neighbour, pixels.
pub(super) const UNDERLAP_PX: f32 = 0.8;
/// Distance by which an edge moves over a neighbour that was painted before, pixels.
pub(super) const OVERLAP_PX: f32 = 0.35;
/// Minimum sine of the angle between two edges whose intersection is used.
const PARALLEL: f32 = 0.15;
/// Maximum displacement of a corner, in underlap distances.
const FARTHEST: f32 = 2.5;

/// Returns the corners with the edges (corner to next corner) moved outward by these distances.
pub(super) fn sealed(corners: [Vec2; 3], edges_px: [f32; 3]) -> [Vec2; 3] {
    let [a, b, c] = corners;
    let turned = (b - a).perp_dot(c - a).signum();
    let outward = |i: usize| {
        let along = (corners[(i + 1) % 3] - corners[i]).normalize_or_zero();
        // With y downward, a positive area is clockwise on the screen: outside is to the left.
        Vec2::new(along.y, -along.x) * turned
    };
    let middle = (a + b + c) / 3.0;
    std::array::from_fn(|i| {
        let before = (i + 2) % 3;
        let (d0, d1) = (edges_px[before], edges_px[i]);
        if d0 == 0.0 && d1 == 0.0 {
            return corners[i];
        }
        let (n0, n1) = (outward(before), outward(i));
        let det = n0.perp_dot(n1);
        let offset = if det.abs() < PARALLEL {
            (corners[i] - middle).normalize_or_zero() * d0.max(d1)
        } else {
            Vec2::new(d0 * n1.y - d1 * n0.y, d1 * n0.x - d0 * n1.x) / det
        };
        corners[i] + offset.clamp_length_max(FARTHEST * UNDERLAP_PX)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_corner_moves_by_both_edges_and_free_edges_stay() {
        let corners = [Vec2::ZERO, Vec2::new(10.0, 0.0), Vec2::new(0.0, 10.0)];
        let d = UNDERLAP_PX;
        for flip in [false, true] {
            let corners = if flip {
                [corners[0], corners[2], corners[1]]
            } else {
                corners
            };
            let all = sealed(corners, [UNDERLAP_PX; 3]);
            assert!((all[0] - Vec2::splat(-d)).length() < 1e-6, "{all:?}");
            assert_eq!(sealed(corners, [0.0; 3]), corners);
        }
        // The edge along x moves up; its ends move along the two other edges.
        let one = sealed(corners, [UNDERLAP_PX, 0.0, 0.0]);
        assert!((one[0] - Vec2::new(0.0, -d)).length() < 1e-6, "{one:?}");
        assert!(
            (one[1] - Vec2::new(10.0 + d, -d)).length() < 1e-5,
            "{one:?}"
        );
        assert_eq!(one[2], corners[2]);
    }

    #[test]
    fn slivers_stay_near() {
        let corners = [Vec2::ZERO, Vec2::new(50.0, 0.1), Vec2::new(100.0, 0.0)];
        for (from, to) in corners.iter().zip(sealed(corners, [UNDERLAP_PX; 3])) {
            assert!((*from - to).length() <= FARTHEST * UNDERLAP_PX + 1e-5);
        }
    }
}
