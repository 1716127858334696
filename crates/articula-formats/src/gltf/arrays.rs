//! Reordering of vertex arrays; the bytes of each element are unchanged.
//!
//! Interleaved, shared or strided arrays get a view of their own; sparse ones stay sparse.

use super::accessor::Accessor;
use super::append::{Use, entries_mut, object, set};
use super::document::Document;
use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;
use serde_json::{Value, json};

/// An accessor with its elements in a new order, not yet in the document.
pub(super) struct Reordered {
    /// The accessor's JSON without views, offsets and count.
    template: Value,
    count: usize,
    element_size: usize,
    /// The elements without padding; `None` for zeros.
    dense: Option<Vec<u8>>,
    sparse: Option<Overlay>,
}

/// Ascending indices of sparse elements, and their bytes.
type Overlay = (Vec<u32>, Vec<u8>);

/// Returns the elements of an array whose index a place holds, with old element `order[i]` at index
/// `i`.
pub(super) fn reordered<'a>(
    reader: &mut Reader<'a>,
    index: &Place<'a>,
    order: &[u32],
) -> Result<Reordered, ReadError> {
    let accessor = reader.accessor(index)?;
    let outside = |v: &u32| *v as usize >= accessor.count;
    if order.iter().any(outside) {
        return Err(index.malformed("fewer elements than vertices"));
    }
    let element_size = accessor.element_size();
    reader.charge(index, (order.len() * element_size.div_ceil(4)) as u64)?;
    let mut template = accessor.place().value().clone();
    for key in ["bufferView", "byteOffset", "count", "sparse"] {
        object(&mut template).shift_remove(key);
    }
    Ok(Reordered {
        template,
        count: order.len(),
        element_size,
        dense: dense(&accessor, order),
        sparse: sparse(&accessor, order)?,
    })
}

fn dense(accessor: &Accessor<'_>, order: &[u32]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(order.len() * accessor.element_size());
    for v in order {
        bytes.extend_from_slice(accessor.stored(*v as usize)?);
    }
    Some(bytes).filter(|b| !b.is_empty())
}

fn sparse(accessor: &Accessor<'_>, order: &[u32]) -> Result<Option<Overlay>, ReadError> {
    let overlay = accessor.overlay()?;
    let mut indices = Vec::new();
    let mut values = Vec::new();
    for (new, old) in (0u32..).zip(order) {
        if let Some(bytes) = overlay.get(&(*old as usize)) {
            indices.push(new);
            values.extend_from_slice(bytes);
        }
    }
    Ok((!indices.is_empty()).then_some((indices, values)))
}

impl Document {
    /// Stores an array and returns its accessor. Declared bounds become stale.
    pub(super) fn add_reordered(&mut self, array: Reordered) -> usize {
        let mut accessor = array.template;
        set(&mut accessor, "count", array.count);
        if let Some(bytes) = array.dense {
            let view = self.add_elements(&bytes, array.element_size);
            set(&mut accessor, "bufferView", view);
        }
        if let Some((indices, values)) = array.sparse {
            let value = self.add_sparse(&indices, &values);
            set(&mut accessor, "sparse", value);
        }
        self.add_accessor(accessor)
    }

    /// Adds a view of elements that start at multiples of 4, as the format requires for vertices,
    /// with an explicit stride so that several accessors may use it.
    pub(super) fn add_elements(&mut self, bytes: &[u8], element_size: usize) -> usize {
        let stride = element_size.next_multiple_of(4);
        let mut padded = Vec::with_capacity(bytes.len() / element_size * stride);
        for element in bytes.chunks_exact(element_size) {
            padded.extend_from_slice(element);
            padded.resize(padded.len().next_multiple_of(4), 0);
        }
        let view = self.add_view(&padded, Use::Vertices);
        set(
            &mut entries_mut(&mut self.json, "bufferViews")[view],
            "byteStride",
            stride,
        );
        view
    }

    fn add_sparse(&mut self, indices: &[u32], values: &[u8]) -> Value {
        let is_short = indices.last().is_none_or(|i| u16::try_from(*i).is_ok());
        let bytes: Vec<u8> = if is_short {
            indices
                .iter()
                .flat_map(|i| (*i as u16).to_le_bytes())
                .collect()
        } else {
            indices.iter().flat_map(|i| i.to_le_bytes()).collect()
        };
        json!({
            "count": indices.len(),
            "indices": {
                "bufferView": self.add_view(&bytes, Use::Other),
                "componentType": if is_short { 5123 } else { 5125 },
            },
            "values": {"bufferView": self.add_view(values, Use::Other)},
        })
    }
}
