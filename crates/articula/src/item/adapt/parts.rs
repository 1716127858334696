//! The parts of an item as those of a decision: options, and the layers that each keeps.

use super::left_out;
use super::option_of_part::{OptionOfPart, PartLayers};
use super::options::AdaptOptions;
use super::{mesh, motion, texture};
use crate::item::files::Item;
use crate::item::part::PartKind as ItemKind;
use articula_stream::decide::{Part, PartKind};
use articula_stream::description::Context;

/// The parts of an item as those of a decision.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemParts {
    /// The parts: all motions of the body together, all of the face, each mesh, all textures, and what
    /// regions that are left out cost.
    pub parts: Vec<Part>,
    /// For each of them and each of its options the layers of the item.
    pub layers: Vec<Vec<PartLayers>>,
}

/// Which options count.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scope<'a> {
    /// Those alone that a table can name.
    pub(super) is_even: bool,
    /// Those alone that keep no other layers than these, of each part of the item.
    pub(super) within: Option<&'a [Vec<bool>]>,
}

impl Scope<'_> {
    fn has(&self, option: &OptionOfPart) -> bool {
        let inside = |(part, kept): &(usize, Vec<bool>)| {
            let most = self.within.and_then(|within| within.get(*part));
            most.is_none_or(|most| kept.iter().zip(most).all(|(kept, most)| *most || !kept))
        };
        (option.is_even || !self.is_even) && option.layers.iter().all(inside)
    }
}

impl ItemParts {
    /// Collects the parts of an item with their bytes, errors at `pixels_per_metre`, memory, and the time
    /// that the terminal of a context takes for each.
    pub(super) fn of(
        item: &Item,
        context: &Context,
        options: &AdaptOptions,
        pixels_per_metre: f64,
        scope: Scope<'_>,
    ) -> Self {
        let mut made = Self {
            parts: Vec::new(),
            layers: Vec::new(),
        };
        let of_kind = |kind: ItemKind| {
            let parts = item.manifest.parts.iter().enumerate();
            parts.filter(move |(_, part)| part.kind == kind).collect()
        };
        let terminal = &context.terminal;
        let joints = motion::Cost::per_ms(terminal.joints_per_ms);
        let faps = motion::Cost::per_ms(terminal.faps_per_ms);
        let targets = item.manifest.figure.morph_targets;
        let finest = (options.finest_tier, targets);
        let first = item.manifest.first_motion();
        let bodies = motion::options(of_kind(ItemKind::BodyMotion), first, finest, joints);
        made.add("body", PartKind::BodyMotion, bodies, scope);
        let faces = motion::options(of_kind(ItemKind::FaceMotion), None, finest, faps);
        made.add("face", PartKind::FaceMotion, faces, scope);
        let meshes: Vec<_> = of_kind(ItemKind::Mesh);
        for (index, part) in meshes {
            let found = mesh::options(index, part, (terminal.triangles_per_s, targets));
            made.add(&part.name, PartKind::Mesh, found, scope);
        }
        let textures = of_kind(ItemKind::Texture);
        let found = texture::options(textures, options.max_texture_px, pixels_per_metre);
        made.add("textures", PartKind::Texture, found, scope);
        for lost in left_out::parts(&item.manifest.parts) {
            made.parts.push(lost);
            made.layers.push(vec![Vec::new()]);
        }
        made
    }

    fn add(&mut self, name: &str, kind: PartKind, found: Vec<OptionOfPart>, scope: Scope<'_>) {
        let found = found.into_iter().filter(|option| scope.has(option));
        let (options, layers): (Vec<_>, Vec<_>) = found.map(|o| (o.option, o.layers)).unzip();
        if options.is_empty() {
            return;
        }
        self.parts.push(Part::new(name, kind, options));
        self.layers.push(layers);
    }
}
