//! A bounding box tree over the triangles of a surface, refitted when the surface moves.
//!
//! Built once by splitting the triangles at the median of their centres along the longest side (Kay
//! and Kajiya 1986); refitted from the leaves up (van den Bergh, Efficient Collision Detection of
//! Complex Deformable Models using AABB Trees, 1997).

use super::skin_point::SkinPoint;
use articula_core::{triangle_distance_squared, triangle_weights};
use glam::Vec3;

/// Hint for a point without a known close triangle.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

/// Number of triangles in a leaf.
const LEAF: usize = 2;

/// Maximum depth: halving `u32::MAX` triangles ends well above it.
const DEEPEST: usize = 40;

/// Triangles of a surface for closest-point queries.
#[derive(Debug, Clone)]
pub(super) struct SurfaceTree {
    /// Depth first: the left child of an inner node follows it.
    nodes: Vec<Node>,
    /// Vertex indices of the triangles, leaf by leaf.
    triangles: Vec<[u32; 3]>,
    /// Position of each given triangle in `triangles`.
    places: Vec<u32>,
    /// Corners of `triangles` in the last fitted pose.
    corners: Vec<[Vec3; 3]>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    lo: Vec3,
    hi: Vec3,
    /// First triangle of a leaf, right child of an inner node.
    at: u32,
    /// Number of triangles of a leaf; 0 for an inner node.
    count: u32,
}

impl Node {
    /// The empty box, at infinite distance from every point.
    const EMPTY: Self = Self {
        lo: Vec3::INFINITY,
        hi: Vec3::NEG_INFINITY,
        at: 0,
        count: 0,
    };

    /// Squared distance of a point to the box; infinite if it is empty.
    fn squared_distance(&self, point: Vec3) -> f32 {
        let out = (self.lo - point).max(point - self.hi).max(Vec3::ZERO);
        out.length_squared()
    }
}

impl SurfaceTree {
    /// Builds the tree over triangles and fits it to these positions of the vertices.
    ///
    /// # Panics
    /// If a triangle indexes a vertex that does not exist.
    pub(super) fn new(triangles: &[[u32; 3]], positions: &[Vec3]) -> Self {
        let centre = |t: &[u32; 3]| {
            let sum: Vec3 = t.iter().map(|v| positions[*v as usize]).sum();
            if sum.is_finite() { sum } else { Vec3::ZERO }
        };
        let centres: Vec<Vec3> = triangles.iter().map(centre).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        build(&mut nodes, &centres, &mut order, 0);
        let mut places = vec![0; triangles.len()];
        for (place, t) in order.iter().enumerate() {
            places[*t as usize] = place as u32;
        }
        let mut tree = Self {
            nodes,
            triangles: order.iter().map(|t| triangles[*t as usize]).collect(),
            places,
            corners: vec![[Vec3::ZERO; 3]; triangles.len()],
        };
        tree.refit(positions);
        tree
    }

    /// Fits the boxes to other positions of the same vertices. Triangles with a corner that is not
    /// finite are ignored. O(triangles), does not allocate.
    ///
    /// # Panics
    /// If there are fewer positions than vertices.
    pub(super) fn refit(&mut self, positions: &[Vec3]) {
        for (corners, t) in self.corners.iter_mut().zip(&self.triangles) {
            *corners = t.map(|v| positions[v as usize]);
            if !corners.iter().all(|c| c.is_finite()) {
                *corners = [Vec3::NAN; 3];
            }
        }
        for n in (0..self.nodes.len()).rev() {
            let Node { at, count, .. } = self.nodes[n];
            let (mut lo, mut hi) = (Node::EMPTY.lo, Node::EMPTY.hi);
            if count == 0 {
                for child in [n + 1, at as usize] {
                    lo = lo.min(self.nodes[child].lo);
                    hi = hi.max(self.nodes[child].hi);
                }
            } else {
                let there = &self.corners[at as usize..(at + count) as usize];
                for corner in there.iter().filter(|c| c[0].is_finite()).flatten() {
                    lo = lo.min(*corner);
                    hi = hi.max(*corner);
                }
            }
            self.nodes[n] = Node { lo, hi, at, count };
        }
    }

