//! Layers: the assignment of each triangle of the 2D mesh to a layer in each view.
//!
//! Triangles that nothing covers are taken from the view as it is seen. Covered ones (teeth behind
//! closed lips, an eye behind its lid, the neck behind the jaw) lie in further layers, each of
//! which is rendered separately and whose triangles do not cover each other: a colouring of the
//! conflict graph. So no triangle shows the colours of another one.

use super::flat_mesh::{FlatMesh, corners_of, front_area};
use crate::error::PictureError;
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use glam::{Vec2, Vec4};

/// Fraction of a triangle's samples that others may cover.
const COVERED_MOST: f32 = 0.04;
/// Maximum number of layers of a view; triangles that fit in none count as not seen.
const MAX_LAYERS: u8 = 7;
/// Value for triangles that are in no layer of a view.
pub(super) const NOT_SEEN: u8 = u8::MAX;

/// Layers of all triangles in all views.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Layers {
    /// For each view, for each triangle, its layer or [`NOT_SEEN`]. Layer 0 is the view as it is
    /// seen.
    pub of_view: Vec<Vec<u8>>,
    /// For each view, its last layer if that contains triangles which face away in all views: they
    /// are seen from behind in it.
    pub turned: Vec<Option<u8>>,
}

impl Layers {
    /// Number of layers of a view.
    pub(crate) fn count(&self, view: usize) -> usize {
        let seen = self.of_view[view].iter().filter(|l| **l != NOT_SEEN);
        seen.max().map_or(0, |l| usize::from(*l) + 1)
    }

    /// Views in which a triangle is seen.
    pub(crate) fn seen(&self, triangle: usize) -> Vec<bool> {
        let views = self.of_view.iter();
        views.map(|view| view[triangle] != NOT_SEEN).collect()
    }
}

/// Assigns triangles to layers. `views` are the corners of all vertices in each view.
pub(crate) fn layers(
    flat: &FlatMesh,
    views: &[Vec<Vec4>],
    size: (u32, u32),
) -> Result<Layers, PictureError> {
    let count = flat.triangles.len();
    let mut of_view = Vec::with_capacity(views.len());
    for corners in views {
        of_view.push(layers_of_view(flat, corners, size)?);
    }
    let mut layers = Layers {
        turned: vec![None; views.len()],
        of_view,
    };
    let unseen = (0..count).filter(|t| !layers.seen(*t).contains(&true));
    let unseen: Vec<usize> = unseen.collect();
    let places: Vec<Vec<Vec2>> = views.iter().map(|v| super::posing::places(v)).collect();
    let next: Vec<u8> = (0..views.len()).map(|v| layers.count(v) as u8).collect();
    for t in unseen {
        let area = |v: usize| front_area(corners_of(&places[v], flat.triangles[t])).abs();
        let best = (0..views.len()).max_by(|a, b| area(*a).total_cmp(&area(*b)).then(b.cmp(a)));
        if let Some(view) = best {
            layers.of_view[view][t] = next[view];
            layers.turned[view] = Some(next[view]);
        }
    }
    Ok(layers)
}

/// Layer of each triangle in one view.
fn layers_of_view(
    flat: &FlatMesh,
    corners: &[Vec4],
    size: (u32, u32),
) -> Result<Vec<u8>, PictureError> {
    let coverage = Coverage::new(flat, corners, size)?;
    let mut layers = vec![NOT_SEEN; flat.triangles.len()];
    let mut covered = Vec::new();
    for &t in &coverage.shown {
        if coverage.is_bare(t) {
            layers[t] = 0;
        } else {
            covered.push(t);
        }
    }
    // Near ones first, so that the triangles of a layer have similar depths.
    let depth = |t: usize| {
        flat.triangles[t]
            .map(|v| corners[v as usize].w)
            .iter()
            .sum::<f32>()
    };
    covered.sort_by(|a, b| depth(*a).total_cmp(&depth(*b)).then(a.cmp(b)));
    for t in covered {
        let conflicts = coverage.conflicts(t);
        let is_free = |l: &u8| conflicts.iter().all(|c| layers[*c as usize] != *l);
        if let Some(layer) = (1..MAX_LAYERS).find(is_free) {
            layers[t] = layer;
        }
    }
    Ok(layers)
}

