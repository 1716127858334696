//! What every part of the reader shares: the document, the limits, the warnings.

use super::document::Document;
use super::place::Place;
use crate::error::{ReadError, Warning};
use crate::limits::Limits;

/// More warnings than a person would read are only counted.
const MOST_WARNINGS: usize = 1000;

/// Warnings in the order in which they came up, bounded.
#[derive(Debug, Default)]
pub(super) struct Notes {
    list: Vec<Warning>,
    left_out: usize,
}

impl Notes {
    pub(super) fn add(&mut self, at: impl Into<String>, what: impl Into<String>) {
        if self.list.len() < MOST_WARNINGS {
            self.list.push(Warning::new(at, what));
        } else {
            self.left_out += 1;
        }
    }

    pub(super) fn into_list(mut self) -> Vec<Warning> {
        if self.left_out > 0 {
            let what = format!("{} more warnings are not listed", self.left_out);
            self.list.push(Warning::new("file", what));
        }
        self.list
    }
}

/// A document being turned into a character.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    pub(super) root: Place<'a>,
    pub(super) document: &'a Document,
    pub(super) limits: &'a Limits,
    pub(super) notes: Notes,
    /// Elements decoded so far, all arrays together.
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

    /// Claims room for `elements` before it is allocated.
    pub(super) fn charge(&mut self, at: &str, elements: u64) -> Result<(), ReadError> {
        // Even an empty array costs something, so that a million of them are seen.
        self.spent = self.spent.saturating_add(elements.max(4));
        Limits::check(at, "decoded elements", self.spent, self.limits.elements)
    }

    pub(super) fn warn(&mut self, place: &Place<'_>, what: impl Into<String>) {
        self.notes.add(place.at(), what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_are_bounded_and_counted() {
        let mut notes = Notes::default();
        for i in 0..MOST_WARNINGS + 7 {
            notes.add("here", format!("{i}"));
        }
        let list = notes.into_list();
        assert_eq!(list.len(), MOST_WARNINGS + 1);
        assert_eq!(list[MOST_WARNINGS].what, "7 more warnings are not listed");
    }
}
