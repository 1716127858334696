//! Which triangles of the 2D mesh nothing covers in a view, and in which layer they are painted.
//!
//! A triangle that is covered in all views (teeth behind closed lips, an eye behind its lid)
//! goes to a further layer, which is rendered without what covers it.

use super::flat_mesh::{FlatMesh, corners_of};
use crate::error::PictureError;
use crate::item_buffer::{Faces, ItemBuffer, Samples};
use glam::{Vec2, Vec4};

/// Share of a triangle's samples that others may cover.
const COVERED_MOST: f32 = 0.04;
/// Most layers; what is still covered in the last one is painted as it is.
pub(crate) const MAX_LAYERS: usize = 4;

/// The layer of each triangle, and the views in which it is uncovered there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Uncovered {
    /// Layer of each triangle; 0 is everything as it is seen.
    pub layers: Vec<u8>,
    /// For each view, for each triangle, whether nothing covers it.
    pub seen: Vec<Vec<bool>>,
}

impl Uncovered {
    /// Number of layers.
    pub fn layer_count(&self) -> usize {
        self.layers.iter().max().map_or(0, |l| usize::from(*l) + 1)
    }

    /// The views in which one triangle is uncovered.
    pub fn views_of(&self, triangle: usize) -> Vec<bool> {
        self.seen.iter().map(|view| view[triangle]).collect()
    }
}

/// Sorts triangles into layers. `views` are the corners of all vertices in each view.
pub(crate) fn uncovered(
    flat: &FlatMesh,
    views: &[Vec<Vec4>],
    size: (u32, u32),
) -> Result<Uncovered, PictureError> {
    let count = flat.triangles.len();
    let mut layers = vec![u8::MAX; count];
    let mut seen = vec![vec![false; count]; views.len()];
    for layer in 0..MAX_LAYERS {
        let left: Vec<usize> = (0..count).filter(|t| layers[*t] == u8::MAX).collect();
        if left.is_empty() {
            break;
        }
        let mut found = vec![false; count];
        for (view, corners) in views.iter().enumerate() {
            let bare = bare_triangles(flat, corners, size, &left)?;
            for &t in &left {
                found[t] |= bare[t];
                seen[view][t] = bare[t];
            }
        }
        let last = layer + 1 == MAX_LAYERS;
        for &t in &left {
            if found[t] || last {
                layers[t] = layer as u8;
            }
        }
    }
    // Without a view that shows it in any layer, a triangle still lies in the last one there is.
    let used: Vec<u8> = (0..MAX_LAYERS as u8).filter(|l| layers.contains(l)).collect();
    for layer in &mut layers {
        *layer = used.partition_point(|u| u < layer) as u8;
    }
    Ok(Uncovered { layers, seen })
}

/// Which of some triangles are covered by no other of them but those that touch them.
fn bare_triangles(
    flat: &FlatMesh,
    corners: &[Vec4],
    size: (u32, u32),
    among: &[usize],
) -> Result<Vec<bool>, PictureError> {
    let mut buffer = ItemBuffer::new(size.0, size.1, Samples::Two)?;
    let places: Vec<Vec2> = corners.iter().map(|c| Vec2::new(c.x, c.y) / c.w).collect();
    let shown = |t: &usize| flat.shows(*t, corners_of(&places, flat.triangles[*t]));
    let drawn: Vec<usize> = among.iter().copied().filter(shown).collect();
    let of = |t: usize| flat.triangles[t].map(|v| corners[v as usize]);
    for &t in &drawn {
        buffer.draw(t as u32, of(t), Faces::Both);
    }
    // A second buffer that keeps nothing tells which samples a triangle alone would take.
    let mut alone = ItemBuffer::new(size.0, size.1, Samples::Two)?;
    let mut bare = vec![false; flat.triangles.len()];
    for &t in &drawn {
        let (mut all, mut covered) = (0u32, 0u32);
        alone.draw_where(t as u32, of(t), Faces::Both, |at| {
            let holder = buffer.item((at.x * 2.0) as u32, (at.y * 2.0) as u32);
            all += 1;
            let other = holder.is_some_and(|h| !touch(flat, t, h as usize));
            covered += u32::from(other);
            false
        });
        bare[t] = all > 0 && covered as f32 <= COVERED_MOST * all as f32;
    }
    Ok(bare)
}

/// Whether two triangles are one or share a corner.
fn touch(flat: &FlatMesh, a: usize, b: usize) -> bool {
    let (a, b) = (flat.triangles[a], flat.triangles[b]);
    a.iter().any(|v| b.contains(v))
}
