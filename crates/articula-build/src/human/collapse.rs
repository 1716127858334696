//! Fewer triangles for the same surface: edge collapse by quadric error.
//!
//! Source: Garland and Heckbert, *Surface simplification using quadric error metrics* (1997),
//! with the link condition of Dey et al. so that a manifold stays one. Differs: every new point
//! is moved onto the distance field, and the open rim of a half surface stays in its plane.

use super::polygonise::Surface;
use glam::{DMat3, DVec3, Vec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A symmetric quadratic form: squared distances to planes, weighted by area.
#[derive(Debug, Clone, Copy, Default)]
struct Quadric {
    a: [f64; 6],
    b: DVec3,
    c: f64,
}

impl Quadric {
    fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let (n, d) = (normal, -normal.dot(point));
        Self {
            a: [
                n.x * n.x,
                n.x * n.y,
                n.x * n.z,
                n.y * n.y,
                n.y * n.z,
                n.z * n.z,
            ]
            .map(|v| v * weight),
            b: n * (d * weight),
            c: d * d * weight,
        }
    }

    /// Weakly pulls towards a point, so that flat regions have an optimum too.
    fn point(point: DVec3, weight: f64) -> Self {
        Self {
            a: [weight, 0.0, 0.0, weight, 0.0, weight],
            b: -point * weight,
            c: point.length_squared() * weight,
        }
    }

    fn add(&mut self, o: &Self) {
        for (a, b) in self.a.iter_mut().zip(o.a) {
            *a += b;
        }
        self.b += o.b;
        self.c += o.c;
    }

    fn matrix(&self) -> DMat3 {
        let a = self.a;
        DMat3::from_cols_array(&[a[0], a[1], a[2], a[1], a[3], a[4], a[2], a[4], a[5]])
    }

    fn at(&self, p: DVec3) -> f64 {
        p.dot(self.matrix() * p) + 2.0 * self.b.dot(p) + self.c
    }

    /// The point of least error, if it lies within `radius` of `near`.
    fn optimum(&self, near: DVec3, radius: f64) -> DVec3 {
        let m = self.matrix();
        if m.determinant().abs() < 1e-30 {
            return near;
        }
        let p = m.inverse() * -self.b;
        if p.is_finite() && p.distance(near) < radius {
            p
        } else {
            near
        }
    }
}

/// How a surface is thinned.
pub(super) struct Options<'a> {
    /// Triangles to keep.
    pub(super) target: usize,
    /// Whether the open rim lies in the plane x = 0.
    pub(super) mirrored: bool,
    /// How much an error at a point counts; 1 is normal.
    pub(super) importance: &'a dyn Fn(Vec3) -> f32,
    /// Vertices on the border between two tones; none if it is empty.
    pub(super) on_border: &'a [bool],
    /// Moves a point onto the surface and to what holds it.
    pub(super) onto: &'a dyn Fn(Vec3, Hold) -> Vec3,
}

/// What a vertex stays on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Hold {
    /// The plane x = 0, where the open rim lies.
    pub(super) rim: bool,
    /// The border between two tones.
    pub(super) border: bool,
}

impl Hold {
    fn or(self, other: Self) -> Self {
        Self {
            rim: self.rim || other.rim,
            border: self.border || other.border,
        }
    }
}

struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<Option<[u32; 3]>>,
    /// Triangles around each vertex.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    versions: Vec<u32>,
    holds: Vec<Hold>,
    /// Tone of each triangle.
    tones: Vec<bool>,
    live: usize,
}

/// Order of the queue: bits of a non-negative cost, then vertices and their versions.
type Entry = Reverse<(u64, u32, u32, u32, u32)>;

/// Collapses edges, cheapest first, until the target is met or no edge may go.
pub(super) fn collapse(surface: &Surface, options: &Options<'_>) -> Surface {
    let mut mesh = Mesh::new(surface, options);
    let mut queue = BinaryHeap::<Entry>::new();
    for v in 0..mesh.positions.len() as u32 {
        for n in mesh.neighbours(v).into_iter().filter(|n| *n > v) {
            queue.push(mesh.entry(v, n));
        }
    }
    while mesh.live > options.target {
        let Some(Reverse((_, a, b, va, vb))) = queue.pop() else {
            break;
        };
        if mesh.versions[a as usize] != va || mesh.versions[b as usize] != vb {
            continue;
        }
        let Some(point) = mesh.allowed(a, b, options) else {
            continue;
        };
        mesh.merge(a, b, point);
        for n in mesh.neighbours(a) {
            queue.push(mesh.entry(a.min(n), a.max(n)));
        }
    }
    for (p, hold) in mesh.positions.iter_mut().zip(&mesh.holds) {
        *p = (options.onto)(p.as_vec3(), *hold).as_dvec3();
    }
    mesh.surface()
}

