//! All that a policy knows of an item: its pieces, its levels, what plays when, and what errors the
//! manifest states.

use super::catalogue::{Catalogue, PieceOf};
use super::ladder::{Kept, Ladder, is_motion, largest, side};
use super::options::TraceOptions;
use super::timeline::{Play, Timeline};
use crate::error::Result;
use crate::item::files::Item;
use crate::item::part::{ItemPart, PartKind};
use articula_stream::description::Context;

/// An item that is ready to be played.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Content {
    pub(super) item: Item,
    pub(super) catalogue: Catalogue,
    pub(super) ladder: Ladder,
    pub(super) timeline: Timeline,
    /// Pixels per metre at the distance of the character.
    pub(super) pixels_per_metre: f64,
}

impl Content {
    pub(super) fn of(item: Item, context: &Context, options: &TraceOptions) -> Result<Self> {
        let ladder = Ladder::of(&item, context, options)?;
        Ok(Self {
            catalogue: Catalogue::of(&item)?,
            timeline: Timeline::of(&item, options)?,
            pixels_per_metre: ladder.decision.decision.request.pixels_per_metre,
            ladder,
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

    /// Which pieces are missing of what is no motion, from coarse to fine, for some layers.
    pub(super) fn missing_of_shape(&self, has: &[bool], kept: &Kept) -> Vec<usize> {
        let mut found = Missing::new(&self.catalogue, has);
        found.add(PieceOf::Figure);
        for (index, _) in self.parts().filter(|(_, part)| !is_motion(part)) {
            let layers = self.unmet(has, index, &kept[index]);
            found.add_layers(index, None, &layers);
        }
        found.pieces
    }

    /// Which pieces are missing to play an access unit with some layers of its motion.
    pub(super) fn missing_of_unit(&self, has: &[bool], play: &Play, layers: &[bool]) -> Vec<usize> {
        let mut found = Missing::new(&self.catalogue, has);
        let (part, _) = self.motion_part(play.motion);
        found.add(head(part));
        let numbers = layers.iter().enumerate().filter(|(_, kept)| **kept);
        let numbers: Vec<usize> = numbers.map(|(layer, _)| layer).collect();
        found.add_layers(part, Some(play.unit), &numbers);
        found.pieces
    }

    /// The layers of a part that are wanted: of a texture the largest size alone, unless one that is no
    /// smaller is there.
    fn unmet(&self, has: &[bool], part: usize, kept: &[bool]) -> Vec<usize> {
        let of = &self.item.manifest.parts[part];
        let numbers = || (0..kept.len()).filter(|layer| kept[*layer]);
        match of.kind {
            PartKind::Texture => {
                let there = largest(of, &self.layers_there(has, part, None));
                let most = numbers().max_by_key(|layer| side(&of.layers[*layer]));
                let larger = |layer: &usize| side(&of.layers[*layer]) > there;
                most.filter(larger).into_iter().collect()
            }
            _ => numbers().collect(),
        }
    }

    /// The layers of a part that are there, with what they build on: of a motion those of an access unit.
    pub(super) fn layers_there(&self, has: &[bool], part: usize, unit: Option<usize>) -> Vec<bool> {
        let of = &self.item.manifest.parts[part];
        let is_there = |of: PieceOf| self.catalogue.find(of).is_none_or(|piece| has[piece]);
        let piece = |layer| PieceOf::Part { part, unit, layer };
        let has_base = is_there(head(part)) && is_there(piece(None));
        let mut there: Vec<bool> = Vec::with_capacity(of.layers.len());
        for (number, layer) in of.layers.iter().enumerate() {
            let stands = layer.needs.iter().all(|need| there[*need]);
            there.push(has_base && stands && is_there(piece(Some(number))));
        }
        there
    }

    /// For each piece of some parts and access units whether it is there.
    pub(super) fn pieces_there(
        &self,
        has: &[bool],
        is_one: impl Fn(usize, Option<usize>) -> bool,
    ) -> Vec<bool> {
        let pieces = self.catalogue.pieces.iter().zip(has);
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
        let there = self.catalogue.pieces.iter().zip(has);
        let bytes = there.filter_map(|(piece, has)| match piece.of {
            PieceOf::Part { part, unit, .. } if *has && is_one(part, unit) => Some(piece.bytes),
            _ => None,
        });
        bytes.sum()
    }

    /// Whether an access unit plays: its coarsest layer is there, and the coarsest of all else.
    pub(super) fn is_ready(&self, has: &[bool], play: &Play) -> bool {
        let least = &self.ladder.levels[0];
        let (part, _) = self.motion_part(play.motion);
        self.missing_of_shape(has, least).is_empty()
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

/// What comes before the first access unit of a stream, or before all layers of a mesh.
fn head(part: usize) -> PieceOf {
    PieceOf::Part {
        part,
        unit: None,
        layer: None,
    }
}

/// Pieces that are not there.
struct Missing<'a> {
    catalogue: &'a Catalogue,
    has: &'a [bool],
    pieces: Vec<usize>,
}

impl<'a> Missing<'a> {
    fn new(catalogue: &'a Catalogue, has: &'a [bool]) -> Self {
        Self {
            catalogue,
            has,
            pieces: Vec::new(),
        }
    }

    fn add(&mut self, of: PieceOf) {
        let piece = self.catalogue.find(of).filter(|piece| !self.has[*piece]);
        self.pieces.extend(piece);
    }

    fn add_layers(&mut self, part: usize, unit: Option<usize>, layers: &[usize]) {
        let of = |layer| PieceOf::Part { part, unit, layer };
        self.add(of(None));
        layers.iter().for_each(|layer| self.add(of(Some(*layer))));
    }
}
