//! A bounding box tree over the triangles of a surface, refitted when the surface moves.
//!
//! Built once by splitting the triangles at the median of their centres along the longest side (Kay
//! and Kajiya 1986), with four children a node and four triangles a leaf, which are tested at once
//! (Dammertz, Hanika and Keller, Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of
//! Incoherent Rays, 2008); refitted from the leaves up (van den Bergh, Efficient Collision Detection
//! of Complex Deformable Models using AABB Trees, 1997).

use super::bounds::{Bounds, FourBounds};
use super::four_triangles::{FourTriangles, LANES};
use super::skin_point::SkinPoint;
use articula_core::triangle_weights;
use glam::Vec3;

/// Hint for a point without a known close triangle.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

/// Most nodes that wait for a visit: three of each of 20 levels, and `u32::MAX` triangles have fewer.
const WAITING: usize = 64;

/// Triangles of a surface for closest-point queries.
#[derive(Debug, Clone)]
pub(super) struct SurfaceTree {
    /// Depth first; the root is the first.
    nodes: Vec<Node>,
    /// Vertex indices of the triangles of each leaf; its last one fills it up.
    triangles: Vec<[[u32; 3]; LANES]>,
    /// The leaves in the last fitted pose.
    leaves: Vec<FourTriangles>,
    /// Position of each given triangle: leaf and lane.
    places: Vec<u32>,
    /// Box of all triangles.
    bounds: Bounds,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: FourBounds,
    children: [Child; LANES],
}

/// What a node has in a lane, by index.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Child {
    None,
    Leaf(u32),
    Node(u32),
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
        let mut built = Built {
            nodes: Vec::with_capacity(triangles.len() / LANES),
            leaves: Vec::with_capacity(triangles.len() / LANES + 1),
        };
        built.node(&centres, &mut order);
        let mut places = vec![0; triangles.len()];
        for (leaf, own) in built.leaves.iter().enumerate() {
            for (lane, t) in own.iter().enumerate() {
                places[*t as usize] = (leaf * LANES + lane) as u32;
            }
        }
        let of_leaf = |leaf: &[u32; LANES]| leaf.map(|t| triangles[t as usize]);
        let nowhere = FourTriangles::new([[Vec3::NAN; 3]; LANES]);
        let mut tree = Self {
            nodes: built.nodes,
            triangles: built.leaves.iter().map(of_leaf).collect(),
            leaves: vec![nowhere; built.leaves.len()],
            places,
            bounds: Bounds::EMPTY,
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
        for n in (0..self.nodes.len()).rev() {
            for lane in 0..LANES {
                let bounds = match self.nodes[n].children[lane] {
                    Child::None => continue,
                    Child::Leaf(leaf) => self.refit_leaf(leaf as usize, positions),
                    Child::Node(node) => self.nodes[node as usize].bounds.all(),
                };
                self.nodes[n].bounds.set(lane, bounds);
            }
        }
        self.bounds = self.nodes.first().map_or(Bounds::EMPTY, |n| n.bounds.all());
    }

    fn refit_leaf(&mut self, leaf: usize, positions: &[Vec3]) -> Bounds {
        let posed = self.triangles[leaf].map(|t| {
            let corners = t.map(|v| positions[v as usize]);
            let is_finite = corners.iter().all(|c| c.is_finite());
            if is_finite { corners } else { [Vec3::NAN; 3] }
        });
        self.leaves[leaf] = FourTriangles::new(posed);
        Bounds::around(&posed)
    }

    /// Closest point of the surface in a pose that it is fitted to; `None` if there is no triangle.
    pub(super) fn closest_point(&self, point: Vec3, positions: &[Vec3]) -> Option<SkinPoint> {
        let (_, place) = self.closest(point, NO_TRIANGLE, f32::INFINITY, 0.0)?;
        let corners = self.corners(place);
        Some(SkinPoint {
            corners,
            weights: triangle_weights(point, corners.map(|v| positions[v as usize])),
        })
    }

    /// Vertex indices of the triangle at a position, as [`Self::closest`] returns them.
    pub(super) fn corners(&self, place: u32) -> [u32; 3] {
        self.triangles[place as usize / LANES][place as usize % LANES]
    }

    /// Position of a given triangle, for use as a hint of [`Self::closest`].
    pub(super) fn place(&self, triangle: usize) -> u32 {
        self.places[triangle]
    }

    /// Squared distance from a finite point to the box of all triangles; infinite if there is none.
    pub(super) fn squared_distance_to_bounds(&self, point: Vec3) -> f32 {
        self.bounds.squared_distance(point)
    }

    /// Squared distance from a finite point to the surface and the position of the closest triangle;
    /// `None` if none is closer than the squared distance `limit`. A hint that is close speeds up the
    /// search, which ends with any triangle whose squared distance is at most `enough`.
    pub(super) fn closest(
        &self,
        point: Vec3,
        hint: u32,
        limit: f32,
        enough: f32,
    ) -> Option<(f32, u32)> {
        let mut nearest = Nearest {
            squared: limit,
            place: None,
        };
        let leaf = hint as usize / LANES;
        if leaf < self.leaves.len() {
            nearest.take(leaf, &self.leaves[leaf], point);
        }
        if nearest.squared > enough {
            self.search(point, &mut nearest, enough);
        }
        nearest.place.map(|place| (nearest.squared, place))
    }

    fn search(&self, point: Vec3, nearest: &mut Nearest, enough: f32) {
        let mut waiting = [(0.0_f32, 0_u32); WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let (near, n) = waiting[count];
            if near >= nearest.squared {
                continue;
            }
            let node = &self.nodes[n as usize];
            let first = count;
            let near = node.bounds.squared_distances(point);
            for (child, near) in node.children.iter().zip(near) {
                if near >= nearest.squared {
                    continue;
                }
                match child {
                    Child::None => {}
                    Child::Leaf(leaf) => {
                        let leaf = *leaf as usize;
                        nearest.take(leaf, &self.leaves[leaf], point);
                        if nearest.squared <= enough {
                            return;
                        }
                    }
                    Child::Node(child) => {
                        // The nearest child is visited first.
                        let mut at = count;
                        while at > first && waiting[at - 1].0 < near {
                            waiting[at] = waiting[at - 1];
                            at -= 1;
                        }
                        waiting[at] = (near, *child);
                        count += 1;
                    }
                }
            }
        }
    }
}

