//! What a layer wants of a motion.

use crate::planar::clip::PlanarClip;
use crate::planar::keyed_clip::GRID;
use crate::planar::order::Layer;
use glam::DVec2;

/// Corners of a layer in every frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Item {
    /// Corners by frame, grid steps.
    pub corners: Vec<[DVec2; 3]>,
    /// Whether it is shown, by frame.
    pub is_shown: Vec<bool>,
    /// Dominant joint.
    pub part: u16,
    /// Tolerance of its corners, grid steps.
    pub tolerance: f64,
}

/// The corners of layers, before sealing.
pub(super) fn items(clip: &PlanarClip, layers: &[Layer], pos_tol_px: f32) -> Vec<Item> {
    let frames = clip.frames.len();
    let item = |layer: &Layer| {
        let t = layer.triangle as usize;
        let mut is_shown = vec![false; frames];
        for span in &layer.frames {
            is_shown[span.clone()].fill(true);
        }
        let corners = |f| {
            clip.places(f, t)
                .map(|place| place.as_dvec2() * f64::from(GRID))
        };
        Item {
            corners: (0..frames).map(corners).collect(),
            is_shown,
            part: clip.part[t],
            tolerance: f64::from(pos_tol_px * GRID as f32).max(0.5),
        }
    };
    layers.iter().map(item).collect()
}
