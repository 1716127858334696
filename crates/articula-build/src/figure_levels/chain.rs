//! The chain of levels through the cheapest candidates within rising tolerances.

use articula_core::{FigureLevel, Mesh, Part};

/// Maximum cost of a level relative to the level before.
const WORTH: f32 = 0.88;

/// Ratio of successive tolerances: half an octave.
const STEP: f32 = std::f32::consts::SQRT_2;

/// A combination of skin and mesh level, with its error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) skin: usize,
    pub(super) level: FigureLevel,
    /// Maximum over all clips, in metres.
    pub(super) error_metres: f32,
}

impl Candidate {
    /// Whether it has no more joints, triangles or influences than `other`.
    fn is_within(&self, other: &FigureLevel) -> bool {
        let level = &self.level;
        level.joint_level >= other.joint_level
            && level.mesh_level >= other.mesh_level
            && level.influences <= other.influences
    }
}

/// Selects, for rising tolerances, the cheapest candidate that has no more joints, triangles or
/// influences than the one before. The full character comes first.
pub(super) fn choose(mut all: Vec<Candidate>, first_metres: f32, most: usize) -> Vec<Candidate> {
    let Some(full) = all.iter().copied().reduce(|a, b| {
        let finer = b.is_within(&a.level);
        if finer { a } else { b }
    }) else {
        return Vec::new();
    };
    for candidate in &mut all {
        candidate.level.cost = cost(&candidate.level, &full.level);
    }
    let mut chain = vec![Candidate {
        level: FigureLevel {
            cost: cost(&full.level, &full.level),
            ..full.level
        },
        error_metres: 0.0,
        ..full
    }];
    let mut tolerance = first_metres.max(1e-6);
    // Beyond a kilometre there is nothing left to drop.
    while tolerance < 1e3 {
        let last = chain[chain.len() - 1];
        let fits = |c: &&Candidate| c.error_metres <= tolerance && c.is_within(&last.level);
        let order = |c: &&Candidate| (c.level.cost, c.error_metres);
        let best = all.iter().filter(fits).min_by(|a, b| {
            let ((cost, error), (other, its)) = (order(a), order(b));
            cost.total_cmp(&other).then(error.total_cmp(&its))
        });
        if let Some(best) = best.filter(|b| b.level.cost <= WORTH * last.level.cost) {
            chain.push(*best);
        }
        tolerance *= STEP;
    }
    // Too many levels: drop the inner level whose neighbours have the most similar cost.
    while chain.len() > most.max(1) {
        let ratio = |i: usize| chain[i + 1].level.cost / chain[i - 1].level.cost;
        let inner = 1..chain.len() - 1;
        match inner.max_by(|a, b| ratio(*a).total_cmp(&ratio(*b)).then(b.cmp(a))) {
            Some(at) => chain.remove(at),
            None => chain.remove(chain.len() - 1),
        };
    }
    chain
}

/// Joints, triangles and influences of all vertices, as fractions of those of the full character.
fn cost(level: &FigureLevel, full: &FigureLevel) -> f32 {
    let part = |own: usize, all: usize| own as f32 / all.max(1) as f32;
    part(level.joints, full.joints)
        + part(level.triangles, full.triangles)
        + part(
            level.vertices * level.influences,
            full.vertices * full.influences,
        )
}

/// Number of different vertices that the triangles use.
pub(super) fn vertices(triangles: &[[u32; 3]]) -> usize {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.len()
}

/// The parts of a mesh with their triangles at a level. Triangles of a part are contiguous, and a
/// triangle belongs to the part of its vertices.
pub(super) fn parts(full: &Mesh, triangles: &[[u32; 3]]) -> Vec<Part> {
    let of = |part: &Part| {
        let is_in = |t: &[u32; 3]| part.vertices.contains(&(t[0] as usize));
        let first = triangles.iter().position(is_in).unwrap_or(0);
        let count = triangles.iter().filter(|t| is_in(t)).count();
        Part {
            triangles: first..first + count,
            ..part.clone()
        }
    };
    full.parts.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a character with 100 joints, 1000 triangles, 500 vertices and 4 influences.
    fn candidate(joints: usize, triangles: usize, influences: usize, error_mm: f32) -> Candidate {
        Candidate {
            skin: 0,
            level: FigureLevel {
                joint_level: 100 - joints,
                mesh_level: 10 - triangles / 100,
                joints,
                triangles,
                vertices: triangles / 2,
                influences,
                cost: 0.0,
            },
            error_metres: error_mm / 1000.0,
        }
    }

    fn sizes(chain: &[Candidate]) -> Vec<[usize; 3]> {
        let of = |c: &Candidate| [c.level.joints, c.level.triangles, c.level.influences];
        chain.iter().map(of).collect()
    }

    #[test]
    fn by_hand() {
        let all = vec![
            candidate(20, 100, 1, 40.0),
            candidate(100, 1000, 4, 0.0),
            // 1 mm: fewer triangles is the cheaper choice.
            candidate(50, 1000, 4, 0.9),
            candidate(100, 400, 4, 1.0),
            // 2 mm: the cheapest has all joints again, more than the level before; this one does
            // not.
            candidate(50, 400, 4, 1.9),
            candidate(50, 400, 2, 1.95),
            // Hardly cheaper: not a level.
            candidate(49, 400, 2, 3.0),
            candidate(100, 100, 4, 7.0),
        ];
        let chain = choose(all.clone(), 1e-3, 9);
        let wanted = [[100, 1000, 4], [100, 400, 4], [50, 400, 2], [20, 100, 1]];
        assert_eq!(sizes(&chain), wanted);
        let costs: Vec<f32> = chain.iter().map(|c| c.level.cost).collect();
        assert_eq!(costs[..2], [3.0, 1.0 + 0.4 + 0.4]);
        assert!((costs[3] - (0.2 + 0.1 + 0.025)).abs() < 1e-6);
        assert_eq!(sizes(&choose(all.clone(), 1e-3, 2)), [wanted[0], wanted[3]]);
        assert_eq!(sizes(&choose(all, 1e-3, 0)), [wanted[0]]);
        assert!(choose(Vec::new(), 1e-3, 9).is_empty());
    }

    #[test]
    fn what_is_always_off_is_never_shown() {
        let all = vec![
            candidate(100, 1000, 4, 0.0),
            candidate(10, 100, 1, f32::INFINITY),
        ];
        assert_eq!(choose(all, 1e-3, 9).len(), 1);
    }
}