/// The closest triangle so far.
struct Nearest {
    squared: f32,
    place: Option<u32>,
}

impl Nearest {
    #[inline(always)]
    fn take(&mut self, leaf: usize, triangles: &FourTriangles, point: Vec3) {
        let all = triangles.distances_squared(point);
        for (lane, squared) in all.into_iter().enumerate() {
            if squared < self.squared {
                self.squared = squared;
                self.place = Some((leaf * LANES + lane) as u32);
            }
        }
    }
}

/// Nodes and the triangles of the leaves.
struct Built {
    nodes: Vec<Node>,
    leaves: Vec<[u32; LANES]>,
}

impl Built {
    /// Adds what is below a node or leaf with these triangles.
    fn child(&mut self, centres: &[Vec3], order: &mut [u32]) -> Child {
        let Some(&last) = order.last() else {
            return Child::None;
        };
        if order.len() > LANES {
            return Child::Node(self.node(centres, order));
        }
        let of_lane = |lane: usize| order.get(lane).copied().unwrap_or(last);
        self.leaves.push([0, 1, 2, 3].map(of_lane));
        Child::Leaf(self.leaves.len() as u32 - 1)
    }

    fn node(&mut self, centres: &[Vec3], order: &mut [u32]) -> u32 {
        let node = self.nodes.len();
        self.nodes.push(Node {
            bounds: FourBounds::EMPTY,
            children: [Child::None; LANES],
        });
        let (left, right) = halves(centres, order);
        let ((a, b), (c, d)) = (halves(centres, left), halves(centres, right));
        self.nodes[node].children = [a, b, c, d].map(|quarter| self.child(centres, quarter));
        node as u32
    }
}

/// Sorts triangles into two halves along the longest side, the first of whole leaves; all into the
/// first if they are of one leaf.
fn halves<'a>(centres: &[Vec3], order: &'a mut [u32]) -> (&'a mut [u32], &'a mut [u32]) {
    let count = order.len();
    if count <= LANES {
        return order.split_at_mut(count);
    }
    let half = (count / 2).next_multiple_of(LANES);
    let points = order.iter().map(|t| centres[*t as usize]);
    let (lo, hi) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), c| {
        (lo.min(c), hi.max(c))
    });
    let axis = (hi - lo).max_position();
    let by = |t: &u32| centres[*t as usize][axis];
    // Ties by the index of the triangle, so that the tree is the same on all platforms.
    order.select_nth_unstable_by(half, |a, b| by(a).total_cmp(&by(b)).then(a.cmp(b)));
    order.split_at_mut(half)
}

