//! Levels of quality of an item in a context: what the joint choice keeps of it for more and more bytes.

use crate::error::{Error, Result};
use crate::item::adapt::{AdaptOptions, ItemCut, ItemDecision, decide};
use crate::item::files::Item;
use crate::item::part::{ItemLayer, ItemPart, PartKind};
use articula_stream::decide::{Outcome, Part};
use articula_stream::description::Context;

/// Number of levels.
const LEVELS: usize = 8;
/// Share of the search for a proof that a choice is best: levels between the least and the whole need
/// none.
const EFFORT: u32 = 20_000;

/// Which layers of each part of the item are kept.
pub(crate) type Kept = Vec<Vec<bool>>;

/// Levels of quality, each with all layers of those before.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ladder {
    /// The layers of each level, from the least to all that the context asks for.
    pub(crate) levels: Vec<Kept>,
    /// The parts that were decided on, and the scale of their errors.
    pub(crate) decision: ItemDecision,
}

impl Ladder {
    /// The levels of an item for the view, the device and the wishes of a context, whatever its bandwidth.
    pub(crate) fn of(item: &Item, context: &Context, options: &AdaptOptions) -> Result<Self> {
        let mut context = context.clone();
        context.network = Default::default();
        let at = |max_bytes: Option<u64>| {
            let options = AdaptOptions {
                max_bytes,
                effort: EFFORT.min(options.effort),
                ..*options
            };
            decide(item, &context, &options)
        };
        let decision = at(options.max_bytes)?;
        let (Some(top), Outcome::Parts(choice)) = (layers(&decision), &decision.decision.outcome)
        else {
            let what = format!("this context gets no 3D:\n{}", decision.decision);
            return Err(Error::unsuited(what));
        };
        let least = least(item, &decision);
        let always = decision.bytes_always;
        let parts = decision.parts.parts.iter();
        let fewest: u64 = parts.filter_map(fewest_bytes).sum();
        let growth = (choice.bytes.max(1) as f64 / fewest.max(1) as f64).max(1.0);
        let mut levels = vec![least];
        for step in 1..LEVELS - 1 {
            let share = step as f64 / (LEVELS - 1) as f64;
            let bytes = (fewest.max(1) as f64 * growth.powf(share)).ceil() as u64;
            if let Some(kept) = layers(&at(Some(bytes + always))?) {
                add(item, &mut levels, kept.clone());
            }
        }
        add(item, &mut levels, top.clone());
        Ok(Self { levels, decision })
    }

    /// All that the context asks for.
    pub(crate) fn top(&self) -> &Kept {
        &self.levels[self.levels.len() - 1]
    }
}

fn layers(decision: &ItemDecision) -> Option<&Kept> {
    match &decision.cut {
        Some(ItemCut::Layers { kept, .. }) => Some(kept),
        Some(ItemCut::Flat(_)) | None => None,
    }
}

fn fewest_bytes(part: &Part) -> Option<u64> {
    part.options.iter().map(|option| option.bytes_once).min()
}

/// The coarsest layers: without those of a motion, it does not play.
fn least(item: &Item, decision: &ItemDecision) -> Kept {
    let parts = &item.manifest.parts;
    let mut kept: Kept = parts
        .iter()
        .map(|part| match is_motion(part) {
            true => part.closure(&[0]),
            false => vec![false; part.layers.len()],
        })
        .collect();
    let of_parts = decision.parts.parts.iter().zip(&decision.parts.layers);
    for (part, layers) in of_parts {
        let options = part.options.iter().zip(layers);
        let fewest = options.min_by_key(|(option, _)| option.bytes_once);
        for (index, of_part) in fewest.iter().flat_map(|(_, layers)| *layers) {
            if !is_motion(&parts[*index]) {
                kept[*index].clone_from(of_part);
            }
        }
    }
    kept
}

/// Adds a level, with the layers of the one before; nothing if that has all of them.
fn add(item: &Item, levels: &mut Vec<Kept>, mut kept: Kept) {
    let Some(before) = levels.last() else { return };
    let parts = item.manifest.parts.iter();
    for (part, (kept, before)) in parts.zip(kept.iter_mut().zip(before)) {
        match part.kind {
            // Sizes of a texture replace each other.
            PartKind::Texture if largest(part, kept) < largest(part, before) => {
                kept.clone_from(before);
            }
            PartKind::Texture => {}
            _ => kept.iter_mut().zip(before).for_each(|(k, b)| *k |= b),
        }
    }
    if kept != *before {
        levels.push(kept);
    }
}

/// Whether a part is a motion.
pub(crate) fn is_motion(part: &ItemPart) -> bool {
    part.kind.is_motion()
}

/// The longer side of the largest size among some layers of a texture; 0 without one.
pub(crate) fn largest(part: &ItemPart, kept: &[bool]) -> u32 {
    let kept = part.layers.iter().zip(kept).filter(|(_, kept)| **kept);
    kept.map(|(layer, _)| side(layer)).max().unwrap_or(0)
}

/// The longer side of a size of a texture.
pub(crate) fn side(layer: &ItemLayer) -> u32 {
    layer.size_px.map_or(0, |[width, height]| width.max(height))
}

/// The finest level that all regions of a mesh have.
pub(crate) fn mesh_level(part: &ItemPart, there: &[bool]) -> Option<u32> {
    let level = |layer: usize| part.layers[layer].keep.get("level").copied();
    let has_all = |wanted: &u32| {
        (0..there.len()).all(|layer| there[layer] || level(layer).is_none_or(|l| l < *wanted))
    };
    let levels = (0..there.len())
        .filter(|layer| there[*layer])
        .filter_map(level);
    levels.filter(has_all).min()
}