    /// Closest point of the surface; `None` if there is no triangle.
    pub(super) fn closest_point(&self, point: Vec3) -> Option<SkinPoint> {
        let (_, place) = self.closest(point, NO_TRIANGLE);
        let corners = self.corners.get(place as usize)?;
        Some(SkinPoint {
            corners: self.triangles[place as usize],
            weights: triangle_weights(point, *corners),
        })
    }

    /// Position of a given triangle, for use as a hint of [`Self::closest`].
    pub(super) fn place(&self, triangle: usize) -> u32 {
        self.places[triangle]
    }

    /// Squared distance from a finite point to the surface, infinite if there is none, and the
    /// position of the closest triangle. A hint that is close speeds up the search.
    pub(super) fn closest(&self, point: Vec3, hint: u32) -> (f32, u32) {
        let mut best = f32::INFINITY;
        let mut place = hint;
        if let Some(corners) = self.corners.get(hint as usize) {
            let guess = triangle_distance_squared(point, *corners);
            best = if guess.is_nan() { best } else { guess };
        }
        if best == 0.0 || self.nodes.is_empty() {
            return (best, place);
        }
        let mut stack = [(0.0f32, 0u32); DEEPEST];
        let mut depth = 1;
        stack[0] = (self.nodes[0].squared_distance(point), 0);
        while depth > 0 {
            depth -= 1;
            let (near, n) = stack[depth];
            if near >= best {
                continue;
            }
            let node = &self.nodes[n as usize];
            if node.count > 0 {
                for t in node.at..node.at + node.count {
                    let squared = triangle_distance_squared(point, self.corners[t as usize]);
                    if squared < best {
                        (best, place) = (squared, t);
                    }
                }
                continue;
            }
            let of = |child: u32| (self.nodes[child as usize].squared_distance(point), child);
            let (mut first, mut last) = (of(n + 1), of(node.at));
            if last.0 < first.0 {
                (first, last) = (last, first);
            }
            // The nearer child is searched first.
            for child in [last, first] {
                if child.0 < best {
                    stack[depth] = child;
                    depth += 1;
                }
            }
        }
        (best, place)
    }
}

