//! Merges equal vertices, and selects the points and wedges that each level's faces use.

use super::super::canonical::rotated;
use super::super::mesh::QuantisedMesh;
use super::Quantised;
use articula_core::Mismatch;
use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};

/// Makes the levels of `out` from a mesh of one point and one wedge per vertex.
pub(super) fn merge(
    whole: &QuantisedMesh,
    levels: &[Vec<[u32; 3]>],
    out: &mut Quantised,
) -> Result<(), Mismatch> {
    let points = first_with_key(whole.wedges(), |v| point_key(whole, v));
    let wedges = first_with_key(whole.wedges(), |v| wedge_key(whole, points[v], v));
    let mut finer: Option<Finer> = None;
    for (level, triangles) in levels.iter().enumerate() {
        let named = used(whole.wedges(), triangles).map_err(|v| {
            wrong(
                level,
                format!(
                    "vertex {v} is out of range: the mesh has {} vertices",
                    whole.wedges()
                ),
            )
        })?;
        let mut seen = HashSet::new();
        let mut faces = Vec::with_capacity(triangles.len());
        for t in triangles {
            let face = t.map(|v| wedges[v as usize]);
            let found = finer.as_ref().map_or(Some(face), |finer| finer.find(face));
            let Some(face) = found else {
                out.degenerate_faces += 1;
                continue;
            };
            let [a, b, c] = face.map(|w| points[w as usize]);
            if a == b || b == c || c == a {
                out.degenerate_faces += 1;
            } else if seen.insert(rotated(face)) {
                faces.push(face);
            } else {
                out.duplicate_faces += 1;
            }
        }
        finer = Some(Finer::new(whole, &points, &wedges, &faces, &named));
        out.levels.push(of_faces(whole, &points, &faces));
    }
    Ok(())
}

fn wrong(level: usize, what: String) -> Mismatch {
    Mismatch::new(format!("levels[{level}]"), what)
}

/// Marks the vertices that triangles use; the error is the first invalid index.
fn used(vertices: usize, triangles: &[[u32; 3]]) -> Result<Vec<bool>, u32> {
    let mut out = vec![false; vertices];
    for &v in triangles.as_flattened() {
        *out.get_mut(v as usize).ok_or(v)? = true;
    }
    Ok(out)
}

/// For each vertex the first one with the same key.
fn first_with_key(vertices: usize, key: impl Fn(usize) -> Vec<i32>) -> Vec<u32> {
    let mut firsts = HashMap::with_capacity(vertices);
    let first = |v: usize| *firsts.entry(key(v)).or_insert(v as u32);
    (0..vertices).map(first).collect()
}

fn point_key(whole: &QuantisedMesh, v: usize) -> Vec<i32> {
    let mut key = whole.positions[v].to_vec();
    for offsets in &whole.morphs {
        key.extend(offsets[v]);
    }
    if let Some(skin) = whole.skins.get(v) {
        key.extend(skin.iter().map(|i| i32::from(i.0) << 8 | i32::from(i.1)));
    }
    key
}

fn wedge_key(whole: &QuantisedMesh, point: u32, v: usize) -> Vec<i32> {
    let mut key = vec![point as i32];
    key.extend(whole.normals.get(v).into_iter().flatten());
    key.extend(whole.texcoords.get(v).into_iter().flatten());
    let colors = whole.colors.get(v).into_iter().flatten();
    key.extend(colors.map(|c| i32::from(*c)));
    for turns in &whole.morph_normals {
        key.extend(turns.get(v).into_iter().flatten());
    }
    key
}

/// The points and wedges of the next finer level; a coarser level uses only these among the
/// vertices that the finer one names.
///
/// Substitutes are needed because of rounding: a wedge is lost if all its faces become degenerate.
struct Finer {
    /// For each vertex the wedge to use: its own, one of the same point, or one of the same
    /// position.
    stand_ins: Vec<Option<u32>>,
}

impl Finer {
    fn new(
        whole: &QuantisedMesh,
        points: &[u32],
        wedges: &[u32],
        faces: &[[u32; 3]],
        named: &[bool],
    ) -> Self {
        let mut is_used = vec![false; points.len()];
        for &w in faces.as_flattened() {
            is_used[w as usize] = true;
        }
        let (mut of_point, mut of_position) = (HashMap::new(), HashMap::new());
        for w in (0..points.len()).filter(|w| is_used[*w]) {
            of_point.entry(points[w]).or_insert(w as u32);
            of_position.entry(whole.positions[w]).or_insert(w as u32);
        }
        let stand_in = |v: usize| {
            let wedge = wedges[v];
            // A vertex that the finer level does not name is kept: the levels of a region may meet
            // others at vertices that only finer faces of those use.
            if is_used[wedge as usize] || !named[v] {
                return Some(wedge);
            }
            let same_point = of_point.get(&points[v]);
            let found = same_point.or_else(|| of_position.get(&whole.positions[v]));
            found.copied()
        };
        let stand_ins = (0..points.len()).map(stand_in).collect();
        Self { stand_ins }
    }

    fn find(&self, [a, b, c]: [u32; 3]) -> Option<[u32; 3]> {
        let wedge = |w: u32| self.stand_ins[w as usize];
        Some([wedge(a)?, wedge(b)?, wedge(c)?])
    }
}

/// The mesh of some faces, with points and wedges in the order of first use.
fn of_faces(whole: &QuantisedMesh, points: &[u32], faces: &[[u32; 3]]) -> QuantisedMesh {
    const NONE: u32 = u32::MAX;
    let mut wedge_ids = vec![NONE; whole.wedges()];
    let mut point_ids = vec![NONE; whole.wedges()];
    let (mut kept_wedges, mut kept_points) = (Vec::new(), Vec::new());
    let mut out = QuantisedMesh::default();
    for face in faces {
        let named = face.map(|w| {
            let point = points[w as usize] as usize;
            if point_ids[point] == NONE {
                point_ids[point] = kept_points.len() as u32;
                kept_points.push(point);
            }
            if wedge_ids[w as usize] == NONE {
                wedge_ids[w as usize] = kept_wedges.len() as u32;
                kept_wedges.push(w as usize);
                out.wedge_points.push(point_ids[point]);
            }
            wedge_ids[w as usize]
        });
        out.faces.push(named);
    }
    out.positions = pick(&whole.positions, &kept_points);
    out.skins = pick(&whole.skins, &kept_points);
    let morphs = whole.morphs.iter();
    out.morphs = morphs.map(|m| pick(m, &kept_points)).collect();
    out.normals = pick(&whole.normals, &kept_wedges);
    out.texcoords = pick(&whole.texcoords, &kept_wedges);
    out.colors = pick(&whole.colors, &kept_wedges);
    let turns = whole.morph_normals.iter();
    out.morph_normals = turns.map(|m| pick(m, &kept_wedges)).collect();
    out
}

/// Selects values of vertices; empty for a kind that does not exist.
fn pick<T: Clone>(values: &[T], kept: &[usize]) -> Vec<T> {
    if values.is_empty() {
        return Vec::new();
    }
    kept.iter().map(|i| values[*i].clone()).collect()
}
