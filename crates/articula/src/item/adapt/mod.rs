//! Adaptation of an item: what to keep of it in a context, and the item with that.
//!
//! Source: thesis 3.2 and 7.2.1; method: `docs/methods/adaptation.md`.
//!
//! ```text
//! Item, Context, AdaptOptions ─ decide ─▶ ItemDecision: options of each part, with reasons, ItemCut
//! Item, Aqos, Context ─ decide_by_table ─▶ ItemCut
//! Item, ItemCut ─ adapt ─▶ AdaptedItem: fewer layers, or one form in 2D
//! ```
//!
//! - `options`: what a caller may ask for beyond the context
//! - `option_of_part`, `parts`, `mesh`, `motion`, `texture`, `memory`: the parts of an item as those of a
//!   decision
//! - `regions`, `left_out`: leaving out regions of body and face, and what that costs
//! - `decision`: from a context to the request of a decision, and its answer
//! - `table`: the same by an AQoS, and the AQoS of an item
//! - `cut`, `selected`, `cutter`: what is kept, as layers and as the selection of a description

mod cut;
mod cutter;
mod decision;
mod left_out;
mod memory;
mod mesh;
mod motion;
mod option_of_part;
mod options;
mod parts;
mod regions;
mod selected;
mod table;
mod texture;

pub use cut::ItemCut;
pub use cutter::Transform;
pub use decision::{ItemDecision, decide};
pub use option_of_part::PartLayers;
pub use options::AdaptOptions;
pub use parts::ItemParts;
pub use regions::Regions;
pub use table::{aqos, decide_by_table};

pub(super) use regions::applied_regions;
pub(super) use table::parameters;
pub(crate) use texture::texture_error_px;

use cutter::by_description;

use super::files::Item;
use super::manifest::FlatEntry;
use super::part::ItemPart;
use crate::error::{Context, Error, Result};
use std::collections::BTreeMap;

/// What is sent.
#[derive(Debug, Clone, PartialEq)]
pub enum AdaptedItem {
    /// The item with fewer layers, without its forms in 2D.
    Layers(Item),
    /// A form in 2D, with the files that are carried whole.
    Flat {
        /// What it is.
        entry: FlatEntry,
        /// The files with their names.
        files: Vec<(String, Vec<u8>)>,
        /// Their bytes as they are sent.
        sent_bytes: u64,
    },
}

impl AdaptedItem {
    /// Bytes of what is sent, compressed where that is shorter, without manifest and unit indices.
    pub fn sent_bytes(&self) -> u64 {
        match self {
            Self::Layers(item) => item.sent_bytes(),
            Self::Flat { sent_bytes, .. } => *sent_bytes,
        }
    }
}

/// Cuts an item, by its unit indices alone. Motions without a kept layer are not in what is made, but for
/// the first of the body, which rests then: a client that wants one fetches its layers later.
///
/// # Errors
/// An [`Error`] if the cut is of another item, or an index does not belong to its stream.
pub fn adapt(item: &Item, cut: &ItemCut) -> Result<AdaptedItem> {
    adapted(item, cut, &mut |item, keeps| item.kept(keeps))
}

/// Cuts an item by the descriptions of its streams: each is transformed by another program with the
/// item's [stylesheet](articula_stream::description::stylesheet), and the stream written anew from
/// it. The bytes are those of [`adapt`].
///
/// # Errors
/// As [`adapt`], and what the transformation could not do.
pub fn adapt_by_description(
    item: &Item,
    cut: &ItemCut,
    transform: &mut Transform<'_>,
) -> Result<AdaptedItem> {
    adapted(item, cut, &mut |item, keeps| {
        item.kept_by(keeps, &mut |part, kept, stream, index| {
            by_description(part, kept, (stream, index), transform)
        })
    })
}

/// Whether a part keeps a layer.
type Keeps<'a> = dyn Fn(&ItemPart, usize) -> bool + 'a;

fn adapted(
    item: &Item,
    cut: &ItemCut,
    kept_of: &mut dyn FnMut(&Item, &Keeps<'_>) -> Result<Item>,
) -> Result<AdaptedItem> {
    match cut {
        ItemCut::Flat(form) => {
            let Some(entry) = item.manifest.flat.get(*form) else {
                return Err(Error::argument("the cut is of another item"));
            };
            let whole = item.manifest.whole.iter().map(|file| &file.file);
            let mut files = Vec::new();
            for name in whole.chain([&entry.file]) {
                let missing = || Error::unsuited("the item lacks this file");
                let bytes = item.file(name).ok_or_else(missing).context(name)?;
                files.push((name.clone(), bytes.to_vec()));
            }
            let sent_bytes = files.iter().map(|(name, _)| item.manifest.sent_bytes(name));
            Ok(AdaptedItem::Flat {
                entry: entry.clone(),
                sent_bytes: sent_bytes.sum(),
                files,
            })
        }
        ItemCut::Layers { kept, regions } => {
            let item = regions.applied(item)?.without_flat();
            let names = item.manifest.parts.iter().map(|p| (p.kind, &p.name));
            let of: BTreeMap<_, _> = names.zip(kept).collect();
            let numbered = kept.iter().enumerate();
            let stay = numbered.map(|(part, kept)| item.manifest.has_part(part, kept));
            let sent = item.with_parts(&stay.collect::<Vec<_>>());
            let keeps = |part: &ItemPart, layer: usize| {
                let kept = of.get(&(part.kind, &part.name));
                kept.is_some_and(|kept| kept.get(layer) == Some(&true))
            };
            Ok(AdaptedItem::Layers(kept_of(&sent, &keeps)?))
        }
    }
}
