//! Textures of an item: all at one greatest size.

use super::memory;
use super::option_of_part::OptionOfPart;
use crate::item::part::{ItemLayer, ItemPart, TextureView};
use articula_stream::decide::{MAX_OPTIONS, PartOption};
use std::collections::BTreeSet;

/// The options of all textures: each with the greatest longer side that one of them has.
pub(super) fn options(
    parts: Vec<(usize, &ItemPart)>,
    max_px: Option<u32>,
    pixels_per_metre: f64,
) -> Vec<OptionOfPart> {
    let sizes = parts
        .iter()
        .flat_map(|(_, part)| part.layers.iter().map(side));
    let all: BTreeSet<u32> = sizes.collect();
    let least = all.first().copied().unwrap_or(0);
    let most = max_px.unwrap_or(u32::MAX).max(least);
    let allowed = all.into_iter().filter(|size| *size <= most);
    let made = allowed
        .rev()
        .enumerate()
        .map(|(level, size)| option(&parts, size, level as u32, pixels_per_metre));
    made.take(MAX_OPTIONS).collect()
}

/// The longer side of a size in pixels.
fn side(layer: &ItemLayer) -> u32 {
    layer.size_px.map_or(0, |[width, height]| width.max(height))
}

fn option(
    parts: &[(usize, &ItemPart)],
    size: u32,
    level: u32,
    pixels_per_metre: f64,
) -> OptionOfPart {
    let mut option = PartOption {
        name: match size {
            0 | 1 => "mean colour".to_owned(),
            _ => format!("{size} px"),
        },
        level,
        ..PartOption::default()
    };
    let mut layers = Vec::with_capacity(parts.len());
    for (index, part) in parts {
        let numbered = || part.layers.iter().enumerate();
        let fitting = numbered().filter(|(_, layer)| side(layer) <= size);
        let found = fitting
            .max_by_key(|(_, layer)| side(layer))
            .or_else(|| numbered().min_by_key(|(_, layer)| side(layer)));
        let chosen: Vec<usize> = found.iter().map(|(i, _)| *i).collect();
        let kept = part.closure(&chosen);
        // Pictures lie side by side on the skin: the worst one counts.
        let error = found.map_or(0.0, |(_, layer)| error_px(&layer.views, pixels_per_metre));
        option.error_px = option.error_px.max(error);
        option.bytes_once += part.bytes_of(&kept);
        let memory = found.map_or(0, |(_, layer)| memory::picture(layer));
        option.memory_bytes = (option.memory_bytes + memory).min(memory::MOST);
        layers.push((*index, kept));
    }
    OptionOfPart {
        option,
        layers,
        is_even: true,
    }
}

/// The error of the largest of some sizes of a texture; of the smallest one without any.
pub(crate) fn texture_error_px(part: &ItemPart, sizes: &[bool], pixels_per_metre: f64) -> f64 {
    let there = part.layers.iter().zip(sizes).filter(|(_, there)| **there);
    let largest = there
        .map(|(layer, _)| layer)
        .max_by_key(|layer| side(layer));
    let shown = largest.or_else(|| part.layers.iter().min_by_key(|layer| side(layer)));
    shown.map_or(0.0, |layer| error_px(&layer.views, pixels_per_metre))
}

/// The error at a number of pixels per metre: linear between the nearest measured views, that of the
/// farthest view beyond it, and nearer than all in proportion to the pixels per metre. No view, no
/// error: nothing of the figure shows the picture.
fn error_px(views: &[TextureView], pixels_per_metre: f64) -> f64 {
    let farther = views.iter().filter(|v| v.px_per_metre <= pixels_per_metre);
    let nearer = views.iter().filter(|v| v.px_per_metre > pixels_per_metre);
    let by = |a: &&TextureView, b: &&TextureView| a.px_per_metre.total_cmp(&b.px_per_metre);
    match (farther.max_by(by), nearer.min_by(by)) {
        (Some(far), Some(near)) => {
            let span = near.px_per_metre - far.px_per_metre;
            let t = (pixels_per_metre - far.px_per_metre) / span;
            far.error_px + t * (near.error_px - far.error_px)
        }
        (Some(nearest), None) => {
            nearest.error_px * pixels_per_metre / nearest.px_per_metre.max(f64::MIN_POSITIVE)
        }
        (None, Some(farthest)) => farthest.error_px,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_between_views_by_hand() {
        let view = |px_per_metre, error_px| TextureView {
            distance_m: 1.0,
            px_per_metre,
            rms_levels: 0.0,
            error_px,
            texel_px: None,
        };
        let views = [view(100.0, 0.5), view(400.0, 2.0)];
        assert_eq!(error_px(&views, 200.0), 1.0);
        assert_eq!(error_px(&views, 50.0), 0.5);
        assert_eq!(error_px(&views, 800.0), 4.0);
        assert_eq!(error_px(&[], 800.0), 0.0);
    }
}