#[cfg(test)]
mod tests {
    use super::super::slow::{slow, surface};
    use super::*;
    use articula_core::triangle_distance_squared;
    use proptest::prelude::*;

    /// Returns the depth below a child, its box and its triangles, and checks boxes and sizes.
    fn below(tree: &SurfaceTree, pose: &[Vec3], child: Child) -> (usize, Bounds, Vec<[u32; 3]>) {
        let node = match child {
            Child::None => return (0, Bounds::EMPTY, Vec::new()),
            Child::Leaf(leaf) => {
                let own = tree.triangles[leaf as usize];
                let posed = own.map(|t| t.map(|v| pose[v as usize]));
                return (1, Bounds::around(&posed), own.to_vec());
            }
            Child::Node(node) => &tree.nodes[node as usize],
        };
        let all = node.children.map(|child| below(tree, pose, child));
        let mut four = FourBounds::EMPTY;
        for (lane, (_, bounds, _)) in all.iter().enumerate() {
            four.set(lane, *bounds);
        }
        let bits = |four: &FourBounds| format!("{four:?}");
        assert_eq!(bits(&node.bounds), bits(&four));
        let depth = 1 + all.iter().map(|a| a.0).max().unwrap();
        let triangles = all.into_iter().flat_map(|a| a.2).collect();
        (depth, four.all(), triangles)
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
                let (depth, bounds, found) = below(&tree, &moved, Child::Node(0));
                // Full leaves, two levels below the root.
                assert_eq!((found.len(), depth, tree.nodes.len()), (64, 3, 5));
                assert_eq!(tree.bounds, bounds);
                let quarters = tree.nodes[0].children.map(|c| below(&tree, &moved, c).1);
                for pair in quarters.windows(2) {
                    assert!(pair[0].hi.x < pair[1].lo.x + 3.0, "quarters along x");
                }
            }
            for (t, triangle) in triangles.iter().enumerate() {
                let place = tree.place(t) as usize;
                assert_eq!(tree.triangles[place / LANES][place % LANES], *triangle);
            }
        }
    }

    proptest! {
        #[test]
        fn the_tree_finds_the_closest_triangle_also_after_it_moved(
            (points, triangles) in surface(),
            moves in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 40),
            asked in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 20),
            hint in 0..70u32,
            share in 0.0f32..2.0,
        ) {
            let mut tree = SurfaceTree::new(&triangles, &points);
            let moved: Vec<Vec3> = points.iter().zip(&moves).map(|(p, m)| *p + Vec3::from_array(*m)).collect();
            for positions in [&points, &moved] {
                tree.refit(positions);
                for point in &asked {
                    let point = Vec3::from_array(*point);
                    let (squared, place) = tree.closest(point, NO_TRIANGLE, f32::INFINITY, 0.0).unwrap();
                    let slow = slow(point, &triangles, positions);
                    let fast = f64::from(squared.sqrt());
                    prop_assert!((fast - slow).abs() < 5e-3 * (1.0 + slow), "{} {}", fast, slow);
                    let found = tree.triangles[place as usize / LANES][place as usize % LANES];
                    let corners = found.map(|v| positions[v as usize]);
                    prop_assert_eq!(triangle_distance_squared(point, corners), squared);
                    // Any hint gives the same distance, and a limit either that or nothing.
                    let limit = share * squared;
                    let limited = tree.closest(point, hint, limit, 0.0).map(|found| found.0);
                    let wanted = (squared < limit).then_some(squared);
                    let same = |a: f32, b: f32| (a - b).abs() <= 1e-6 * (1.0 + b);
                    match (limited, wanted) {
                        (Some(a), Some(b)) => prop_assert!(same(a, b), "{} {}", a, b),
                        (a, b) => prop_assert!(a.is_none() && b.is_none() || same(share, 1.0)),
                    }
                }
            }
        }
    }
}
