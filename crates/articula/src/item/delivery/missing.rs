//! What is there and missing of an item in pieces.

use super::catalogue::{Catalogue, PieceOf, UnitsOf};
use super::ladder::{Kept, Ladder, is_motion, largest, side};
use crate::error::Result;
use crate::item::adapt::AdaptOptions;
use crate::item::files::Item;
use crate::item::manifest::Manifest;
use crate::item::part::PartKind;
use articula_stream::description::Context;

/// An item in pieces, with the levels of quality of a context.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Delivery {
    pub(crate) manifest: Manifest,
    pub(crate) catalogue: Catalogue,
    pub(crate) ladder: Ladder,
}

impl Delivery {
    /// The pieces of an item and its levels for the view, the device and the wishes of a context, whatever
    /// its bandwidth.
    pub(crate) fn of(
        item: &Item,
        context: &Context,
        options: &AdaptOptions,
        units: &mut UnitsOf<'_>,
    ) -> Result<Self> {
        Ok(Self {
            ladder: Ladder::of(item, context, options)?,
            catalogue: Catalogue::of(&item.manifest, units)?,
            manifest: item.manifest.clone(),
        })
    }

    /// Pixels per metre at the distance of the character.
    pub(crate) fn pixels_per_metre(&self) -> f64 {
        self.ladder.decision.decision.request.pixels_per_metre
    }

    /// Which pieces are missing of what is no motion, from coarse to fine, for some layers.
    pub(crate) fn missing_of_shape(&self, has: &[bool], kept: &Kept) -> Vec<usize> {
        let mut found = Missing::new(&self.catalogue, has);
        found.add(PieceOf::Figure);
        let parts = self.manifest.parts.iter().enumerate();
        for (index, _) in parts.filter(|(_, part)| !is_motion(part)) {
            let layers = self.unmet(has, index, &kept[index]);
            found.add_layers(index, None, &layers);
        }
        found.pieces
    }

    /// Which pieces are missing of an access unit of a motion with some of its layers.
    pub(crate) fn missing_of_unit(
        &self,
        has: &[bool],
        (part, unit): (usize, Option<usize>),
        layers: &[bool],
    ) -> Vec<usize> {
        let mut found = Missing::new(&self.catalogue, has);
        found.add(head(part));
        let numbers = layers.iter().enumerate().filter(|(_, kept)| **kept);
        let numbers: Vec<usize> = numbers.map(|(layer, _)| layer).collect();
        found.add_layers(part, unit, &numbers);
        found.pieces
    }

    /// The layers of a part that are wanted: of a texture the largest size alone, unless one that is no
    /// smaller is there.
    fn unmet(&self, has: &[bool], part: usize, kept: &[bool]) -> Vec<usize> {
        let of = &self.manifest.parts[part];
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
    pub(crate) fn layers_there(&self, has: &[bool], part: usize, unit: Option<usize>) -> Vec<bool> {
        let of = &self.manifest.parts[part];
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
