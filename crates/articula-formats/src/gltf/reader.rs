//! Shared state of all parts of the reader: the document, the limits, the warnings.

use super::document::Document;
use super::place::Place;
use crate::error::ReadError;
use crate::limits::Limits;
pub(super) use crate::notes::Notes;
use std::fmt::Display;

/// A document being converted to a character.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    pub(super) root: Place<'a>,
    pub(super) document: &'a Document,
    pub(super) limits: &'a Limits,
    pub(super) notes: Notes,
    /// Elements decoded so far, in all arrays together.
    spent: u64,
}

impl<'a> Reader<'a> {
    pub(super) fn new(document: &'a Document, limits: &'a Limits, notes: Notes) -> Self {
        Self {
            root: Place::root(&document.json),
            document,
            limits,
            notes,
            spent: 0,
        }
    }

    /// Counts `elements` against the limit before they are allocated.
    pub(super) fn charge(&mut self, at: impl Display, elements: u64) -> Result<(), ReadError> {
        // Even an empty array has a cost, so that a million of them exceed the limit.
        self.spent = self.spent.saturating_add(elements.max(4));
        Limits::check(at, "decoded elements", self.spent, self.limits.elements)
    }

    pub(super) fn warn(&mut self, place: &Place<'_>, what: impl Into<String>) {
        self.notes.add(place.at(), what);
    }
}
