//! The loops around the visited faces, as linked lists of edges.
//!
//! Source: S. Gumhold and W. Strasser, "Real time compression of triangle mesh connectivity", 1998
//! (the cut-border). Differs: an edge without a face beyond stays in its loop as a border, adjacent
//! borders are merged, and a face that joins two loops is handled like one that splits a loop.

use super::super::half_edges::NONE;

/// State of the far side of a loop's edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// A face to be visited, or not yet known.
    Open,
    /// Nothing; one edge of the mesh.
    Border,
    /// Nothing; several merged borders.
    Borders,
    /// The entry is not in a loop any more.
    Gone,
}

/// A corner of a loop and the edge to the next one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) point: u32,
    pub(super) next: u32,
    pub(super) previous: u32,
    /// Half-edge of the visited face at the edge.
    pub(super) half_edge: u32,
    pub(super) beyond: Beyond,
    /// An older entry of the same point.
    older: u32,
}

/// All loops.
#[derive(Debug, Default)]
pub(super) struct Border {
    entries: Vec<Entry>,
    /// The latest entry of each point.
    latest: Vec<u32>,
}

/// Maximum number of steps that a corner is searched along a loop.
pub(super) const REACH: u32 = 1024;

impl Border {
    pub(super) fn at(&self, entry: u32) -> &Entry {
        &self.entries[entry as usize]
    }

    pub(super) fn at_mut(&mut self, entry: u32) -> &mut Entry {
        &mut self.entries[entry as usize]
    }

    /// The next entry.
    pub(super) fn next(&self, entry: u32) -> u32 {
        self.at(entry).next
    }

    /// The previous entry.
    pub(super) fn previous(&self, entry: u32) -> u32 {
        self.at(entry).previous
    }

    /// Adds an open entry, linked to itself.
    pub(super) fn add(&mut self, point: u32, half_edge: u32) -> u32 {
        let id = self.entries.len() as u32;
        if self.latest.len() <= point as usize {
            self.latest.resize(point as usize + 1, NONE);
        }
        self.entries.push(Entry {
            point,
            next: id,
            previous: id,
            half_edge,
            beyond: Beyond::Open,
            older: self.latest[point as usize],
        });
        self.latest[point as usize] = id;
        id
    }

    /// Links two entries.
    pub(super) fn link(&mut self, entry: u32, next: u32) {
        self.at_mut(entry).next = next;
        self.at_mut(next).previous = entry;
    }

    /// Removes an entry from its loop.
    pub(super) fn remove(&mut self, entry: u32) {
        let Entry { next, previous, .. } = *self.at(entry);
        self.link(previous, next);
        self.at_mut(entry).beyond = Beyond::Gone;
    }

    /// Returns an entry of a point that is in a loop.
    pub(super) fn find(&mut self, point: u32) -> Option<u32> {
        let latest = self.latest.get_mut(point as usize)?;
        // Removed entries stay removed.
        while *latest != NONE && self.entries[*latest as usize].beyond == Beyond::Gone {
            *latest = self.entries[*latest as usize].older;
        }
        (*latest != NONE).then_some(*latest)
    }

    /// The number of steps from one entry to another of the same loop, if below [`REACH`].
    pub(super) fn steps(
        &self,
        from: u32,
        to: u32,
        step: impl Fn(&Self, u32) -> u32,
    ) -> Option<u32> {
        let mut at = from;
        for steps in 0..REACH {
            if at == to {
                return Some(steps);
            }
            at = step(self, at);
        }
        None
    }

    /// Returns whether a loop has at most two corners and no merged borders: both edges join the
    /// same two points, and no face can lie beyond.
    pub(super) fn is_closed(&self, entry: u32) -> bool {
        let next = self.next(entry);
        let single = |e: u32| self.at(e).beyond != Beyond::Borders;
        self.next(next) == entry && single(entry) && single(next)
    }

    /// Removes a loop of two corners.
    pub(super) fn close(&mut self, entry: u32) {
        let next = self.next(entry);
        self.at_mut(entry).beyond = Beyond::Gone;
        self.at_mut(next).beyond = Beyond::Gone;
    }

    /// Marks an edge as border and merges it with adjacent borders. Returns an entry of the loop,
    /// or `None` if the whole loop is border.
    pub(super) fn set_border(&mut self, entry: u32) -> Option<u32> {
        self.at_mut(entry).beyond = Beyond::Border;
        let mut entry = entry;
        let next = self.next(entry);
        if next != entry && self.is_border(next) {
            self.remove(next);
            self.at_mut(entry).beyond = Beyond::Borders;
        }
        let previous = self.previous(entry);
        if previous != entry && self.is_border(previous) {
            self.remove(entry);
            self.at_mut(previous).beyond = Beyond::Borders;
            entry = previous;
        }
        if self.next(entry) == entry {
            self.at_mut(entry).beyond = Beyond::Gone;
            return None;
        }
        Some(entry)
    }

    fn is_border(&self, entry: u32) -> bool {
        matches!(self.at(entry).beyond, Beyond::Border | Beyond::Borders)
    }
}