impl Mesh {
    fn new(surface: &Surface, options: &Options<'_>) -> Self {
        let count = surface.positions.len();
        let positions: Vec<DVec3> = surface.positions.iter().map(|p| p.as_dvec3()).collect();
        let mut mesh = Self {
            around: vec![Vec::new(); count],
            quadrics: vec![Quadric::default(); count],
            versions: vec![0; count],
            holds: holds(surface, options),
            tones: surface.tones.clone(),
            triangles: surface.triangles.iter().copied().map(Some).collect(),
            live: surface.triangles.len(),
            positions,
        };
        for (t, triangle) in surface.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let normal = (b - a).cross(c - a);
            let area = normal.length() * 0.5;
            let weight = area * f64::from((options.importance)(((a + b + c) / 3.0).as_vec3()));
            let mut quadric = Quadric::plane(normal.normalize_or_zero(), a, weight);
            quadric.add(&Quadric::point((a + b + c) / 3.0, weight * 2e-3));
            for v in triangle {
                mesh.around[*v as usize].push(t as u32);
                mesh.quadrics[*v as usize].add(&quadric);
            }
        }
        mesh.hold_borders();
        mesh
    }

    /// Along a border errors across it count too, so that it keeps its course.
    fn hold_borders(&mut self) {
        for t in 0..self.triangles.len() {
            let Some(triangle) = self.triangles[t] else {
                continue;
            };
            for i in 0..3 {
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                let held = [a, b].iter().all(|v| self.holds[*v as usize].border);
                if !held || !self.is_border_edge(a, b) {
                    continue;
                }
                let [p, q, r] = [a, b, triangle[(i + 2) % 3]].map(|v| self.positions[v as usize]);
                let edge = q - p;
                let across = edge.cross(edge.cross(r - p)).normalize_or_zero();
                let quadric = Quadric::plane(across, p, edge.length_squared());
                self.quadrics[a as usize].add(&quadric);
                self.quadrics[b as usize].add(&quadric);
            }
        }
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut all: Vec<u32> = self.fan(v).flatten().filter(|n| *n != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn fan(&self, v: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.around[v as usize]
            .iter()
            .filter_map(|t| self.triangles[*t as usize])
    }

    /// Where the edge would go, before projection.
    fn meeting_point(&self, a: u32, b: u32) -> (DVec3, f64) {
        let (pa, pb) = (self.positions[a as usize], self.positions[b as usize]);
        let mut quadric = self.quadrics[a as usize];
        quadric.add(&self.quadrics[b as usize]);
        let (ha, hb) = (self.holds[a as usize], self.holds[b as usize]);
        let both = ha.or(hb);
        let middle = match (ha == both, hb == both) {
            (true, false) => pa,
            (false, true) => pb,
            _ => 0.5 * (pa + pb),
        };
        let mut point = if both.rim && both.border {
            middle
        } else {
            quadric.optimum(middle, pa.distance(pb))
        };
        if both.rim {
            point.x = 0.0;
        }
        (point, quadric.at(point).max(0.0))
    }

    fn entry(&self, a: u32, b: u32) -> Entry {
        let cost = self.meeting_point(a, b).1;
        Reverse((
            cost.to_bits(),
            a,
            b,
            self.versions[a as usize],
            self.versions[b as usize],
        ))
    }

    /// The new point, if the surface stays a manifold and no triangle turns over.
    fn allowed(&self, a: u32, b: u32, options: &Options<'_>) -> Option<Vec3> {
        let (na, nb) = (self.neighbours(a), self.neighbours(b));
        let shared = na.iter().filter(|n| nb.contains(n)).count();
        let faces = self.fan(a).filter(|t| t.contains(&b)).count();
        let rim = |v: u32| self.holds[v as usize].rim;
        let expected = if rim(a) && rim(b) { 1 } else { 2 };
        if shared != expected || faces != expected || !self.rim_stays_simple(a, b, &na, &nb) {
            return None;
        }
        if na.len() + nb.len() - shared - 2 < 4 || na.len() + nb.len() > 18 {
            return None;
        }
        let (ha, hb) = (self.holds[a as usize], self.holds[b as usize]);
        let both = ha.or(hb);
        let apart = ha.border && hb.border && !self.is_border_edge(a, b);
        if apart || (both != ha && both != hb) {
            return None;
        }
        let point = (options.onto)(self.meeting_point(a, b).0.as_vec3(), both);
        let keeps = |v: u32, other: u32| {
            self.fan(v)
                .filter(|t| !t.contains(&other))
                .all(|t| self.stays_upright(t, v, point.as_dvec3()))
        };
        (keeps(a, b) && keeps(b, a)).then_some(point)
    }

    /// An inner edge between two rim vertices would be doubled by the mirror.
    fn rim_stays_simple(&self, a: u32, b: u32, na: &[u32], nb: &[u32]) -> bool {
        let rim = |v: u32| self.holds[v as usize].rim;
        let (inner, rest) = match (rim(a), rim(b)) {
            (true, false) => (nb, na),
            (false, true) => (na, nb),
            _ => return true,
        };
        let kept = if rim(a) { a } else { b };
        inner
            .iter()
            .all(|n| *n == kept || !rim(*n) || (rest.contains(n) && self.is_rim_edge(kept, *n)))
    }

    fn is_rim_edge(&self, a: u32, b: u32) -> bool {
        self.fan(a).filter(|t| t.contains(&b)).count() == 1
    }

    fn is_border_edge(&self, a: u32, b: u32) -> bool {
        let beside = self.around[a as usize]
            .iter()
            .filter(|t| self.triangles[**t as usize].is_some_and(|triangle| triangle.contains(&b)));
        let mut tones = beside.map(|t| self.tones.get(*t as usize));
        matches!((tones.next(), tones.next()), (Some(one), Some(other)) if one != other)
    }

    fn stays_upright(&self, triangle: [u32; 3], moved: u32, to: DVec3) -> bool {
        let before = triangle.map(|v| self.positions[v as usize]);
        let after = triangle.map(|v| {
            if v == moved {
                to
            } else {
                self.positions[v as usize]
            }
        });
        let normal = |p: [DVec3; 3]| (p[1] - p[0]).cross(p[2] - p[0]);
        let (old, new) = (normal(before), normal(after));
        let longest = (0..3)
            .map(|i| after[i].distance_squared(after[(i + 1) % 3]))
            .fold(0.0, f64::max);
        // Neither turned by more than 60 degrees nor thinner than about one in twelve.
        old.dot(new) > 0.5 * old.length() * new.length() && new.length() > 0.08 * longest
    }

    fn merge(&mut self, a: u32, b: u32, point: Vec3) {
        for t in std::mem::take(&mut self.around[b as usize]) {
            let Some(mut triangle) = self.triangles[t as usize] else {
                continue;
            };
            if triangle.contains(&a) {
                self.triangles[t as usize] = None;
                self.live -= 1;
                continue;
            }
            for v in &mut triangle {
                if *v == b {
                    *v = a;
                }
            }
            self.triangles[t as usize] = Some(triangle);
            self.around[a as usize].push(t);
        }
        let triangles = &self.triangles;
        self.around[a as usize].retain(|t| triangles[*t as usize].is_some());
        let moved = self.quadrics[b as usize];
        self.quadrics[a as usize].add(&moved);
        self.positions[a as usize] = point.as_dvec3();
        self.holds[a as usize] = self.holds[a as usize].or(self.holds[b as usize]);
        self.versions[a as usize] += 1;
        self.versions[b as usize] += 1;
    }

    fn surface(&self) -> Surface {
        let mut out = Surface::default();
        let mut renamed = vec![u32::MAX; self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let Some(triangle) = triangle else {
                continue;
            };
            out.tones.extend(self.tones.get(t));
            out.triangles.push(triangle.map(|v| {
                if renamed[v as usize] == u32::MAX {
                    renamed[v as usize] = out.positions.len() as u32;
                    out.positions.push(self.positions[v as usize].as_vec3());
                }
                renamed[v as usize]
            }));
        }
        out
    }
}

fn holds(surface: &Surface, options: &Options<'_>) -> Vec<Hold> {
    let hold = |(v, p): (usize, &Vec3)| Hold {
        rim: options.mirrored && p.x == 0.0,
        border: options.on_border.get(v).copied().unwrap_or(false),
    };
    surface.positions.iter().enumerate().map(hold).collect()
}

#[cfg(test)]
mod tests {
    use super::super::polygonise::tests::{ball, edge_uses};
    use super::*;

    fn thinned(half: bool, target: usize) -> Surface {
        let center = if half { Vec3::ZERO } else { Vec3::X * 3.0 };
        let options = Options {
            target,
            mirrored: half,
            importance: &|_| 1.0,
            on_border: &[],
            onto: &|p, hold| {
                let p = if hold.rim {
                    Vec3::new(0.0, p.y, p.z)
                } else {
                    p
                };
                center + (p - center).normalize()
            },
        };
        collapse(&ball(half), &options)
    }

    #[test]
    fn a_thinned_ball_is_still_a_ball() {
        let thin = thinned(false, 200);
        assert!((198..=200).contains(&thin.triangles.len()));
        assert!(edge_uses(&thin).values().all(|n| *n == 2));
        assert!(
            thin.positions
                .iter()
                .all(|p| ((*p - Vec3::X * 3.0).length() - 1.0).abs() < 1e-5)
        );
    }

    #[test]
    fn a_thinned_half_keeps_its_rim_in_the_plane() {
        let thin = thinned(true, 120);
        assert!((118..=120).contains(&thin.triangles.len()));
        for ((a, b), uses) in edge_uses(&thin) {
            let in_plane = [a, b].iter().all(|v| thin.positions[*v as usize].x == 0.0);
            assert_eq!(uses, if in_plane { 1 } else { 2 });
        }
    }

    #[test]
    fn a_target_out_of_reach_ends_with_a_closed_surface() {
        let least = thinned(false, 0);
        assert!(least.triangles.len() >= 4);
        assert!(edge_uses(&least).values().all(|n| *n == 2));
    }
}
