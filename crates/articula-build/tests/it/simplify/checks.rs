//! Properties of the levels of any mesh.

use articula_build::{LevelTriangles, Simplified, SimplifyOptions, simplify};
use articula_core::Mesh;
use std::collections::{BTreeMap, BTreeSet};

pub(crate) fn of(mesh: &Mesh, options: &SimplifyOptions) -> Simplified {
    simplify(mesh, std::slice::from_ref(&mesh.positions), options).unwrap()
}

pub(crate) fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
}

/// Number of uses of each directed edge between position classes.
pub(crate) fn edges(found: &Simplified, level: &LevelTriangles) -> BTreeMap<(u32, u32), usize> {
    let mut uses = BTreeMap::new();
    for t in &level.triangles {
        let c = t.map(|v| found.position_classes[v as usize]);
        for k in 0..3 {
            *uses.entry((c[k], c[(k + 1) % 3])).or_default() += 1;
        }
    }
    uses
}

pub(crate) fn is_closed(found: &Simplified, level: &LevelTriangles) -> bool {
    let uses = edges(found, level);
    uses.iter()
        .all(|((a, b), n)| *n == 1 && uses.get(&(*b, *a)) == Some(&1))
}

/// Checks the properties that hold for the levels of any mesh.
pub(crate) fn check(mesh: &Mesh, found: &Simplified, options: &SimplifyOptions) {
    assert_eq!(found.levels.len(), options.targets.len());
    let mut before = BTreeSet::new();
    let mut gone = BTreeSet::<(usize, [u32; 3])>::new();
    let mut vertices: BTreeSet<u32> = (0..mesh.len() as u32).collect();
    for level in &found.levels {
        assert_eq!(level.parts.len(), mesh.parts.len());
        let mut faces = BTreeSet::new();
        let mut next = 0;
        for (p, range) in level.parts.iter().enumerate() {
            assert_eq!(range.start, next);
            next = range.end;
            for t in &level.triangles[range.clone()] {
                assert!(faces.insert((p, turned(*t))), "{t:?} is there twice");
                assert!(
                    t.iter()
                        .all(|v| mesh.parts[p].vertices.contains(&(*v as usize)))
                );
            }
        }
        assert_eq!(next, level.triangles.len());
        assert!(faces.is_disjoint(&gone), "a face comes back");
        gone.extend(before.difference(&faces).copied());
        before = faces;
        let used: BTreeSet<u32> = level.triangles.iter().flatten().copied().collect();
        assert!(used.is_subset(&vertices), "a vertex comes back");
        vertices = used;
    }
}