/// Adds the nodes of the triangles `order`, which start at position `first`, and sorts them.
fn build(nodes: &mut Vec<Node>, centres: &[Vec3], order: &mut [u32], first: usize) {
    let count = order.len();
    if count <= LEAF {
        if count > 0 {
            nodes.push(Node {
                at: first as u32,
                count: count as u32,
                ..Node::EMPTY
            });
        }
        return;
    }
    let node = nodes.len();
    nodes.push(Node::EMPTY);
    let bounds = order.iter().map(|t| centres[*t as usize]);
    let (lo, hi) = bounds.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), c| {
        (lo.min(c), hi.max(c))
    });
    let axis = (hi - lo).max_position();
    let half = count / 2;
    let by = |t: &u32| centres[*t as usize][axis];
    // Ties by the index of the triangle, so that the tree is the same on all platforms.
    order.select_nth_unstable_by(half, |a, b| by(a).total_cmp(&by(b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(half);
    build(nodes, centres, left, first);
    nodes[node].at = nodes.len() as u32;
    build(nodes, centres, right, first + half);
}

#[cfg(test)]
mod tests {
    use super::super::slow::{slow, surface};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_distance_to_a_box_by_hand() {
        let node = Node {
            lo: Vec3::new(1.0, 2.0, 3.0),
            hi: Vec3::new(2.0, 4.0, 6.0),
            ..Node::EMPTY
        };
        for (point, squared) in [
            ([1.5, 3.0, 4.0], 0.0),
            ([2.0, 4.0, 6.0], 0.0),
            ([-1.0, 3.0, 4.0], 4.0),
            ([5.0, 8.0, 4.0], 25.0),
            ([0.0, 0.0, 1.0], 9.0),
        ] {
            assert_eq!(node.squared_distance(Vec3::from_array(point)), squared);
        }
        assert_eq!(Node::EMPTY.squared_distance(Vec3::ONE), f32::INFINITY);
    }

    /// Returns the number of triangles and the depth below a node, and checks that its box is that of
    /// their corners.
    fn below(tree: &SurfaceTree, n: usize) -> (usize, usize, Vec<[Vec3; 3]>) {
        let node = &tree.nodes[n];
        let (count, depth, corners) = if node.count > 0 {
            let there = node.at as usize..(node.at + node.count) as usize;
            (there.len(), 1, tree.corners[there].to_vec())
        } else {
            let [a, b] = [n + 1, node.at as usize].map(|child| below(tree, child));
            assert!(a.0.abs_diff(b.0) <= 1, "{} and {}", a.0, b.0);
            (a.0 + b.0, 1 + a.1.max(b.1), [a.2, b.2].concat())
        };
        let all = corners.iter().flatten();
        let lo = all.clone().fold(Vec3::INFINITY, |lo, c| lo.min(*c));
        let hi = all.fold(Vec3::NEG_INFINITY, |hi, c| hi.max(*c));
        assert_eq!((node.lo, node.hi), (lo, hi));
        (count, depth, corners)
    }

    #[test]
    fn boxes_are_tight_and_split_the_longest_side_in_half() {
        // A ribbon of 64 triangles along x, far longer than wide, wherever it lies.
        let at = |i: u32| Vec3::new(i as f32, (i % 2) as f32, 0.1 * (i % 3) as f32);
        // Not in order.
        let triangles: Vec<[u32; 3]> = (0..64)
            .map(|i| (i * 37) % 64)
            .map(|i| [i, i + 1, i + 2])
            .collect();
        for offset in [Vec3::ZERO, Vec3::Y * 1000.0, Vec3::X * 1000.0] {
            let points: Vec<Vec3> = (0..66).map(|i| at(i) + offset).collect();
            let mut tree = SurfaceTree::new(&triangles, &points);
            for shift in [Vec3::ZERO, Vec3::new(3.0, -2.0, 1.0)] {
                let moved: Vec<Vec3> = points.iter().map(|p| *p + shift).collect();
                tree.refit(&moved);
                let (count, depth, _) = below(&tree, 0);
                // Leaves of two triangles, at the sixth level.
                assert_eq!((count, depth, tree.nodes.len()), (64, 6, 63));
                let halves = [1, tree.nodes[0].at as usize].map(|n| &tree.nodes[n]);
                assert!(halves[0].hi.x < halves[1].lo.x + 3.0, "halves along x");
            }
            for (t, triangle) in triangles.iter().enumerate() {
                assert_eq!(tree.triangles[tree.place(t) as usize], *triangle);
            }
        }
    }

    proptest! {
        #[test]
        fn the_tree_finds_the_closest_triangle_also_after_it_moved(
            (points, triangles) in surface(),
            moves in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 40),
            asked in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 20),
        ) {
            let mut tree = SurfaceTree::new(&triangles, &points);
            let moved: Vec<Vec3> = points.iter().zip(&moves).map(|(p, m)| *p + Vec3::from_array(*m)).collect();
            for positions in [&points, &moved] {
                tree.refit(positions);
                for point in &asked {
                    let point = Vec3::from_array(*point);
                    let fast = f64::from(tree.closest(point, NO_TRIANGLE).0.sqrt());
                    let slow = slow(point, &triangles, positions);
                    prop_assert!((fast - slow).abs() < 5e-3 * (1.0 + slow), "{} {}", fast, slow);
                }
            }
        }
    }
}
