//! Layers that are kept, as the selection of a description.

use crate::error::{Error, Result};
use crate::item::part::{ItemLayer, ItemPart, PartKind};
use articula_stream::description::Selection;
use std::collections::BTreeMap;

/// Tier that no stream has: everything with a tier is finer.
const NO_TIER: u32 = u32::MAX;

/// The selection that keeps the same units of a stream as some layers of its part.
///
/// # Errors
/// [`Error::Argument`] for layers that are no level with a tier, or levels of regions: those of a
/// decision always are.
pub(super) fn selection(part: &ItemPart, kept: &[bool]) -> Result<Selection> {
    let layers: Vec<&ItemLayer> = part
        .layers
        .iter()
        .zip(kept)
        .filter(|(_, kept)| **kept)
        .map(|(layer, _)| layer)
        .collect();
    let of = |layer: &ItemLayer, scheme: &str| layer.keep.get(scheme).copied();
    let finest = |scheme| layers.iter().filter_map(|l| of(l, scheme)).min();
    let most = |scheme| layers.iter().filter_map(|l| of(l, scheme)).max();
    let has = |scheme: &str| part.layers.iter().any(|l| l.keep.contains_key(scheme));
    let selection = match part.kind {
        PartKind::Texture => Selection::default(),
        PartKind::Mesh => mesh(part, &layers),
        PartKind::BodyMotion | PartKind::FaceMotion => {
            let tier = has("tier").then(|| finest("tier").unwrap_or(NO_TIER));
            // AFP-1 calls the level of a parameter `loa`.
            let loa = most("face_loa").or_else(|| most("loa"));
            let mut made = Selection {
                tier,
                ..Selection::default()
            };
            match (part.kind, loa) {
                (PartKind::BodyMotion, loa) => made.body_loa = loa,
                (_, Some(loa)) => made.face_levels = Some([loa.min(3) as u8; 8]),
                (_, None) => {}
            }
            made
        }
    };
    let same = |(layer, kept): (&ItemLayer, &bool)| keeps(&selection, part.kind, layer) == *kept;
    if !part.layers.iter().zip(kept).all(same) {
        let what = format!(
            "part \"{}\": these layers cannot be selected by level, region and tier; cut the item \
             by its indices",
            part.name
        );
        return Err(Error::argument(what));
    }
    Ok(selection)
}

/// Whether a selection keeps a layer, by its markers.
pub(super) fn keeps(selection: &Selection, kind: PartKind, layer: &ItemLayer) -> bool {
    let of = |scheme: &str| layer.keep.get(scheme).copied();
    let within = |value: Option<u32>, most: Option<u32>| match (value, most) {
        (Some(value), Some(most)) => value <= most,
        _ => true,
    };
    let tier = within(selection.tier, of("tier"));
    match kind {
        PartKind::Texture => true,
        PartKind::BodyMotion => tier && within(of("loa"), selection.body_loa),
        PartKind::FaceMotion => {
            let finest = selection.face_levels.map(|levels| u32::from(levels[0]));
            tier && within(of("face_loa").or_else(|| of("loa")), finest)
        }
        PartKind::Mesh => {
            let listed = |region| selection.mesh_levels.iter().find(|(r, _)| *r == region);
            let of_region = of("region").and_then(listed).map(|(_, level)| *level);
            within(selection.mesh_level, of("level")) && within(of_region, of("level"))
        }
    }
}

/// One level of all regions, or the level of each.
fn mesh(part: &ItemPart, kept: &[&ItemLayer]) -> Selection {
    let level = |layer: &ItemLayer| layer.keep.get("level").copied().unwrap_or(0);
    let region = |layer: &ItemLayer| layer.keep.get("region").copied();
    let is_common = |layer: &&ItemLayer| region(layer).is_none();
    let base = part.layers.iter().filter(is_common).map(level).min();
    if kept.iter().all(|layer| region(layer).is_none()) {
        let finest = kept.iter().map(|layer| level(layer)).min();
        return Selection {
            mesh_level: Some(finest.unwrap_or(NO_TIER)),
            ..Selection::default()
        };
    }
    let base = base.unwrap_or(0);
    let mut levels: BTreeMap<u32, u32> = part
        .layers
        .iter()
        .filter_map(|layer| Some((region(layer)?, base)))
        .collect();
    for layer in kept {
        if let Some(region) = region(layer) {
            let finest = levels.entry(region).or_insert(base);
            *finest = level(layer).min(*finest);
        }
    }
    Selection {
        mesh_levels: levels.into_iter().collect(),
        ..Selection::default()
    }
}
