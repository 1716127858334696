//! Faces over position classes, and the corners around each class, in flat arrays.

use super::classes::Classes;

/// No corner.
const NONE: u32 = u32::MAX;

/// A surface whose vertices are merged one after another.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    /// Vertices (wedges) of each face.
    pub(super) wedges: Vec<[u32; 3]>,
    /// Position classes of each face.
    pub(super) faces: Vec<[u32; 3]>,
    alive: Vec<bool>,
    /// Number of live faces.
    pub(super) live: usize,
    /// First corner around each class; corner `3 f + k` belongs to `faces[f][k]`.
    head: Vec<u32>,
    next: Vec<u32>,
    /// Number of live corners around each class, and number of corners in its list.
    valence: Vec<u32>,
    listed: Vec<u32>,
}

impl Surface {
    /// Builds the surface of the faces that have three different classes.
    pub(super) fn new(triangles: &[[u32; 3]], classes: &Classes) -> Self {
        let mut surface = Self {
            wedges: triangles.to_vec(),
            faces: triangles
                .iter()
                .map(|t| t.map(|v| classes.of_vertex[v as usize]))
                .collect(),
            alive: vec![false; triangles.len()],
            live: 0,
            head: vec![NONE; classes.len()],
            next: vec![NONE; triangles.len() * 3],
            valence: vec![0; classes.len()],
            listed: vec![0; classes.len()],
        };
        // From last to first, so that each list is ascending.
        for f in (0..triangles.len()).rev() {
            let [a, b, c] = surface.faces[f];
            if a == b || b == c || c == a {
                continue;
            }
            surface.alive[f] = true;
            surface.live += 1;
            for (k, class) in surface.faces[f].into_iter().enumerate() {
                let corner = (3 * f + k) as u32;
                surface.next[corner as usize] = surface.head[class as usize];
                surface.head[class as usize] = corner;
                surface.valence[class as usize] += 1;
                surface.listed[class as usize] += 1;
            }
        }
        surface
    }

    /// Whether a face has not been removed.
    pub(super) fn is_alive(&self, face: usize) -> bool {
        self.alive[face]
    }

    /// Corners around a class, as (face, index of the corner in it).
    pub(super) fn around(&self, class: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        let mut at = self.head[class as usize];
        std::iter::from_fn(move || {
            while at != NONE {
                let corner = at as usize;
                at = self.next[corner];
                if self.alive[corner / 3] {
                    return Some((corner / 3, corner % 3));
                }
            }
            None
        })
    }

    /// Number of faces around a class.
    pub(super) fn valence(&self, class: u32) -> usize {
        self.valence[class as usize] as usize
    }

    /// Removes a face.
    pub(super) fn kill(&mut self, face: usize) {
        self.alive[face] = false;
        self.live -= 1;
        for class in self.faces[face] {
            self.valence[class as usize] -= 1;
            if self.listed[class as usize] > 2 * self.valence[class as usize] + 4 {
                self.prune(class);
            }
        }
    }

    /// Moves the corners of `from` to `to` and removes faces that have both. `images` holds the new
    /// wedge of each moved corner, in the order of [`Self::around`] without the removed faces.
    pub(super) fn collapse(&mut self, from: u32, to: u32, images: &[u32]) {
        let mut images = images.iter();
        let mut at = self.head[from as usize];
        self.head[from as usize] = NONE;
        self.listed[from as usize] = 0;
        while at != NONE {
            let corner = at as usize;
            at = self.next[corner];
            let face = corner / 3;
            if !self.alive[face] {
                continue;
            }
            if self.faces[face].contains(&to) {
                self.kill(face);
                continue;
            }
            self.faces[face][corner % 3] = to;
            if let Some(wedge) = images.next() {
                self.wedges[face][corner % 3] = *wedge;
            }
            self.next[corner] = self.head[to as usize];
            self.head[to as usize] = corner as u32;
            self.valence[from as usize] -= 1;
            self.valence[to as usize] += 1;
            self.listed[to as usize] += 1;
        }
    }

