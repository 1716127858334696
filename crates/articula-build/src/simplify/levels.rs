//! Levels as lists of triangles, part by part, without duplicates.

use super::LevelTriangles;
use super::classes::Classes;
use super::topology::Surface;
use crate::clusters::rotated;
use articula_core::Mesh;
use foldhash::{HashSet, HashSetExt};
use std::ops::Range;

/// The triangles that simplification starts from.
#[derive(Debug, Clone, Default)]
pub(super) struct Sources {
    /// Corners as the first vertices of their wedges.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Triangles of each part.
    pub(super) parts: Vec<Range<usize>>,
}

/// Triangles of a mesh, without duplicates and degenerate ones.
pub(super) fn faces(mesh: &Mesh, classes: &Classes) -> Sources {
    let mut sources = Sources::default();
    let mut known = HashSet::new();
    for part in &mesh.parts {
        known.clear();
        let first = sources.triangles.len();
        for t in &mesh.triangles[part.triangles.clone()] {
            let [a, b, c] = t.map(|v| classes.wedge[v as usize]);
            if a != b && b != c && c != a && known.insert(rotated([a, b, c])) {
                sources.triangles.push([a, b, c]);
            }
        }
        sources.parts.push(first..sources.triangles.len());
    }
    sources
}

impl Sources {
    /// All triangles as a level.
    pub(super) fn level(&self) -> LevelTriangles {
        LevelTriangles {
            triangles: self.triangles.clone(),
            parts: self.parts.clone(),
        }
    }

    /// The remaining triangles; duplicates that collapses created are removed from the surface.
    pub(super) fn left(&self, surface: &mut Surface) -> LevelTriangles {
        let (level, duplicates) = self.listed(surface);
        duplicates.into_iter().for_each(|face| surface.kill(face));
        level
    }

    /// The remaining triangles without duplicates, and these.
    fn listed(&self, surface: &Surface) -> (LevelTriangles, Vec<usize>) {
        let mut level = LevelTriangles::default();
        let mut duplicates = Vec::new();
        let mut known = HashSet::new();
        for part in &self.parts {
            known.clear();
            let first = level.triangles.len();
            for face in part.clone().filter(|face| surface.is_alive(*face)) {
                if known.insert(rotated(surface.wedges[face])) {
                    level.triangles.push(surface.wedges[face]);
                } else {
                    duplicates.push(face);
                }
            }
            level.parts.push(first..level.triangles.len());
        }
        (level, duplicates)
    }
}

/// Levels that are noted on the way to the next one, which stays as it is without them.
pub(super) struct Notes<'a> {
    sources: &'a Sources,
    /// Numbers of faces, the next one last.
    wanted: Vec<usize>,
    pub(super) levels: Vec<LevelTriangles>,
}

impl<'a> Notes<'a> {
    /// Notes at these numbers of faces, which fall.
    pub(super) fn new(
        sources: &'a Sources,
        wanted: impl DoubleEndedIterator<Item = usize>,
    ) -> Self {
        Self {
            sources,
            wanted: wanted.rev().collect(),
            levels: Vec::new(),
        }
    }

    /// Notes the level of a surface that is down to the next number of faces.
    pub(super) fn take(&mut self, surface: &Surface) {
        while self.wanted.pop_if(|faces| surface.live <= *faces).is_some() {
            self.levels.push(self.sources.listed(surface).0);
        }
    }
}
