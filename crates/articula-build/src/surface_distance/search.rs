//! The distances of points to several levels, pose after pose.

use super::pieces::Pieces;
use super::points::Points;
use super::tree::{NO_TRIANGLE, SurfaceTree};
use foldhash::{HashMap, HashMapExt};
use glam::Vec3;

/// Levels, and the points measured against them.
#[derive(Clone)]
pub(super) struct Search {
    pieces: Vec<Piece>,
    levels: Vec<Level>,
    points: Points,
    /// For each point, the first with the same position at rest.
    same: Vec<u32>,
    /// What is known about the pieces at one point.
    known: Vec<Known>,
}

/// Triangles that levels share.
#[derive(Clone)]
struct Piece {
    tree: SurfaceTree,
    /// For each point, the closest triangle that was found last.
    hints: Vec<u32>,
}

#[derive(Clone)]
struct Level {
    /// Indices of its pieces.
    pieces: Vec<usize>,
    /// For each point, the piece that was closest.
    closest: Vec<u32>,
}

/// What is known about the squared distance of a point to a piece.
#[derive(Clone, Copy)]
struct Known {
    at_least: f32,
    at_most: f32,
}

impl Search {
    /// `rest` has the positions of all vertices at rest.
    pub(super) fn new(pieces: Pieces, rest: &[Vec3], points: Points) -> Self {
        let all = pieces.triangles.iter();
        let level = |pieces: Vec<usize>| Level {
            closest: vec![pieces.first().map_or(0, |p| *p as u32); points.len()],
            pieces,
        };
        Self {
            pieces: all.map(|t| Piece::new(t, rest, &points)).collect(),
            levels: pieces.of_level.into_iter().map(level).collect(),
            same: same(&points, rest),
            known: Vec::with_capacity(pieces.triangles.len()),
            points,
        }
    }

    /// Returns the distance of each point to each level in a pose, by level; NaN for a point that is
    /// not finite there, infinity without a triangle.
    pub(super) fn distances(&mut self, pose: &[Vec3]) -> Vec<Vec<f32>> {
        let points = self.posed(pose);
        let mut out = vec![vec![f32::NAN; points.len()]; self.levels.len()];
        for (i, point) in points.iter().enumerate() {
            let same = self.same[i] as usize;
            if same < i && points[same] == *point {
                out.iter_mut().for_each(|level| level[i] = level[same]);
            } else if point.is_finite() {
                self.start(*point);
                for (l, out) in out.iter_mut().enumerate() {
                    out[i] = self.squared_distance(l, i, *point, 0.0).sqrt();
                }
            }
        }
        out
    }

    /// Raises the greatest distance to each level to that of a pose. Faster than [`Self::distances`]: a
    /// point that has a triangle within the greatest distance needs no search for its closest one.
    pub(super) fn raise(&mut self, pose: &[Vec3], greatest: &mut [f32]) {
        let points = self.posed(pose);
        for (i, point) in points.iter().enumerate() {
            let same = self.same[i] as usize;
            if !point.is_finite() || same < i && points[same] == *point {
                continue;
            }
            self.start(*point);
            for (l, greatest) in greatest.iter_mut().enumerate() {
                // Distances are compared, since squares of different ones may have the same root.
                let squared = self.squared_distance(l, i, *point, *greatest * *greatest);
                *greatest = greatest.max(squared.sqrt());
            }
        }
    }

    /// The points in a pose, to which the trees are fitted.
    fn posed(&mut self, pose: &[Vec3]) -> Vec<Vec3> {
        for piece in &mut self.pieces {
            piece.tree.refit(pose);
        }
        self.points.posed(pose).collect()
    }

    /// Forgets what was known at another point.
    fn start(&mut self, point: Vec3) {
        self.known.clear();
        self.known.extend(self.pieces.iter().map(|piece| Known {
            at_least: piece.tree.squared_distance_to_bounds(point),
            at_most: f32::INFINITY,
        }));
    }

    /// The least distance to a piece, or any that is at most `enough`. The piece that was closest before
    /// comes first, since its distance rules out most of the others.
    fn squared_distance(&mut self, level: usize, i: usize, point: Vec3, enough: f32) -> f32 {
        let level = &mut self.levels[level];
        let closest = &mut level.closest[i];
        let mut least = f32::INFINITY;
        let first = [*closest as usize];
        let first = if level.pieces.is_empty() {
            &[][..]
        } else {
            &first
        };
        for p in first.iter().chain(&level.pieces) {
            let known = &mut self.known[*p];
            if known.at_least >= least {
                continue;
            }
            if known.at_most > enough && known.at_least < known.at_most {
                *known = self.pieces[*p].within(i, point, *known, (least, enough));
            }
            if known.at_most < least {
                (least, *closest) = (known.at_most, *p as u32);
            }
            if least <= enough {
                break;
            }
        }
        least
    }
}