/// Overlaps between triangles in a view.
struct Coverage {
    /// Triangles that face the viewer.
    shown: Vec<usize>,
    /// Number of samples of each triangle, and of those covered by a triangle that it does not
    /// touch.
    samples: Vec<u32>,
    covered: Vec<u32>,
    /// Number of samples that two triangles have in common, sorted; none for triangles that touch.
    overlaps: Vec<((u32, u32), u32)>,
}

impl Coverage {
    fn new(flat: &FlatMesh, corners: &[Vec4], size: (u32, u32)) -> Result<Self, PictureError> {
        let mut buffer = ItemBuffer::new(size.0, size.1, Supersampling::Two)?;
        let mut alone = buffer.clone();
        let places = super::posing::places(corners);
        let shows = |t: &usize| FlatMesh::shows(corners_of(&places, flat.triangles[*t]));
        let shown: Vec<usize> = (0..flat.triangles.len()).filter(shows).collect();
        let of = |t: usize| flat.triangles[t].map(|v| corners[v as usize]);
        for &t in &shown {
            buffer.draw(t as u32, of(t), Faces::Both);
        }
        let mut samples = vec![0; flat.triangles.len()];
        let mut covered = samples.clone();
        // All triangles that cover each sample, visible or not; the buffer stores nothing.
        let mut takers: Vec<(u32, u32)> = Vec::new();
        let (width, _) = buffer.sample_size();
        for &t in &shown {
            alone.draw_where(t as u32, of(t), Faces::Both, |at| {
                let (x, y) = ((at.x * 2.0) as u32, (at.y * 2.0) as u32);
                samples[t] += 1;
                let holder = buffer.item(x, y).map_or(t, |h| h as usize);
                covered[t] += u32::from(!touch(flat, t, holder));
                takers.push((y * width + x, t as u32));
                false
            });
        }
        takers.sort_unstable();
        let mut out = Self {
            shown,
            samples,
            covered,
            overlaps: Vec::new(),
        };
        out.count(flat, &takers);
        Ok(out)
    }

    fn count(&mut self, flat: &FlatMesh, takers: &[(u32, u32)]) {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for group in takers.chunk_by(|a, b| a.0 == b.0) {
            for (i, (_, a)) in group.iter().enumerate() {
                for (_, b) in &group[i + 1..] {
                    // Uncovered triangles lie in layer 0.
                    if !self.is_bare(*a as usize) && !self.is_bare(*b as usize) {
                        pairs.push((*a, *b));
                    }
                }
            }
        }
        pairs.sort_unstable();
        let groups = pairs.chunk_by(|a, b| a == b);
        let counts = groups.map(|g| (g[0], g.len() as u32));
        self.overlaps = counts
            .filter(|((a, b), _)| !touch(flat, *a as usize, *b as usize))
            .collect();
    }

    fn is_bare(&self, t: usize) -> bool {
        self.covered[t] as f32 <= COVERED_MOST * self.samples[t] as f32
    }

    /// Triangles that cannot share a layer with a triangle.
    fn conflicts(&self, t: usize) -> Vec<u32> {
        let t = t as u32;
        let other = |((a, b), count): &((u32, u32), u32)| {
            let other = if *a == t { *b } else { *a };
            let least = self.samples[t as usize].min(self.samples[other as usize]);
            let is_much = *count as f32 > COVERED_MOST * least as f32;
            ((*a == t || *b == t) && is_much).then_some(other)
        };
        self.overlaps.iter().filter_map(other).collect()
    }
}

/// Whether two triangles are the same or share a corner.
fn touch(flat: &FlatMesh, a: usize, b: usize) -> bool {
    let (a, b) = (flat.triangles[a], flat.triangles[b]);
    a.iter().any(|v| b.contains(v))
}
