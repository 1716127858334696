//! The two sides of a face: vertices at mirrored places.
//!
//! A mesh may have mirrored vertices, but triangles that cut its quadrangles along other diagonals on the
//! other side. Paths along the surface then differ; with the edges of both sides they do not.

use glam::Vec3;
use std::collections::HashMap;

/// Grid on which mirrored places must be the same, metres.
const GRID: f32 = 1e-5;

/// The vertex at the mirrored place of each vertex, if there is one.
#[derive(Debug, Clone)]
pub(in crate::face) struct Mirror {
    twins: Vec<Option<u32>>,
}

impl Mirror {
    /// The twins of vertices, mirrored at a plane across x. `joined` is the first vertex of the same place
    /// of each.
    pub(in crate::face) fn of(positions: &[Vec3], joined: &[u32], middle: f32) -> Self {
        let key = |x: f32, p: Vec3| [x, p.y, p.z].map(|c| (c / GRID).round() as i32);
        let all = positions.iter().zip(joined);
        let first: HashMap<[i32; 3], u32> = all
            .rev()
            .map(|(p, v)| (key(p.x - middle, *p), *v))
            .collect();
        let twin = |p: &Vec3| first.get(&key(middle - p.x, *p)).copied();
        Self {
            twins: positions.iter().map(twin).collect(),
        }
    }

    /// The twin of an edge, if both of its ends have one.
    pub(super) fn edge(&self, (a, b): (u32, u32)) -> Option<(u32, u32)> {
        let twin = |v: u32| self.twins.get(v as usize).copied().flatten();
        Some((twin(a)?, twin(b)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twins_are_at_mirrored_places() {
        let at = |x: f32, y: f32| Vec3::new(0.5 + x, y, 0.1);
        // The third is at the place of the second, the last has no twin.
        let positions = [
            at(0.2, 0.0),
            at(-0.2, 0.0),
            at(-0.2, 0.0),
            at(0.0, 1.0),
            at(0.3, 0.0),
        ];
        let mirror = Mirror::of(&positions, &[0, 1, 1, 3, 4], 0.5);
        assert_eq!(mirror.edge((0, 3)), Some((1, 3)));
        assert_eq!(mirror.edge((2, 0)), Some((0, 1)));
        assert_eq!(mirror.edge((0, 4)), None);
    }
}