    /// Unlinks corners of removed faces from the list around a class.
    fn prune(&mut self, class: u32) {
        let mut kept = NONE;
        let mut at = self.head[class as usize];
        self.head[class as usize] = NONE;
        while at != NONE {
            let corner = at as usize;
            at = self.next[corner];
            if !self.alive[corner / 3] {
                continue;
            }
            if kept == NONE {
                self.head[class as usize] = corner as u32;
            } else {
                self.next[kept as usize] = corner as u32;
            }
            kept = corner as u32;
        }
        if kept != NONE {
            self.next[kept as usize] = NONE;
        }
        self.listed[class as usize] = self.valence[class as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surface::tangle;
    use super::*;
    use proptest::prelude::*;

    /// Faces of a plain list around a class, as (face, corner).
    fn around(faces: &[Option<[u32; 3]>], class: u32) -> Vec<(usize, usize)> {
        let corners = faces.iter().enumerate().filter_map(|(f, t)| {
            let at = (*t)?.iter().position(|c| *c == class)?;
            Some((f, at))
        });
        corners.collect()
    }

    fn assert_same(surface: &Surface, faces: &[Option<[u32; 3]>]) {
        assert_eq!(surface.live, faces.iter().flatten().count());
        for (f, face) in faces.iter().enumerate() {
            assert_eq!(surface.is_alive(f), face.is_some());
            assert!(face.is_none_or(|face| surface.faces[f] == face));
        }
        for class in 0..9 {
            let mut found: Vec<_> = surface.around(class).collect();
            found.sort_unstable();
            let expected = around(faces, class);
            assert_eq!(found, expected);
            assert_eq!(surface.valence(class), expected.len());
        }
    }

    proptest! {
        #[test]
        fn collapses_and_removals_are_those_of_a_plain_list(
            (classes, triangles) in tangle(),
            moves in prop::collection::vec((0u32..9, 0u32..9, any::<bool>()), 0..20),
        ) {
            let mut surface = Surface::new(&triangles, &classes);
            let mut faces: Vec<_> = triangles.iter().map(|t| Some(*t)).collect();
            assert_same(&surface, &faces);
            for (step, (from, to, whole)) in moves.into_iter().enumerate() {
                if !whole {
                    let face = (from * 9 + to) as usize % faces.len().max(1);
                    if faces.get(face).is_some_and(Option::is_some) {
                        surface.kill(face);
                        faces[face] = None;
                    }
                } else if from != to {
                    let stay: Vec<_> = surface
                        .around(from)
                        .filter(|(f, _)| !surface.faces[*f].contains(&to))
                        .collect();
                    let image = |i: usize| (100 * (step + 1) + i) as u32;
                    let images: Vec<u32> = (0..stay.len()).map(image).collect();
                    surface.collapse(from, to, &images);
                    for ((f, at), image) in stay.into_iter().zip(images) {
                        prop_assert_eq!(surface.wedges[f][at], image);
                    }
                    for face in &mut faces {
                        *face = face.filter(|t| !(t.contains(&from) && t.contains(&to)));
                        *face = face.map(|t| t.map(|c| if c == from { to } else { c }));
                    }
                }
                assert_same(&surface, &faces);
            }
        }
    }

    #[test]
    fn faces_around_a_class_ascend() {
        let classes = Classes {
            of_vertex: (0..6).collect(),
            first: (0..6).collect(),
            ..Classes::default()
        };
        let triangles = [[0, 1, 2], [3, 0, 2], [4, 4, 0], [5, 4, 0]];
        let surface = Surface::new(&triangles, &classes);
        // The face that uses a class twice is none.
        assert_eq!(
            surface.around(0).collect::<Vec<_>>(),
            [(0, 0), (1, 1), (3, 2)]
        );
        assert_eq!(surface.live, 3);
    }

    #[test]
    fn lists_of_corners_stay_short() {
        let classes = Classes {
            of_vertex: (0..50).collect(),
            first: (0..50).collect(),
            ..Classes::default()
        };
        let fan: Vec<[u32; 3]> = (1..49).map(|v| [0, v, v + 1]).collect();
        let mut surface = Surface::new(&fan, &classes);
        // From both ends and from the middle of the list.
        let order = (0..16).flat_map(|i| [i, 47 - i, 16 + i]);
        for (gone, face) in order.enumerate() {
            surface.kill(face);
            assert_eq!(surface.around(0).count(), 47 - gone);
            assert!(surface.around(0).is_sorted());
            assert!(surface.listed[0] <= 2 * surface.valence[0] + 4);
        }
        assert_eq!(surface.live, 0);
    }
}
