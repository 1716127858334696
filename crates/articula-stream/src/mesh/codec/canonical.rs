//! Ordering of a level that depends on its values only.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1: a chunk depends on the coarser level only as
//! a mesh, so every order and every tie is decided by quantised values.

use super::half_edges::NONE;
use super::mesh::QuantisedMesh;
use std::cmp::Ordering;

/// The points, wedges and faces of a mesh that faces use, sorted by value.
#[derive(Debug)]
pub(super) struct Canonical {
    /// Points, wedges and faces in rising order; each face starts with its lowest wedge.
    pub(super) mesh: QuantisedMesh,
    /// Index of each point in the original mesh.
    pub(super) points: Vec<u32>,
    /// Index of each wedge in the original mesh.
    pub(super) wedges: Vec<u32>,
}

/// Compares two points by value.
pub(super) fn compare_points(
    (a, i): (&QuantisedMesh, u32),
    (b, j): (&QuantisedMesh, u32),
) -> Ordering {
    let (i, j) = (i as usize, j as usize);
    let positions = a.positions[i].cmp(&b.positions[j]);
    let skins = || a.skins.get(i).cmp(&b.skins.get(j));
    let offsets = |m: &(&Vec<[i32; 3]>, &Vec<[i32; 3]>)| m.0[i].cmp(&m.1[j]);
    let morphs = || {
        let pairs = a.morphs.iter().zip(&b.morphs);
        let mut orders = pairs.map(|m| offsets(&m));
        orders.find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    };
    positions.then_with(skins).then_with(morphs)
}

/// Compares two wedges by their values, without their points.
pub(super) fn compare_wedges(
    (a, i): (&QuantisedMesh, u32),
    (b, j): (&QuantisedMesh, u32),
) -> Ordering {
    let (i, j) = (i as usize, j as usize);
    let normals = a.normals.get(i).cmp(&b.normals.get(j));
    let texcoords = || a.texcoords.get(i).cmp(&b.texcoords.get(j));
    let colors = || a.colors.get(i).cmp(&b.colors.get(j));
    let morphs = || {
        let pairs = a.morph_normals.iter().zip(&b.morph_normals);
        let mut orders = pairs.map(|(x, y)| x.get(i).cmp(&y.get(j)));
        orders.find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    };
    normals
        .then_with(texcoords)
        .then_with(colors)
        .then_with(morphs)
}

impl Canonical {
    /// Sorts the used parts of a valid mesh.
    pub(super) fn new(mesh: &QuantisedMesh) -> Self {
        let mut used_wedges = vec![false; mesh.wedges()];
        let mut used_points = vec![false; mesh.points()];
        for &wedge in mesh.faces.iter().flatten() {
            used_wedges[wedge as usize] = true;
            used_points[mesh.wedge_points[wedge as usize] as usize] = true;
        }
        let used = |u: &[bool]| -> Vec<u32> {
            let all = 0..u.len() as u32;
            all.filter(|&i| u[i as usize]).collect()
        };
        let mut points = used(&used_points);
        points.sort_by(|&i, &j| compare_points((mesh, i), (mesh, j)));
        let point_ids = inverse(&points, mesh.points());
        let mut wedges = used(&used_wedges);
        let point = |w: u32| point_ids[mesh.wedge_points[w as usize] as usize];
        wedges.sort_by(|&i, &j| {
            let points = point(i).cmp(&point(j));
            points.then_with(|| compare_wedges((mesh, i), (mesh, j)))
        });
        let wedge_ids = inverse(&wedges, mesh.wedges());
        let mut faces: Vec<[u32; 3]> = mesh
            .faces
            .iter()
            .map(|face| rotated(face.map(|w| wedge_ids[w as usize])))
            .collect();
        faces.sort_unstable();
        let mut sorted = mesh.picked(&points, &wedges);
        for point in &mut sorted.wedge_points {
            *point = point_ids[*point as usize];
        }
        sorted.faces = faces;
        Self {
            mesh: sorted,
            points,
            wedges,
        }
    }

    /// Returns for each point and each wedge of a finer mesh the equal one of this mesh.
    pub(super) fn matches(&self, fine: &Self) -> (Vec<u32>, Vec<u32>) {
        let (here, there) = (&self.mesh, &fine.mesh);
        let points = matches(self.points.len(), fine.points.len(), |i, j| {
            compare_points((here, i), (there, j))
        });
        // Wedges are sorted by point, and points have the same order in both meshes.
        let wedges = matches(self.wedges.len(), fine.wedges.len(), |i, j| {
            let p = (here, here.wedge_points[i as usize]);
            let q = (there, there.wedge_points[j as usize]);
            compare_points(p, q).then_with(|| compare_wedges((here, i), (there, j)))
        });
        (points, wedges)
    }
}

/// For each item of the second sorted list the equal one of the first.
fn matches(known: usize, fine: usize, compare: impl Fn(u32, u32) -> Ordering) -> Vec<u32> {
    let mut i = 0;
    (0..fine as u32)
        .map(|j| {
            while (i as usize) < known && compare(i, j).is_lt() {
                i += 1;
            }
            let is_equal = (i as usize) < known && compare(i, j).is_eq();
            if is_equal { i } else { NONE }
        })
        .collect()
}

/// Position of each of `count` ids in a list, or [`NONE`].
fn inverse(list: &[u32], count: usize) -> Vec<u32> {
    let mut places = vec![NONE; count];
    for (place, &id) in list.iter().enumerate() {
        places[id as usize] = place as u32;
    }
    places
}

/// Rotates a face so that its lowest wedge comes first.
pub(super) fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

impl QuantisedMesh {
    /// Selects points and wedges by id; wedges keep their points; no faces.
    pub(super) fn picked(&self, points: &[u32], wedges: &[u32]) -> Self {
        fn pick<T: Clone>(values: &[T], ids: &[u32]) -> Vec<T> {
            if values.is_empty() {
                return Vec::new();
            }
            ids.iter().map(|&i| values[i as usize].clone()).collect()
        }
        Self {
            positions: pick(&self.positions, points),
            skins: pick(&self.skins, points),
            morphs: self.morphs.iter().map(|m| pick(m, points)).collect(),
            wedge_points: pick(&self.wedge_points, wedges),
            normals: pick(&self.normals, wedges),
            texcoords: pick(&self.texcoords, wedges),
            colors: pick(&self.colors, wedges),
            morph_normals: self.morph_normals.iter().map(|m| pick(m, wedges)).collect(),
            faces: Vec::new(),
        }
    }
}
