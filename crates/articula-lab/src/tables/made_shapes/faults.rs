//! Triangles that a shape turns over, and triangles that it makes cross each other.

use articula_build::face::FaceSurface;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Width of the cells by which near triangles are found, metres.
const CELL: f32 = 0.004;
/// Share of an edge, and of a triangle, within which they do not cross yet: they may touch.
const TOUCH: f32 = 1e-3;
/// Length from which a vertex moves, metres.
const MOVES: f32 = 1e-4;

/// A mesh at rest, by the places of its vertices.
pub(super) struct Faults<'a> {
    surface: &'a FaceSurface,
    skin: &'a [[u32; 3]],
    /// First vertex at the same place.
    place: Vec<u32>,
    /// Triangles of the skin across each edge of places.
    beside: Vec<Vec<usize>>,
}

impl<'a> Faults<'a> {
    pub(super) fn new(surface: &'a FaceSurface, skin: &'a [[u32; 3]]) -> Self {
        let mut first: HashMap<[u32; 3], u32> = HashMap::new();
        let of = surface.positions.iter().enumerate();
        let place: Vec<u32> = of
            .map(|(v, p)| {
                let key = p.to_array().map(|x| (x + 0.0).to_bits());
                *first.entry(key).or_insert(v as u32)
            })
            .collect();
        let mut of_edge: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for (t, triangle) in skin.iter().enumerate() {
            for i in 0..3 {
                let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|v| place[v as usize]);
                of_edge.entry([a.min(b), a.max(b)]).or_default().push(t);
            }
        }
        let mut beside = vec![Vec::new(); skin.len()];
        for two in of_edge.values().filter(|two| two.len() == 2) {
            beside[two[0]].push(two[1]);
            beside[two[1]].push(two[0]);
        }
        Self {
            surface,
            skin,
            place,
            beside,
        }
    }

    /// Triangles of the skin that face another way than at rest and than the triangles beside them.
    pub(super) fn flips(&self, moved: &[Vec3]) -> BTreeSet<usize> {
        let normals = |by: f32| -> Vec<Vec3> {
            let at = |v: u32| self.surface.positions[v as usize] + by * moved[v as usize];
            let normal = |t: &[u32; 3]| {
                let [a, b, c] = t.map(at);
                (b - a).cross(c - a).normalize_or_zero()
            };
            self.skin.iter().map(normal).collect()
        };
        let (rest, now) = (normals(0.0), normals(1.0));
        let against = |normals: &[Vec3], t: usize| {
            let around: Vec3 = self.beside[t].iter().map(|b| normals[*b]).sum();
            normals[t].dot(around) < 0.0
        };
        let is_over =
            |t: &usize| rest[*t].dot(now[*t]) < 0.0 && against(&now, *t) && !against(&rest, *t);
        (0..self.skin.len()).filter(is_over).collect()
    }

    /// Pairs of triangles of the skin that cross each other and do not at rest.
    pub(super) fn crossings(&self, moved: &[Vec3]) -> BTreeSet<(u32, u32)> {
        let at: Vec<Vec3> = self
            .surface
            .positions
            .iter()
            .zip(moved)
            .map(|(p, d)| *p + *d)
            .collect();
        let triangles = self.skin;
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        let near: Vec<u32> = (0..triangles.len() as u32)
            .filter(|t| {
                triangles[*t as usize]
                    .iter()
                    .any(|v| moved[*v as usize].length() > MOVES)
            })
            .collect();
        let mut cells_of_moved = BTreeSet::new();
        for t in &near {
            cells_of_moved.extend(cells_of(&at, &triangles[*t as usize]));
        }
        for (t, triangle) in triangles.iter().enumerate() {
            for cell in cells_of(&at, triangle).filter(|c| cells_of_moved.contains(c)) {
                cells.entry(cell).or_default().push(t as u32);
            }
        }
        let mut found = BTreeSet::new();
        for t in &near {
            for cell in cells_of(&at, &triangles[*t as usize]) {
                for other in &cells[&cell] {
                    let pair = (*t.min(other), *t.max(other));
                    if t != other && !found.contains(&pair) && self.cross_now(&at, pair) {
                        found.insert(pair);
                    }
                }
            }
        }
        found
    }

    fn cross_now(&self, at: &[Vec3], (a, b): (u32, u32)) -> bool {
        let [a, b] = [a, b].map(|t| self.skin[t as usize]);
        let shares = a.iter().any(|v| {
            b.iter()
                .any(|w| self.place[*v as usize] == self.place[*w as usize])
        });
        let places = |t: [u32; 3], at: &[Vec3]| t.map(|v| at[v as usize]);
        let rest = &self.surface.positions;
        !shares && cross(places(a, at), places(b, at)) && !cross(places(a, rest), places(b, rest))
    }
}

