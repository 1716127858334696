//! The loops around what was visited so far, as linked lists of edges.
//!
//! Source: S. Gumhold and W. Strasser, "Real time compression of triangle mesh connectivity",
//! 1998 (the cut-border). Differs: an edge without a face beyond stays in its loop as a border,
//! neighbouring borders become one, and a loop that a face joins with another is spliced in the
//! same way as one that it splits.

use super::super::half_edges::NONE;

/// What lies beyond an edge of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// A face that is to be visited, or it is not known yet that there is none.
    Open,
    /// Nothing; one edge of the mesh.
    Border,
    /// Nothing; several borders in a row.
    Borders,
    /// The entry is in no loop any more.
    Gone,
}

/// A corner of a loop and the edge to the next one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) point: u32,
    pub(super) next: u32,
    pub(super) previous: u32,
    /// The half-edge of the visited face at the edge.
    pub(super) half_edge: u32,
    pub(super) beyond: Beyond,
    /// An entry of the same point, made before.
    older: u32,
}

/// All loops.
#[derive(Debug, Default)]
pub(super) struct Border {
    entries: Vec<Entry>,
    /// The latest entry of each point.
    latest: Vec<u32>,
}

/// How far a corner is searched along a loop.
pub(super) const REACH: u32 = 1024;

impl Border {
    pub(super) fn at(&self, entry: u32) -> &Entry {
        &self.entries[entry as usize]
    }

    pub(super) fn at_mut(&mut self, entry: u32) -> &mut Entry {
        &mut self.entries[entry as usize]
    }

    /// The entry that follows.
    pub(super) fn next(&self, entry: u32) -> u32 {
        self.at(entry).next
    }

    /// The entry before.
    pub(super) fn previous(&self, entry: u32) -> u32 {
        self.at(entry).previous
    }

    /// A new entry, open, linked to itself.
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

    /// Takes an entry out of its loop.
    pub(super) fn remove(&mut self, entry: u32) {
        let Entry { next, previous, .. } = *self.at(entry);
        self.link(previous, next);
        self.at_mut(entry).beyond = Beyond::Gone;
    }

    /// An entry of a point that is in a loop.
    pub(super) fn find(&mut self, point: u32) -> Option<u32> {
        let latest = self.latest.get_mut(point as usize)?;
        // What is gone stays gone.
        while *latest != NONE && self.entries[*latest as usize].beyond == Beyond::Gone {
            *latest = self.entries[*latest as usize].older;
        }
        (*latest != NONE).then_some(*latest)
    }

    /// The steps from one entry to another of the same loop, if there are few.
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

    /// Whether a loop has two corners at most, no row of borders among its edges: both edges
    /// bound the same two points, and no face can be beyond.
    pub(super) fn is_closed(&self, entry: u32) -> bool {
        let next = self.next(entry);
        let single = |e: u32| self.at(e).beyond != Beyond::Borders;
        self.next(next) == entry && single(entry) && single(next)
    }

    /// Drops a loop of two corners.
    pub(super) fn close(&mut self, entry: u32) {
        let next = self.next(entry);
        self.at_mut(entry).beyond = Beyond::Gone;
        self.at_mut(next).beyond = Beyond::Gone;
    }

    /// Notes that nothing lies beyond an edge; joins it with the borders beside it. Gives an
    /// entry of the loop, none if the whole loop is border.
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
