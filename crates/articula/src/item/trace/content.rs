//! All that a policy knows of an item: its pieces, its levels, what plays when, and what errors the
//! manifest states.

use super::options::TraceOptions;
use super::timeline::{Play, Timeline};
use crate::error::Result;
use crate::item::delivery::{Delivery, PieceOf};
use crate::item::files::Item;
use crate::item::part::ItemPart;
use articula_stream::description::Context;
use std::ops::Range;

/// An item that is ready to be played.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Content {
    pub(super) item: Item,
    pub(super) delivery: Delivery,
    pub(super) timeline: Timeline,
    /// Pixels per metre at the distance of the character.
    pub(super) pixels_per_metre: f64,
}

impl Content {
    pub(super) fn of(item: Item, context: &Context, options: &TraceOptions) -> Result<Self> {
        let mut units = |part: &ItemPart| access_units(&item, part);
        let delivery = Delivery::of(&item, context, &options.adapt, &mut units)?;
        Ok(Self {
            timeline: Timeline::of(&item, options)?,
            pixels_per_metre: delivery.pixels_per_metre(),
            delivery,
            item,
        })
    }

    /// The parts of the item with their numbers.
    pub(super) fn parts(&self) -> impl Iterator<Item = (usize, &ItemPart)> {
        self.item.manifest.parts.iter().enumerate()
    }

    /// The part of a motion of the timeline.
    pub(super) fn motion_part(&self, motion: usize) -> (usize, &ItemPart) {
        let part = self.timeline.motions[motion].part;
        (part, &self.item.manifest.parts[part])
    }

    /// Which pieces are missing to play an access unit with some layers of its motion.
    pub(super) fn missing_of_unit(&self, has: &[bool], play: &Play, layers: &[bool]) -> Vec<usize> {
        let (part, _) = self.motion_part(play.motion);
        let delivery = &self.delivery;
        delivery.missing_of_unit(has, (part, Some(play.unit)), layers)
    }

    /// For each piece of some parts and access units whether it is there.
    pub(super) fn pieces_there(
        &self,
        has: &[bool],
        is_one: impl Fn(usize, Option<usize>) -> bool,
    ) -> Vec<bool> {
        let pieces = self.delivery.catalogue.pieces.iter().zip(has);
        let of_parts = pieces.filter(|(piece, _)| match piece.of {
            PieceOf::Part { part, unit, .. } => is_one(part, unit),
            PieceOf::Manifest | PieceOf::Figure => false,
        });
        of_parts.map(|(_, has)| *has).collect()
    }

    /// Bytes of the pieces of some parts and access units that are there.
    pub(super) fn bytes_there(
        &self,
        has: &[bool],
        is_one: impl Fn(usize, Option<usize>) -> bool,
    ) -> u64 {
        let there = self.delivery.catalogue.pieces.iter().zip(has);
        let bytes = there.filter_map(|(piece, has)| match piece.of {
            PieceOf::Part { part, unit, .. } if *has && is_one(part, unit) => Some(piece.bytes),
            _ => None,
        });
        bytes.sum()
    }

    /// Whether an access unit plays: its coarsest layer is there, and the coarsest of all else.
    pub(super) fn is_ready(&self, has: &[bool], play: &Play) -> bool {
        let least = &self.delivery.ladder.levels[0];
        let (part, _) = self.motion_part(play.motion);
        self.delivery.missing_of_shape(has, least).is_empty()
            && self.missing_of_unit(has, play, &least[part]).is_empty()
    }

    /// The error that the manifest states for the layers of a motion that are there, in pixels.
    pub(super) fn stated_px(&self, part: usize, there: &[bool]) -> f64 {
        let of = &self.item.manifest.parts[part];
        let layers = of.layers.iter().zip(there).filter(|(_, there)| **there);
        let least = layers.map(|(layer, _)| layer.error_m).reduce(f64::min);
        let coarsest = || of.layers.first().map(|layer| layer.error_m);
        let error_m = least.or(of.base_error_m).or_else(coarsest).unwrap_or(0.0);
        self.pixels_per_metre * error_m
    }
}

/// The bytes of each access unit of a motion, in order.
fn access_units(item: &Item, part: &ItemPart) -> Result<Vec<Range<u64>>> {
    let map = item.unit_tree(part)?;
    let units = map.children.iter();
    let units = units.filter(|unit| unit.marker("access_unit").is_some());
    Ok(units
        .map(|unit| unit.bits.start / 8..unit.bits.end / 8)
        .collect())
}
