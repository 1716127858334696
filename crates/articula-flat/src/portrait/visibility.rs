//! In which layer of each view a triangle of the 2D mesh lies bare.
//!
//! What covers another triangle in a view is taken away with its whole layer, until everything
//! that faces the viewer was seen: teeth behind closed lips, an eye behind its lid, the neck
//! behind the jaw. So no triangle shows the colours of another one.

use super::flat_mesh::{FlatMesh, corners_of, front_area};
use crate::error::PictureError;
use crate::item_buffer::{Faces, ItemBuffer, Samples};
use glam::{Vec2, Vec4};

/// Share of a triangle's samples that others may cover.
const COVERED_MOST: f32 = 0.04;
/// Most layers of a view; what is still covered in the last one counts as not seen.
const MAX_LAYERS: u8 = 4;
/// The layer of a view in which a triangle does not lie.
pub const NOT_SEEN: u8 = u8::MAX;

/// The layers of all triangles in all views.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layers {
    /// For each view, for each triangle, its layer or [`NOT_SEEN`]. Layer 0 is everything as it
    /// is seen.
    pub of_view: Vec<Vec<u8>>,
    /// For each view, its last layer if that is one of triangles which face away in all views:
    /// they are seen from behind there.
    pub turned: Vec<Option<u8>>,
}

impl Layers {
    /// Number of layers of a view.
    pub fn count(&self, view: usize) -> usize {
        let seen = self.of_view[view].iter().filter(|l| **l != NOT_SEEN);
        seen.max().map_or(0, |l| usize::from(*l) + 1)
    }

    /// The views in which one triangle is seen.
    pub fn seen(&self, triangle: usize) -> Vec<bool> {
        let views = self.of_view.iter();
        views.map(|view| view[triangle] != NOT_SEEN).collect()
    }
}

/// Sorts triangles into layers. `views` are the corners of all vertices in each view.
pub(crate) fn layers(
    flat: &FlatMesh,
    views: &[Vec<Vec4>],
    size: (u32, u32),
) -> Result<Layers, PictureError> {
    let count = flat.triangles.len();
    let mut of_view = Vec::with_capacity(views.len());
    for corners in views {
        let mut layers = vec![NOT_SEEN; count];
        for layer in 0..MAX_LAYERS {
            let left: Vec<usize> = (0..count).filter(|t| layers[*t] == NOT_SEEN).collect();
            let bare = bare_triangles(flat, corners, size, &left)?;
            bare.iter().for_each(|t| layers[*t] = layer);
        }
        of_view.push(layers);
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

/// The triangles that face the viewer and that no other of them covers but those that touch them.
fn bare_triangles(
    flat: &FlatMesh,
    corners: &[Vec4],
    size: (u32, u32),
    among: &[usize],
) -> Result<Vec<usize>, PictureError> {
    let mut buffer = ItemBuffer::new(size.0, size.1, Samples::Two)?;
    let places = super::posing::places(corners);
    let shown = |t: &usize| FlatMesh::shows(corners_of(&places, flat.triangles[*t]));
    let drawn: Vec<usize> = among.iter().copied().filter(shown).collect();
    let of = |t: usize| flat.triangles[t].map(|v| corners[v as usize]);
    for &t in &drawn {
        buffer.draw(t as u32, of(t), Faces::Both);
    }
    // A second buffer that keeps nothing tells which samples a triangle alone would take.
    let mut alone = ItemBuffer::new(size.0, size.1, Samples::Two)?;
    let mut bare = Vec::new();
    for &t in &drawn {
        let (mut all, mut covered) = (0u32, 0u32);
        alone.draw_where(t as u32, of(t), Faces::Both, |at| {
            let holder = buffer.item((at.x * 2.0) as u32, (at.y * 2.0) as u32);
            all += 1;
            let other = holder.is_some_and(|h| !touch(flat, t, h as usize));
            covered += u32::from(other);
            false
        });
        if covered as f32 <= COVERED_MOST * all as f32 {
            bare.push(t);
        }
    }
    Ok(bare)
}

/// Whether two triangles are one or share a corner.
fn touch(flat: &FlatMesh, a: usize, b: usize) -> bool {
    let (a, b) = (flat.triangles[a], flat.triangles[b]);
    a.iter().any(|v| b.contains(v))
}