impl Piece {
    fn new(triangles: &[[u32; 3]], rest: &[Vec3], points: &Points) -> Self {
        let tree = SurfaceTree::new(triangles, rest);
        // A vertex that the piece has is found immediately.
        let mut of_vertex = vec![NO_TRIANGLE; rest.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for v in triangle {
                of_vertex[*v as usize] = tree.place(t);
            }
        }
        let of_point = points.vertices.iter().map(|v| of_vertex[*v as usize]);
        let mut hints: Vec<u32> = of_point.collect();
        hints.resize(points.len(), NO_TRIANGLE);
        Self { tree, hints }
    }

    /// What a search tells of a point that looks for less than a limit, and for no less than `enough`.
    fn within(
        &mut self,
        i: usize,
        point: Vec3,
        known: Known,
        (limit, enough): (f32, f32),
    ) -> Known {
        let hint = &mut self.hints[i];
        match self.tree.closest(point, *hint, limit, enough) {
            Some((squared, place)) => {
                *hint = place;
                let is_exact = squared > enough;
                Known {
                    at_least: if is_exact { squared } else { known.at_least },
                    at_most: squared.min(known.at_most),
                }
            }
            None => Known {
                at_least: limit.max(known.at_least),
                ..known
            },
        }
    }
}

/// For each point, the first one with the same position, such as that of a vertex on the other side
/// of a seam.
fn same(points: &Points, rest: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::new();
    let bits = |point: Vec3| point.to_array().map(f32::to_bits);
    let of_point = |(i, point): (usize, Vec3)| *first.entry(bits(point)).or_insert(i as u32);
    points.posed(rest).enumerate().map(of_point).collect()
}

#[cfg(test)]
mod tests {
    use super::super::DistanceOptions;
    use super::super::slow::{Triangles, slow, surface};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn levels_that_share_triangles_have_the_distances_of_the_slow_way(
            (points, triangles) in surface(),
            picks in prop::collection::vec(0u32..16, 60),
            moves in prop::collection::vec(prop::array::uniform3(-0.5f32..0.5), 40 * 4),
            lost in 0usize..80,
        ) {
            // Each triangle is in the levels of the bits of its number.
            let level = |l: u32| -> Triangles {
                let all = triangles.iter().zip(&picks).filter(|(_, p)| *p >> l & 1 == 1);
                all.map(|(t, _)| *t).collect()
            };
            let levels: Vec<Triangles> = (0..4).map(level).collect();
            let slices: Vec<&[[u32; 3]]> = levels.iter().map(Vec::as_slice).collect();
            let measured = Points::of(&triangles, points.len(), &DistanceOptions::default());
            let mut search = Search::new(Pieces::of(&slices), &points, measured.clone());
            let mut other = search.clone();
            let (mut most, mut greatest) = (vec![0.0_f32; 4], vec![0.0_f32; 4]);
            for moves in moves.chunks(40) {
                let moved = points.iter().zip(moves).map(|(p, m)| *p + Vec3::from_array(*m));
                let mut pose: Vec<Vec3> = moved.collect();
                // A vertex is not finite, in some cases.
                if let Some(point) = pose.get_mut(lost) {
                    *point = Vec3::NAN;
                }
                other.raise(&pose, &mut greatest);
                for ((level, found), most) in levels.iter().zip(search.distances(&pose)).zip(&mut most) {
                    *most = found.iter().copied().fold(*most, f32::max);
                    for (point, found) in measured.posed(&pose).zip(found) {
                        if !point.is_finite() {
                            prop_assert!(found.is_nan());
                            continue;
                        }
                        let wanted = slow(point, level, &pose);
                        let found = f64::from(found);
                        let is_same = (found - wanted).abs() < 5e-3 * (1.0 + wanted);
                        prop_assert!(found == wanted || is_same, "{} {}", found, wanted);
                    }
                }
            }
            prop_assert_eq!(most, greatest);
        }
    }

    #[test]
    fn equal_points_that_part_are_measured_apart() {
        let rest = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::Z];
        let level: [&[[u32; 3]]; 1] = [&[[0, 1, 2]]];
        let opts = DistanceOptions {
            face_centres: 0,
            ..DistanceOptions::default()
        };
        let points = Points::of(&[[3, 4, 4]], rest.len(), &opts);
        let mut search = Search::new(Pieces::of(&level), &rest, points);
        assert_eq!(search.same, [0, 0]);
        assert_eq!(search.distances(&rest), [[1.0, 1.0]]);
        let mut parted = rest;
        parted[4].z = 3.0;
        assert_eq!(search.distances(&parted), [[1.0, 3.0]]);
    }
}
