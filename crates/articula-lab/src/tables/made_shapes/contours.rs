//! Contours of lips and lids: chains of vertices along the edges of the skin, and distances between them.

use articula_build::face::{FacePoints, FaceSurface};
use articula_core::feature_points::PointId;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Inner and outer contours of the upper and the lower lip.
const LIPS: [&[PointId]; 4] = [
    &[(2, 5), (2, 7), (2, 2), (2, 6), (2, 4)],
    &[(2, 5), (2, 9), (2, 3), (2, 8), (2, 4)],
    &[(8, 4), (8, 6), (8, 1), (8, 5), (8, 3)],
    &[(8, 4), (8, 8), (8, 2), (8, 7), (8, 3)],
];
/// Upper and lower rim of the left and the right eye.
const LIDS: [[&[PointId]; 2]; 2] = [
    [&[(3, 11), (3, 1), (3, 7)], &[(3, 11), (3, 3), (3, 7)]],
    [&[(3, 12), (3, 2), (3, 8)], &[(3, 12), (3, 4), (3, 8)]],
];

/// Chains of vertices of a face.
pub(super) struct Contours {
    lips: Vec<Vec<u32>>,
    lids: [Vec<Vec<u32>>; 2],
}

impl Contours {
    pub(super) fn of(surface: &FaceSurface, points: &FacePoints) -> Self {
        let edges = edges(surface, points);
        let chain = |through: &&[PointId]| chain(points, &edges, through);
        Self {
            lips: LIPS.iter().filter_map(chain).collect(),
            lids: LIDS.map(|eye| eye.iter().filter_map(chain).collect()),
        }
    }

    /// Mean distance between the contours of the lips by two motions, metres; `None` if they are not found.
    pub(super) fn lips(&self, rest: &[Vec3], motions: [&[Vec3]; 2]) -> Option<f32> {
        distance(&self.lips, rest, motions)
    }

    /// As [`Contours::lips`], of the lids of an eye.
    pub(super) fn lids(&self, eye: usize, rest: &[Vec3], motions: [&[Vec3]; 2]) -> Option<f32> {
        distance(&self.lids[eye], rest, motions)
    }
}

/// Lengths of the edges of the skin, from each vertex. Vertices of one place and the same motions are one.
fn edges(surface: &FaceSurface, points: &FacePoints) -> BTreeMap<u32, Vec<(u32, f32)>> {
    let mut same: BTreeMap<Vec<[u32; 3]>, Vec<u32>> = BTreeMap::new();
    for v in points.skin().iter().flatten() {
        let moved = surface.shapes.iter().map(|(_, d)| d[*v as usize]);
        let key = std::iter::once(surface.positions[*v as usize]).chain(moved);
        let key = key.map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        same.entry(key.collect()).or_default().push(*v);
    }
    let mut edges: BTreeMap<u32, Vec<(u32, f32)>> = BTreeMap::new();
    for triangle in points.skin() {
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            let length = surface.positions[a as usize].distance(surface.positions[b as usize]);
            edges.entry(a).or_default().push((b, length));
            edges.entry(b).or_default().push((a, length));
        }
    }
    for twins in same.values().filter(|twins| twins.len() > 1) {
        for pair in twins.windows(2).filter(|pair| pair[0] != pair[1]) {
            edges.entry(pair[0]).or_default().push((pair[1], 0.0));
            edges.entry(pair[1]).or_default().push((pair[0], 0.0));
        }
    }
    edges
}

/// The shortest way along edges through points.
fn chain(
    points: &FacePoints,
    edges: &BTreeMap<u32, Vec<(u32, f32)>>,
    through: &[PointId],
) -> Option<Vec<u32>> {
    let vertices: Option<Vec<u32>> = through.iter().map(|p| points.get(*p)?.vertex).collect();
    let mut chain = Vec::new();
    for pair in vertices?.windows(2) {
        chain.extend(path(edges, pair[0], pair[1])?);
    }
    chain.dedup();
    (chain.len() > 2).then_some(chain)
}

/// The shortest path between two vertices, both included.
fn path(edges: &BTreeMap<u32, Vec<(u32, f32)>>, from: u32, to: u32) -> Option<Vec<u32>> {
    let mut found: BTreeMap<u32, (f32, u32)> = BTreeMap::from([(from, (0.0, from))]);
    let mut open = BinaryHeap::from([Reverse((0_u32, from))]);
    while let Some(Reverse((bits, vertex))) = open.pop() {
        let here = f32::from_bits(bits);
        if vertex == to {
            break;
        }
        if here > found[&vertex].0 {
            continue;
        }
        for (next, length) in edges.get(&vertex).into_iter().flatten() {
            let there = here + length;
            if found.get(next).is_none_or(|(known, _)| there < *known) {
                found.insert(*next, (there, vertex));
                open.push(Reverse((there.to_bits(), *next)));
            }
        }
    }
    let mut path = vec![to];
    while *path.last()? != from {
        path.push(found.get(path.last()?)?.1);
    }
    path.reverse();
    Some(path)
}

/// Mean distance of the places of each chain by the one motion from the chain by the other one, both ways.
fn distance(chains: &[Vec<u32>], rest: &[Vec3], motions: [&[Vec3]; 2]) -> Option<f32> {
    let (mut sum, mut count) = (0.0, 0.0);
    for chain in chains {
        let [a, b] = motions.map(|moved| {
            let at = chain.iter().map(|v| rest[*v as usize] + moved[*v as usize]);
            at.collect::<Vec<Vec3>>()
        });
        for (from, to) in [(&a, &b), (&b, &a)] {
            sum += from.iter().map(|p| to_line(*p, to)).sum::<f32>();
            count += from.len() as f32;
        }
    }
    (count > 0.0).then(|| sum / count)
}

fn to_line(place: Vec3, line: &[Vec3]) -> f32 {
    let near = line.windows(2).map(|ends| {
        let along = ends[1] - ends[0];
        let part = (place - ends[0]).dot(along) / along.length_squared().max(1e-12);
        place.distance(ends[0] + part.clamp(0.0, 1.0) * along)
    });
    near.fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sliding_along_a_contour_is_no_error() {
        let rest: Vec<Vec3> = (0..11).map(|i| i as f32 * Vec3::X).collect();
        let chains = vec![(0..11).collect()];
        let still = vec![Vec3::ZERO; 11];
        let along = vec![0.5 * Vec3::X; 11];
        let up = vec![2.0 * Vec3::Y; 11];
        // Of eleven places each way one end is half a step beyond the other contour.
        let slid = distance(&chains, &rest, [&still, &along]).unwrap();
        assert!((slid - 1.0 / 22.0).abs() < 1e-6, "{slid}");
        assert!((distance(&chains, &rest, [&still, &up]).unwrap() - 2.0).abs() < 1e-6);
        assert_eq!(distance(&[], &rest, [&still, &up]), None);
    }
}
