//! Pages of a flipbook: one clip per frame, with common ramps.
//!
//! Source: `docs/methods/vector.md` 8.2.

use super::prepared::PreparedClip;
use crate::planar::key_frames::{KeyOptions, keyed};
use crate::planar::keyed_clip::{KeyedClip, KeyedPaint};
use crate::planar::order::Layer;
use crate::planar::underlap::{Sealed, seal};
use crate::planar::{Drawn, PlanarClip, PlanarError};

/// Returns one clip of one frame for each frame, back to front in that frame's painting order.
///
/// # Errors
/// Errors of the clip.
pub(super) fn pages(
    prepared: &PreparedClip,
    options: &KeyOptions,
) -> Result<Vec<KeyedClip>, PlanarError> {
    let clip = &prepared.clip;
    let corners = seal(clip, &prepared.drawn, &prepared.painting, prepared.underlap).corners;
    let mut page = PlanarClip {
        frames: Vec::new(),
        ..clip.clone()
    };
    let mut all = Vec::with_capacity(clip.frames.len());
    for (f, (frame, corners)) in clip.frames.iter().zip(corners).enumerate() {
        page.frames = vec![frame.clone()];
        let order = prepared.order_at(f);
        let mut drawn = Drawn::none(1, clip.triangles.len());
        for t in &order {
            drawn.set(0, *t as usize, true);
        }
        let layer = |triangle| Layer {
            triangle,
            frames: std::iter::once(0..1).collect(),
        };
        let layers: Vec<Layer> = order.into_iter().map(layer).collect();
        let sealed = Sealed {
            corners: vec![corners],
        };
        all.push(keyed(&page, &drawn, &layers, &sealed, options)?.0);
    }
    share_ramps(&mut all);
    Ok(all)
}

/// Gives all pages the union of their ramps.
fn share_ramps(pages: &mut [KeyedClip]) {
    let mut ramps: Vec<[u8; 3]> = Vec::new();
    for page in &mut *pages {
        for shape in &mut page.shapes {
            if let KeyedPaint::Ramp { ramp, .. } = &mut shape.paint {
                let color = page.ramps[*ramp as usize];
                let known = ramps.iter().position(|r| *r == color);
                *ramp = known.unwrap_or(ramps.len()) as u32;
                if known.is_none() {
                    ramps.push(color);
                }
            }
        }
    }
    for page in pages {
        page.ramps.clone_from(&ramps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::PrepareClipOptions;
    use crate::planar::clip::fixture;
    use crate::vector::flipbook::flipbook;
    use articula_core::Progress;

    #[test]
    fn pages_show_what_is_drawn_in_order_and_make_a_book() {
        let cube = fixture::turning_cube(6);
        let options = PrepareClipOptions::default();
        let prepared = PreparedClip::new(cube, &options, &mut Progress::none()).unwrap();
        let pages = pages(&prepared, &KeyOptions::default()).unwrap();
        assert_eq!(pages.len(), 6);
        for (f, page) in pages.iter().enumerate() {
            assert_eq!(page.shapes.len(), prepared.order_at(f).len());
            assert_eq!(page.ramps, pages[0].ramps);
        }
        assert!(flipbook(&pages, "cube").unwrap().contains("<animate"));
    }
}