fn cells_of(at: &[Vec3], triangle: &[u32; 3]) -> impl Iterator<Item = [i32; 3]> + use<> {
    let [a, b, c] = triangle.map(|v| at[v as usize] / CELL);
    let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).floor());
    let [low, high] = [low, high].map(|p| p.to_array().map(|x| x as i32));
    (low[0]..=high[0]).flat_map(move |x| {
        (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
    })
}

/// Whether an edge of one triangle goes through the other one.
fn cross(a: [Vec3; 3], b: [Vec3; 3]) -> bool {
    let edges = |t: [Vec3; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    edges(a).into_iter().any(|e| through(e, b)) || edges(b).into_iter().any(|e| through(e, a))
}

/// Möller and Trumbore 1997, of a segment.
fn through((from, to): (Vec3, Vec3), [a, b, c]: [Vec3; 3]) -> bool {
    let (way, ab, ac) = (to - from, b - a, c - a);
    let p = way.cross(ac);
    let det = ab.dot(p);
    if det.abs() < 1e-18 {
        return false;
    }
    let s = from - a;
    let u = s.dot(p) / det;
    let q = s.cross(ab);
    let (v, t) = (way.dot(q) / det, ac.dot(q) / det);
    u > TOUCH && v > TOUCH && u + v < 1.0 - TOUCH && (TOUCH..1.0 - TOUCH).contains(&t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares, one above the other, each of two triangles.
    fn squares() -> FaceSurface {
        let square = |z: f32| {
            [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]].map(|[x, y]| Vec3::new(x, y, z))
        };
        FaceSurface {
            positions: [square(0.0), square(0.002)].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..FaceSurface::default()
        }
    }

    #[test]
    fn what_goes_through_crosses() {
        let surface = squares();
        let faults = Faults::new(&surface, &surface.triangles);
        let mut moved = vec![Vec3::ZERO; 8];
        assert!(faults.crossings(&moved).is_empty());
        // A corner goes through the other square.
        moved[6] = Vec3::new(-0.002, -0.004, -0.004);
        let found = faults.crossings(&moved);
        assert!(
            !found.is_empty() && found.iter().all(|(a, b)| *a < 2 && *b >= 2),
            "{found:?}"
        );
        moved[6] = Vec3::new(0.0, 0.0, -0.001);
        assert!(faults.crossings(&moved).is_empty());
    }

    #[test]
    fn a_triangle_that_folds_over_its_neighbour_is_a_flip() {
        let surface = squares();
        let faults = Faults::new(&surface, &surface.triangles);
        let mut moved = vec![Vec3::ZERO; 8];
        // The corner of one of the two goes across the diagonal that they share; the other one stays.
        moved[3] = Vec3::new(0.009, -0.008, 0.0);
        assert_eq!(faults.flips(&moved), BTreeSet::from([1]));
        moved[3] = Vec3::new(0.002, -0.002, 0.0);
        assert!(faults.flips(&moved).is_empty());
    }
}
