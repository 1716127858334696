//! Levels as lists of triangles, part by part, without duplicates.

use super::LevelTriangles;
use super::classes::Classes;
use super::topology::Surface;
use crate::clusters::rotated;
use articula_core::Mesh;
use std::collections::HashSet;
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
        let mut level = LevelTriangles::default();
        let mut known = HashSet::new();
        for part in &self.parts {
            known.clear();
            let first = level.triangles.len();
            for face in part.clone() {
                if !surface.is_alive(face) {
                    continue;
                }
                if known.insert(rotated(surface.wedges[face])) {
                    level.triangles.push(surface.wedges[face]);
                } else {
                    surface.kill(face);
                }
            }
            level.parts.push(first..level.triangles.len());
        }
        level
    }
}
