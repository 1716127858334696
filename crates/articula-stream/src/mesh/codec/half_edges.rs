//! Adjacency of faces by half-edges.
//!
//! Half-edge `3 f + k` runs from corner `k` of face `f` to the next. Source:
//! `docs/methods/clustered-mesh.md` part 8.1 (a): non-manifold edges count as borders.

/// Marks the absence of a half-edge, face, point or wedge.
pub(super) const NONE: u32 = u32::MAX;

/// The next half-edge in the same face.
pub(super) fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 {
        half_edge - 2
    } else {
        half_edge + 1
    }
}

/// The previous half-edge in the same face.
pub(super) fn previous(half_edge: u32) -> u32 {
    next(next(half_edge))
}

/// Start point of a half-edge.
pub(super) fn start(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    faces[half_edge as usize / 3][half_edge as usize % 3]
}

/// End point of a half-edge.
pub(super) fn end(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    start(faces, next(half_edge))
}

/// The corner opposite of a half-edge in its face.
pub(super) fn apex(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    start(faces, previous(half_edge))
}

/// For each half-edge the opposite one, or [`NONE`] at borders and non-manifold edges.
pub(super) fn twins(faces: &[[u32; 3]]) -> Vec<u32> {
    let mut edges: Vec<(u32, u32, u32)> = (0..faces.len() as u32 * 3)
        .map(|h| {
            let (a, b) = (start(faces, h), end(faces, h));
            (a.min(b), a.max(b), h)
        })
        .collect();
    edges.sort_unstable();
    let mut twins = vec![NONE; edges.len()];
    for edge in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        if let [(.., h), (.., g)] = *edge
            && start(faces, h) == end(faces, g)
        {
            twins[h as usize] = g;
            twins[g as usize] = h;
        }
    }
    twins
}

/// The outgoing half-edges of each point, sorted by end point.
#[derive(Debug)]
pub(super) struct Rings {
    first: Vec<u32>,
    out: Vec<u32>,
}

impl Rings {
    /// Builds the rings of faces over `points` points.
    pub(super) fn new(faces: &[[u32; 3]], points: usize) -> Self {
        let mut first = vec![0; points + 1];
        for &point in faces.iter().flatten() {
            first[point as usize + 1] += 1;
        }
        for i in 0..points {
            first[i + 1] += first[i];
        }
        let mut at = first.clone();
        let mut out = vec![0; faces.len() * 3];
        for h in 0..out.len() as u32 {
            let slot = &mut at[start(faces, h) as usize];
            out[*slot as usize] = h;
            *slot += 1;
        }
        for i in 0..points {
            let ring = &mut out[first[i] as usize..first[i + 1] as usize];
            ring.sort_unstable_by_key(|&h| (end(faces, h), h));
        }
        Self { first, out }
    }

    /// The outgoing half-edges of a point.
    pub(super) fn leaving(&self, point: u32) -> &[u32] {
        let i = point as usize;
        &self.out[self.first[i] as usize..self.first[i + 1] as usize]
    }

    /// A half-edge from one point to another.
    pub(super) fn find(&self, faces: &[[u32; 3]], from: u32, to: u32) -> Option<u32> {
        let ring = self.leaving(from);
        let at = ring.partition_point(|&h| end(faces, h) < to);
        ring.get(at).copied().filter(|&h| end(faces, h) == to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twins_pair_manifold_edges_alone() {
        // Two faces share 0-1; a third one along it makes it a border.
        let pair = [[0, 1, 2], [1, 0, 3]];
        assert_eq!(twins(&pair), [3, NONE, NONE, 0, NONE, NONE]);
        let fin = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        assert_eq!(twins(&fin), [NONE; 9]);
        // Two faces with the same direction along an edge.
        assert_eq!(twins(&[[0, 1, 2], [0, 1, 3]]), [NONE; 6]);
    }

    #[test]
    fn rings_find_edges() {
        let faces = [[0, 1, 2], [1, 0, 3]];
        let rings = Rings::new(&faces, 5);
        assert_eq!(rings.find(&faces, 0, 3), Some(4));
        assert_eq!(rings.find(&faces, 3, 0), None);
        assert_eq!(rings.leaving(0), [0, 4]);
        assert!(rings.leaving(4).is_empty());
    }
}
