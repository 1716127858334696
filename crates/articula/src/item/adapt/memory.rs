//! Bytes of memory that parts of an item take once they are decoded, by what the manifest tells of them.

use crate::item::part::{ItemLayer, ItemPart};

/// Position, normal, tangent, texture coordinates, colour, four joints and four weights.
const VERTEX: u64 = 12 + 12 + 16 + 8 + 4 + 8 + 16;
/// Offsets of position and normal.
const TARGET: u64 = 12 + 12;
/// Three indices.
const TRIANGLE: u64 = 12;
/// Rotation, translation and scale in a frame.
const JOINT: u64 = 16 + 12 + 12;
/// A weight in a frame.
const WEIGHT: u64 = 4;
/// Red, green, blue and opacity.
const TEXEL: u64 = 4;

/// Memory from which on it is not told apart, bytes.
pub(super) const MOST: u64 = 1 << 48;

/// A mesh of so many vertices with morph targets, and triangles.
pub(super) fn mesh(vertices: u64, triangles: u64, morph_targets: u64) -> u64 {
    let vertex = VERTEX.saturating_add(TARGET.saturating_mul(morph_targets));
    let vertices = vertices.saturating_mul(vertex);
    vertices.saturating_add(triangles.saturating_mul(TRIANGLE))
}

/// A motion, all of its frames.
pub(super) fn motion(part: &ItemPart, layer: &ItemLayer, morph_targets: u64) -> u64 {
    let secs = part.duration_secs.unwrap_or(0.0);
    let frames = (secs * part.rate_hz.unwrap_or(0.0)).round() as u64;
    let joints = JOINT.saturating_mul(layer.joints.unwrap_or(0));
    let frame = joints.saturating_add(WEIGHT.saturating_mul(morph_targets));
    frames.saturating_add(1).saturating_mul(frame)
}

/// A picture with all of its halves, which take a third more.
pub(super) fn picture(layer: &ItemLayer) -> u64 {
    let texels = layer
        .size_px
        .map_or(0, |[w, h]| u64::from(w) * u64::from(h));
    TEXEL.saturating_mul(texels).saturating_mul(4) / 3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item::part::PartKind;

    #[test]
    fn decoded_bytes_by_hand() {
        assert_eq!(mesh(100, 50, 0), 7600 + 600);
        assert_eq!(mesh(100, 50, 2), 7600 + 4800 + 600);
        let layer = ItemLayer {
            joints: Some(10),
            size_px: Some([1024, 512]),
            ..ItemLayer::default()
        };
        // 2 MiB, and a third of it.
        assert_eq!(picture(&layer), (1 << 21) + (1 << 21) / 3);
        let walk = ItemPart {
            duration_secs: Some(2.0),
            rate_hz: Some(30.0),
            ..ItemPart::new("walk", PartKind::BodyMotion)
        };
        assert_eq!(motion(&walk, &layer, 3), 61 * (400 + 12));
    }
}
