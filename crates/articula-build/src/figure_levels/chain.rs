//! The chain of levels through the cheapest candidates within rising tolerances.

use articula_core::{FigureLevel, Mesh, Part};

/// Maximum cost of a level, relative to the level before.
const WORTH: f32 = 0.88;

/// Most draws of a character's levels: a level is drawn once for each of its materials that differ in more than colour
/// and for each of the usual sources of poses.
const DRAWS: usize = 60;
const SOURCES: usize = 2;

/// Levels that are kept however many draws they are: with none between the full character and the coarsest, a crowd
/// would be drawn in full up to where the coarsest will do.
const LEAST_LEVELS: usize = 6;

/// Ratio of successive tolerances: a quarter of an octave.
const STEP: f32 = 1.189_207_1;

/// A combination of skin and mesh level, with its error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) skin: usize,
    pub(super) level: FigureLevel,
    /// Maximum over all clips, in metres.
    pub(super) error_metres: f32,
    /// Number of materials of its mesh, those that differ in colour alone counted once.
    pub(super) materials: usize,
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
/// influences than the one before. The full character comes first. Costs are relative to the level before, so
/// that halving a few triangles is worth as much as halving many. Of too many levels those are left out that save
/// least in a crowd, the farthest of which are shown within `far_metres`.
pub(super) fn choose(
    mut all: Vec<Candidate>,
    (first_metres, far_metres): (f32, f32),
    most: usize,
) -> Vec<Candidate> {
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
        let last = chain[chain.len() - 1].level;
        let fits = |c: &&Candidate| c.error_metres <= tolerance && c.is_within(&last);
        let costs = all.iter().filter(fits).map(|c| (cost(&c.level, &last), c));
        let best = costs.min_by(|(cost, a), (other, b)| {
            let by_error = a.error_metres.total_cmp(&b.error_metres);
            cost.total_cmp(other).then(by_error)
        });
        if let Some((_, best)) = best.filter(|b| b.0 <= WORTH * cost(&last, &last)) {
            chain.push(*best);
        }
        tolerance *= STEP;
    }
    let draws = |chain: &[Candidate]| SOURCES * chain.iter().map(|c| c.materials).sum::<usize>();
    while chain.len() > most.max(1) || chain.len() > LEAST_LEVELS && draws(&chain) > DRAWS {
        let inner = 1..chain.len() - 1;
        let worth = |i: usize| saved(&chain[i - 1..=i + 1], far_metres);
        match inner.min_by(|a, b| worth(*a).total_cmp(&worth(*b)).then(a.cmp(b))) {
            Some(at) => chain.remove(at),
            None => chain.remove(chain.len() - 1),
        };
    }
    chain
}

/// What the second of three levels saves in a crowd that is spread evenly over the ground: as many are shown within a
/// tolerance as its square tells, up to that of the farthest.
fn saved(levels: &[Candidate], far_metres: f32) -> f32 {
    let [finer, level, coarser] = levels else {
        return 0.0;
    };
    let shown = |c: &Candidate| c.error_metres.min(far_metres).powi(2);
    (1.0 - cost(&level.level, &finer.level) / 3.0)
        * finer.level.triangles as f32
        * (shown(coarser) - shown(level))
}

/// Joints, triangles and influences of all vertices, as fractions of those of a finer level.
fn cost(level: &FigureLevel, finer: &FigureLevel) -> f32 {
    let part = |own: usize, all: usize| own as f32 / all.max(1) as f32;
    part(level.joints, finer.joints)
        + part(level.triangles, finer.triangles)
        + part(
            level.vertices * level.influences,
            finer.vertices * finer.influences,
        )
}

/// Number of different vertices that the triangles use.
pub(super) fn vertices(triangles: &[[u32; 3]]) -> usize {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.len()
}

/// Number of materials by which the parts that triangles belong to are drawn.
pub(super) fn materials(full: &Mesh, triangles: &[[u32; 3]]) -> usize {
    let shown = parts(full, triangles);
    let shown = shown.iter().filter(|part| !part.triangles.is_empty());
    let mut materials: Vec<Option<usize>> = shown.map(|part| part.draw_material).collect();
    materials.sort_unstable();
    materials.dedup();
    materials.len()
}

/// The parts of a mesh with their triangles at a level. Triangles of a part are contiguous, and a
/// triangle belongs to the part of its vertices.
pub(super) fn parts(full: &Mesh, triangles: &[[u32; 3]]) -> Vec<Part> {
    let mut of_vertex = vec![usize::MAX; full.len()];
    for (index, part) in full.parts.iter().enumerate() {
        of_vertex[part.vertices.clone()].fill(index);
    }
    let mut parts = full.parts.clone();
    parts.iter_mut().for_each(|part| part.triangles = 0..0);
    for (t, triangle) in triangles.iter().enumerate() {
        if let Some(part) = parts.get_mut(of_vertex[triangle[0] as usize]) {
            let first = match part.triangles.is_empty() {
                true => t,
                false => part.triangles.start,
            };
            part.triangles = first..t + 1;
        }
    }
    parts
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
            materials: 1,
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
        let chain = choose(all.clone(), (1e-3, 0.1), 9);
        let wanted = [[100, 1000, 4], [100, 400, 4], [50, 400, 2], [20, 100, 1]];
        assert_eq!(sizes(&chain), wanted);
        let costs: Vec<f32> = chain.iter().map(|c| c.level.cost).collect();
        assert_eq!(costs[..2], [3.0, 1.0 + 0.4 + 0.4]);
        assert!((costs[3] - (0.2 + 0.1 + 0.025)).abs() < 1e-6);
        assert_eq!(
            sizes(&choose(all.clone(), (1e-3, 0.1), 2)),
            [wanted[0], wanted[3]]
        );
        assert_eq!(sizes(&choose(all, (1e-3, 0.1), 0)), [wanted[0]]);
        assert!(choose(Vec::new(), (1e-3, 0.1), 9).is_empty());
    }

    #[test]
    fn many_materials_leave_levels_between_the_finest_and_the_coarsest() {
        let of_materials = |materials: usize| -> Vec<Candidate> {
            let halved = |i: u32| Candidate {
                materials,
                ..candidate(100 >> i, 1024 >> i, 4, ((1 << i) - 1) as f32)
            };
            (0..7).map(halved).collect()
        };
        let levels = |materials| choose(of_materials(materials), (1e-3, 0.1), 16).len();
        assert_eq!(levels(1), 7);
        assert_eq!(levels(4), 7, "56 draws");
        assert_eq!(levels(5), 6, "70 and 60 draws");
        assert_eq!(levels(40), LEAST_LEVELS);
        assert_eq!(choose(of_materials(40), (1e-3, 0.1), 3).len(), 3);
    }

    #[test]
    fn what_is_always_off_is_never_shown() {
        let all = vec![
            candidate(100, 1000, 4, 0.0),
            candidate(10, 100, 1, f32::INFINITY),
        ];
        assert_eq!(choose(all, (1e-3, 0.1), 9).len(), 1);
    }
}
