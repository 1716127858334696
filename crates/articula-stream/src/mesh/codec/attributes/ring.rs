//! Surroundings of an element (a point or a wedge) of a surface.
//!
//! Walks have a bounded length however many faces meet, so that a hostile mesh cannot make them
//! long.

/// Maximum number of faces examined around an element.
const MAX_CORNERS: usize = 48;

/// The faces around each element.
#[derive(Debug)]
pub(super) struct Ring {
    faces: Vec<[u32; 3]>,
    starts: Vec<u32>,
    /// Face and corner as `3 * face + corner`.
    corners: Vec<u32>,
}

impl Ring {
    /// Builds the rings of faces over `count` elements.
    pub(super) fn new(count: usize, faces: Vec<[u32; 3]>) -> Self {
        let mut starts = vec![0u32; count + 1];
        for &v in faces.as_flattened() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..count {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; faces.len() * 3];
        for (c, &v) in faces.as_flattened().iter().enumerate() {
            corners[next[v as usize] as usize] = c as u32;
            next[v as usize] += 1;
        }
        Self {
            faces,
            starts,
            corners,
        }
    }

    /// Number of elements.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The faces.
    pub(super) fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Each corner at an element as (face, corner).
    pub(super) fn corners(&self, v: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        let at = self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize;
        let all = self.corners[at].iter();
        all.map(|c| (*c as usize / 3, *c as usize % 3))
            .take(MAX_CORNERS)
    }

    /// The other two corners of each face around an element, counter-clockwise.
    pub(super) fn edges(&self, v: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.corners(v).map(|(f, k)| {
            let face = self.faces[f];
            [face[(k + 1) % 3], face[(k + 2) % 3]]
        })
    }

    /// The corner opposite of edge a-b in the face on its right.
    pub(super) fn across(&self, a: u32, b: u32) -> Option<u32> {
        let mut found = self.edges(a).filter(|e| e[1] == b);
        found.next().map(|e| e[0])
    }

    /// The neighbours of an element with lower ids, each once.
    pub(super) fn known(&self, v: u32, out: &mut Vec<u32>) {
        self.known_below(v, v, out);
    }

    /// The neighbours of an element with ids below `end`, each once.
    pub(super) fn known_below(&self, v: u32, end: u32, out: &mut Vec<u32>) {
        out.clear();
        for u in self.edges(v).flatten().filter(|u| *u < end) {
            if !out.contains(&u) {
                out.push(u);
            }
        }
    }
}
