//! Adaptation of an item: what to keep of it in a context, and the item with that.
//!
//! Source: thesis 3.2 and 7.2.1; method: `docs/methods/adaptation.md`.
//!
//! ```text
//! Item, Context, AdaptOptions ─ decide ─▶ ItemDecision: options of each part, with reasons
//! Item, ItemDecision ─ adapt ─▶ AdaptedItem: fewer layers, or one form in 2D
//! ```
//!
//! - `options`: what a caller may ask for beyond the context
//! - `parts`, `mesh`, `motion`, `texture`: the parts of an item as those of a decision
//! - `regions`: leaving out regions of body and face
//! - `decision`: from a context to the request of a decision, and its answer

mod decision;
mod mesh;
mod motion;
mod options;
mod parts;
mod regions;
mod texture;

pub use decision::{ItemDecision, decide};
pub use options::AdaptOptions;
pub use parts::{ItemParts, PartLayers};

use super::files::Item;
use super::manifest::FlatEntry;
use crate::error::{Context, Error, Result};
use articula_stream::decide::Outcome;
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
    },
}

impl AdaptedItem {
    /// Bytes of what is sent, without manifest and unit indices.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Layers(item) => item.bytes(),
            Self::Flat { files, .. } => files.iter().map(|(_, bytes)| bytes.len() as u64).sum(),
        }
    }
}

/// Cuts an item to a decision about it, by its unit indices alone.
///
/// # Errors
/// An [`Error`] if the decision found nothing that fits, is about another item, or an index does not
/// belong to its stream.
pub fn adapt(item: &Item, decision: &ItemDecision) -> Result<AdaptedItem> {
    match &decision.decision.outcome {
        Outcome::Nothing => {
            let what = "nothing of the item fits the budget; allow more bytes or time";
            Err(Error::argument(what))
        }
        Outcome::Representation(form) => {
            let Some(entry) = item.manifest.flat.get(*form) else {
                return Err(Error::argument("the decision is about another item"));
            };
            let whole = item.manifest.whole.iter().map(|file| &file.file);
            let mut files = Vec::new();
            for name in whole.chain([&entry.file]) {
                let missing = || Error::unsuited("the item lacks this file");
                let bytes = item.file(name).ok_or_else(missing).context(name)?;
                files.push((name.clone(), bytes.to_vec()));
            }
            Ok(AdaptedItem::Flat {
                entry: entry.clone(),
                files,
            })
        }
        Outcome::Parts(_) => {
            let item = decision.regions.applied(item)?.without_flat();
            let names = item.manifest.parts.iter().map(|p| (p.kind, &p.name));
            let kept: BTreeMap<_, _> = names.zip(&decision.kept).collect();
            let item = item.kept(|part, layer| {
                let kept = kept.get(&(part.kind, &part.name));
                kept.is_some_and(|kept| kept.get(layer) == Some(&true))
            })?;
            Ok(AdaptedItem::Layers(item))
        }
    }
}
