//! Rectangles of charts in one picture.

use super::charts::{Chart, Charts};
use etagere::{AtlasAllocator, size2};
use glam::Vec2;

/// Pixels around each chart, so that filters see nothing of its neighbours.
const GUTTER: f32 = 1.5;
/// Maximum width and height of the picture.
const MOST_PX: i32 = 2048;
/// Sides of the picture are multiples of this, the blocks of the encoder.
const BLOCK: i32 = 16;
/// Halvings of all scales until everything has room.
const HALVINGS: usize = 16;

/// Where charts lie in a picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Places {
    /// Width and height, pixels.
    pub(super) size: (u32, u32),
    charts: Vec<(Chart, Vec2)>,
}

impl Places {
    /// Position in the picture of a place of a chart, in texels of its texture.
    pub(super) fn place(&self, chart: usize, texels: Vec2) -> Vec2 {
        let (chart, corner) = &self.charts[chart];
        *corner + GUTTER + (texels - chart.least) * chart.scale
    }

    /// Pixels of the picture per texel of a chart.
    pub(super) fn scale(&self, chart: usize) -> f32 {
        self.charts[chart].0.scale
    }
}

/// Packs charts into a small picture, the highest first; coarser if they have no room in the largest.
/// `None` without charts.
pub(super) fn packed(charts: &Charts) -> Option<Places> {
    let mut charts = charts.charts.clone();
    if charts.is_empty() {
        return None;
    }
    for _ in 0..HALVINGS {
        if let Some(places) = at_scale(&charts) {
            return Some(places);
        }
        charts.iter_mut().for_each(|chart| chart.scale *= 0.5);
    }
    None
}

/// The least picture of those that are tried, from the sum of all areas on.
fn at_scale(charts: &[Chart]) -> Option<Places> {
    let outer = |chart: &Chart| {
        let size = (chart.size_px() + 2.0 * GUTTER).ceil().max(Vec2::ONE);
        size.min(Vec2::splat(2.0 * MOST_PX as f32))
    };
    let sizes: Vec<Vec2> = charts.iter().map(outer).collect();
    let area: f32 = sizes.iter().map(|size| size.x * size.y).sum();
    let widest = sizes.iter().map(|size| size.x).fold(0.0, f32::max);
    let highest = sizes.iter().map(|size| size.y).fold(0.0, f32::max);
    let blocks = |px: f32| (px.min(1e6) / BLOCK as f32).ceil() as i32 * BLOCK;
    let mut width = blocks(area.sqrt().max(widest));
    let mut height = blocks((area / width as f32).max(highest));
    while width <= MOST_PX && height <= MOST_PX {
        if let Some(corners) = corners(&sizes, (width, height)) {
            return Some(Places {
                size: (width as u32, height as u32),
                charts: charts.iter().copied().zip(corners).collect(),
            });
        }
        if width <= height {
            width += BLOCK;
        } else {
            height += BLOCK;
        }
    }
    None
}

fn corners(sizes: &[Vec2], (width, height): (i32, i32)) -> Option<Vec<Vec2>> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by(|a, b| sizes[*b].y.total_cmp(&sizes[*a].y));
    let mut free = AtlasAllocator::new(size2(width, height));
    let mut corners = vec![Vec2::ZERO; sizes.len()];
    for i in order {
        let found = free.allocate(size2(sizes[i].x as i32, sizes[i].y as i32))?;
        corners[i] = Vec2::new(found.rectangle.min.x as f32, found.rectangle.min.y as f32);
    }
    Some(corners)
}
