//! The pieces of a character, and the levels of quality that they make.

use crate::error::Result;
use crate::item::delivery::{Delivery, Kept, PieceOf, access_units, is_motion};
use crate::item::{AdaptOptions, Item, ItemPart, Manifest};
use articula_stream::description::Context;
use std::ops::Range;
use std::sync::Arc;

/// An item in pieces with its levels of quality in a context, as the manifest alone tells them. Clones share
/// them, as the sessions of a server do.
#[derive(Debug, Clone)]
pub struct DeliveryPlan(pub(super) Arc<Planned>);

/// What a plan holds: what is asked for again and again is found once.
#[derive(Debug)]
pub(super) struct Planned {
    pub(super) delivery: Delivery,
    /// What shows at all times, from coarse to fine.
    pub(super) shape: Vec<Turn>,
    /// Of each part the access units of a motion, each from coarse to fine; one list for a motion without
    /// access units, none for what is no motion.
    pub(super) motions: Vec<Vec<Vec<Turn>>>,
    /// All motions together, level by level; only what plays now is of the least level.
    pub(super) later: Vec<Turn>,
    /// Where the bytes of each piece lie.
    pub(super) places: Vec<Vec<Place>>,
}

/// Bytes of a file.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) file: String,
    pub(super) range: Range<u64>,
    /// Bytes of the whole file.
    pub(super) bytes: u64,
}

impl DeliveryPlan {
    /// Plans an item for the view, the device and the wishes of a context, whatever its bandwidth.
    ///
    /// # Errors
    /// As [`decide`](crate::item::decide); if the context gets no 3D, or the manifest has no ranges of bytes.
    pub fn new(manifest: &Manifest, context: &Context, options: &AdaptOptions) -> Result<Self> {
        let mut units = |part: &_| Ok(access_units(part));
        let item = Item::elsewhere(manifest.clone());
        let delivery = Delivery::of(&item, context, options, &mut units)?;
        Ok(Self(Arc::new(Planned::of(delivery))))
    }
}

/// A piece in its turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    pub(super) piece: usize,
    /// Level of quality that it belongs to.
    pub(super) level: usize,
}

impl Planned {
    fn of(delivery: Delivery) -> Self {
        let parts = delivery.manifest.parts.iter().enumerate();
        let levels = &delivery.ladder.levels;
        let nothing = vec![false; delivery.catalogue.pieces.len()];
        let shape = turns(levels, &nothing, &|level, has| {
            delivery.missing_of_shape(has, level)
        });
        let motions = parts.map(|(part, of)| {
            let of_unit = |unit| {
                turns(levels, &nothing, &|level, has| {
                    delivery.missing_of_unit(has, (part, unit), &level[part])
                })
            };
            match is_motion(of) {
                true => units_of(of).into_iter().map(of_unit).collect(),
                false => Vec::new(),
            }
        });
        let motions: Vec<Vec<Vec<Turn>>> = motions.collect();
        let later = motions.iter().flatten().flatten().map(|turn| Turn {
            level: turn.level.max(1),
            ..*turn
        });
        let mut later: Vec<Turn> = later.collect();
        later.sort_by_key(|turn| turn.level);
        let pieces = 0..delivery.catalogue.pieces.len();
        Self {
            motions,
            later,
            places: pieces.map(|piece| places(&delivery, piece)).collect(),
            shape,
            delivery,
        }
    }
}

/// The pieces that levels ask for, each at the first one that does.
fn turns(
    levels: &[Kept],
    nothing: &[bool],
    missing: &dyn Fn(&Kept, &[bool]) -> Vec<usize>,
) -> Vec<Turn> {
    let mut seen = nothing.to_vec();
    let mut turns = Vec::new();
    for (number, level) in levels.iter().enumerate() {
        for piece in missing(level, nothing) {
            if !std::mem::replace(&mut seen[piece], true) {
                turns.push(Turn {
                    piece,
                    level: number,
                });
            }
        }
    }
    turns
}

/// The access units of a motion; `None` alone if it has none.
pub(super) fn units_of(part: &ItemPart) -> Vec<Option<usize>> {
    match access_units(part).len() {
        0 => vec![None],
        count => (0..count).map(Some).collect(),
    }
}

/// Where the bytes of a piece lie.
fn places(delivery: &Delivery, piece: usize) -> Vec<Place> {
    let manifest = &delivery.manifest;
    let piece = &delivery.catalogue.pieces[piece];
    let whole = |file: &str, bytes: u64| Place {
        file: file.to_owned(),
        range: 0..bytes,
        bytes,
    };
    match piece.of {
        // It is there before there is a plan.
        PieceOf::Manifest => Vec::new(),
        PieceOf::Figure => {
            let figure = [whole(&manifest.figure.file, manifest.figure.bytes)];
            let carried = manifest.whole.iter();
            let carried = carried.map(|file| whole(&file.file, file.bytes));
            figure.into_iter().chain(carried).collect()
        }
        PieceOf::Part { part, layer, .. } => {
            let part = &manifest.parts[part];
            match (&part.file, layer.map(|layer| &part.layers[layer])) {
                (Some(file), _) => {
                    let place = |range: &Range<u64>| Place {
                        file: file.clone(),
                        range: range.clone(),
                        bytes: part.bytes,
                    };
                    piece.ranges.iter().map(place).collect()
                }
                (None, Some(size)) => {
                    let file = size.file.iter();
                    file.map(|file| whole(file, size.bytes)).collect()
                }
                (None, None) => Vec::new(),
            }
        }
    }
}
