//! The parts of an item as those of a decision: options, and the layers that each keeps.

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
    /// The parts: all motions of the body together, all of the face, each mesh, all textures.
    pub parts: Vec<Part>,
    /// For each of them and each of its options the layers of the item.
    pub layers: Vec<Vec<PartLayers>>,
}

impl ItemParts {
    /// Collects the parts of an item with their bytes, errors at `pixels_per_metre`, and the time that
    /// the terminal of a context takes for each.
    pub fn of(
        item: &Item,
        context: &Context,
        options: &AdaptOptions,
        pixels_per_metre: f64,
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
        let finest = options.finest_tier;
        let bodies = motion::options(of_kind(ItemKind::BodyMotion), finest, joints);
        made.add("body", PartKind::BodyMotion, bodies);
        let faces = motion::options(of_kind(ItemKind::FaceMotion), finest, faps);
        made.add("face", PartKind::FaceMotion, faces);
        let meshes: Vec<_> = of_kind(ItemKind::Mesh);
        for (index, part) in meshes {
            let found = mesh::options(index, part, terminal.triangles_per_s);
            made.add(&part.name, PartKind::Mesh, found);
        }
        let textures = of_kind(ItemKind::Texture);
        let found = texture::options(textures, options.max_texture_px, pixels_per_metre);
        made.add("textures", PartKind::Texture, found);
        made
    }

    fn add(&mut self, name: &str, kind: PartKind, found: Vec<OptionOfPart>) {
        if found.is_empty() {
            return;
        }
        let (options, layers) = found.into_iter().map(|o| (o.option, o.layers)).unzip();
        self.parts.push(Part::new(name, kind, options));
        self.layers.push(layers);
    }
}
