//! Walk through the records of a file in either encoding.

use super::records::{Place, Record, is_binary};
use super::{ascii, binary};

/// Visits the records of a file, of at most `depth` levels; returns where it ended if that is not the end.
pub(super) fn walk(
    bytes: &[u8],
    depth: usize,
    visit: &mut dyn FnMut(&Record<'_>),
) -> Option<Place> {
    match is_binary(bytes) {
        true => binary::walk(bytes, depth, visit).map(Place::Byte),
        false => ascii::walk(bytes, depth, visit).map(|at| {
            let before = bytes.get(..at).unwrap_or(bytes);
            Place::Line(1 + before.iter().filter(|b| **b == b'\n').count())
        }),
    }
}
